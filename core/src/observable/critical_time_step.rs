//! The critical time step: the largest at which the integrator is stable on the contacts as they are.
//!
//! For a mode of stiffness κ and damping c per mass, leapfrog with damping by half-step velocities is stable while
//! Δt² κ + 2 Δt c < 4 (Jury's criterion for v' = v − Δt(κ x + c v), x' = x + Δt v').
//! The largest κ and its c are found by power iteration with the tangent stiffness of every contact:
//! (3/2) k_n √p along the normal, k across it (law-dependent), damping likewise.

use crate::math::plain::{add, cross, dot, scale, sub};
use crate::scene::{Physics, Replicas, Scene};
use crate::wall::{WALLS, axis, inward};

/// Iterations from a rough start: the top of the spectrum is dense, so the estimate is a lower bound good to about 2 %.
const ITERATIONS: usize = 60;

/// One contact's tangent: what resists a change of its branch vector.
struct Tangent {
    i: usize,
    /// The other grain, or none for a wall.
    j: Option<usize>,
    normal: [f64; 3],
    arm_i: [f64; 3],
    arm_j: [f64; 3],
    /// Stiffness and damping along the normal.
    along: [f64; 2],
    /// Stiffness and damping across it.
    across: [f64; 2],
}

/// A motion of all grains: velocity and spin of each.
type Mode = Vec<([f64; 3], [f64; 3])>;

/// Stiffness and damping of the tangential law across a contact, before it slips.
#[derive(Clone, Copy, Debug, Default)]
pub struct Across {
    /// \[E R\].
    pub stiffness: f64,
    /// \[E R t_c\].
    pub damping: f64,
}

/// The critical time step of replica `k` \[t_c\]; `f64::MAX` if nothing touches.
#[must_use]
pub fn critical_time_step<R: Replicas, P: Physics>(
    scene: &Scene<R, P>,
    k: usize,
    across: Across,
) -> f64 {
    let tangents = tangents(scene, k, across);
    if tangents.is_empty() {
        return f64::MAX;
    }
    let body = &scene.laws.body;
    let (mass, inertia) = (body.mass, body.inertia);
    let mut mode: Mode = (0..scene.grains.len()).map(start).collect();
    let (mut stiffness, mut damping) = (0.0, 0.0);
    for _ in 0..ITERATIONS {
        let length = mode
            .iter()
            .map(|(v, w)| mass * dot(*v, *v) + inertia * dot(*w, *w))
            .sum::<f64>()
            .sqrt();
        for (v, w) in &mut mode {
            *v = scale(*v, 1.0 / length);
            *w = scale(*w, 1.0 / length);
        }
        let mut image: Mode = vec![([0.0; 3], [0.0; 3]); mode.len()];
        (stiffness, damping) = apply(&tangents, &mode, &mut image);
        for ((v, w), (f, t)) in mode.iter_mut().zip(&image) {
            *v = scale(*f, 1.0 / mass);
            // Spheres without friction have nothing that spins them; their spin stays zero.
            *w = scale(*t, 1.0 / inertia);
        }
    }
    (-damping + (damping * damping + 4.0 * stiffness).sqrt()) / stiffness
}

/// A start without symmetry, the same for every scene.
fn start(i: usize) -> ([f64; 3], [f64; 3]) {
    let part = |n: usize| ((i * 6 + n) * 7919 % 1009) as f64 / 1009.0 - 0.5;
    ([part(0), part(1), part(2)], [part(3), part(4), part(5)])
}

/// Adds K·mode to `image`; returns the quadratic forms of stiffness and damping.
fn apply(tangents: &[Tangent], mode: &Mode, image: &mut Mode) -> (f64, f64) {
    let (mut stiffness, mut damping) = (0.0, 0.0);
    for tangent in tangents {
        let (v, w) = mode[tangent.i];
        let mut relative = add(v, cross(w, tangent.arm_i));
        if let Some(j) = tangent.j {
            let (v, w) = mode[j];
            relative = sub(relative, add(v, cross(w, tangent.arm_j)));
        }
        let along = scale(tangent.normal, dot(relative, tangent.normal));
        let across = sub(relative, along);
        stiffness += tangent.along[0] * dot(along, along) + tangent.across[0] * dot(across, across);
        damping += tangent.along[1] * dot(along, along) + tangent.across[1] * dot(across, across);
        let force = add(
            scale(along, tangent.along[0]),
            scale(across, tangent.across[0]),
        );
        let on_i = &mut image[tangent.i];
        on_i.0 = add(on_i.0, force);
        on_i.1 = add(on_i.1, cross(tangent.arm_i, force));
        if let Some(j) = tangent.j {
            let on_j = &mut image[j];
            on_j.0 = sub(on_j.0, force);
            on_j.1 = sub(on_j.1, cross(tangent.arm_j, force));
        }
    }
    (stiffness, damping)
}

fn tangents<R: Replicas, P: Physics>(
    scene: &Scene<R, P>,
    k: usize,
    across: Across,
) -> Vec<Tangent> {
    let mut tangents = vec![];
    let material = &scene.laws.material;
    let grains = &scene.grains;
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
                arm_i: sub(arm(i, a), scale(normal, middle)),
                arm_j: add(arm(j, b), scale(normal, middle)),
                along: [
                    1.5 * material.normal_stiffness * root,
                    material.normal_damping * root,
                ],
                across: [across.stiffness, across.damping],
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
                    arm_i: arm(i, a),
                    arm_j: [0.0; 3],
                    along: [
                        1.5 * material.wall_stiffness * root,
                        material.wall_damping * root,
                    ],
                    across: [0.0; 2],
                });
            }
        }
    }
    tangents
}
