//! A survey of a scene: what is counted and summed over all grains and contacts, for all replicas at once.

use crate::grains::Grains;
use crate::lanes::{Kernel, Lane};
use crate::math::Vec3;
use crate::shape::Shape;

use super::interact::branch;
use super::{Physics, Replicas, Scene};

/// Sums over all grains and contacts, per replica.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums<R> {
    /// Touching pairs of spheres of different grains.
    pub(crate) sphere_contacts: R,
    /// Touching pairs of grains.
    pub(crate) grain_contacts: R,
    /// Spheres that touch a wall.
    pub(crate) wall_contacts: R,
    /// The largest −(|L|² − 4), from which the largest overlap follows.
    pub(crate) deepest: R,
    /// The largest overlap of a sphere with a wall.
    pub(crate) deepest_wall: R,
    /// Σ |v|².
    pub(crate) velocity_square: R,
    /// Σ |ω|².
    pub(crate) spin_square: R,
}

/// Surveys a scene at its present positions and last velocities.
pub(crate) struct Survey<'a, R: Replicas, P: Physics> {
    pub(crate) scene: &'a Scene<R, P>,
}

impl<R: Replicas, P: Physics> Kernel<R> for Survey<'_, R, P> {
    type Output = Sums<R>;

    #[inline(always)]
    fn run<L: Lane<Row = R, Scalar = R::Scalar>>(self) -> Sums<R> {
        const { assert!(!P::GRADED, "a survey takes all grains for alike") }
        let scene = self.scene;
        let zero = L::constant(0.0);
        let one = L::constant(1.0);
        let (mut spheres, mut grains, mut walls, mut deepest) = (zero, zero, zero, zero);
        let mut deepest_wall = zero;
        let (mut velocity_square, mut spin_square) = (zero, zero);
        for i in 0..scene.grains.len() {
            let velocity: Vec3<L> = scene.grains.velocity[i].load();
            velocity_square = velocity_square + velocity.dot(velocity);
            if P::SPINS {
                let spin: Vec3<L> = scene.grains.spin[i].load();
                spin_square = spin_square + spin.dot(spin);
            }
            let (mut last, mut met) = (u32::MAX, zero);
            for candidate in &scene.contacts.candidates
                [scene.contacts.starts[i] as usize..scene.contacts.starts[i + 1] as usize]
            {
                let j = candidate.j as usize;
                let change = shifted::<L, P>(&scene.grains, i, usize::from(candidate.a))
                    - shifted::<L, P>(&scene.grains, j, usize::from(candidate.b));
                let reach = L::constant(2.0);
                let excess =
                    branch::<L, P>(candidate.reference.map(L::splat), change, reach).excess;
                let touch = one.keep(excess.lt(zero));
                spheres = spheres + touch;
                deepest = (-excess).max(deepest);
                if candidate.j != last {
                    grains = grains + met;
                    (last, met) = (candidate.j, zero);
                }
                met = touch.max(met);
            }
            grains = grains + met;
            for candidate in &scene.contacts.wall_candidates
                [scene.contacts.wall_starts[i] as usize..scene.contacts.wall_starts[i + 1] as usize]
            {
                let w = usize::from(candidate.wall);
                let center = shifted::<L, P>(&scene.grains, i, usize::from(candidate.a));
                let along = match crate::wall::axis(w) {
                    0 => center.x,
                    1 => center.y,
                    _ => center.z,
                };
                let shift = along - L::load(&scene.walls.displacement[w]);
                let gap =
                    L::constant(crate::wall::inward(w)).mul_add(shift, L::splat(candidate.gap));
                walls = walls + one.keep(gap.lt(zero));
                deepest_wall = (-gap).max(deepest_wall);
            }
        }
        let row = |lanes: L| {
            let mut row = R::default();
            lanes.store(&mut row);
            row
        };
        Sums {
            sphere_contacts: row(spheres),
            grain_contacts: row(grains),
            wall_contacts: row(walls),
            deepest: row(deepest),
            deepest_wall: row(deepest_wall),
            velocity_square: row(velocity_square),
            spin_square: row(spin_square),
        }
    }
}

/// Displacement of the center of sphere `a` of grain `i` from the reference.
#[inline(always)]
fn shifted<L: Lane, P: Physics>(grains: &Grains<L::Row>, i: usize, a: usize) -> Vec3<L> {
    let displacement = grains.displacement[i].load();
    if P::ORIENTED {
        let arm = Vec3::broadcast(grains.lane_arms[P::Shape::SPHERES * i + a]);
        displacement + grains.turn[i].load::<L>().shift(arm)
    } else {
        displacement
    }
}
