//! The settings of a study as people read them.

use granary_api::table::SetRow;
use granary_core::model::Model;
use granary_core::study::Judged;

use crate::table::{Table, digits, number, parameter};

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
pub(super) fn scene(rows: &[SetRow]) -> Vec<String> {
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
    cells.push(row.remark());
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
        let name = format!("{}_deviation{what}", judged.name);
        result(row, &name).map(|error| error * scale)
    };
    let mean = get("")?;
    let sem = get("_sem").map_or_else(String::new, |sem| format!(" ± {}", digits(sem, 2)));
    let bound = get("_bound").map_or_else(String::new, |bound| format!(" ({})", digits(bound, 2)));
    let sign = if mean > 0.0 { "+" } else { "" };
    Some(format!("{sign}{}{sem}{unit}{bound}", digits(mean, 2)))
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
            warning: None,
            confused: vec![],
        }
    }

    #[test]
    fn errors_have_two_digits_and_shares_are_percent() {
        let study = [
            row(
                "reference",
                "reference",
                &[("gain", 0.35), ("gain_deviation", 0.0)],
            ),
            row(
                "ramp 4500",
                "front",
                &[
                    ("gain", 0.357),
                    ("gain_deviation", 0.0213),
                    ("gain_deviation_sem", 0.00412),
                    ("gain_deviation_bound", 0.0561),
                    ("fidelity_deviation", -0.00327),
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
}
