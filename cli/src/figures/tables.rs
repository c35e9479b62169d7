//! Table I: our fits of Eq. (4) beside the published ones.

use granary_api::table::SetRow;
use serde_json::Value;

use super::beams;
use super::data::Data;
use super::drawing::csv_line;
use crate::published::strengths::{PublishedFit, published};
use crate::table::{Table, number};

/// One row: what it is of, and the numbers.
struct Row<'a> {
    set: &'a SetRow,
    /// \[MPa\].
    modulus: f64,
    protocol: &'a str,
    published: Option<PublishedFit>,
}

fn rows(data: &Data) -> Vec<Row<'_>> {
    let mut rows: Vec<Row<'_>> = beams::fits(data)
        .filter_map(|set| {
            let modulus = set.parameters.get("youngs_modulus")?.as_f64()?;
            let protocol = set.parameters.get("protocol").and_then(Value::as_str)?;
            Some(Row {
                set,
                modulus: modulus * 1e-6,
                protocol,
                published: published(modulus, protocol),
            })
        })
        .collect();
    rows.sort_by(|a, b| {
        let by_modulus = a.modulus.total_cmp(&b.modulus);
        by_modulus.then(a.protocol.cmp(b.protocol))
    });
    rows
}

impl Row<'_> {
    /// Y⁰ and Y^∞ \[kPa\] and a with their errors, each as far as the strengths determine it.
    fn ours(&self) -> [[Option<f64>; 2]; 3] {
        let value = |name: &str, scale: f64| {
            let found = self.set.results.get(name).copied().flatten();
            found.map(|found| found * scale)
        };
        let names = [
            ("strength_zero_friction", 1e-3),
            ("strength_infinite_friction", 1e-3),
            ("strength_rate", 1.0),
        ];
        names.map(|(name, scale)| [value(name, scale), value(&format!("{name}_error"), scale)])
    }

    fn theirs(&self) -> [Option<f64>; 3] {
        let fit = self.published;
        [
            fit.map(|fit| fit.zero),
            fit.map(|fit| fit.infinite),
            fit.map(|fit| fit.rate),
        ]
    }

    fn shape(&self) -> &str {
        self.set.shape.as_deref().unwrap_or_default()
    }
}

/// The table for people.
pub(super) fn fits(data: &Data) -> Table {
    let mut table = Table::new([
        "E_p [MPa]",
        "protocol",
        "Y⁰ [kPa]",
        "published",
        "Y^∞ [kPa]",
        "published",
        "a",
        "published",
        "shape",
        "strengths",
        "remark",
    ]);
    for row in rows(data) {
        let mut cells = vec![number(row.modulus), row.protocol.to_owned()];
        for (ours, theirs) in row.ours().into_iter().zip(row.theirs()) {
            cells.push(match ours {
                [Some(value), Some(error)] => format!("{value:.2} ± {error:.2}"),
                [Some(value), None] => format!("{value:.2}"),
                [None, _] => "–".to_owned(),
            });
            cells.push(theirs.map_or_else(String::new, |value| format!("{value:.2}")));
        }
        cells.push(row.shape().replace('_', " "));
        cells.push(format!("{} of {}", row.set.n, row.set.of));
        cells.push(row.set.remark());
        table.push(cells);
    }
    table
}

/// The same for machines.
pub(super) fn fits_csv(data: &Data) -> String {
    let mut text = csv_line([
        "youngs_modulus_mpa",
        "protocol",
        "zero_friction_kpa",
        "zero_friction_error_kpa",
        "zero_friction_published_kpa",
        "infinite_friction_kpa",
        "infinite_friction_error_kpa",
        "infinite_friction_published_kpa",
        "rate",
        "rate_error",
        "rate_published",
        "shape",
        "strengths_used",
        "strengths",
    ]);
    for row in rows(data) {
        let mut cells = vec![row.modulus.to_string(), row.protocol.to_owned()];
        for ([value, error], theirs) in row.ours().into_iter().zip(row.theirs()) {
            let shown = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
            cells.extend([value, error, theirs].map(shown));
        }
        cells.extend([
            row.shape().to_owned(),
            row.set.n.to_string(),
            row.set.of.to_string(),
        ]);
        text += &csv_line(cells.iter().map(String::as_str));
    }
    text
}
