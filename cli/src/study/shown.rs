//! The settings of a study as people read them.

use granary_api::table::SetRow;
use granary_core::model::Model;
use granary_core::study::Judged;

use crate::table::{Table, number, parameter};

/// What the columns mean.
pub(super) const LEGEND: &str = "\
errors are mean ± standard error over packings; 9 of 10 further packings are off by less than what stands in brackets
front: no other setting is cheaper and at least as accurate; beaten: some other is; incomplete: some packing has no result";

/// The table of a study.
pub(super) fn table(rows: &[SetRow], model: Model) -> Table {
    let scene = scene(rows);
    let mut heading = vec!["setting".to_owned()];
    heading.extend(scene.iter().cloned());
    for judged in model.judged() {
        heading.push(judged.name.to_owned());
        heading.push("error".to_owned());
    }
    heading.extend(["core-s", "cost", "verdict", "n", "remark"].map(str::to_owned));
    let mut table = Table::new(heading);
    for row in rows {
        table.push(line(row, &scene, model));
    }
    table
}

/// The parameters in which scenes differ: those that change from one reference to the next.
fn scene(rows: &[SetRow]) -> Vec<String> {
    let is_reference = |row: &&SetRow| row.verdict.as_deref() == Some("reference");
    let references: Vec<&SetRow> = rows.iter().filter(is_reference).collect();
    let Some(first) = references.first() else {
        return vec![];
    };
    let differs = |name: &&String| {
        let of = |row: &&SetRow| row.parameters.get(*name).cloned();
        references.iter().any(|row| of(row) != of(first))
    };
    first.parameters.keys().filter(differs).cloned().collect()
}

fn line(row: &SetRow, scene: &[String], model: Model) -> Vec<String> {
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".to_owned());
    let mut cells = vec![row.setting.clone().unwrap_or_default()];
    cells.extend(scene.iter().map(|name| parameter(row.parameters.get(name))));
    for judged in model.judged() {
        cells.push(or_dash(result(row, judged.name).map(number)));
        cells.push(or_dash(error(row, judged)));
    }
    cells.push(or_dash(result(row, "core_seconds").map(|s| digits(s, 3))));
    cells.push(or_dash(result(row, "relative_cost").map(|c| digits(c, 2))));
    cells.push(row.verdict.clone().unwrap_or_default());
    cells.push(if row.n == row.of {
        row.n.to_string()
    } else {
        format!("{} of {}", row.n, row.of)
    });
    cells.push(row.missing_reason.clone().unwrap_or_default());
    cells
}

/// The number called `name`, if there is one.
pub(super) fn result(row: &SetRow, name: &str) -> Option<f64> {
    row.results.get(name).copied().flatten()
}

/// An error as people read it, in percent where it is a share; nothing for the reference, whose is none.
fn error(row: &SetRow, judged: &Judged) -> Option<String> {
    let (scale, unit) = if judged.relative {
        (100.0, " %")
    } else {
        (1.0, "")
    };
    if row.verdict.as_deref() == Some("reference") {
        return None;
    }
    let get = |what: &str| {
        let name = format!("{}_error{what}", judged.name);
        result(row, &name).map(|error| error * scale)
    };
    let mean = get("")?;
    let sem = get("_sem").map_or_else(String::new, |sem| format!(" ± {}", digits(sem, 2)));
    let bound = get("_bound").map_or_else(String::new, |bound| format!(" ({})", digits(bound, 2)));
    let sign = if mean > 0.0 { "+" } else { "" };
    Some(format!("{sign}{}{sem}{unit}{bound}", digits(mean, 2)))
}

/// So many significant digits, without a power of ten where six places will do.
fn digits(value: f64, count: i32) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn row(setting: &str, verdict: &str, results: &[(&str, f64)]) -> SetRow {
        SetRow {
            set: 0,
            reduce: "study".to_owned(),
            processing: None,
            parameters: serde_json::Map::new(),
            results: results
                .iter()
                .map(|(name, value)| ((*name).to_owned(), Some(*value)))
                .collect::<BTreeMap<_, _>>(),
            shape: None,
            setting: Some(setting.to_owned()),
            verdict: Some(verdict.to_owned()),
            n: 2,
            of: 2,
            provisional: false,
            missing_reason: None,
        }
    }

    #[test]
    fn errors_have_two_digits_and_shares_are_percent() {
        let study = [
            row(
                "reference",
                "reference",
                &[("gain", 0.35), ("gain_error", 0.0)],
            ),
            row(
                "ramp 4500",
                "front",
                &[
                    ("gain", 0.357),
                    ("gain_error", 0.0213),
                    ("gain_error_sem", 0.00412),
                    ("gain_error_bound", 0.0561),
                    ("fidelity_error", -0.00327),
                    ("core_seconds", 12.345),
                    ("relative_cost", 0.2513),
                ],
            ),
        ];
        let text = table(&study, Model::Memory).render();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[2].contains("+2.1 ± 0.41 % (5.6)"), "{text}");
        assert!(lines[2].contains("-0.0033"), "{text}");
        assert!(lines[2].contains("12.3    0.25  front"), "{text}");
        assert!(lines[1].contains("–"), "{text}");
    }

    #[test]
    fn digits_are_significant_ones() {
        let shown = [0.000_123_4, 0.012_34, 1.234, 123.4, 0.0].map(|value| digits(value, 2));
        assert_eq!(shown, ["0.00012", "0.012", "1.2", "120", "0"]);
        assert_eq!(digits(1.2e-9, 2), "1e-9");
        assert_eq!(digits(0.0996, 2), "0.100");
    }
}
