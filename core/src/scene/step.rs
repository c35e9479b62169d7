//! One step of a scene, for all replicas at once.

use crate::contact::{Components, Contact, TangentialLaw, hertz};
use crate::force::{AffineRate, BodyForce};
use crate::grains::{Grains, LoadedGrain};
use crate::lanes::{Kernel, Lane, Mask, Row, Scalar};
use crate::math::Vec3;
use crate::shape::Shape;
use crate::wall::{MAX_LANES, Walls, axis, inward};

use super::contacts::{Candidate, WallCandidate};
use super::{Laws, Physics, Scene};

/// Most spheres of any shape.
pub(super) const MOST_SPHERES: usize = 4;

/// The whole step; returns how far anything can have moved.
pub(super) struct Step<'a, R: Row, P: Physics> {
    pub(super) scene: &'a mut Scene<R, P>,
}

/// Constants in registers.
#[derive(Clone, Copy)]
struct Constants<L: Lane, T: TangentialLaw> {
    normal_stiffness: L,
    normal_damping: L,
    wall_stiffness: L,
    wall_damping: L,
    tangential: T::Constants<L>,
    time_step: L,
    inverse_mass: L,
    inverse_inertia: L,
}

impl<L: Lane, T: TangentialLaw> Constants<L, T> {
    #[inline(always)]
    fn new<P: Physics<Tangential = T>>(laws: &Laws<P>) -> Self {
        Self {
            normal_stiffness: L::constant(laws.material.normal_stiffness),
            normal_damping: L::constant(laws.material.normal_damping),
            wall_stiffness: L::constant(laws.material.wall_stiffness),
            wall_damping: L::constant(laws.material.wall_damping),
            tangential: laws.tangential.constants(),
            time_step: L::constant(laws.time_step),
            inverse_mass: L::constant(1.0 / laws.body.mass),
            inverse_inertia: L::constant(1.0 / laws.body.inertia),
        }
    }
}

/// The grain whose row is at hand.
#[derive(Clone, Copy)]
struct RowGrain<L> {
    velocity: Vec3<L>,
    spin: Vec3<L>,
    /// Displacement of each sphere's center from the reference.
    shifted: [Vec3<L>; MOST_SPHERES],
    /// Each sphere's center from the center of mass.
    arms: [Vec3<L>; MOST_SPHERES],
}

/// What acts on the grain whose row is at hand.
#[derive(Clone, Copy)]
struct Load<L> {
    force: Vec3<L>,
    torque: Vec3<L>,
}

impl<R: Row, P: Physics> Kernel<R> for Step<'_, R, P> {
    type Output = f64;

    #[inline(always)]
    fn run<L: Lane<Row = R, Scalar = R::Scalar>>(self) -> f64 {
        let Scene {
            laws,
            grains,
            walls,
            contacts,
            affine,
            ..
        } = self.scene;
        let constants = Constants::<L, P::Tangential>::new(laws);
        walls.force = [[0.0; MAX_LANES]; 6];
        let (mut fastest, mut fastest_spin) = (L::constant(0.0), L::constant(0.0));
        for i in 0..grains.len() {
            let at = row_grain::<L, P>(grains, i);
            let mut load = take_load::<L, P>(grains, i);
            for c in contacts.starts[i] as usize..contacts.starts[i + 1] as usize {
                let (candidate, history) =
                    (&mut contacts.candidates[c], &mut contacts.histories[c]);
                pair::<L, P>(&constants, &at, candidate, history, grains, &mut load);
            }
            for c in contacts.wall_starts[i] as usize..contacts.wall_starts[i + 1] as usize {
                wall::<L, P>(
                    &constants,
                    &at,
                    &contacts.wall_candidates[c],
                    walls,
                    &mut load,
                );
            }
            let speeds = advance::<L, P>(&constants, &laws.body_force, affine, i, &load, grains);
            fastest = speeds.0.max(fastest);
            fastest_spin = speeds.1.max(fastest_spin);
        }
        swept(fastest, fastest_spin, laws, walls)
    }
}

#[inline(always)]
fn row_grain<L: Lane, P: Physics>(grains: &Grains<L::Row>, i: usize) -> RowGrain<L> {
    let loaded: LoadedGrain<L> = grains.load(i, P::ORIENTED);
    let mut at = RowGrain {
        velocity: grains.velocity[i].load(),
        spin: if P::SPINS {
            grains.spin[i].load()
        } else {
            Vec3::zero()
        },
        shifted: [loaded.displacement; MOST_SPHERES],
        arms: [Vec3::zero(); MOST_SPHERES],
    };
    if P::ORIENTED {
        for a in 0..P::Shape::SPHERES {
            let arm = grains.broadcast_arm(i, a, P::Shape::SPHERES);
            let shift = loaded.turn.shift(arm);
            at.shifted[a] = loaded.displacement + shift;
            at.arms[a] = arm + shift;
        }
    }
    at
}

/// What earlier rows left on grain `i`; the sums start at zero again.
#[inline(always)]
fn take_load<L: Lane, P: Physics>(grains: &mut Grains<L::Row>, i: usize) -> Load<L> {
    let force = grains.force[i].load();
    Vec3::<L>::zero().store(&mut grains.force[i]);
    let torque = if P::SPINS {
        let torque = grains.torque[i].load();
        Vec3::<L>::zero().store(&mut grains.torque[i]);
        torque
    } else {
        Vec3::zero()
    };
    Load { force, torque }
}

/// The force of one pair of spheres, if any replica's touch.
#[inline(always)]
fn pair<L: Lane, P: Physics>(
    constants: &Constants<L, P::Tangential>,
    at: &RowGrain<L>,
    candidate: &mut Candidate<L::Scalar>,
    history: &mut <P::Tangential as TangentialLaw>::History<L::Row>,
    grains: &mut Grains<L::Row>,
    load: &mut Load<L>,
) {
    let (j, a) = (candidate.j as usize, usize::from(candidate.a));
    let other: LoadedGrain<L> = grains.load(j, P::ORIENTED);
    let (mut shifted_j, mut arm_j) = (other.displacement, Vec3::zero());
    if P::ORIENTED {
        let arm = grains.broadcast_arm(j, usize::from(candidate.b), P::Shape::SPHERES);
        let shift = other.turn.shift(arm);
        shifted_j = shifted_j + shift;
        arm_j = arm + shift;
    }
    // |L|² − 4 = |L0|² − 4 + (2 L0 + e)·e with e the change of the branch vector: no digits are lost to |L|² ≈ 4.
    let change = at.shifted[a] - shifted_j;
    let twice = Vec3::broadcast(candidate.twice_branch);
    let both = twice + change;
    let start = L::splat(candidate.excess);
    let excess = both.x.mul_add(
        change.x,
        both.y.mul_add(change.y, both.z.mul_add(change.z, start)),
    );
    let touching = excess.lt(L::constant(0.0));
    if !touching.any() {
        if candidate.live {
            *history = Components::from_fn(|_| L::Row::default());
            candidate.live = false;
        }
        return;
    }
    candidate.live = true;

    let branch = twice.scale_add(L::constant(0.5), change);
    let length = (excess + L::constant(4.0)).sqrt();
    let sum = length + L::constant(2.0);
    let inverse = L::constant(1.0) / (length * sum);
    let normal = branch.scale(inverse * sum);
    let overlap = -excess * (inverse * length);
    let root_overlap = overlap.sqrt();

    // The contact point lies in the middle of the overlap, R − p/2 from either center.
    let half = overlap.neg_mul_add(L::constant(0.5), L::constant(1.0));
    let arm_i = normal.scale_sub(half, at.arms[a]);
    let arm_j = normal.scale_add(half, arm_j);
    let mut relative = at.velocity - grains.velocity[j].load();
    if P::SPINS {
        let spin_j: Vec3<L> = grains.spin[j].load();
        relative = arm_j.cross_add(spin_j, at.spin.cross_add(arm_i, relative));
    }
    let overlap_rate = -relative.dot(normal);
    let normal_force = hertz::normal_force(
        constants.normal_stiffness,
        constants.normal_damping,
        overlap,
        root_overlap,
        overlap_rate,
    );
    let mut force = normal.scale(normal_force);
    let mut tangential = Vec3::zero();
    if P::Tangential::TANGENTIAL {
        let contact = Contact {
            normal,
            sliding_velocity: normal.scale_add(overlap_rate, relative),
            root_overlap,
            normal_force,
            time_step: constants.time_step,
        };
        let mut carried = <P::Tangential as TangentialLaw>::History::<L>::from_fn(|n| {
            L::load(&history.as_slice()[n])
        });
        tangential = P::Tangential::force(&constants.tangential, &contact, &mut carried);
        force = force + tangential;
        for (row, lanes) in history.as_mut_slice().iter_mut().zip(carried.as_slice()) {
            lanes.keep(touching).store(row);
        }
    }
    let force = force.keep(touching);
    load.force = load.force + force;
    let on_j: Vec3<L> = grains.force[j].load();
    (on_j - force).store(&mut grains.force[j]);
    if P::SPINS {
        // A sphere's arm lies along the normal force: without it, not even rounding spins a sphere that nothing pulls.
        let turning = if P::ORIENTED {
            force
        } else {
            tangential.keep(touching)
        };
        // Lanes that do not touch may have an arm that is not a number: their torque must not see it.
        load.torque = arm_i.keep(touching).cross_add(turning, load.torque);
        let on_j: Vec3<L> = grains.torque[j].load();
        turning
            .cross_add(arm_j.keep(touching), on_j)
            .store(&mut grains.torque[j]);
    }
}

/// The force of a wall on one sphere.
#[inline(always)]
fn wall<L: Lane, P: Physics>(
    constants: &Constants<L, P::Tangential>,
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

/// Kick and drift of grain `i`; returns the squares of its speed and spin.
#[inline(always)]
fn advance<L: Lane, P: Physics>(
    constants: &Constants<L, P::Tangential>,
    body_force: &P::Body,
    affine: &AffineRate<L::Row>,
    i: usize,
    load: &Load<L>,
    grains: &mut Grains<L::Row>,
) -> (L, L) {
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
    let mut spin_square = L::constant(0.0);
    if P::SPINS {
        let spin: Vec3<L> = grains.spin[i].load();
        let acceleration = body_force.angular(spin, load.torque.scale(constants.inverse_inertia));
        let spin = acceleration.scale_add(constants.time_step, spin);
        spin.store(&mut grains.spin[i]);
        if P::ORIENTED {
            grains.turn[i]
                .load()
                .turned(spin.scale(constants.time_step))
                .store(&mut grains.turn[i]);
            spin_square = spin.dot(spin);
        }
    }
    (velocity.dot(velocity), spin_square)
}

/// An upper bound of how far any sphere or wall moved in this step.
#[inline(always)]
fn swept<L: Lane, P: Physics>(
    fastest: L,
    fastest_spin: L,
    laws: &Laws<P>,
    walls: &Walls<L::Row>,
) -> f64 {
    let (mut speed, mut spin) = (L::Row::default(), L::Row::default());
    fastest.store(&mut speed);
    fastest_spin.store(&mut spin);
    let mut most = 0.0f64;
    for k in 0..L::K {
        let grain =
            speed.lanes()[k].to_f64().sqrt() + laws.body.reach() * spin.lanes()[k].to_f64().sqrt();
        most = if grain <= most { most } else { grain };
        for wall in &walls.velocity {
            most = most.max(wall.lanes()[k].to_f64().abs());
        }
    }
    most * laws.time_step
}
