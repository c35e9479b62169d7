//! Observables: what is measured in a scene; they borrow it and change nothing.

pub mod critical_time_step;
mod lanczos;

use serde::{Deserialize, Serialize};

use crate::grains::Pose;
use crate::lanes::{Scalar, dispatch};
use crate::scene::survey::Survey;
use crate::scene::{Physics, Replicas, Scene};

/// What a survey of one replica finds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Observation {
    /// φ: volume of the grains, overlaps counted twice, over the volume of the box.
    pub volume_fraction: f64,
    /// Z: grains that a grain touches, on average.
    pub coordination_number: f64,
    /// Touching pairs of spheres over N: each pair counted once.
    pub sphere_contacts_per_grain: f64,
    /// Spheres that touch a wall, over N.
    pub wall_contacts_per_grain: f64,
    /// Kinetic energy over N \[E R³\].
    pub kinetic_energy: f64,
    /// The largest overlap of two spheres \[R\].
    pub largest_overlap: f64,
    /// The largest overlap of a sphere with a wall \[R\].
    pub largest_wall_overlap: f64,
    /// Whether every position and orientation is a number; a grain without one touches nothing, so no overlap tells.
    pub has_places: bool,
}

impl Observation {
    /// Whether every number is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.has_places && self.kinetic_energy.is_finite() && self.largest_overlap.is_finite()
    }
}

/// Observes every replica at its present positions and last velocities.
#[must_use]
pub fn observe<R: Replicas, P: Physics>(scene: &Scene<R, P>) -> Vec<Observation> {
    let sums = dispatch::<R, _>(scene.laws.width, Survey { scene });
    let n = scene.grains.len() as f64;
    let body = &scene.laws.body;
    (0..R::K)
        .map(|k| {
            let of = |row: &R| row.lanes()[k].to_f64();
            // −(|L|² − 4) = p (2 + |L|) = p (4 − p).
            let deepest = of(&sums.deepest);
            let largest_overlap = 2.0 - (4.0 - deepest).sqrt();
            Observation {
                volume_fraction: n * body.mass / scene.walls.volume(k),
                coordination_number: 2.0 * of(&sums.grain_contacts) / n,
                sphere_contacts_per_grain: of(&sums.sphere_contacts) / n,
                wall_contacts_per_grain: of(&sums.wall_contacts) / n,
                kinetic_energy: 0.5
                    * (body.mass * of(&sums.velocity_square)
                        + body.inertia * of(&sums.spin_square))
                    / n,
                largest_overlap,
                largest_wall_overlap: of(&sums.deepest_wall),
                has_places: (0..scene.grains.len()).all(|i| has_place(&scene.grains.pose(i, k))),
            }
        })
        .collect()
}

fn has_place(pose: &Pose) -> bool {
    let finite = |x: &f64| x.is_finite();
    pose.position.iter().all(finite) && pose.orientation.iter().all(finite)
}
