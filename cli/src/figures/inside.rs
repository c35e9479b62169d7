//! Figures of the inside of a beam: 4, 10, 12 and 14 to 16.

use granary_api::table::PointRow;

use super::beams::MU;
use super::curves::{STRESS, over_stress, yields};
use super::data::{Change, Data, Field, StressBin, Structure, is, is_protocol, real};
use super::drawing::{Axis, Chart, Curve, Dot, Drawing, Heatmap, Panel, Style, Tile, told};

const DISTANCE: Axis = Axis {
    symbol: "r / d_mean",
    unit: "",
    column: "distance_d",
};
const PAIRS: Axis = Axis {
    symbol: "g",
    unit: "",
    column: "pair_correlation",
};
const CORRELATION: Axis = Axis {
    symbol: "C(r) / C(0)",
    unit: "",
    column: "autocorrelation",
};
const HEIGHT: Axis = Axis {
    symbol: "h",
    unit: "mm",
    column: "height_mm",
};
const PROFILE: Axis = Axis {
    symbol: "D_min, normalized",
    unit: "",
    column: "non_affine_normalized",
};
const NON_AFFINE: Axis = Axis {
    symbol: "⟨D_min⟩ / d_mean",
    unit: "",
    column: "non_affine_d",
};
const FRACTION: Axis = Axis {
    symbol: "φ",
    unit: "",
    column: "volume_fraction",
};
pub(super) const LENGTH: Axis = Axis {
    symbol: "x",
    unit: "mm",
    column: "x_mm",
};
pub(super) const UPWARD: Axis = Axis {
    symbol: "z",
    unit: "mm",
    column: "z_mm",
};
/// Stresses of Figures 10, 11 and 13 \[Pa\].
pub(super) const EARLY_AND_LATE: [f64; 2] = [15e3, 100e3];
/// Where the interval of Figure 15 begins \[Pa\].
const LATE: f64 = 175e3;
/// Width of an interval of stress \[kPa\].
const INTERVAL: f64 = 25.0;

/// The first analyzed beam among the points that are kept.
fn first(data: &Data, keep: impl Fn(&PointRow) -> bool) -> Option<&Structure> {
    let mut kept = data.points.iter().filter(|row| keep(row));
    kept.find_map(|row| data.structures.get(&row.point))
}

fn solid(label: String, color: usize, dots: Vec<Dot>) -> Curve {
    Curve {
        label,
        told: true,
        color,
        style: Style::Solid,
        dots,
    }
}

/// Dots at `places`, where there is a value.
fn dots(places: impl Iterator<Item = f64>, values: &[Option<f64>]) -> Vec<Dot> {
    let pairs = places.zip(values);
    pairs
        .filter_map(|(x, y)| y.map(|y| Dot::new(x, y)))
        .collect()
}

fn side_by_side(charts: impl IntoIterator<Item = Chart>, columns: usize) -> Drawing {
    Drawing {
        panels: charts.into_iter().map(Panel::Chart).collect(),
        columns,
    }
}

/// Figure 4.
pub(super) fn pair_correlation(data: &Data) -> Drawing {
    let panel = |title: &str, (name, symbol, scale): (&str, &str, f64), (other, usual)| {
        let mut chart = Chart::new(title, DISTANCE, PAIRS);
        let values = data.by(name, |row| is(row, other, usual));
        for (color, (value, _)) in values.into_iter().enumerate() {
            let here = |row: &PointRow| is(row, other, usual) && is(row, name, value);
            let found = first(data, here).and_then(|structure| {
                let pairs = structure.snapshots.first()?.pair_correlation.as_ref()?;
                let (diameter, all) = (structure.mean_diameter?, pairs.paper.all.as_ref()?);
                let places = pairs.distances.iter().map(move |r| r / diameter);
                Some(places.zip(all).map(|(r, g)| Dot::new(r, *g)).collect())
            });
            let label = told(symbol, value * scale);
            chart
                .curves
                .extend(found.map(|dots| solid(label, color, dots)));
        }
        chart
    };
    let (fraction, pressure) = ("initial_volume_fraction", "confining_pressure");
    let a = panel(
        "(a) Δp = 90 kPa",
        (fraction, "φ_init", 1.0),
        (pressure, 90e3),
    );
    let b = panel(
        "(b) φ_init = 0.5",
        (pressure, "Δp/kPa", 1e-3),
        (fraction, 0.5),
    );
    side_by_side([a, b], 2)
}

/// Figure 10.
pub(super) fn displacement(data: &Data) -> Drawing {
    let found = first(data, |_| true);
    let mut panels = vec![];
    for (component, name) in [(0, "x"), (1, "y")] {
        for stress in EARLY_AND_LATE {
            let change = found.and_then(|structure| nearest(&structure.changes, stress));
            let field =
                change.and_then(|change| Some((change.stress, change.displacement.as_ref()?)));
            let letter = char::from(b'a' + panels.len() as u8);
            panels.extend(field.map(|(stress, field)| {
                let title = format!("({letter}) Δr in {name}, σ = {:.0} kPa", stress * 1e-3);
                Panel::Heatmap(field_map(&title, field, component))
            }));
        }
    }
    Drawing { panels, columns: 2 }
}

/// The change at the stress nearest to `stress`, on the way up to it.
fn nearest(changes: &[Change], stress: f64) -> Option<&Change> {
    let distance = |change: &&Change| (change.stress - stress).abs();
    changes
        .iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

fn field_map(title: &str, field: &Field, component: usize) -> Heatmap {
    let [columns, _, rows] = field.count;
    let along = |axis: usize, k: usize| 1e3 * (field.low[axis] + field.spacing[axis] * k as f64);
    let tile = |i: usize, k: usize| {
        let node = field.values.get(k * columns + i).copied().flatten();
        let reason = if node.is_some() { "" } else { "too few grains" };
        Tile {
            value: node.map(|r| r[component] * 1e6),
            reason: reason.to_owned(),
            ..Tile::default()
        }
    };
    Heatmap {
        title: title.to_owned(),
        x: LENGTH,
        y: UPWARD,
        value: Axis {
            symbol: "Δr",
            unit: "µm",
            column: "displacement_um",
        },
        across: (0..columns).map(|i| along(0, i)).collect(),
        upward: (0..rows).map(|k| along(2, k)).collect(),
        tiles: (0..rows)
            .map(|k| (0..columns).map(|i| tile(i, k)).collect())
            .collect(),
    }
}

fn interval(bin: &StressBin) -> String {
    let from = bin.from * 1e-3;
    format!("{from:.0}–{:.0} kPa", from + INTERVAL)
}

/// Figure 12.
pub(super) fn autocorrelation(data: &Data) -> Drawing {
    let mut chart = Chart::new(
        "E_p = 100 MPa, μ_p = 0.3, protocol B",
        DISTANCE,
        CORRELATION,
    );
    if let Some(structure) = first(data, |_| true) {
        let mut all = structure.changes.iter();
        let distances = all.find_map(|change| change.autocorrelation.as_ref());
        let places = distances.map_or(&[][..], |found| &found.distances);
        let diameter = structure.mean_diameter.unwrap_or(1.0);
        for (color, bin) in structure.by_stress.autocorrelation.iter().enumerate() {
            let Some(at_zero) = bin.mean.first().copied().flatten() else {
                continue;
            };
            let scaled: Vec<_> = bin.mean.iter().map(|c| c.map(|c| c / at_zero)).collect();
            let places = places.iter().map(|r| r / diameter);
            let dots = dots(places, &scaled);
            chart.curves.push(solid(interval(bin), color, dots));
        }
    }
    side_by_side([chart], 1)
}

/// A bin with this part of the grains of the fullest one, or fewer, is not drawn: single grains that stick out.
const FEW: f64 = 0.02;

/// The dots of a height profile.
fn profile(structure: &Structure, bin: &StressBin) -> Vec<Dot> {
    let Some(first) = structure.changes.first() else {
        return vec![];
    };
    let grains = |k: usize| -> usize {
        let changes = structure.changes.iter();
        let bins = changes.filter_map(|change| change.height_profile.get(k));
        bins.map(|bin| bin.count).sum()
    };
    let fullest = (0..first.height_profile.len()).map(grains).max();
    let enough = |k: usize| grains(k) as f64 > FEW * fullest.unwrap_or(0) as f64;
    let kept = { first.height_profile.iter().zip(&bin.mean).enumerate() };
    kept.filter(|(k, _)| enough(*k))
        .filter_map(|(_, (at, mean))| mean.map(|mean| Dot::new(at.height * 1e3, mean)))
        .collect()
}

/// Figure 14.
pub(super) fn height(data: &Data) -> Drawing {
    let mut chart = Chart::new("E_p = 100 MPa, μ_p = 0.3", HEIGHT, PROFILE);
    if let Some(structure) = first(data, |_| true) {
        for (color, bin) in structure.by_stress.height_profile.iter().enumerate() {
            chart
                .curves
                .push(solid(interval(bin), color, profile(structure, bin)));
        }
    }
    side_by_side([chart], 1)
}

/// Figure 15.
pub(super) fn height_and_friction(data: &Data) -> Drawing {
    let mut chart = Chart::new("175 kPa ≤ σ ≤ 200 kPa, protocol B", HEIGHT, PROFILE);
    for (color, (friction, _)) in data.by(MU.column, |_| true).into_iter().enumerate() {
        let Some(structure) = first(data, |row| is(row, MU.column, friction)) else {
            continue;
        };
        let late = |bin: &&StressBin| (bin.from - LATE).abs() < 1.0;
        let bin = structure.by_stress.height_profile.iter().find(late);
        let label = told(MU.symbol, friction);
        chart
            .curves
            .extend(bin.map(|bin| solid(label, color, profile(structure, bin))));
    }
    side_by_side([chart], 1)
}

/// Figure 16.
pub(super) fn over_stress_of_all(data: &Data) -> Drawing {
    let mut charts = vec![];
    for modulus in [10e6, 100e6] {
        for protocol in ["A", "B"] {
            let what = format!("E_p = {} MPa, protocol {protocol}", modulus * 1e-6);
            let letter = |k: usize| char::from(b'a' + (charts.len() + k) as u8);
            let mut left = Chart::new(&format!("({}) {what}", letter(0)), STRESS, NON_AFFINE);
            let mut right = Chart::new(&format!("({}) {what}", letter(1)), STRESS, FRACTION);
            let here =
                |row: &PointRow| is(row, "youngs_modulus", modulus) && is_protocol(row, protocol);
            for row in data.points.iter().filter(|row| here(row)) {
                add_beam(data, row, [&mut left, &mut right]);
            }
            charts.extend([left, right]);
        }
    }
    side_by_side(charts, 2)
}

fn add_beam(data: &Data, row: &PointRow, [left, right]: [&mut Chart; 2]) {
    let frictions = data.by(MU.column, |_| true);
    let Some(friction) = real(row, MU.column) else {
        return;
    };
    let place = frictions
        .iter()
        .position(|(value, _)| value.total_cmp(&friction).is_eq());
    let color = place.unwrap_or_default();
    let label = told(MU.symbol, friction);
    let again = right.curves.iter().any(|curve| curve.label == label);
    if let Some(history) = data.histories.get(&row.point) {
        let values: Vec<_> = history.volume_fraction.iter().copied().map(Some).collect();
        let mut curve = solid(label.clone(), color, over_stress(&history.stress, &values));
        curve.told = !again;
        right.curves.push(curve);
        right.verticals.extend(yields(row, &label, color));
    }
    if let Some(structure) = data.structures.get(&row.point) {
        let diameter = structure.mean_diameter.unwrap_or(1.0);
        let all = structure.changes.iter();
        let dots = all.filter_map(|change| {
            Some(Dot::new(
                change.stress * 1e-3,
                change.non_affine.all? / diameter,
            ))
        });
        let mut curve = solid(label.clone(), color, dots.collect());
        curve.told = !again;
        left.curves.push(curve);
        left.verticals.extend(yields(row, &label, color));
    }
}
