//! Non-affine motion D_min: how far neighbors stray from the best uniform strain between two moments, Eq. (5).
//!
//! With d_j the branch from grain i to its neighbor j before and d'_j after, X = Σ d'_j d_jᵀ and Y = Σ d_j d_jᵀ:
//! 1 + ε = X Y⁻¹, D² = (1/n) Σ |d'_j − (1 + ε) d_j|², D_min = √D² \[m\] (Falk and Langer 1998).
//! ε has nine entries, so that rotations are affine too.

use serde::{Deserialize, Serialize};

use super::cells::PointGrid;
use super::symmetric::{Eigen, Matrix, apply, outer, product, sum};
use super::{Packing, SnapshotError};
use crate::math::plain::{dot, sub};

/// Neighbors are centers nearer than this before, in d_p: some 13 of them. The paper says "vicinity".
pub const VICINITY: f64 = 1.5;

/// Grains with fewer contacts are left out, as in the paper.
const LEAST_CONTACTS: usize = 3;

/// Grains with fewer neighbors are left out: nine entries of ε would fit 3 of them exactly, whatever they do.
const LEAST_NEIGHBORS: usize = 6;

/// Grains whose Y has a larger condition number are left out: their neighbors lie nearly in a plane.
const LARGEST_CONDITION: f64 = 1e4;

/// D_min of each grain, and how many have none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NonAffine {
    /// D_min \[m\]; `None` for a grain left out.
    pub values: Vec<Option<f64>>,
    /// Why grains are left out.
    pub excluded: Excluded,
}

/// How many grains have no D_min, each counted under the first reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Excluded {
    /// Fewer than 3 contacts before.
    pub few_contacts: usize,
    /// Fewer than 6 neighbors.
    pub few_neighbors: usize,
    /// Neighbors nearly in a plane.
    pub flat: usize,
}

/// D_min of the motion between two snapshots of the same grains, neighbors nearer than `vicinity` d_p in the first.
///
/// [`VICINITY`] is the default; 1.25 and 2.0 tell how much it matters.
pub fn non_affine(
    before: &Packing<'_>,
    after: &Packing<'_>,
    vicinity: f64,
) -> Result<NonAffine, SnapshotError> {
    let (positions, moved) = (before.snapshot().positions, after.snapshot().positions);
    same_grains(before, after)?;
    let reach = vicinity * before.mean_diameter().unwrap_or(0.0);
    let grid = PointGrid::new(positions, reach);
    let mut excluded = Excluded::default();
    let mut branches = vec![];
    let values = before
        .contact_counts()
        .iter()
        .enumerate()
        .map(|(i, &contacts)| {
            if contacts < LEAST_CONTACTS {
                excluded.few_contacts += 1;
                return None;
            }
            branches.clear();
            grid.visit(positions[i], reach, |j, branch, _| {
                if i != j {
                    branches.push((branch, sub(moved[j], moved[i])));
                }
            });
            if branches.len() < LEAST_NEIGHBORS {
                excluded.few_neighbors += 1;
                return None;
            }
            let least = least_square(&branches);
            excluded.flat += usize::from(least.is_none());
            least.map(f64::sqrt)
        })
        .collect();
    Ok(NonAffine { values, excluded })
}

/// Whether two packings are of equally many grains.
pub(super) fn same_grains(before: &Packing<'_>, after: &Packing<'_>) -> Result<(), SnapshotError> {
    let [before, after] = [before, after].map(|packing| packing.snapshot().positions.len());
    if before == after {
        return Ok(());
    }
    Err(SnapshotError::Grains { before, after })
}

/// The least D² of pairs (d_j, d'_j); `None` if Y is nearly singular.
fn least_square(branches: &[([f64; 3], [f64; 3])]) -> Option<f64> {
    let products =
        |of: fn(&([f64; 3], [f64; 3])) -> Matrix| branches.iter().map(of).fold([[0.0; 3]; 3], sum);
    let eigen = Eigen::of(products(|(before, _)| outer(*before, *before)));
    let condition = eigen.condition_number();
    if !condition.is_finite() || condition > LARGEST_CONDITION {
        return None;
    }
    let inverse = eigen.inverse();
    let strain = product(products(|(before, after)| outer(*after, *before)), inverse);
    let left =
        |strain: Matrix, (before, after): ([f64; 3], [f64; 3])| sub(after, apply(strain, before));
    // Rounding of X Y⁻¹ grows with the condition number; what it leaves over is fitted once more.
    let rest = branches
        .iter()
        .map(|&pair| outer(left(strain, pair), pair.0))
        .fold([[0.0; 3]; 3], sum);
    let strain = sum(strain, product(rest, inverse));
    let squares = branches.iter().map(|&pair| {
        let left = left(strain, pair);
        dot(left, left)
    });
    Some(squares.sum::<f64>() / branches.len() as f64)
}

#[cfg(test)]
mod tests;
