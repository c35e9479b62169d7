//! Figures of numbers that a beam has as a whole: 3, 6, 7 and 8.

use granary_api::table::{PointRow, SetRow};
use serde_json::Value;

use super::data::{Data, is, is_protocol, mean};
use super::drawing::{Axis, Chart, Curve, Dot, Drawing, Heatmap, Panel, Style, Tile, told};
use crate::published::strengths::{self, PublishedFit};

const FRICTION: &str = "friction_coefficient";
const MODULUS: &str = "youngs_modulus";
const FRACTION: &str = "initial_volume_fraction";
const PRESSURE: &str = "confining_pressure";

pub(super) const MU: Axis = Axis {
    symbol: "μ_p",
    unit: "",
    column: "friction_coefficient",
};
const E_P: Axis = Axis {
    symbol: "E_p",
    unit: "MPa",
    column: "youngs_modulus_mpa",
};
const E_B: Axis = Axis {
    symbol: "E_b",
    unit: "MPa",
    column: "beam_stiffness_mpa",
};
pub(super) const Y_B: Axis = Axis {
    symbol: "Y_b",
    unit: "kPa",
    column: "ultimate_strength_kpa",
};
const Z: Axis = Axis {
    symbol: "z",
    unit: "",
    column: "coordination_number",
};
const PHI_INIT: Axis = Axis {
    symbol: "φ_init",
    unit: "",
    column: "initial_volume_fraction",
};
const DELTA_P: Axis = Axis {
    symbol: "Δp",
    unit: "kPa",
    column: "confining_pressure_kpa",
};
/// The paper's Δp \[Pa\] and φ_init, at each of which the other is varied.
const USUAL_PRESSURE: f64 = 90e3;
const USUAL_FRACTION: f64 = 0.5;
/// Dots of a fitted curve.
const STEPS: u32 = 120;

fn dot(x: f64, tile: &Tile) -> Option<Dot> {
    tile.value.map(|y| Dot {
        x,
        y,
        error: tile.error,
    })
}

/// Figure 3.
pub(super) fn coordination(data: &Data) -> Drawing {
    let panel =
        |title: &str, axis: Axis, (name, scale): (&str, f64), (other, usual): (&str, f64)| {
            let mut chart = Chart::new(title, axis, Z);
            for (color, (friction, _)) in data.by(FRICTION, |_| true).into_iter().enumerate() {
                let rows = data.by(name, |row| {
                    is(row, other, usual) && is(row, FRICTION, friction)
                });
                let dots = rows.iter().filter_map(|(value, rows)| {
                    dot(value * scale, &mean(rows, "coordination_number", 1.0))
                });
                chart.curves.push(Curve {
                    label: told("μ_init", friction),
                    told: true,
                    color,
                    style: Style::Joined,
                    dots: dots.collect(),
                });
            }
            Panel::Chart(chart)
        };
    let pressure = panel(
        "(b) φ_init = 0.5",
        DELTA_P,
        (PRESSURE, 1e-3),
        (FRACTION, USUAL_FRACTION),
    );
    let fraction = panel(
        "(a) Δp = 90 kPa",
        PHI_INIT,
        (FRACTION, 1.0),
        (PRESSURE, USUAL_PRESSURE),
    );
    Drawing {
        panels: vec![fraction, pressure],
        columns: 2,
    }
}

/// Figures 6 and 7.
pub(super) fn maps(data: &Data) -> Drawing {
    let map = |title: &str, value: Axis, result: &str, scale: f64| {
        let across: Vec<f64> = data
            .by(FRICTION, |_| true)
            .iter()
            .map(|(mu, _)| *mu)
            .collect();
        let rows = data.by(MODULUS, |_| true);
        let tile = |modulus: f64, friction: f64| {
            let here = |row: &&PointRow| is(row, MODULUS, modulus) && is(row, FRICTION, friction);
            let rows: Vec<&PointRow> = data.points.iter().filter(here).collect();
            mean(&rows, result, scale)
        };
        let tiles = rows
            .iter()
            .map(|(modulus, _)| across.iter().map(|mu| tile(*modulus, *mu)).collect());
        Panel::Heatmap(Heatmap {
            title: title.to_owned(),
            x: MU,
            y: E_P,
            value,
            tiles: tiles.collect(),
            upward: rows.iter().map(|(modulus, _)| modulus * 1e-6).collect(),
            across,
        })
    };
    Drawing {
        panels: vec![
            map("(a)", E_B, "beam_stiffness", 1e-6),
            map("(b)", Y_B, "ultimate_strength", 1e-3),
        ],
        columns: 2,
    }
}

/// Figure 8.
pub(super) fn over_friction(data: &Data) -> Drawing {
    let mut stiffness = Chart::new("(a)", MU, E_B);
    let mut strength = Chart::new("(b)", MU, Y_B);
    for (color, (modulus, _)) in data.by(MODULUS, |_| true).into_iter().enumerate() {
        for protocol in ["A", "B"] {
            let here = |row: &PointRow| is(row, MODULUS, modulus) && is_protocol(row, protocol);
            let rows = data.by(FRICTION, here);
            let curve = |result: &str, scale: f64, style: Style| Curve {
                label: format!("{} MPa, {protocol}", modulus * 1e-6),
                told: true,
                color,
                style,
                dots: rows
                    .iter()
                    .filter_map(|(mu, rows)| dot(*mu, &mean(rows, result, scale)))
                    .collect(),
            };
            let [joined, marks, line] = match protocol {
                "A" => [Style::Joined, Style::Marks, Style::Solid],
                _ => [Style::OpenJoined, Style::Open, Style::Dashed],
            };
            stiffness.curves.push(curve("beam_stiffness", 1e-6, joined));
            strength
                .curves
                .push(curve("ultimate_strength", 1e-3, marks));
            let from = if protocol == "A" { 0.0 } else { 0.3 };
            if let Some(law) = fit_of(data, modulus, protocol) {
                let label = format!("{} MPa, {protocol}, our fit of Eq. (4)", modulus * 1e-6);
                strength.curves.push(line_of(label, color, line, from, law));
            }
            if let Some(fit) = strengths::published(modulus, protocol) {
                let label = format!("{} MPa, {protocol}, published fit", modulus * 1e-6);
                let law = move |mu: f64| fit.at(mu);
                strength
                    .curves
                    .push(line_of(label, color, Style::Dotted, from, law));
            }
        }
    }
    for (style, label) in [
        (Style::Solid, "our fits of Eq. (4)"),
        (Style::Dotted, "published fits"),
    ] {
        if strength.curves.iter().any(|curve| curve.style == style) {
            strength.curves.push(in_legend(label, style));
        }
    }
    Drawing {
        panels: vec![Panel::Chart(stiffness), Panel::Chart(strength)],
        columns: 2,
    }
}

/// A curve that only the legend shows.
fn in_legend(label: &str, style: Style) -> Curve {
    Curve {
        label: label.to_owned(),
        told: true,
        color: 0,
        style,
        dots: vec![],
    }
}

fn line_of(
    label: String,
    color: usize,
    style: Style,
    from: f64,
    law: impl Fn(f64) -> f64,
) -> Curve {
    let at = |k: u32| from + (1.2 - from) * f64::from(k) / f64::from(STEPS);
    Curve {
        label,
        told: false,
        color,
        style,
        dots: (0..=STEPS).map(|k| Dot::new(at(k), law(at(k)))).collect(),
    }
}

/// Our fit as Y_b(μ_p) \[kPa\], whatever shape the strengths have.
fn fit_of(data: &Data, modulus: f64, protocol: &str) -> Option<Box<dyn Fn(f64) -> f64>> {
    let set = fits(data).find(|set| of(set, modulus, protocol))?;
    let value = |name: &str| Some(set.results.get(name).copied().flatten()? * 1e-3);
    let rate = set.results.get("strength_rate").copied().flatten();
    let zero = value("strength_zero_friction");
    let infinite = value("strength_infinite_friction");
    let law = match set.shape.as_deref()? {
        "exponential" => PublishedFit {
            zero: zero?,
            infinite: infinite?,
            rate: rate?,
        },
        "step" => PublishedFit::constant(infinite?),
        "constant" => PublishedFit::constant(value("strength_mean")?),
        "straight" => {
            let (zero, slope) = (zero?, value("strength_slope")?);
            return Some(Box::new(move |mu| zero + slope * mu));
        }
        _ => return None,
    };
    Some(Box::new(move |mu| law.at(mu)))
}

/// The fits among the sets.
pub(super) fn fits(data: &Data) -> impl Iterator<Item = &SetRow> {
    data.sets
        .iter()
        .filter(|set| set.reduce == "ultimate_strength_fit")
}

fn of(set: &SetRow, modulus: f64, protocol: &str) -> bool {
    let word = set.parameters.get("protocol").and_then(Value::as_str);
    let number = set.parameters.get(MODULUS).and_then(Value::as_f64);
    word == Some(protocol) && number.is_some_and(|found| found.total_cmp(&modulus).is_eq())
}
