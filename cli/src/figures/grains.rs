//! Figures of single grains: 11 and 13, from the snapshots of a beam.

use std::collections::BTreeMap;

use anyhow::Context;

use super::data::{Data, Structure};
use super::drawing::{Axis, Chart, Curve, Disk, Disks, Dot, Drawing, Panel, Style, Vertical};
use super::inside::{EARLY_AND_LATE, LENGTH, UPWARD};

const NON_AFFINE: Axis = Axis {
    symbol: "D_min / d_mean",
    unit: "",
    column: "non_affine_d",
};
const DENSER: Axis = Axis {
    symbol: "Δφ",
    unit: "",
    column: "volume_fraction_change",
};

/// A grain in one snapshot; SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Grain {
    pub(crate) position: [f64; 3],
    pub(crate) radius: f64,
    /// Since the snapshot before; none of the first, and of grains with too few neighbors.
    pub(crate) non_affine: Option<f64>,
    pub(crate) volume_fraction: Option<f64>,
}

/// Reads the snapshots of a LAMMPS text dump that names D_min and φ.
pub(crate) fn read(bytes: &[u8]) -> anyhow::Result<Vec<Vec<Grain>>> {
    let text = std::str::from_utf8(bytes).context("a dump of grains is no text")?;
    let mut frames = vec![];
    let mut columns = BTreeMap::new();
    let mut reading = false;
    for line in text.lines() {
        if let Some(names) = line.strip_prefix("ITEM: ATOMS ") {
            columns = names.split_whitespace().zip(0..).collect();
            frames.push(vec![]);
            reading = true;
        } else if line.starts_with("ITEM: ") {
            reading = false;
        } else if reading && let Some(frame) = frames.last_mut() {
            let grain = grain(line, &columns);
            frame.push(grain.with_context(|| format!("a dump of grains has the line `{line}`"))?);
        }
    }
    Ok(frames)
}

fn grain(line: &str, columns: &BTreeMap<&str, usize>) -> Option<Grain> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let number = |name: &str| words.get(*columns.get(name)?)?.parse::<f64>().ok();
    let finite = |name: &str| number(name).filter(|value| value.is_finite());
    Some(Grain {
        position: [number("x")?, number("y")?, number("z")?],
        radius: number("radius")?,
        non_affine: finite("d_min"),
        volume_fraction: finite("phi"),
    })
}

/// Two snapshots, one after the other.
struct Pair<'a> {
    before: &'a [Grain],
    after: &'a [Grain],
    /// Half way between them \[Pa\].
    stress: f64,
    /// d_mean \[m\].
    diameter: f64,
}

/// The snapshots of the first beam, nearest to a stress.
fn at(data: &Data, stress: f64) -> Option<Pair<'_>> {
    let (point, frames) = data.grains.first_key_value()?;
    let structure: &Structure = data.structures.get(point)?;
    let distance = |k: &usize| (structure.changes[*k].stress - stress).abs();
    let count = structure.changes.len().min(frames.len().saturating_sub(1));
    let k = (0..count).min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    Some(Pair {
        before: &frames[k],
        after: &frames[k + 1],
        stress: structure.changes[k].stress,
        diameter: structure.mean_diameter?,
    })
}

/// Figure 11: a cut through the middle of the beam, two grains thick.
pub(super) fn non_affine(data: &Data) -> Drawing {
    let mut panels = vec![];
    for (k, stress) in EARLY_AND_LATE.into_iter().enumerate() {
        let Some(pair) = at(data, stress) else {
            continue;
        };
        let cut = pair
            .after
            .iter()
            .filter(|grain| grain.position[1].abs() <= pair.diameter);
        let mut disks: Vec<(f64, Disk)> = cut
            .map(|grain| {
                let [x, y, z] = grain.position;
                let disk = Disk {
                    x: 1e3 * x,
                    y: 1e3 * z,
                    radius: 1e3 * grain.radius,
                    value: grain.non_affine.map(|d| d / pair.diameter),
                };
                (y, disk)
            })
            .collect();
        // Seen from the front: what is behind is drawn first.
        disks.sort_by(|a, b| b.0.total_cmp(&a.0));
        panels.push(Panel::Disks(Disks {
            title: format!("({}) σ = {:.0} kPa", letter(k), 1e-3 * pair.stress),
            x: LENGTH,
            y: UPWARD,
            value: NON_AFFINE,
            all: disks.into_iter().map(|(_, disk)| disk).collect(),
        }));
    }
    Drawing { panels, columns: 1 }
}

/// Figure 13.
pub(super) fn non_affine_over_change(data: &Data) -> Drawing {
    let mut panels = vec![];
    for stress in EARLY_AND_LATE {
        let Some(pair) = at(data, stress) else {
            continue;
        };
        let tops = is_top(pair.after, pair.diameter);
        for (top, part) in [(true, "top"), (false, "bottom")] {
            let grains = pair.before.iter().zip(pair.after).zip(&tops);
            let dots: Vec<Dot> = grains
                .filter(|(_, is_top)| **is_top == top)
                .filter_map(|((before, after), _)| {
                    let change = after.volume_fraction? - before.volume_fraction?;
                    Some(Dot::new(change, after.non_affine? / pair.diameter))
                })
                .collect();
            let title = format!(
                "({}) {part} part, σ = {:.0} kPa",
                letter(panels.len()),
                1e-3 * pair.stress
            );
            let mut chart = Chart::new(&title, DENSER, NON_AFFINE);
            let mean = dots.iter().map(|dot| dot.x).sum::<f64>() / dots.len() as f64;
            chart.verticals.extend((!dots.is_empty()).then(|| Vertical {
                label: "⟨Δφ⟩".to_owned(),
                at: mean,
                color: 1,
            }));
            chart.curves.push(Curve {
                label: "grains".to_owned(),
                told: false,
                color: 0,
                style: Style::Cloud,
                dots,
            });
            panels.push(Panel::Chart(chart));
        }
    }
    Drawing { panels, columns: 2 }
}

fn letter(k: usize) -> char {
    char::from(b'a' + k as u8)
}

/// Which grains are nearer to the top of the beam than to its bottom, by the surfaces of grains within a diameter along x.
fn is_top(grains: &[Grain], diameter: f64) -> Vec<bool> {
    let of = |grain: &Grain| {
        let near = grains
            .iter()
            .filter(|other| (other.position[0] - grain.position[0]).abs() <= diameter);
        let ends = near.map(|other| {
            [
                other.position[2] - other.radius,
                other.position[2] + other.radius,
            ]
        });
        let [low, high] = ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [a, b]| {
            [low.min(a), high.max(b)]
        });
        grain.position[2] > 0.5 * (low + high)
    };
    grains.iter().map(of).collect()
}
