//! Figures along the stress–strain curve: 5 and 9, and the volume fraction of 16.

use granary_api::table::PointRow;

use super::beams::MU;
use super::data::{Data, History, real, result};
use super::drawing::{Axis, Chart, Curve, Dot, Drawing, Panel, Style, Vertical, told};

pub(super) const STRESS: Axis = Axis {
    symbol: "σ",
    unit: "kPa",
    column: "stress_kpa",
};
const STRAIN: Axis = Axis {
    symbol: "ε",
    unit: "",
    column: "strain",
};
/// Samples that are averaged to one dot of a curve over stress: contacts come and go from one to the next.
const SMOOTHED: usize = 10;

fn axis(symbol: &'static str, unit: &'static str, column: &'static str) -> Axis {
    Axis {
        symbol,
        unit,
        column,
    }
}

/// Figure 5.
pub(super) fn stress_strain(data: &Data) -> Drawing {
    let mut chart = Chart::new("", STRAIN, STRESS);
    let mut inset = Chart::new("cyclic, to ε = 0.002", STRAIN, STRESS);
    for row in &data.points {
        let Some(history) = data.histories.get(&row.point) else {
            continue;
        };
        let cyclic = real(row, "cycles").is_some_and(|cycles| cycles > 0.0);
        let of = if cyclic { &mut inset } else { &mut chart };
        if !of.curves.is_empty() {
            continue;
        }
        let count = if cyclic {
            cycles_of(history)
        } else {
            usize::MAX
        };
        let dots = history.strain.iter().zip(&history.stress).take(count);
        let dots = dots.map(|(strain, stress)| Dot::new(*strain, stress * 1e-3));
        of.curves.push(Curve {
            label: if cyclic { "cyclic" } else { "bending" }.to_owned(),
            told: !cyclic,
            color: 0,
            style: Style::Solid,
            dots: dots.collect(),
        });
        if !cyclic {
            chart.curves.extend(found(row, history));
        }
    }
    if !inset.curves.is_empty() {
        chart.inset = Some(Box::new(inset));
    }
    Drawing {
        panels: vec![Panel::Chart(chart)],
        columns: 1,
    }
}

/// Samples of the cycles, and of the last loading as far as they went.
fn cycles_of(history: &History) -> usize {
    let up = history
        .rod_travel
        .windows(2)
        .rposition(|way| way[1] < way[0]);
    let turned = up.map_or(0, |up| up + 1).min(history.strain.len());
    let (cycles, last) = history.strain.split_at(turned);
    let most = cycles.iter().copied().fold(0.0, f64::max);
    turned + last.iter().take_while(|strain| **strain <= most).count()
}

/// The lines that E_b and Y_b are.
fn found(row: &PointRow, history: &History) -> Vec<Curve> {
    let end = history.strain.iter().copied().fold(0.0, f64::max);
    let most = history.stress.iter().copied().fold(0.0, f64::max);
    let mut curves = vec![];
    if let Some(slope) = result(row, "beam_stiffness").filter(|slope| *slope > 0.0) {
        let intercept = result(row, "beam_stiffness_intercept").unwrap_or_default();
        let until = ((most - intercept) / slope).min(end);
        let at = |strain: f64| Dot::new(strain, (slope * strain + intercept) * 1e-3);
        curves.push(Curve {
            label: "E_b".to_owned(),
            told: true,
            color: 1,
            style: Style::Dashed,
            dots: vec![at(0.0), at(until)],
        });
    }
    if let Some(strength) = result(row, "ultimate_strength") {
        let ends = [0.0, end].map(|strain| Dot::new(strain, strength * 1e-3));
        curves.push(Curve {
            label: "Y_b".to_owned(),
            told: true,
            color: 7,
            style: Style::Dotted,
            dots: ends.to_vec(),
        });
    }
    curves
}

/// Figure 9.
pub(super) fn forces(data: &Data) -> Drawing {
    let forces = axis("⟨F⟩", "N", "mean_contact_force_n");
    let normal = axis("⟨F_n⟩", "N", "mean_normal_force_n");
    let tangential = axis("⟨F_t⟩", "N", "mean_tangential_force_n");
    let limit = axis("fraction at the Coulomb limit", "", "coulomb_fraction");
    let mut charts = [
        Chart::new("(a) E_p = 100 MPa, protocol B", STRESS, forces),
        Chart::new("(b), left axis", STRESS, normal),
        Chart::new("(b), right axis", STRESS, tangential),
        Chart::new("(c)", STRESS, limit),
    ];
    for (color, (friction, rows)) in data.by(MU.column, |_| true).into_iter().enumerate() {
        for (k, row) in rows.into_iter().enumerate() {
            let Some(history) = data.histories.get(&row.point) else {
                continue;
            };
            let known = |values: &[f64]| values.iter().copied().map(Some).collect::<Vec<_>>();
            let label = told(MU.symbol, friction);
            let forces = [
                known(&history.mean_contact_force),
                known(&history.mean_normal_force),
                known(&history.mean_tangential_force),
                history.coulomb_fraction.clone(),
            ];
            for (chart, values) in charts.iter_mut().zip(forces) {
                chart.curves.push(Curve {
                    label: label.clone(),
                    told: k == 0,
                    color,
                    style: Style::Solid,
                    dots: over_stress(&history.stress, &values),
                });
                chart.verticals.extend(yields(row, &label, color));
            }
        }
    }
    Drawing {
        panels: charts.map(Panel::Chart).to_vec(),
        columns: 2,
    }
}

/// The vertical line at σ = Y_b.
pub(super) fn yields(row: &PointRow, label: &str, color: usize) -> Option<Vertical> {
    result(row, "ultimate_strength").map(|strength| Vertical {
        label: format!("Y_b, {label}"),
        at: strength * 1e-3,
        color,
    })
}

/// `values` over stress \[kPa\], a few samples averaged to one dot.
pub(super) fn over_stress(stress: &[f64], values: &[Option<f64>]) -> Vec<Dot> {
    let pairs: Vec<[f64; 2]> = stress
        .iter()
        .zip(values)
        .filter_map(|(stress, value)| Some([stress * 1e-3, (*value)?]))
        .collect();
    let mean = |some: &[[f64; 2]]| {
        let sum = |k: usize| some.iter().map(|pair| pair[k]).sum::<f64>() / some.len() as f64;
        Dot::new(sum(0), sum(1))
    };
    pairs.chunks(SMOOTHED).map(mean).collect()
}
