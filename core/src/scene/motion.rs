//! Walls and motion: what happens to one grain once all contacts of its row are known.

use crate::contact::hertz;
use crate::force::{AffineRate, BodyForce};
use crate::grains::Size;
use crate::lanes::{Lane, Mask, Row, Scalar};
use crate::math::{Quaternion, Vec3};
use crate::scene::contacts::WallCandidate;
use crate::scene::motions::{Fixed, Motions, MotionsMut};
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
    dither: L,
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
            dither: L::constant(laws.dither),
            inverse_mass: L::constant(1.0 / laws.body.mass),
            inverse_inertia: L::constant(1.0 / laws.body.inertia),
        }
    }

    /// The same for grains of the sizes that `of` reads; unchanged where all are alike.
    #[inline(always)]
    pub(super) fn sized<P: Physics>(self, of: impl Fn(fn(&Size) -> f64) -> L) -> Self {
        if P::GRADED {
            Self {
                inverse_mass: of(|size| size.inverse_mass),
                inverse_inertia: of(|size| size.inverse_inertia),
                ..self
            }
        } else {
            self
        }
    }
}

/// How one grain departs from its reference and moves.
#[derive(Clone, Copy)]
pub(super) struct Moving<L> {
    pub(super) displacement: Vec3<L>,
    pub(super) velocity: Vec3<L>,
    /// Meaningless for spheres.
    pub(super) turn: Quaternion<L>,
    /// Meaningless where nothing spins.
    pub(super) spin: Vec3<L>,
}

impl<L: Lane> Moving<L> {
    #[inline(always)]
    pub(super) fn load<P: Physics>(grains: &Motions<'_, L::Row>, i: usize) -> Self {
        Self {
            displacement: grains.displacement[i].load(),
            velocity: grains.velocity[i].load(),
            turn: if P::ORIENTED {
                grains.turn[i].load()
            } else {
                Quaternion {
                    w: L::constant(1.0),
                    v: Vec3::zero(),
                }
            },
            spin: if P::SPINS {
                grains.spin[i].load()
            } else {
                Vec3::zero()
            },
        }
    }

    #[inline(always)]
    pub(super) fn store<P: Physics>(self, grains: &mut MotionsMut<'_, L::Row>, i: usize) {
        self.displacement.store(&mut grains.displacement[i]);
        self.velocity.store(&mut grains.velocity[i]);
        if P::ORIENTED {
            self.turn.store(&mut grains.turn[i]);
        }
        if P::SPINS {
            self.spin.store(&mut grains.spin[i]);
        }
    }

    /// Where the sphere at `arm` in the reference is: its displacement, and its place about the center of mass.
    #[inline(always)]
    pub(super) fn sphere<P: Physics>(&self, arm: Vec3<L>) -> (Vec3<L>, Vec3<L>) {
        if P::ORIENTED {
            let shift = self.turn.shift(arm);
            (self.displacement + shift, arm + shift)
        } else {
            (self.displacement, Vec3::zero())
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
    /// 1 where all are alike.
    pub(super) radius: L,
    /// Meaningless where all are alike.
    pub(super) inverse_mass: L,
}

/// Radius and inverse mass of grain `i`; 1 and nothing where all are alike.
#[inline(always)]
pub(super) fn size<L: Lane, P: Physics>(sizes: &[Size], i: usize) -> (L, L) {
    if P::GRADED {
        let size = sizes[i];
        (L::constant(size.radius), L::constant(size.inverse_mass))
    } else {
        (L::constant(1.0), L::constant(0.0))
    }
}

impl<L: Lane> RowGrain<L> {
    #[inline(always)]
    pub(super) fn load<P: Physics>(
        fixed: &Fixed<'_, L::Row>,
        moving: &Moving<L>,
        i: usize,
    ) -> Self {
        let (radius, inverse_mass) = size::<L, P>(fixed.sizes, i);
        let mut at = Self {
            velocity: moving.velocity,
            spin: moving.spin,
            shifted: [moving.displacement; MOST_SPHERES],
            arms: [Vec3::zero(); MOST_SPHERES],
            radius,
            inverse_mass,
        };
        if P::ORIENTED {
            for a in 0..P::Shape::SPHERES {
                let arm = Vec3::broadcast(fixed.lane_arms[P::Shape::SPHERES * i + a]);
                (at.shifted[a], at.arms[a]) = moving.sphere::<P>(arm);
            }
        }
        at
    }
}

/// What acts on the grain whose row is at hand.
#[derive(Clone, Copy)]
pub(super) struct Load<L> {
    pub(super) force: Vec3<L>,
    /// Meaningless where nothing spins.
    pub(super) torque: Vec3<L>,
}

impl<L: Lane> Load<L> {
    /// Nothing.
    #[inline(always)]
    pub(super) fn none() -> Self {
        Self {
            force: Vec3::zero(),
            torque: Vec3::zero(),
        }
    }
}

/// The force of a wall on one sphere, noted in `pushes` if there is any.
#[inline(always)]
pub(super) fn push_of_wall<L: Lane, P: Physics>(
    constants: &MotionConstants<L>,
    at: &RowGrain<L>,
    candidate: &WallCandidate<L::Scalar>,
    walls: &Walls<L::Row>,
    pushes: &mut Vec<(u8, L::Row)>,
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
    pushes.push((candidate.wall, row));
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
    pub(super) fn swept<P: Physics>(self, laws: &Laws<P>, walls: &Walls<impl Row>) -> f64 {
        let (mut speed, mut spin) = (L::Row::default(), L::Row::default());
        self.speed.store(&mut speed);
        self.spin.store(&mut spin);
        let grains = speed
            .lanes()
            .iter()
            .zip(spin.lanes())
            .map(|(v, w)| v.to_f64().sqrt() + laws.body.reach() * w.to_f64().sqrt());
        let walls = walls.velocity.iter().flat_map(Row::lanes);
        let walls = walls.map(|v| v.to_f64().abs());
        grains.chain(walls).fold(0.0, farther) * laws.time_step
    }
}

/// The larger of two; not a number if either is none.
pub(super) fn farther(a: f64, b: f64) -> f64 {
    if b <= a || a.is_nan() { a } else { b }
}

/// Kick by a whole step and drift of a grain whose reference is at `position`.
#[inline(always)]
pub(super) fn advance<L: Lane, P: Physics>(
    constants: &MotionConstants<L>,
    (body_force, affine): (&P::Body, &AffineRate<L::Row>),
    position: [L; 3],
    load: &Load<L>,
    from: Moving<L>,
    fastest: &mut Fastest<L>,
) -> Moving<L> {
    let [x, y, z] = position;
    let mut to = from;
    let acceleration = body_force.linear(
        Vec3 { x, y, z } + from.displacement,
        from.velocity,
        affine,
        load.force.scale(constants.inverse_mass),
    );
    to.velocity = acceleration.scale_add(constants.time_step, from.velocity);
    to.displacement = if L::Scalar::COARSE {
        let path = to.velocity.scale(constants.time_step);
        from.displacement.grown(path, constants.dither)
    } else {
        to.velocity
            .scale_add(constants.time_step, from.displacement)
    };
    // `max` keeps its second argument where the first is not a number, so a square that is none must come second.
    fastest.speed = fastest.speed.max(to.velocity.dot(to.velocity));
    if P::SPINS {
        let acceleration =
            body_force.angular(from.spin, load.torque.scale(constants.inverse_inertia));
        to.spin = acceleration.scale_add(constants.time_step, from.spin);
        if P::ORIENTED {
            let turn = to.spin.scale(constants.time_step);
            to.turn = from.turn.turned(turn, constants.dither);
            fastest.spin = fastest.spin.max(to.spin.dot(to.spin));
        }
    }
    to
}
