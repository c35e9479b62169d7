//! Tables for people: aligned columns, numbers with six digits.

use std::fmt::Write;

use granary_api::table::{PointRow, Scalar, SetRow};
use serde_json::Value;

/// Rows of text under a heading.
#[derive(Debug, Default)]
pub(crate) struct Table {
    heading: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with these columns.
    pub(crate) fn new<S: Into<String>>(heading: impl IntoIterator<Item = S>) -> Self {
        Self {
            heading: heading.into_iter().map(Into::into).collect(),
            rows: vec![],
        }
    }

    /// Adds a row; missing cells stay blank.
    pub(crate) fn push(&mut self, row: Vec<String>) {
        self.rows.push(row);
    }

    /// The text: columns two blanks apart, all but the last padded.
    pub(crate) fn render(&self) -> String {
        let mut widths: Vec<usize> = vec![0; self.heading.len()];
        for row in std::iter::once(&self.heading).chain(&self.rows) {
            for (width, cell) in widths.iter_mut().zip(row) {
                *width = (*width).max(cell.chars().count());
            }
        }
        let mut text = String::new();
        for row in std::iter::once(&self.heading).chain(&self.rows) {
            let mut line = String::new();
            for (width, cell) in widths.iter().zip(row) {
                let blanks = width - cell.chars().count() + 2;
                line.push_str(cell);
                line.extend(std::iter::repeat_n(' ', blanks));
            }
            text.push_str(line.trim_end());
            text.push('\n');
        }
        text
    }
}

/// A number with six significant digits, four where it needs a power of ten, as short as it goes.
pub(crate) fn number(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude != 0.0 && !(1e-3..1e7).contains(&magnitude) {
        let text = format!("{value:.3e}");
        return match text.split_once('e') {
            Some((digits, power)) => format!("{}e{power}", short(digits)),
            None => text,
        };
    }
    let whole = if magnitude < 1.0 {
        0
    } else {
        magnitude.log10() as usize
    };
    let text = format!("{value:.*}", 5usize.saturating_sub(whole));
    short(&text).to_owned()
}

/// So many significant digits, without a power of ten where six places will do.
pub(crate) fn digits(value: f64, count: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return number(value);
    }
    let power = value.abs().log10().floor() as i32;
    let unit = 10f64.powi(power + 1 - count);
    let rounded = (value / unit).round() * unit;
    match usize::try_from(count - 1 - power) {
        Ok(places @ 0..=6) => format!("{rounded:.places$}"),
        Ok(_) => format!("{value:.0e}"),
        Err(_) => format!("{rounded:.0}"),
    }
}

/// A decimal fraction without zeros at its end.
fn short(text: &str) -> &str {
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        text
    }
}

/// A result; a number without meaning is shown as a dash.
fn result(value: Option<&Option<f64>>) -> String {
    value.map_or_else(String::new, |value| {
        value.map_or_else(|| "–".to_owned(), number)
    })
}

/// A result of a point, or the word why another one has no meaning.
fn scalar(value: Option<&Scalar>) -> String {
    match value {
        Some(Scalar::Word(word)) => word.clone(),
        other => result(other.map(Scalar::number).as_ref()),
    }
}

/// A parameter as people write it.
pub(crate) fn parameter(value: Option<&Value>) -> String {
    match value {
        None => String::new(),
        Some(Value::String(text)) => text.clone(),
        Some(Value::Number(value)) if value.is_f64() => {
            value.as_f64().map_or_else(String::new, number)
        }
        Some(value) => value.to_string(),
    }
}

/// Adds the names that are not in `columns` yet.
fn add_columns<'a>(columns: &mut Vec<String>, names: impl Iterator<Item = &'a String>) {
    for name in names {
        if !columns.contains(name) {
            columns.push(name.clone());
        }
    }
}

/// The table of points.
pub(crate) fn points(rows: &[PointRow]) -> Table {
    let (mut parameters, mut results) = (vec![], vec![]);
    for row in rows {
        add_columns(&mut parameters, row.parameters.keys());
        add_columns(&mut results, row.results.keys());
    }
    let mut heading = vec!["point".to_owned(), "state".to_owned()];
    heading.extend(parameters.iter().chain(&results).cloned());
    heading.push("remark".to_owned());
    let mut table = Table::new(heading);
    for row in rows {
        let mut cells = vec![row.point.to_string(), row.state.to_string()];
        cells.extend(
            parameters
                .iter()
                .map(|name| parameter(row.parameters.get(name))),
        );
        cells.extend(results.iter().map(|name| scalar(row.results.get(name))));
        let failure = row.failure.as_ref().map(|failure| failure.message.clone());
        cells.push(failure.unwrap_or_else(|| row.warnings.join(" ")));
        table.push(cells);
    }
    table
}

/// The table of sets.
pub(crate) fn sets(rows: &[SetRow]) -> Table {
    let (mut parameters, mut results) = (vec![], vec![]);
    for row in rows {
        add_columns(&mut parameters, row.parameters.keys());
        add_columns(&mut results, row.results.keys());
    }
    // An error stands beside its number.
    results.sort_by_key(|name| {
        let name = name.trim_end_matches("_sem");
        name.trim_end_matches("_error").to_owned()
    });
    // Of a score the processing, of a fit the shape, of a setting the verdict.
    let how = if rows.iter().any(|row| row.verdict.is_some()) {
        "verdict"
    } else if rows.iter().any(|row| row.shape.is_some()) {
        "shape"
    } else {
        "processing"
    };
    let mut heading = vec!["set".to_owned(), "reduce".to_owned(), how.to_owned()];
    heading.extend(parameters.iter().chain(&results).cloned());
    heading.extend(["n".to_owned(), "remark".to_owned()]);
    let mut table = Table::new(heading);
    for row in rows {
        let how = row.verdict.as_ref().or(row.processing.as_ref());
        let how = how.or(row.shape.as_ref());
        let how = how.cloned().unwrap_or_default();
        let mut cells = vec![row.set.to_string(), row.reduce.clone(), how];
        cells.extend(
            parameters
                .iter()
                .map(|name| parameter(row.parameters.get(name))),
        );
        cells.extend(results.iter().map(|name| result(row.results.get(name))));
        let mut n = row.n.to_string();
        if row.n != row.of {
            let _ = write!(n, " of {}", row.of);
        }
        cells.push(n);
        cells.push(row.remark());
        table.push(cells);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_six_digits_and_no_empty_ones() {
        let shown: Vec<String> = [
            0.0,
            1.0,
            -0.25,
            174_000.0,
            123_456.789,
            3e-15,
            0.912_345_678,
        ]
        .into_iter()
        .map(number)
        .collect();
        let expected = ["0", "1", "-0.25", "174000", "123457", "3e-15", "0.91235"];
        assert_eq!(shown, expected);
    }

    #[test]
    fn digits_are_significant_ones() {
        let shown = [0.000_123_4, 0.012_34, 1.234, 123.4, 0.0].map(|value| digits(value, 2));
        assert_eq!(shown, ["0.00012", "0.012", "1.2", "120", "0"]);
        assert_eq!(digits(1.2e-9, 2), "1e-9");
        assert_eq!(digits(0.0996, 2), "0.100");
    }

    #[test]
    fn columns_are_aligned_whatever_the_width_of_their_signs() {
        let mut table = Table::new(["μ", "𝓕"]);
        table.push(vec!["0.4".to_owned(), "0.5".to_owned()]);
        table.push(vec!["1".to_owned()]);
        assert_eq!(table.render(), "μ    𝓕\n0.4  0.5\n1\n");
    }
}
