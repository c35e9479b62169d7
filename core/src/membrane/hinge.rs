//! Hinges between neighboring triangles: an optional resistance to folding.
//!
//! A hinge joins the corners 0 and 1 of an edge that triangle A, with corner 2 opposite, runs from 0 to 1, and triangle B, with
//! corner 3 opposite, from 1 to 0. Its angle θ, in (−π, π], is that from n̂_A to n̂_B about the edge: zero where flat,
//! positive where the edge stands out to the side of the normals.
//! It stores U = ½ k_θ (θ − θ₀)² and pulls at every corner with F = −[k_θ (θ − θ₀) + c_θ dθ/dt] ∂θ/∂x.
//!
//! Source: Bridson, Marino & Fedkiw, Simulation of clothing with folds and wrinkles (2003), for ∂θ/∂x.

use std::f64::consts::PI;

use super::Bending;
use super::mesh::{Mesh, unit};
use crate::math::plain;

/// The hinges of a sheet; no hinges if it does not resist folding.
#[derive(Clone, Debug, PartialEq, Default)]
pub(super) struct Hinges {
    corners: Vec<[u32; 4]>,
    /// θ₀.
    rest_angles: Vec<f64>,
    bending: Bending,
}

/// ∂θ/∂x at the four corners of a hinge \[1/m\], and θ.
pub(super) struct Fold {
    pub(super) gradients: [[f64; 3]; 4],
    angle: f64,
}

impl Hinges {
    /// A hinge for every edge of `mesh` with two triangles, at rest; none without `bending`.
    pub(super) fn new(mesh: &Mesh, bending: Option<Bending>) -> Self {
        let mut hinges = Self {
            corners: vec![],
            rest_angles: vec![],
            bending: bending.unwrap_or(Bending {
                stiffness: 0.0,
                damping: 0.0,
            }),
        };
        if bending.is_some() {
            let edges = mesh.edges().iter().zip(mesh.edge_triangles());
            let corners = edges.filter_map(|(&[i, j], &both)| {
                let [a, b] = [both[0]?, both[1]?].map(|t| opposite(mesh, t, [i, j]));
                Some([i, j, a, b])
            });
            hinges.corners = corners.collect();
            hinges.reset_rest(mesh);
        }
        hinges
    }

    /// Makes the present angles the rest angles.
    pub(super) fn reset_rest(&mut self, mesh: &Mesh) {
        let angles = self.folds(mesh.positions()).map(|(_, fold)| fold.angle);
        self.rest_angles = angles.collect();
    }

    /// Adds the forces of every hinge, in the order of their edges.
    pub(super) fn add_forces(
        &self,
        positions: &[[f64; 3]],
        velocities: &[[f64; 3]],
        forces: &mut [[f64; 3]],
    ) {
        for ((corners, fold), rest) in self.folds(positions).zip(&self.rest_angles) {
            let corners = corners.map(|vertex| vertex as usize);
            let turning = |c: usize| plain::dot(fold.gradients[c], velocities[corners[c]]);
            let rate = turning(0) + turning(1) + turning(2) + turning(3);
            let moment =
                self.bending.stiffness * turn(fold.angle - rest) + self.bending.damping * rate;
            for (&vertex, &gradient) in corners.iter().zip(&fold.gradients) {
                forces[vertex] = plain::sub(forces[vertex], plain::scale(gradient, moment));
            }
        }
    }

    /// Σ ½ k_θ (θ − θ₀)² \[J\].
    pub(super) fn energy(&self, positions: &[[f64; 3]]) -> f64 {
        let turns = self
            .folds(positions)
            .zip(&self.rest_angles)
            .map(|((_, fold), rest)| turn(fold.angle - rest));
        turns
            .map(|turn| 0.5 * self.bending.stiffness * turn * turn)
            .sum()
    }

    /// Resistance to folding.
    pub(super) fn bending(&self) -> Bending {
        self.bending
    }

    /// The corners of every hinge and how it is folded.
    pub(super) fn folds(&self, positions: &[[f64; 3]]) -> impl Iterator<Item = ([u32; 4], Fold)> {
        let fold = |&corners: &[u32; 4]| {
            let places = corners.map(|vertex| positions[vertex as usize]);
            (corners, Fold::of(places))
        };
        self.corners.iter().map(fold)
    }
}

impl Fold {
    /// The fold of a hinge with its corners at `x`.
    ///
    /// With the edge's unit vector e, and N the normal with the length of twice the area,
    /// ∂θ/∂x₂ = −ℓ N_A/N_A² and likewise for 3; 0 and 1 take the opposite shares, so that the hinge neither moves
    /// nor turns as a whole. All is zero where a triangle has no area.
    pub(super) fn of(x: [[f64; 3]; 4]) -> Self {
        let edge = plain::sub(x[1], x[0]);
        let length = plain::norm(edge);
        let along = unit(edge);
        let arm = |c: usize, from: usize| plain::sub(x[c], x[from]);
        let normals = [plain::cross(edge, arm(2, 0)), plain::cross(arm(3, 0), edge)];
        let [over_a, over_b] = normals.map(|normal| {
            let square = plain::dot(normal, normal);
            let inverse = if square > 0.0 { 1.0 / square } else { 0.0 };
            plain::scale(normal, inverse)
        });
        let share = |from: usize| {
            let a = plain::scale(over_a, plain::dot(arm(2, from), along));
            plain::add(a, plain::scale(over_b, plain::dot(arm(3, from), along)))
        };
        let [n_a, n_b] = normals.map(unit);
        let sine = plain::dot(plain::cross(n_a, n_b), along);
        Self {
            gradients: [
                plain::scale(share(1), -1.0),
                share(0),
                plain::scale(over_a, -length),
                plain::scale(over_b, -length),
            ],
            angle: libm::atan2(sine, plain::dot(n_a, n_b)),
        }
    }
}

/// The corner of triangle `t` that is none of `ends`.
fn opposite(mesh: &Mesh, t: u32, ends: [u32; 2]) -> u32 {
    let corners = mesh.triangles()[t as usize];
    let other = corners.into_iter().find(|vertex| !ends.contains(vertex));
    other.expect("a triangle has three different corners")
}

/// The same angle in [−π, π].
fn turn(angle: f64) -> f64 {
    if angle > PI {
        angle - 2.0 * PI
    } else if angle < -PI {
        angle + 2.0 * PI
    } else {
        angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::F64x8;
    use crate::membrane::shapes::{SHEET, cases, icosphere, strip};
    use crate::membrane::{Cuboid, Membrane, Sheet};
    use proptest::prelude::*;

    const BENDING: Bending = Bending {
        stiffness: 1e-3,
        damping: 1e-4,
    };

    #[test]
    fn sheet_that_folds_freely_has_no_hinges() {
        let sphere = icosphere(1, 1.0);
        assert!(Hinges::new(&sphere, None).corners.is_empty());
        assert_eq!(Hinges::new(&sphere, Some(BENDING)).corners.len(), 120);
        let strip = strip(2, 2, 1.0);
        assert_eq!(Hinges::new(&strip, Some(BENDING)).corners.len(), 16 - 8);
    }

    #[test]
    fn edges_of_a_cuboid_are_folded_by_a_right_angle() {
        let cuboid = Cuboid {
            length: 0.12,
            height: 0.02,
            depth: 0.02,
            edge_length: 4.7e-3,
        };
        let hinges = Hinges::new(&cuboid.mesh().unwrap(), Some(BENDING));
        let mut right = 0;
        for angle in &hinges.rest_angles {
            let is_right = (angle - 0.5 * PI).abs() < 1e-12;
            assert!(is_right || angle.abs() < 1e-12, "{angle}");
            right += u32::from(is_right);
        }
        // Four edges of 26 lattice edges, two of which end in a half one at both ends, and two rims of 20.
        assert!(right > 4 * 25 + 40 && right < 4 * 28 + 40, "{right}");
    }

    proptest! {
        #![proptest_config(cases(64))]

        /// The gradients are those of the angle, and move and turn nothing as a whole.
        #[test]
        fn gradients_are_differences_of_the_angle(
            wing in prop::array::uniform3(-0.4..0.4f64),
            other in prop::array::uniform3(-0.4..0.4f64),
        ) {
            let x = [
                [0.0; 3],
                [1.0, 0.1, -0.2],
                plain::add([0.5, 0.9, 0.0], wing),
                plain::add([0.4, -0.8, 0.0], other),
            ];
            let fold = Fold::of(x);
            let sum = fold.gradients.into_iter().fold([0.0; 3], plain::add);
            prop_assert!(plain::norm(sum) < 1e-13);
            let torques = (0..4).map(|c| plain::cross(x[c], fold.gradients[c]));
            prop_assert!(plain::norm(torques.fold([0.0; 3], plain::add)) < 1e-13);
            for c in 0..4 {
                for axis in 0..3 {
                    let at = |step: f64| {
                        let mut moved = x;
                        moved[c][axis] += step;
                        Fold::of(moved).angle
                    };
                    let slope = (at(1e-5) - at(-1e-5)) / 2e-5;
                    let gradient = fold.gradients[c][axis];
                    prop_assert!((slope - gradient).abs() < 1e-7, "{} {}", slope, gradient);
                }
            }
        }

        /// Springs and hinges pull down the slope of their energy, and only that.
        #[test]
        fn forces_are_the_slope_of_the_energy(seed in prop::collection::vec(-1.0..1.0f64, 252)) {
            let sheet = Sheet { bending: Some(Bending { stiffness: 1e-3, damping: 0.0 }), ..SHEET };
            let mut membrane = Membrane::new(icosphere(1, 0.02), &sheet).unwrap();
            let (shifts, steps) = seed.split_at(126);
            let moved = |places: &mut [[f64; 3]], by: &[f64], scale: f64| {
                for (part, by) in places.as_flattened_mut().iter_mut().zip(by) {
                    *part += scale * by;
                }
            };
            moved(membrane.positions_mut(), shifts, 1e-3);
            membrane.begin_step();
            membrane.add_internal_forces::<F64x8>();
            let work: f64 = membrane.forces().as_flattened().iter().zip(steps).map(|(f, s)| f * s).sum();
            let h = 1e-8;
            moved(membrane.positions_mut(), steps, h);
            let after = membrane.elastic_energy();
            moved(membrane.positions_mut(), steps, -2.0 * h);
            let slope = (after - membrane.elastic_energy()) / (2.0 * h);
            let scale: f64 = membrane.forces().iter().map(|&f| plain::norm(f)).sum();
            prop_assert!((slope + work).abs() < 1e-6 * scale, "{} {}", slope, work);
        }
    }
}
