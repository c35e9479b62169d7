//! Walls and motion: what happens to one grain once all contacts of its row are known.

use crate::contact::hertz;
use crate::force::{AffineRate, BodyForce};
use crate::grains::Grains;
use crate::lanes::{Lane, Mask, Row, Scalar};
use crate::math::Vec3;
use crate::scene::contacts::WallCandidate;
use crate::scene::{Laws, Physics};
use crate::shape::Shape;
use crate::wall::{Walls, axis, inward};

/// Most spheres of any shape.
pub(super) const MOST_SPHERES: usize = 4;

/// Constants of walls and motion in registers.
#[derive(Clone, Copy)]
pub(super) struct MotionConstants<L> {
    wall_stiffness: L,
    wall_damping: L,
    time_step: L,
    inverse_mass: L,
    inverse_inertia: L,
}

impl<L: Lane> MotionConstants<L> {
    #[inline(always)]
    pub(super) fn new<P: Physics>(laws: &Laws<P>) -> Self {
        Self {
            wall_stiffness: L::constant(laws.material.wall_stiffness),
            wall_damping: L::constant(laws.material.wall_damping),
            time_step: L::constant(laws.time_step),
            inverse_mass: L::constant(1.0 / laws.body.mass),
            inverse_inertia: L::constant(1.0 / laws.body.inertia),
        }
    }
}

/// The grain whose row is at hand.
#[derive(Clone, Copy)]
pub(super) struct RowGrain<L> {
    pub(super) velocity: Vec3<L>,
    pub(super) spin: Vec3<L>,
    /// Displacement of each sphere's center from the reference.
    pub(super) shifted: [Vec3<L>; MOST_SPHERES],
    /// Each sphere's center from the center of mass.
    pub(super) arms: [Vec3<L>; MOST_SPHERES],
}

impl<L: Lane> RowGrain<L> {
    #[inline(always)]
    pub(super) fn load<P: Physics>(grains: &Grains<L::Row>, i: usize) -> Self {
        let displacement = grains.displacement[i].load();
        let mut at = Self {
            velocity: grains.velocity[i].load(),
            spin: if P::SPINS {
                grains.spin[i].load()
            } else {
                Vec3::zero()
            },
            shifted: [displacement; MOST_SPHERES],
            arms: [Vec3::zero(); MOST_SPHERES],
        };
        if P::ORIENTED {
            let turn = grains.turn[i].load::<L>();
            for a in 0..P::Shape::SPHERES {
                let arm = Vec3::broadcast(grains.lane_arms[P::Shape::SPHERES * i + a]);
                let shift = turn.shift(arm);
                at.shifted[a] = displacement + shift;
                at.arms[a] = arm + shift;
            }
        }
        at
    }
}

/// What acts on the grain whose row is at hand.
#[derive(Clone, Copy)]
pub(super) struct Load<L> {
    pub(super) force: Vec3<L>,
    pub(super) torque: Vec3<L>,
}

impl<L: Lane> Load<L> {
    /// What has been summed on grain `i` so far; the sums start at zero again.
    #[inline(always)]
    pub(super) fn take<P: Physics>(grains: &mut Grains<L::Row>, i: usize) -> Self {
        let force = grains.force[i].load();
        Vec3::<L>::zero().store(&mut grains.force[i]);
        let torque = if P::SPINS {
            let torque = grains.torque[i].load();
            Vec3::<L>::zero().store(&mut grains.torque[i]);
            torque
        } else {
            Vec3::zero()
        };
        Self { force, torque }
    }
}

/// The force of a wall on one sphere.
#[inline(always)]
pub(super) fn push_of_wall<L: Lane, P: Physics>(
    constants: &MotionConstants<L>,
    at: &RowGrain<L>,
    candidate: &WallCandidate<L::Scalar>,
    walls: &mut Walls<L::Row>,
    load: &mut Load<L>,
) {
    let (w, a) = (usize::from(candidate.wall), usize::from(candidate.a));
    let inward = L::constant(inward(w));
    let shift = component(&at.shifted[a], axis(w)) - L::load(&walls.displacement[w]);
    let gap = inward.mul_add(shift, L::splat(candidate.gap));
    let touching = gap.lt(L::constant(0.0));
    if !touching.any() {
        return;
    }
    let overlap = -gap;
    let mut velocity = component(&at.velocity, axis(w));
    if P::SPINS {
        velocity = velocity + component(&at.spin.cross(at.arms[a]), axis(w));
    }
    let overlap_rate = inward * (L::load(&walls.velocity[w]) - velocity);
    let force = hertz::normal_force(
        constants.wall_stiffness,
        constants.wall_damping,
        overlap,
        overlap.sqrt(),
        overlap_rate,
    )
    .keep(touching);
    let mut row = L::Row::default();
    force.store(&mut row);
    for (sum, &lane) in walls.force[w].iter_mut().zip(row.lanes()) {
        *sum += lane.to_f64();
    }
    let mut push = Vec3::zero();
    *component_mut(&mut push, axis(w)) = inward * force;
    load.force = load.force + push;
    if P::ORIENTED {
        load.torque = at.arms[a].cross_add(push, load.torque);
    }
}

#[inline(always)]
fn component<L: Copy>(vector: &Vec3<L>, axis: usize) -> L {
    match axis {
        0 => vector.x,
        1 => vector.y,
        _ => vector.z,
    }
}

#[inline(always)]
fn component_mut<L>(vector: &mut Vec3<L>, axis: usize) -> &mut L {
    match axis {
        0 => &mut vector.x,
        1 => &mut vector.y,
        _ => &mut vector.z,
    }
}

/// The squares of the largest speed and spin of any grain.
#[derive(Clone, Copy)]
pub(super) struct Fastest<L> {
    speed: L,
    spin: L,
}

impl<L: Lane> Fastest<L> {
    #[inline(always)]
    pub(super) fn none() -> Self {
        Self {
            speed: L::constant(0.0),
            spin: L::constant(0.0),
        }
    }

    /// An upper bound of how far any sphere or wall moved in this step; not a number if anything is not.
    #[inline(always)]
    pub(super) fn swept<P: Physics>(self, laws: &Laws<P>, walls: &Walls<L::Row>) -> f64 {
        let (mut speed, mut spin) = (L::Row::default(), L::Row::default());
        self.speed.store(&mut speed);
        self.spin.store(&mut spin);
        let mut most = 0.0f64;
        for k in 0..L::K {
            let grain = speed.lanes()[k].to_f64().sqrt()
                + laws.body.reach() * spin.lanes()[k].to_f64().sqrt();
            most = if grain <= most { most } else { grain };
            for wall in &walls.velocity {
                let wall = wall.lanes()[k].to_f64().abs();
                most = if wall <= most { most } else { wall };
            }
        }
        most * laws.time_step
    }
}

/// Kick by a whole step and drift of grain `i`.
#[inline(always)]
pub(super) fn advance<L: Lane, P: Physics>(
    constants: &MotionConstants<L>,
    (body_force, affine): (&P::Body, &AffineRate<L::Row>),
    i: usize,
    load: &Load<L>,
    grains: &mut Grains<L::Row>,
    fastest: &mut Fastest<L>,
) {
    let displacement: Vec3<L> = grains.displacement[i].load();
    let velocity: Vec3<L> = grains.velocity[i].load();
    let position = Vec3::splat(grains.reference()[i].position) + displacement;
    let acceleration = body_force.linear(
        position,
        velocity,
        affine,
        load.force.scale(constants.inverse_mass),
    );
    let velocity = acceleration.scale_add(constants.time_step, velocity);
    velocity.store(&mut grains.velocity[i]);
    velocity
        .scale_add(constants.time_step, displacement)
        .store(&mut grains.displacement[i]);
    // `max` keeps its second argument where the first is not a number, so a square that is none must come second.
    fastest.speed = fastest.speed.max(velocity.dot(velocity));
    if P::SPINS {
        let spin: Vec3<L> = grains.spin[i].load();
        let acceleration = body_force.angular(spin, load.torque.scale(constants.inverse_inertia));
        let spin = acceleration.scale_add(constants.time_step, spin);
        spin.store(&mut grains.spin[i]);
        if P::ORIENTED {
            grains.turn[i]
                .load::<L>()
                .turned(spin.scale(constants.time_step))
                .store(&mut grains.turn[i]);
            fastest.spin = fastest.spin.max(spin.dot(spin));
        }
    }
}
