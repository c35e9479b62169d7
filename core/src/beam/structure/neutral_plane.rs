//! The neutral plane: where along the beam's height the motion toward its center turns into motion away from it.

use serde::{Deserialize, Serialize};

use super::Packing;
use super::displacement::Field;
use super::faces::Faces;

/// Width of the slabs along x in d_p.
const SLAB: f64 = 2.0;

/// The neutral plane in one slab.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NeutralPoint {
    /// x of the slab's middle \[m\].
    pub x: f64,
    /// z where the x-component is zero \[m\]; `None` where all of the slab moves one way.
    ///
    /// Of several the one nearest to the beam's middle. Near its center the component means little: there x − x_c is zero.
    pub z: Option<f64>,
    /// h' \[m\]: how far that is above the middle of the faces.
    pub height: Option<f64>,
}

/// The neutral plane of `field`, in slabs of 2 d_p along the beam; empty without grains.
#[must_use]
pub fn neutral_plane(packing: &Packing<'_>, field: &Field) -> Vec<NeutralPoint> {
    let (Some(diameter), Some(faces)) = (packing.mean_diameter(), Faces::of(packing)) else {
        return vec![];
    };
    let nodes = ((SLAB * diameter / field.spacing[0]).round() as usize).max(1);
    (0..field.count[0])
        .step_by(nodes)
        .map(|first| {
            let last = (first + nodes).min(field.count[0]) - 1;
            let x = 0.5 * (field.coordinate(0, first) + field.coordinate(0, last));
            let middle = faces.middle(x);
            let nearest = zeros(field, first, last)
                .into_iter()
                .min_by(|a, b| (a - middle).abs().total_cmp(&(b - middle).abs()));
            NeutralPoint {
                x,
                z: nearest,
                height: nearest.map(|z| z - middle),
            }
        })
        .collect()
}

/// The heights where the x-component, averaged over a slab and its depth, crosses zero.
fn zeros(field: &Field, first: usize, last: usize) -> Vec<f64> {
    let level = |k: usize| {
        let nodes = (0..field.count[1]).flat_map(|j| (first..=last).map(move |i| [i, j, k]));
        let values = nodes.filter_map(|node| field.at(node));
        let mean = super::mean(values.map(|value| value[0]))?;
        Some((field.coordinate(2, k), mean))
    };
    let levels: Vec<(f64, f64)> = (0..field.count[2]).filter_map(level).collect();
    let pairs = levels.windows(2);
    let crossing = |pair: &[(f64, f64)]| {
        let ((low, below), (high, above)) = (pair[0], pair[1]);
        ((below > 0.0) != (above > 0.0)).then(|| low + (high - low) * below / (below - above))
    };
    pairs.filter_map(crossing).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::structure::displacement::displacement_field;
    use crate::beam::structure::fixture::{Beam, bent};

    const SIZE: [usize; 3] = [40, 6, 8];

    /// A beam that is bent by a small angle about the height `neutral`.
    fn bending(neutral: f64) -> (Beam, Beam) {
        let after = Beam::cubic_lattice(SIZE, 1.0);
        let before = after.moved(|at| {
            let push = 1e-3 * (at[0] - 20.0) * (at[2] - neutral);
            [at[0] + push, at[1], at[2]]
        });
        (before, after)
    }

    #[test]
    fn the_neutral_plane_of_pure_bending_is_found_where_it_is() {
        for neutral in [3.0, 4.0, 5.4] {
            let (before, after) = bending(neutral);
            let (before, after) = (before.packing(), after.packing());
            let field = displacement_field(&before, &after).expect("the same grains");
            let found = neutral_plane(&after, &field.expect("grains"));
            assert_eq!(found.len(), 20);
            for point in found.iter().filter(|point| (point.x - 20.0).abs() > 4.0) {
                // Smoothing leaves straight lines where they are, but for the membrane 3 d_p away, and 1/|r − x_c|.
                let z = point.z.expect("both ways");
                assert!((z - neutral).abs() < 0.1, "{point:?}");
                assert!((point.height.expect("known") - z + 4.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_beam_that_only_shrinks_has_no_neutral_plane() {
        let after = Beam::cubic_lattice(SIZE, 1.0);
        let before = after.moved(|at| [1.01 * at[0] - 0.2, at[1], at[2]]);
        let (before, after) = (before.packing(), after.packing());
        let field = displacement_field(&before, &after).expect("the same grains");
        for point in neutral_plane(&after, &field.expect("grains")) {
            assert!(
                point.z.is_none() || (point.x - 20.0).abs() < 2.0,
                "{point:?}"
            );
        }
    }

    #[test]
    fn the_neutral_plane_of_a_bent_beam_follows_it() {
        // Bent further by 1 %, about its middle.
        let straight = Beam::cubic_lattice(SIZE, 1.0);
        let at_angle = |angle: f64| straight.moved(|at| bent(at, 40.0, 8.0, angle));
        let (before, after) = (at_angle(0.5), at_angle(0.505));
        let (before, after) = (before.packing(), after.packing());
        let field = displacement_field(&before, &after).expect("the same grains");
        let found = neutral_plane(&after, &field.expect("grains"));
        for point in found
            .iter()
            .filter(|point| (3.0..12.0).contains(&point.x.abs()))
        {
            // Along the arc s with curvature κ, sin(κs)/κ − h's moves by −(κs²/3 + h') s dκ.
            let expected = -0.5 / 40.0 * point.x * point.x / 3.0;
            let height = point.height.expect("both ways");
            assert!((height - expected).abs() < 0.2, "{point:?} {expected}");
        }
    }
}
