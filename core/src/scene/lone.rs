//! One step of a lone run: every lane is a contact.
//!
//! Touching pairs are gathered eight at a time, across rows, and their forces found side by side.
//! They are added in the order of the list, so the sums are those of an ensemble's lane, bit for bit.

use crate::contact::{Components, TangentialLaw};
use crate::lanes::{F64x1, F64x8, Kernel, Lane, Mask};
use crate::math::Vec3;
use crate::shape::Shape;
use crate::wall::{MAX_LANES, WALLS};

use super::contacts::{Contacts, Placed};
use super::interact::{Constants, Partner, excess, geometry, interact};
use super::motion::{Fastest, Load, MotionConstants, RowGrain, advance, push_of_wall};
use super::{Physics, Scene};
use crate::grains::Grains;

/// Contacts side by side.
const WIDE: usize = 8;

/// The whole step; returns how far anything can have moved.
pub(super) struct LoneStep<'a, P: Physics> {
    pub(super) scene: &'a mut Scene<F64x1, P>,
}

/// Touching pairs, waiting until there are eight.
struct Queue {
    len: usize,
    i: [u32; WIDE],
    candidate: [u32; WIDE],
    excess: F64x8,
    branch: Vec3<F64x8>,
    at_i: Gathered,
    at_j: Gathered,
}

/// One of the two grains of each pair.
#[derive(Clone, Copy, Default)]
struct Gathered {
    arm: Vec3<F64x8>,
    velocity: Vec3<F64x8>,
    spin: Vec3<F64x8>,
}

impl Queue {
    fn empty() -> Self {
        Self {
            len: 0,
            i: [0; WIDE],
            candidate: [0; WIDE],
            excess: F64x8::default(),
            // Lanes that are never filled must still have a length to divide by.
            branch: Vec3 {
                x: F64x8([2.0; WIDE]),
                y: F64x8::default(),
                z: F64x8::default(),
            },
            at_i: Gathered::default(),
            at_j: Gathered::default(),
        }
    }
}

#[inline(always)]
fn put(rows: &mut Vec3<F64x8>, e: usize, vector: Vec3<F64x1>) {
    rows.x.0[e] = vector.x.0[0];
    rows.y.0[e] = vector.y.0[0];
    rows.z.0[e] = vector.z.0[0];
}

#[inline(always)]
fn get(rows: &Vec3<F64x8>, e: usize) -> Vec3<F64x1> {
    Vec3 {
        x: F64x1([rows.x.0[e]]),
        y: F64x1([rows.y.0[e]]),
        z: F64x1([rows.z.0[e]]),
    }
}

impl Gathered {
    #[inline(always)]
    fn put<P: Physics>(
        &mut self,
        e: usize,
        arm: Vec3<F64x1>,
        velocity: Vec3<F64x1>,
        spin: Vec3<F64x1>,
    ) {
        put(&mut self.arm, e, arm);
        put(&mut self.velocity, e, velocity);
        if P::SPINS {
            put(&mut self.spin, e, spin);
        }
    }

    #[inline(always)]
    fn load<W: Lane<Row = F64x8>>(&self) -> Partner<W> {
        Partner {
            arm: self.arm.load(),
            velocity: self.velocity.load(),
            spin: self.spin.load(),
        }
    }
}

impl<P: Physics> Kernel<F64x8> for LoneStep<'_, P> {
    type Output = f64;

    #[inline(always)]
    fn run<W: Lane<Row = F64x8, Scalar = f64>>(self) -> f64 {
        let Scene {
            laws,
            grains,
            walls,
            contacts,
            affine,
            ..
        } = self.scene;
        let constants = Constants::<W, P::Tangential>::new(laws);
        let mut queue = Queue::empty();
        place::<P>(grains, &mut contacts.placed);
        for i in 0..grains.len() {
            for c in contacts.starts[i] as usize..contacts.starts[i + 1] as usize {
                note::<P>(i, c, grains, contacts, &mut queue);
                if queue.len == WIDE {
                    act::<W, P>(&constants, &mut queue, grains, contacts);
                }
            }
        }
        act::<W, P>(&constants, &mut queue, grains, contacts);

        let motion = MotionConstants::<F64x1>::new(laws);
        walls.force = [[0.0; MAX_LANES]; WALLS];
        let mut fastest = Fastest::none();
        for i in 0..grains.len() {
            let mut load = Load::<F64x1>::take::<P>(grains, i);
            let at_walls = contacts.wall_starts[i] as usize..contacts.wall_starts[i + 1] as usize;
            if !at_walls.is_empty() {
                let at = RowGrain::<F64x1>::load::<P>(grains, i);
                for c in at_walls {
                    push_of_wall::<F64x1, P>(
                        &motion,
                        &at,
                        &contacts.wall_candidates[c],
                        walls,
                        &mut load,
                    );
                }
            }
            advance::<F64x1, P>(
                &motion,
                (&laws.body_force, affine),
                i,
                &load,
                grains,
                &mut fastest,
            );
        }
        fastest.swept(laws, walls)
    }
}

/// Finds where every sphere is.
#[inline(always)]
fn place<P: Physics>(grains: &Grains<F64x1>, placed: &mut Vec<Placed<F64x1>>) {
    if P::ORIENTED {
        placed.resize(P::Shape::SPHERES * grains.len(), Placed::default());
        for (i, spheres) in placed.chunks_exact_mut(P::Shape::SPHERES).enumerate() {
            let at = RowGrain::<F64x1>::load::<P>(grains, i);
            for (a, sphere) in spheres.iter_mut().enumerate() {
                *sphere = Placed {
                    shifted: at.shifted[a],
                    arm: at.arms[a],
                };
            }
        }
    }
}

/// Tests candidate `c` and queues it if it touches.
#[inline(always)]
fn note<P: Physics>(
    i: usize,
    c: usize,
    grains: &Grains<F64x1>,
    contacts: &mut Contacts<F64x1, P::Tangential>,
    queue: &mut Queue,
) {
    let candidate = &mut contacts.candidates[c];
    let (j, a, b) = (
        candidate.j as usize,
        usize::from(candidate.a),
        usize::from(candidate.b),
    );
    let sphere = |grain: usize, sphere: usize| {
        if P::ORIENTED {
            contacts.placed[P::Shape::SPHERES * grain + sphere]
        } else {
            Placed {
                shifted: grains.displacement[grain],
                arm: Vec3::zero(),
            }
        }
    };
    let (at_i, at_j) = (sphere(i, a), sphere(j, b));
    let change = at_i.shifted - at_j.shifted;
    let twice = Vec3::broadcast(candidate.twice_branch);
    let excess = excess(twice, F64x1([candidate.excess]), change);
    let touching = excess.lt(F64x1([0.0])).any();
    if candidate.live && !touching {
        contacts.histories[c] = Components::from_fn(|_| F64x1::default());
    }
    candidate.live = touching;
    let e = queue.len;
    queue.i[e] = i as u32;
    queue.candidate[e] = c as u32;
    queue.excess.0[e] = excess.0[0];
    put(&mut queue.branch, e, twice.scale_add(F64x1([0.5]), change));
    let spin = |grain: usize| {
        if P::SPINS {
            grains.spin[grain]
        } else {
            Vec3::zero()
        }
    };
    queue
        .at_i
        .put::<P>(e, at_i.arm, grains.velocity[i], spin(i));
    queue
        .at_j
        .put::<P>(e, at_j.arm, grains.velocity[j], spin(j));
    queue.len += usize::from(touching);
}

/// Adds the forces of all queued pairs, in the order in which they were queued.
#[inline(always)]
fn act<W: Lane<Row = F64x8>, P: Physics>(
    constants: &Constants<W, P::Tangential>,
    queue: &mut Queue,
    grains: &mut Grains<F64x1>,
    contacts: &mut Contacts<F64x1, P::Tangential>,
) {
    let len = std::mem::take(&mut queue.len);
    let mut rows =
        <P::Tangential as TangentialLaw>::History::<F64x8>::from_fn(|_| F64x8::default());
    for (n, row) in rows.as_mut_slice().iter_mut().enumerate() {
        for e in 0..len {
            row.0[e] = contacts.histories[queue.candidate[e] as usize].as_slice()[n].0[0];
        }
    }
    let mut history =
        <P::Tangential as TangentialLaw>::History::<W>::from_fn(|n| W::load(&rows.as_slice()[n]));
    let geometry = geometry(queue.branch.load::<W>(), W::load(&queue.excess));
    let (i, j) = (queue.at_i.load(), queue.at_j.load());
    let action = interact::<W, P>(constants, &geometry, &i, &j, &mut history);
    for (n, row) in rows.as_mut_slice().iter_mut().enumerate() {
        history.as_slice()[n].store(row);
        for e in 0..len {
            contacts.histories[queue.candidate[e] as usize].as_mut_slice()[n].0[0] = row.0[e];
        }
    }
    let (mut force, mut torque_i, mut torque_j) =
        (Vec3::default(), Vec3::default(), Vec3::default());
    action.force.store(&mut force);
    if P::SPINS {
        action.torque_i().store(&mut torque_i);
        action.torque_j().store(&mut torque_j);
    }
    for e in 0..len {
        let i = queue.i[e] as usize;
        let j = contacts.candidates[queue.candidate[e] as usize].j as usize;
        let force = get(&force, e);
        grains.force[i] = grains.force[i] + force;
        grains.force[j] = grains.force[j] - force;
        if P::SPINS {
            grains.torque[i] = grains.torque[i] + get(&torque_i, e);
            grains.torque[j] = grains.torque[j] + get(&torque_j, e);
        }
    }
}
