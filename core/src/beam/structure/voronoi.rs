//! Local volume fraction: φ_i = V_i/V_cell, with the radical Voronoi cell of each grain closed by the membrane.
//!
//! The cell of grain i holds the points inside the membrane whose power |x − r_i|² − R_i² is least for i.
//! Without a membrane it is a convex polyhedron: a cube cut by the radical planes of the grains around, nearest first.
//! What of it lies outside is subtracted exactly, however the membrane is bent or wrinkled.
//! Seen from a point o of the cell, each triangle T casts a shadow: the points x whose segment o–x it crosses.
//! A convex cell holds every such segment, so V_i = w(o) V − Σ_T s_T V(cell ∩ shadow of T), with w the winding number and s_T = 1 where the segment leaves the membrane, −1 where it enters.
//! The cells so divide the membrane's volume without a gap: their sum is its volume to rounding.

use super::membrane::Membrane;
use super::{Packing, ball_volume};

mod shadow;
mod unbounded;

use shadow::Clipper;
use unbounded::Cutter;

/// Half the side of the cube that cells are cut from at first, in d_p: larger cells are rare in a jammed packing.
const FIRST_REACH: f64 = 1.0;

/// If less than this part of the membrane's volume is in no cell, no cell was too large for its cube.
const ROUNDING: f64 = 1e-9;

/// Volumes of the cells inside the membrane \[m³\].
///
/// Of grains with the same center only the largest has a cell, or the first of equals.
#[must_use]
pub fn cell_volumes(packing: &Packing<'_>) -> Vec<f64> {
    let positions = packing.snapshot().positions;
    let mut volumes = vec![0.0; positions.len()];
    let Some(diameter) = packing.mean_diameter() else {
        return volumes;
    };
    let largest = extent(packing.membrane(), positions);
    let mut reach = FIRST_REACH * diameter;
    let mut cutter = Cutter::new(packing.snapshot(), diameter);
    let mut clipper = Clipper::new(packing.membrane());
    let mut bounded = vec![false; volumes.len()];
    let mut next: Vec<usize> = (0..volumes.len()).collect();
    loop {
        next.retain(|&i| {
            let cell = cutter.cell(i, reach);
            volumes[i] = clipper.volume_inside(cell, positions[i]);
            bounded[i] = !cell.has_outer_face();
            !bounded[i] && clipper.is_inside_at_cube(cell, reach, positions[i])
        });
        let missing = packing.membrane().volume() - volumes.iter().sum::<f64>();
        if missing.abs() <= ROUNDING * packing.membrane().volume() || reach > largest {
            return volumes;
        }
        // What no cell reaches from inside belongs to a grain that stands outside or beyond a fold.
        if next.is_empty() {
            next = (0..volumes.len()).filter(|&i| !bounded[i]).collect();
        }
        reach *= 2.0;
    }
}

/// The side of a cube that holds the membrane and all grains, wherever in it its middle is put.
fn extent(membrane: &Membrane<'_>, positions: &[[f64; 3]]) -> f64 {
    let points = membrane
        .bounds()
        .into_iter()
        .chain(positions.iter().copied());
    let [low, high] = super::cells::bounds(points).expect("the membrane has bounds");
    (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max)
}

/// φ_i of each grain; `None` for a grain that has no cell inside the membrane.
///
/// Overlaps are not subtracted, so soft grains reach more than 0.75.
#[must_use]
pub fn local_volume_fractions(packing: &Packing<'_>) -> Vec<Option<f64>> {
    let volumes = cell_volumes(packing);
    let diameter = packing.mean_diameter().unwrap_or(0.0);
    let least = ROUNDING * ball_volume(diameter);
    let fraction =
        |(&radius, &volume): (&f64, &f64)| (volume > least).then(|| ball_volume(radius) / volume);
    let radii = packing.snapshot().radii.iter();
    radii.zip(&volumes).map(fraction).collect()
}

/// Δφ_i = φ_i(after) − φ_i(before) of each grain that has both.
#[must_use]
pub fn changes(before: &[Option<f64>], after: &[Option<f64>]) -> Vec<Option<f64>> {
    let pairs = before.iter().zip(after);
    pairs
        .map(|(before, after)| Some((*after)? - (*before)?))
        .collect()
}

#[cfg(test)]
mod tests;
