//! The critical time step: the largest at which the integrator is stable on the contacts as they are.
//!
//! For a mode of stiffness κ and damping c per mass, leapfrog with damping by half-step velocities is stable while
//! Δt² κ + 2 Δt c < 4 (Jury's criterion for v' = v − Δt(κ x + c v), x' = x + Δt v').
//! For all modes together, with the tangent stiffness K and damping C of every contact, weighted by mass: a motion that
//! changes sign at every step neither grows nor dies where det(4 − H) = 0, H = Δt² K + 2 Δt C, and none grows while the
//! largest eigenvalue of H is below 4.
//! A contact resists by (3/2) k_n √p along its normal and by k across it (law-dependent), and damps likewise.

use serde::{Deserialize, Serialize};

use super::lanczos::{dot as product, subtract, top_vector};
use crate::math::plain::{add, cross, dot, scale, sub};
use crate::scene::{Physics, Replicas, Scene};
use crate::wall::{WALLS, axis, inward};

/// Dimensions of the two Krylov spaces: one for a rough Δt, which H must be told, and one for the answer.
const DIMENSIONS: [usize; 2] = [12, 44];

/// The critical time step between two bounds.
///
/// The upper one is certain: a mode is known that grows from there on.
/// The lower one takes it for granted that the eigenvalue nearest to that mode's is the largest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CriticalTimeStep {
    /// Below this no motion grows \[t_c\].
    pub at_least: f64,
    /// From here on one does \[t_c\].
    pub at_most: f64,
}

impl CriticalTimeStep {
    /// Nothing touches, so every time step is stable.
    pub const NONE: Self = Self {
        at_least: f64::MAX,
        at_most: f64::MAX,
    };
}

/// One contact's tangent: what resists a change of its branch vector.
struct Tangent {
    i: usize,
    /// The other grain, or none for a wall.
    j: Option<usize>,
    normal: [f64; 3],
    /// Arms over the radius of gyration.
    arm_i: [f64; 3],
    arm_j: [f64; 3],
    /// Along the normal.
    along: Resistance,
    /// Across it.
    across: Resistance,
}

/// Stiffness and damping over a grain's mass.
#[derive(Clone, Copy)]
struct Resistance {
    stiffness: f64,
    damping: f64,
}

/// Stiffness and damping of the tangential law across a contact, before it slips.
#[derive(Clone, Copy, Debug, Default)]
pub struct Across {
    /// \[E R\].
    pub stiffness: f64,
    /// \[E R t_c\].
    pub damping: f64,
    /// What the root of the overlap adds to the stiffness \[E R^½\].
    pub stiffness_per_root: f64,
    /// What it adds to the damping \[E R^½ t_c\].
    pub damping_per_root: f64,
}

/// The critical time step of replica `k`.
///
/// With the closed form Δt of a unit vector y, yᵀ H(Δt) y = 4, so the largest eigenvalue is at least 4: the upper bound.
/// Some eigenvalue of H(Δt) is within ρ = |H y − 4 y| of 4, and H(s Δt) is at most s H(Δt) for s < 1: the lower bound is
/// Δt·4/(4 + ρ).
#[must_use]
pub fn critical_time_step<R: Replicas, P: Physics>(
    scene: &Scene<R, P>,
    k: usize,
    across: Across,
) -> CriticalTimeStep {
    let tangents = tangents(scene, k, across);
    if tangents.is_empty() {
        return CriticalTimeStep::NONE;
    }
    let mut mode: Vec<f64> = (0..6 * scene.grains.len()).map(start).collect();
    let mut time_step = 1.0;
    for dimensions in DIMENSIONS {
        mode = top_vector(&mode, dimensions, |x, image| {
            apply(&tangents, time_step, x, image);
        });
        time_step = closed_form(&tangents, &mode);
    }
    let mut residual = vec![0.0; mode.len()];
    apply(&tangents, time_step, &mode, &mut residual);
    subtract(&mut residual, 4.0, &mode);
    let rho = product(&residual, &residual).sqrt();
    CriticalTimeStep {
        at_least: time_step * 4.0 / (4.0 + rho),
        at_most: time_step,
    }
}

/// A start without symmetry, the same for every scene.
fn start(n: usize) -> f64 {
    (n * 7919 % 1009) as f64 / 1009.0 - 0.5
}

/// How the branch vector of a contact changes in a motion, and how much of that is along its normal.
fn change(tangent: &Tangent, motion: &[[f64; 6]]) -> ([f64; 3], f64) {
    let at = |i: usize, arm: [f64; 3]| {
        let [x, y, z, a, b, c] = motion[i];
        add([x, y, z], cross([a, b, c], arm))
    };
    let mut relative = at(tangent.i, tangent.arm_i);
    if let Some(j) = tangent.j {
        relative = sub(relative, at(j, tangent.arm_j));
    }
    (relative, dot(relative, tangent.normal))
}

/// Adds H·motion to `image`; motions are velocity and spin of each grain, times √m and √I.
fn apply(tangents: &[Tangent], time_step: f64, motion: &[f64], image: &mut [f64]) {
    let (motion, image) = (motion.as_chunks().0, image.as_chunks_mut().0);
    let weight = |of: Resistance| time_step * (time_step * of.stiffness + 2.0 * of.damping);
    for tangent in tangents {
        let (relative, along) = change(tangent, motion);
        let across = weight(tangent.across);
        let along = (weight(tangent.along) - across) * along;
        let force = add(scale(relative, across), scale(tangent.normal, along));
        push(&mut image[tangent.i], force, tangent.arm_i);
        if let Some(j) = tangent.j {
            push(&mut image[j], scale(force, -1.0), tangent.arm_j);
        }
    }
}

/// Adds a force and its torque.
fn push(on: &mut [f64; 6], force: [f64; 3], arm: [f64; 3]) {
    let torque = cross(arm, force);
    for n in 0..3 {
        on[n] += force[n];
        on[3 + n] += torque[n];
    }
}

/// The Δt at which yᵀ H(Δt) y = 4 for a unit vector y.
fn closed_form(tangents: &[Tangent], mode: &[f64]) -> f64 {
    let mode = mode.as_chunks().0;
    let (mut stiffness, mut damping) = (0.0, 0.0);
    for tangent in tangents {
        let (relative, along) = change(tangent, mode);
        let along = along * along;
        let across = dot(relative, relative) - along;
        for (square, of) in [(along, tangent.along), (across, tangent.across)] {
            stiffness += of.stiffness * square;
            damping += of.damping * square;
        }
    }
    (-damping + (damping * damping + 4.0 * stiffness).sqrt()) / stiffness
}

fn tangents<R: Replicas, P: Physics>(
    scene: &Scene<R, P>,
    k: usize,
    across: Across,
) -> Vec<Tangent> {
    let mut tangents = vec![];
    let (material, body) = (&scene.laws.material, &scene.laws.body);
    let grains = &scene.grains;
    let gyration = (body.inertia / body.mass).sqrt();
    let scaled = |arm: [f64; 3]| scale(arm, 1.0 / gyration);
    let resistance = |stiffness: f64, damping: f64| Resistance {
        stiffness: stiffness / body.mass,
        damping: damping / body.mass,
    };
    let arm = |i: usize, a: usize| sub(grains.center(i, a, k), grains.pose(i, k).position);
    for (i, key) in scene.pairs() {
        let (a, b, j) = (usize::from(key.a), usize::from(key.b), key.j as usize);
        let branch = sub(grains.center(i, a, k), grains.center(j, b, k));
        let length = dot(branch, branch).sqrt();
        let overlap = 2.0 - length;
        if overlap > 0.0 {
            let normal = scale(branch, 1.0 / length);
            let root = overlap.sqrt();
            let middle = 1.0 - 0.5 * overlap;
            tangents.push(Tangent {
                i,
                j: Some(j),
                normal,
                arm_i: scaled(sub(arm(i, a), scale(normal, middle))),
                arm_j: scaled(add(arm(j, b), scale(normal, middle))),
                along: resistance(
                    1.5 * material.normal_stiffness * root,
                    material.normal_damping * root,
                ),
                across: resistance(
                    across.stiffness + across.stiffness_per_root * root,
                    across.damping + across.damping_per_root * root,
                ),
            });
        }
    }
    for i in 0..grains.len() {
        for (a, w) in (0..grains.spheres()).flat_map(|a| (0..WALLS).map(move |w| (a, w))) {
            let distance =
                inward(w) * (grains.center(i, a, k)[axis(w)] - scene.walls.position(w, k));
            if distance < 1.0 {
                let root = (1.0 - distance).sqrt();
                let mut normal = [0.0; 3];
                normal[axis(w)] = inward(w);
                tangents.push(Tangent {
                    i,
                    j: None,
                    normal,
                    arm_i: scaled(arm(i, a)),
                    arm_j: [0.0; 3],
                    along: resistance(
                        1.5 * material.wall_stiffness * root,
                        material.wall_damping * root,
                    ),
                    across: resistance(0.0, 0.0),
                });
            }
        }
    }
    tangents
}
