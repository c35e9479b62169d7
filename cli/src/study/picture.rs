//! The settings of a study over what they cost, as a picture.

use granary_api::table::SetRow;
use granary_core::model::Model;
use granary_core::study::Judged;

use super::shown::{result, scene};
use crate::figures::drawing::{Axis, Chart, Curve, Dot, Drawing, Note, Panel, Style};
use crate::figures::svg;
use crate::table::parameter;

const COST: Axis = Axis {
    symbol: "cost of a packing",
    unit: "core-seconds",
    column: "core_seconds",
};

/// One chart for each result and scene: how large its error may be, over the cost.
pub(super) fn picture(rows: &[SetRow], model: Model, name: &str) -> String {
    let mut panels = vec![];
    let differ = scene(rows);
    for rows in scenes(rows) {
        let told = |name: &String| {
            let value = rows.first().and_then(|row| row.parameters.get(name));
            format!(", {name} {}", parameter(value))
        };
        let scene: String = differ.iter().map(told).collect();
        for judged in model.judged() {
            panels.push(Panel::Chart(chart(rows, *judged, model, &scene)));
        }
    }
    let drawing = Drawing {
        panels,
        columns: model.judged().len(),
    };
    svg::picture(&drawing, &format!("{name}: error over cost"))
}

/// The rows of each scene, which begin with its reference.
fn scenes(rows: &[SetRow]) -> impl Iterator<Item = &[SetRow]> {
    rows.chunk_by(|_, next| next.verdict.as_deref() != Some("reference"))
}

fn chart(rows: &[SetRow], judged: Judged, model: Model, scene: &str) -> Chart {
    let row = model.results().iter().find(|row| row.name == judged.name);
    let symbol = row.map_or(judged.name, |row| row.symbol);
    let axis = Axis {
        symbol: if judged.relative {
            "relative error"
        } else {
            "error"
        },
        unit: "",
        column: "error",
    };
    let title = format!("Error of {symbol}{scene}");
    let mut chart = Chart::new(&title, COST, axis);
    chart.logarithmic = true;
    for row in rows {
        let Some((x, y)) = place(row, judged) else {
            continue;
        };
        let label = row.setting.clone().unwrap_or_default();
        let knob = kind(&label);
        let known = chart.curves.iter().position(|curve| curve.label == knob);
        let at = known.unwrap_or_else(|| {
            chart.curves.push(Curve {
                label: knob.to_owned(),
                told: true,
                color: chart.curves.len(),
                style: Style::Marks,
                dots: vec![],
            });
            chart.curves.len() - 1
        });
        chart.curves[at].dots.push(Dot::new(x, y));
        let text = label.strip_prefix(knob).map_or(label.as_str(), str::trim);
        chart.notes.push(Note {
            x,
            y,
            text: text.to_owned(),
        });
    }
    chart.curves.push(front(rows, judged));
    chart
}

/// Settings that vary one knob are of its kind, all others of one.
fn kind(label: &str) -> &str {
    let is_pair = label.split(' ').count() == 2 && !label.contains(',');
    match label.split_once(' ') {
        Some((knob, _)) if is_pair && knob != "as" && knob != "preset" => knob,
        _ => "settings",
    }
}

/// Cost, and how large the error may be; nothing if either is not known or zero, which has no place here.
fn place(row: &SetRow, judged: Judged) -> Option<(f64, f64)> {
    let cost = result(row, "core_seconds")?;
    let name = format!("{}_deviation", judged.name);
    let error = result(row, &format!("{name}_bound")).or_else(|| result(row, &name))?;
    (cost > 0.0 && error != 0.0).then_some((cost, error.abs()))
}

/// The least error of this result for each cost.
fn front(rows: &[SetRow], judged: Judged) -> Curve {
    let mut places: Vec<(f64, f64)> = rows.iter().filter_map(|row| place(row, judged)).collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut dots: Vec<Dot> = vec![];
    for (x, y) in places {
        if dots.last().is_none_or(|last| y < last.y) {
            dots.push(Dot::new(x, y));
        }
    }
    Curve {
        label: "the least error for the cost".to_owned(),
        told: true,
        color: 7,
        style: Style::Dashed,
        dots,
    }
}
