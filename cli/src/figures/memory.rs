//! Figures of the memory paper that are sweeps: 4, 6, 8, 9, 11 to 14.
//!
//! E. Dwight and D. Candela, arXiv:2603.14595.

use std::collections::BTreeMap;

use granary_api::table::{PointRow, SetRow};
use granary_core::memory::score::{Dots, Processing};
use granary_core::memory::waveform::{SAMPLES, Waveform, sample_u};
use serde_json::Value;

use super::data::{Data, Recall};
use super::drawing::{Axis, Chart, Curve, Dot, Drawing, Panel, Style, told};
use crate::published::{self, Pack};

const U: Axis = Axis {
    symbol: "u",
    unit: "",
    column: "u",
};
const SIGNAL: Axis = Axis {
    symbol: "p_sig",
    unit: "Pa",
    column: "signal_pa",
};
const FIDELITY: Axis = Axis {
    symbol: "𝓕",
    unit: "",
    column: "fidelity",
};
const GAIN: Axis = Axis {
    symbol: "𝒢",
    unit: "",
    column: "gain",
};
const FRICTION: Axis = Axis {
    symbol: "μ",
    unit: "",
    column: "friction_coefficient",
};
const COMPRESSION: Axis = Axis {
    symbol: "δ0",
    unit: "",
    column: "delta0",
};
const OVERLAP: Axis = Axis {
    symbol: "𝒪 (1: spheres)",
    unit: "",
    column: "overlap",
};
const GRAINS: Axis = Axis {
    symbol: "N",
    unit: "",
    column: "grains",
};
const TIME: Axis = Axis {
    symbol: "ramps",
    unit: "",
    column: "ramps",
};
const FRACTION: Axis = Axis {
    symbol: "φ, Z/10",
    unit: "",
    column: "value",
};
const PRESSURE: Axis = Axis {
    symbol: "p",
    unit: "kPa",
    column: "pressure_kpa",
};
const SHEAR: Axis = Axis {
    symbol: "p_x − p_y",
    unit: "Pa",
    column: "shear_pa",
};
const BITS: Axis = Axis {
    symbol: "L",
    unit: "bits",
    column: "bits",
};
const SCORE: Axis = Axis {
    symbol: "𝓕, accuracy",
    unit: "",
    column: "value",
};

/// The waveform of a point.
fn waveform(row: &PointRow) -> Option<Waveform> {
    Waveform::parse(row.parameters.get("waveform")?).ok()
}

/// What two points of one trained pack have in common.
fn pack_of(row: &PointRow) -> String {
    let others = row
        .parameters
        .iter()
        .filter(|(name, _)| *name != "waveform");
    others
        .map(|(name, value)| format!("{name}={value}"))
        .collect::<Vec<_>>()
        .join(" ")
}

/// A recalled signal, and the J that it should be like.
struct Recalled<'a> {
    row: &'a PointRow,
    waveform: Waveform,
    signal: Vec<f64>,
}

impl Recalled<'_> {
    /// J at every sample.
    fn stored(&self) -> Vec<f64> {
        let curve = self.waveform.curve();
        (0..SAMPLES).map(|k| curve.integral(sample_u(k))).collect()
    }
}

/// The recalled signals of the first packing, but that of the zero waveform.
fn recalled(data: &Data, processing: Processing) -> Vec<Recalled<'_>> {
    let zeros: BTreeMap<String, u64> = data
        .points
        .iter()
        .filter(|row| waveform(row) == Some(Waveform::Zero))
        .map(|row| (pack_of(row), row.point))
        .collect();
    let seed = |row: &PointRow| row.parameters.get("packing_seed").and_then(Value::as_u64);
    let first = data.points.iter().filter_map(seed).min();
    let rows = data.points.iter().filter(|row| seed(row) == first);
    rows.filter_map(|row| {
        let waveform = waveform(row).filter(|waveform| *waveform != Waveform::Zero)?;
        let zero = zeros
            .get(&pack_of(row))
            .and_then(|zero| data.signals.get(zero));
        let signal = processing.apply(data.signals.get(&row.point)?, zero)?;
        Some(Recalled {
            row,
            waveform,
            signal,
        })
    })
    .collect()
}

/// 𝒢 E δ0 γ0 \[Pa\] of a set of signals, Eq. (20).
fn scale(set: &[&Recalled<'_>]) -> Option<f64> {
    let mut dots = Dots::default();
    for one in set {
        dots += Dots::of(&one.signal, &one.waveform.curve(), None);
    }
    (dots.j_j > 0.0).then(|| dots.j_p / dots.j_j)
}

fn over_u(label: &str, color: usize, style: Style, values: &[f64]) -> Curve {
    let dots = values.iter().enumerate();
    Curve {
        label: label.to_owned(),
        told: true,
        color,
        style,
        dots: dots.map(|(k, &y)| Dot::new(sample_u(k), y)).collect(),
    }
}

/// One panel for each signal of a set, all scaled by the set's own gain.
fn panels(set: &[&Recalled<'_>], title: impl Fn(&Recalled<'_>) -> String) -> Vec<Panel> {
    let Some(scale) = scale(set) else {
        return vec![];
    };
    let panel = |one: &&Recalled<'_>| {
        let mut chart = Chart::new(&title(one), U, SIGNAL);
        let stored: Vec<f64> = one.stored().iter().map(|j| scale * j).collect();
        chart
            .curves
            .push(over_u("recalled", 7, Style::Solid, &one.signal));
        chart
            .curves
            .push(over_u("𝒢 E δ0 γ0 J", 0, Style::Dashed, &stored));
        Panel::Chart(chart)
    };
    set.iter().map(panel).collect()
}

/// A number of a record at a sample of one of its series.
type OfRecord<'a> = &'a dyn Fn(&BTreeMap<String, Vec<f64>>, usize) -> Option<f64>;

/// A number over time; the hold, which is not recorded, is a gap of a fifth of a ramp.
fn over_time(
    (label, color, style): (&str, usize, Style),
    recall: Option<&Recall>,
    number: OfRecord<'_>,
) -> Curve {
    let mut dots = vec![];
    for (series, start, forward) in [("encode", 0.0, true), ("decode", 1.2, false)] {
        let Some(columns) = recall.and_then(|recall| recall.series.get(series)) else {
            continue;
        };
        for k in 0..SAMPLES {
            // Records go by u, down which time goes as the pack is released.
            let (k, time) = if forward {
                (k, sample_u(k))
            } else {
                (SAMPLES - 1 - k, sample_u(k))
            };
            dots.extend(number(columns, k).map(|y| Dot::new(start + time, y)));
        }
    }
    Curve {
        label: label.to_owned(),
        told: true,
        color,
        style,
        dots,
    }
}

/// Figure 4.
pub(super) fn pressures(data: &Data) -> Drawing {
    let of = |wanted: &Waveform| -> Option<&Recall> {
        let row = data
            .points
            .iter()
            .find(|row| waveform(row).as_ref() == Some(wanted))?;
        data.recalls.get(&row.point)
    };
    let (signal, zero) = (of(&Waveform::Six(5)), of(&Waveform::Zero));
    let column = |name: &'static str, scale: f64| {
        move |columns: &BTreeMap<String, Vec<f64>>, k: usize| {
            Some(columns.get(name)?.get(k)? * scale)
        }
    };
    let mut structure = Chart::new("(a)", TIME, FRACTION);
    structure.curves = vec![
        over_time(
            ("φ", 0, Style::Solid),
            signal,
            &column("volume_fraction", 1.0),
        ),
        over_time(
            ("Z/10", 1, Style::Solid),
            signal,
            &column("coordination_number", 0.1),
        ),
    ];
    let mut pressure = Chart::new("(b)", TIME, PRESSURE);
    let walls = [("p_x", 0), ("p_y", 1), ("p_z", 2)];
    pressure.curves = walls
        .into_iter()
        .map(|(name, color)| over_time((name, color, Style::Solid), signal, &column(name, 1e-3)))
        .collect();
    let shear = |columns: &BTreeMap<String, Vec<f64>>, k: usize| {
        Some(columns.get("p_x")?.get(k)? - columns.get("p_y")?.get(k)?)
    };
    let mut difference = Chart::new("(c)", TIME, SHEAR);
    difference.curves = vec![
        over_time(("signal 5", 7, Style::Solid), signal, &shear),
        over_time(("nothing", 0, Style::Dashed), zero, &shear),
    ];
    Drawing {
        panels: [structure, pressure, difference].map(Panel::Chart).into(),
        columns: 1,
    }
}

/// Figure 6.
pub(super) fn signals(data: &Data) -> Drawing {
    let all = recalled(data, Processing::Sub0);
    let set: Vec<&Recalled<'_>> = all.iter().collect();
    Drawing {
        panels: panels(&set, |one| one.waveform.to_string()),
        columns: 3,
    }
}

/// Figure 9.
pub(super) fn laws(data: &Data) -> Drawing {
    let all = recalled(data, Processing::Sub0);
    let law = |one: &Recalled<'_>| {
        let law = one.row.parameters.get("force_law").and_then(Value::as_str);
        law.unwrap_or_default().to_owned()
    };
    let mut drawn = vec![];
    for name in ["H", "M1", "M2"] {
        let set: Vec<&Recalled<'_>> = all.iter().filter(|one| law(one) == name).collect();
        drawn.extend(panels(&set, |one| format!("{name}, {}", one.waveform)));
    }
    Drawing {
        panels: drawn,
        columns: 6,
    }
}

/// Figure 13.
pub(super) fn words(data: &Data) -> Drawing {
    let all = recalled(data, Processing::Sub2Baseline);
    let mut drawn = vec![];
    for length in [3, 10] {
        let has = |one: &&Recalled<'_>| matches!(one.waveform, Waveform::BinaryWord { bits, .. } if bits == length);
        let set: Vec<&Recalled<'_>> = all.iter().filter(has).collect();
        drawn.extend(panels(&set, |one| match one.waveform {
            Waveform::BinaryWord { bits, word } => {
                format!("{word:0width$b}", width = usize::from(bits))
            }
            ref other => other.to_string(),
        }));
    }
    Drawing {
        panels: drawn,
        columns: 4,
    }
}

/// The means of a result over packings, by a parameter of the sets that are kept.
fn means(data: &Data, by: &str, result: &str, keep: impl Fn(&SetRow) -> bool) -> Vec<Dot> {
    let rows = data
        .sets
        .iter()
        .filter(|row| row.reduce == "mean_sem" && keep(row));
    let mut dots: Vec<Dot> = rows
        .filter_map(|row| {
            Some(Dot {
                x: row.parameters.get(by)?.as_f64()?,
                y: (*row.results.get(result)?)?,
                error: row.results.get(&format!("{result}_sem")).copied().flatten(),
            })
        })
        .collect();
    dots.sort_by(|a, b| a.x.total_cmp(&b.x));
    dots
}

fn ours(label: &str, color: usize, dots: Vec<Dot>) -> Curve {
    Curve {
        label: label.to_owned(),
        told: true,
        color,
        style: Style::Joined,
        dots,
    }
}

/// The means of the published packs that are kept, by a number of each.
fn theirs(
    by: impl Fn(&Pack) -> f64,
    of: impl Fn(&Pack) -> f64,
    keep: impl Fn(&Pack) -> bool,
) -> Curve {
    let mut groups: Vec<(f64, Vec<f64>)> = vec![];
    for pack in published::packs().filter(keep) {
        let (x, y) = (by(&pack), of(&pack));
        match groups
            .iter_mut()
            .find(|(known, _)| known.total_cmp(&x).is_eq())
        {
            Some((_, values)) => values.push(y),
            None => groups.push((x, vec![y])),
        }
    }
    groups.sort_by(|a, b| a.0.total_cmp(&b.0));
    let dots = groups.into_iter().map(|(x, values)| {
        let mean = published::Mean::of(&values);
        Dot {
            x,
            y: mean.mean,
            error: mean.sem,
        }
    });
    Curve {
        label: "published".to_owned(),
        told: true,
        color: 1,
        style: Style::Open,
        dots: dots.collect(),
    }
}

fn one_chart(x: Axis, y: Axis, curves: Vec<Curve>) -> Drawing {
    let mut chart = Chart::new("", x, y);
    chart.curves = curves;
    Drawing {
        panels: vec![Panel::Chart(chart)],
        columns: 1,
    }
}

/// The size of packs on which most of the paper's numbers are.
const PAPER_GRAINS: u64 = 10_240;

/// Figure 8.
pub(super) fn over_friction(data: &Data) -> Drawing {
    let own = means(data, "friction_coefficient", "fidelity", |_| true);
    let usual = |pack: &Pack| pack.is_tetrahedron(0.6) && pack.grains == PAPER_GRAINS;
    let published = theirs(|pack| pack.friction, |pack| pack.fidelity, usual);
    one_chart(
        FRICTION,
        FIDELITY,
        vec![ours("computed", 0, own), published],
    )
}

/// The inset of Figure 11.
pub(super) fn over_shape(data: &Data) -> Drawing {
    let own = means(data, "overlap", "fidelity", |_| true);
    let usual = |pack: &Pack| pack.friction.total_cmp(&1.0).is_eq() && pack.grains == PAPER_GRAINS;
    let published = theirs(|pack| pack.overlap, |pack| pack.fidelity, usual);
    one_chart(OVERLAP, FIDELITY, vec![ours("computed", 0, own), published])
}

fn over_compression(data: &Data, result: &str, axis: Axis) -> Drawing {
    let gamma = |row: &SetRow| row.parameters.get("gamma0").and_then(Value::as_f64);
    let mut gammas: Vec<f64> = data.sets.iter().filter_map(gamma).collect();
    gammas.sort_by(f64::total_cmp);
    gammas.dedup();
    let curve = |(color, value): (usize, &f64)| {
        let here = |row: &SetRow| gamma(row).is_some_and(|found| found.total_cmp(value).is_eq());
        ours(
            &told("γ0", *value),
            color,
            means(data, "delta0", result, here),
        )
    };
    one_chart(
        COMPRESSION,
        axis,
        gammas.iter().enumerate().map(curve).collect(),
    )
}

/// Figure 11.
pub(super) fn fidelity_over_compression(data: &Data) -> Drawing {
    over_compression(data, "fidelity", FIDELITY)
}

/// Figure 12 (a).
pub(super) fn gain_over_compression(data: &Data) -> Drawing {
    over_compression(data, "gain", GAIN)
}

/// Figure 12 (b).
pub(super) fn over_size(data: &Data) -> Drawing {
    let own = means(data, "grains", "gain", |_| true);
    let usual = |pack: &Pack| pack.is_tetrahedron(0.6) && pack.friction.total_cmp(&1.0).is_eq();
    let published = theirs(|pack| pack.grains as f64, |pack| pack.gain, usual);
    let mut drawing = one_chart(GRAINS, GAIN, vec![ours("computed", 0, own), published]);
    if let [Panel::Chart(chart)] = drawing.panels.as_mut_slice() {
        chart.logarithmic = true;
    }
    drawing
}

/// Figure 14.
pub(super) fn over_words(data: &Data) -> Drawing {
    let curve = |(color, processing): (usize, &str)| {
        let here = |row: &SetRow| row.processing.as_deref() == Some(processing);
        ours(
            &format!("𝓕, {processing}"),
            color,
            means(data, "bits", "fidelity", here),
        )
    };
    let mut curves: Vec<Curve> = ["SUB0", "SUB2", "SUB2-BL"]
        .into_iter()
        .enumerate()
        .map(curve)
        .collect();
    let recognized = means(data, "bits", "recognition_accuracy", |_| true);
    curves.push(ours("recognized, SUB2-BL", 3, recognized));
    one_chart(BITS, SCORE, curves)
}
