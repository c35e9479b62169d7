//! Motion toward or away from the beam's center, smoothed to a field, Eq. (C1).

use serde::{Deserialize, Serialize};

use super::faces::Faces;
use super::non_affine::same_grains;
use super::{Packing, SnapshotError};
use crate::math::plain::{add, dot, norm, scale, sub};

/// Width w of the Gaussian W = exp(−r²/2w²) in d_p.
const WIDTH: f64 = 1.0;

/// Where W is cut off, in w.
const CUT: f64 = 3.0;

/// Nodes with less than this part of the ΣW of the whole beam's density have no value.
const LEAST_WEIGHT: f64 = 0.05;

/// Grains of the bulk this near to the center, in d_p, say how the beam moves as a whole.
const NEAR: f64 = 2.0;

/// Nodes for one d_p, along each axis.
const NODES_PER_DIAMETER: f64 = 1.0;

/// Displacement \[m\] relative to the center of the beam, at the nodes of a grid.
///
/// The components are kept apart; negative is toward the center, positive away from it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Field {
    /// The first node \[m\].
    pub low: [f64; 3],
    /// Distance of neighboring nodes along each axis \[m\].
    pub spacing: [f64; 3],
    /// Number of nodes along each axis.
    pub count: [usize; 3],
    /// Node (i, j, k) stands at (k n_y + j) n_x + i; `None` where there are too few grains.
    pub values: Vec<Option<[f64; 3]>>,
}

impl Field {
    /// The value at node (i, j, k).
    #[must_use]
    pub fn at(&self, [i, j, k]: [usize; 3]) -> Option<[f64; 3]> {
        self.values[(k * self.count[1] + j) * self.count[0] + i]
    }

    /// The mean over the depth: one layer of nodes in the middle, each of those that have a value.
    #[must_use]
    pub fn averaged_over_depth(&self) -> Self {
        let [nx, ny, nz] = self.count;
        let mean = |i: usize, k: usize| {
            let values: Vec<[f64; 3]> = (0..ny).filter_map(|j| self.at([i, j, k])).collect();
            let sum = values.iter().fold([0.0; 3], |sum, value| add(sum, *value));
            (!values.is_empty()).then(|| scale(sum, 1.0 / values.len() as f64))
        };
        let middle = 0.5 * (self.coordinate(1, 0) + self.coordinate(1, ny - 1));
        let nodes = (0..nz).flat_map(|k| (0..nx).map(move |i| (i, k)));
        Self {
            low: [self.low[0], middle, self.low[2]],
            spacing: [
                self.spacing[0],
                self.spacing[1] * ny as f64,
                self.spacing[2],
            ],
            count: [nx, 1, nz],
            values: nodes.map(|(i, k)| mean(i, k)).collect(),
        }
    }

    /// Where along `axis` the node number `k` stands \[m\].
    #[must_use]
    pub fn coordinate(&self, axis: usize, k: usize) -> f64 {
        self.low[axis] + self.spacing[axis] * k as f64
    }
}

/// x_c \[m\]: the middle of the membrane's extent in x and y, and of its faces in z there.
///
/// The paper says "half way between the extremities in x and y".
#[must_use]
pub fn center(packing: &Packing<'_>, faces: &Faces) -> [f64; 3] {
    let [low, high] = packing.membrane().bounds();
    let x = 0.5 * (low[0] + high[0]);
    [x, 0.5 * (low[1] + high[1]), faces.middle(x)]
}

/// Δr_i = [r_i(after) − r_i(before)] ⊙ (r_i − x_c)/|r_i − x_c| \[m\], element by element, r_i and x_c after.
///
/// From the displacements the mean of the bulk grains within 2 d_p of x_c is subtracted, if there are any.
fn relative_displacements(
    before: &Packing<'_>,
    after: &Packing<'_>,
    faces: &Faces,
) -> Vec<[f64; 3]> {
    let (old, new) = (before.snapshot().positions, after.snapshot().positions);
    let center = center(after, faces);
    let near = NEAR * after.mean_diameter().unwrap_or(0.0);
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for (i, &position) in new.iter().enumerate() {
        if after.bulk()[i] && norm(sub(position, center)) <= near {
            sum = add(sum, sub(position, old[i]));
            count += 1.0;
        }
    }
    let whole = if count > 0.0 {
        scale(sum, 1.0 / count)
    } else {
        sum
    };
    new.iter()
        .zip(old)
        .map(|(&new, &old)| {
            let (arm, moved) = (sub(new, center), sub(sub(new, old), whole));
            let distance = norm(arm);
            if distance > 0.0 {
                std::array::from_fn(|k| moved[k] * arm[k] / distance)
            } else {
                [0.0; 3]
            }
        })
        .collect()
}

/// Δr(r) = Σ_i Δr_i W(|r − r_i|)/Σ_i W, on nodes 1 d_p apart throughout the membrane's box; `None` without grains.
pub fn displacement_field(
    before: &Packing<'_>,
    after: &Packing<'_>,
) -> Result<Option<Field>, SnapshotError> {
    same_grains(before, after)?;
    let (Some(diameter), Some(faces)) = (after.mean_diameter(), Faces::of(after)) else {
        return Ok(None);
    };
    let mut field = nodes(after, diameter);
    let width = WIDTH * diameter;
    let mut sums = vec![(0.0, [0.0; 3]); field.values.len()];
    let displacements = relative_displacements(before, after, &faces);
    for (&position, displacement) in after.snapshot().positions.iter().zip(displacements) {
        spread(&field, position, width, |node, weight| {
            sums[node].0 += weight;
            sums[node].1 = add(sums[node].1, scale(displacement, weight));
        });
    }
    // ∫W = (2π)^{3/2} w³ times the number density.
    let density = after.snapshot().positions.len() as f64 / after.membrane().volume();
    let turn = 2.0 * std::f64::consts::PI;
    let least = LEAST_WEIGHT * density * turn * turn.sqrt() * width * width * width;
    let value = |(weight, sum): (f64, [f64; 3])| (weight > least).then(|| scale(sum, 1.0 / weight));
    field.values = sums.into_iter().map(value).collect();
    Ok(Some(field))
}

/// The grid without values: its outermost nodes stand half a spacing inside the membrane's box.
fn nodes(packing: &Packing<'_>, diameter: f64) -> Field {
    let [low, high] = packing.membrane().bounds();
    let most = 4.0 * packing.membrane().volume() / (diameter * diameter * diameter) + 1e6;
    let mut per_diameter = NODES_PER_DIAMETER;
    loop {
        let wanted = |k: usize| {
            ((high[k] - low[k]) * per_diameter / diameter)
                .ceil()
                .max(1.0)
        };
        // A box much larger than its grains gets a coarser grid.
        if (0..3).map(wanted).product::<f64>() > most {
            per_diameter *= 0.5;
            continue;
        }
        let count = [0, 1, 2].map(|k| wanted(k) as usize);
        let spacing = std::array::from_fn(|k| (high[k] - low[k]) / count[k] as f64);
        return Field {
            low: add(low, scale(spacing, 0.5)),
            spacing,
            count,
            values: vec![None; count.iter().product()],
        };
    }
}

/// Calls `visit` with each node within the cut of `position`, and its W.
fn spread(field: &Field, position: [f64; 3], width: f64, mut visit: impl FnMut(usize, f64)) {
    let reach = CUT * width;
    let range = |axis: usize| {
        let place = (position[axis] - field.low[axis]) / field.spacing[axis];
        let far = reach / field.spacing[axis];
        let end = (place + far).floor() + 1.0;
        ((place - far).ceil().max(0.0) as usize)..(end.max(0.0) as usize).min(field.count[axis])
    };
    for k in range(2) {
        for j in range(1) {
            for i in range(0) {
                let node = [i, j, k];
                let at = std::array::from_fn(|axis| field.coordinate(axis, node[axis]));
                let arm = sub(at, position);
                let square = dot(arm, arm);
                if square <= reach * reach {
                    let weight = libm::exp(-0.5 * square / (width * width));
                    visit((k * field.count[1] + j) * field.count[0] + i, weight);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
