//! One step of a lone run: every lane is a contact, or a grain.
//!
//! Candidates are tested one by one; those that touch are gathered eight at a time, across rows, and their forces found
//! side by side.
//! Grains are placed and moved eight at a time.
//! Forces are added in the order of the list, so the sums are those of an ensemble's lane, bit for bit.

mod eight;
mod records;
mod touching;

use crate::contact::{Components, TangentialLaw};
use crate::force::AffineRate;
use crate::grains::Grains;
use crate::lanes::{F64x1, F64x8, Kernel, Lane};
use crate::math::Vec3;
use crate::wall::{MAX_LANES, WALLS, Walls};

use eight::Eight;
pub(super) use records::Records;
use records::{Pair, fours, fours_if, vector};
use touching::{MANY, Touching};

use super::contacts::Contacts;
use super::interact::{Branch, Constants, Geometry, geometry, interact};
use super::motion::{Fastest, Load, MotionConstants, RowGrain, advance, push_of_wall};
use super::{Physics, Scene};

/// Lanes.
const WIDE: usize = 8;

/// The whole step; returns how far anything can have moved.
pub(super) struct LoneStep<'a, P: Physics> {
    pub(super) scene: &'a mut Scene<F64x1, P>,
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
            work,
            ..
        } = self.scene;
        work.write::<W, P>(grains);
        let constants = Constants::<W, P::Tangential>::new(laws);
        let mut touching = Touching::none();
        for first in (0..contacts.candidates.len()).step_by(MANY) {
            interact_many::<W, P>(&constants, first, &mut touching, work, contacts);
        }
        let motion = MotionConstants::<F64x1>::new(laws);
        push_of_walls::<P>(&motion, grains, contacts, walls, &mut work.loads);

        let motion = MotionConstants::<W>::new(laws);
        let affine = AffineRate {
            rate: everywhere(&affine.rate),
        };
        let mut fastest = Fastest::none();
        for first in (0..grains.len()).step_by(WIDE) {
            let eight = Eight::from(first, grains.len());
            let position = eight.gather::<W>(|i| grains.reference()[i].position);
            let moved = advance::<W, P>(
                &motion,
                (&laws.body_force, &affine),
                [position.x, position.y, position.z],
                &work.load::<W, P>(eight),
                eight.load::<W, P>(grains),
                &mut fastest,
            );
            eight.store::<W, P>(moved, grains);
        }
        fastest.swept(laws, walls)
    }
}

/// The same vector in every lane.
#[inline(always)]
fn everywhere(vector: &Vec3<F64x1>) -> Vec3<F64x8> {
    Vec3 {
        x: F64x8([vector.x.0[0]; WIDE]),
        y: F64x8([vector.y.0[0]; WIDE]),
        z: F64x8([vector.z.0[0]; WIDE]),
    }
}

/// The geometry of pairs that are not.
const NOWHERE: Geometry<F64x8> = Geometry {
    normal: Vec3 {
        x: F64x8([0.0; WIDE]),
        y: F64x8([0.0; WIDE]),
        z: F64x8([0.0; WIDE]),
    },
    overlap: F64x8([0.0; WIDE]),
    root_overlap: F64x8([0.0; WIDE]),
};

/// Adds the forces of those of the next candidates that touch, in their order.
///
/// A loop for each part, so that long chains of roots and divisions of different pairs overlap.
#[inline(always)]
fn interact_many<W: Lane<Row = F64x8, Scalar = f64>, P: Physics>(
    constants: &Constants<W, P::Tangential>,
    first: usize,
    touching: &mut Touching,
    work: &mut Records,
    contacts: &mut Contacts<F64x1, P::Tangential>,
) {
    let end = contacts.candidates.len().min(first + MANY);
    touching.find::<P>(first, work, &contacts.candidates[first..end]);
    forget::<P>(first, &touching.all[..end - first], contacts);
    let mut geometries = [NOWHERE; MANY / WIDE];
    let batches = touching.len.div_ceil(WIDE);
    for (rows, branch) in geometries.iter_mut().zip(&touching.branches).take(batches) {
        let geometry = geometry(Branch {
            vector: branch.vector.load::<W>(),
            excess: W::load(&branch.excess),
        });
        geometry.normal.store(&mut rows.normal);
        geometry.overlap.store(&mut rows.overlap);
        geometry.root_overlap.store(&mut rows.root_overlap);
    }
    let (eights, _) = touching.candidates.as_chunks::<WIDE>();
    for (n, (rows, eight)) in geometries.iter().zip(eights).take(batches).enumerate() {
        let count = WIDE.min(touching.len - WIDE * n);
        push::<W, P>(constants, (eight, count), rows, work, contacts);
    }
}

/// Forgets what the pairs that parted remember.
#[inline(always)]
fn forget<P: Physics>(
    first: usize,
    touching: &[bool],
    contacts: &mut Contacts<F64x1, P::Tangential>,
) {
    let live = &mut contacts.live[first..first + touching.len()];
    if live != touching {
        for (e, (live, &touches)) in live.iter_mut().zip(touching).enumerate() {
            if *live && !touches {
                contacts.histories[first + e] = Components::from_fn(|_| F64x1::default());
            }
            *live = touches;
        }
    }
}

/// Adds the forces of the first `count` of eight pairs.
#[inline(always)]
fn push<W: Lane<Row = F64x8, Scalar = f64>, P: Physics>(
    constants: &Constants<W, P::Tangential>,
    (queued, count): (&[u32; WIDE], usize),
    geometry: &Geometry<F64x8>,
    work: &mut Records,
    contacts: &mut Contacts<F64x1, P::Tangential>,
) {
    let geometry = Geometry {
        normal: geometry.normal.load(),
        overlap: W::load(&geometry.overlap),
        root_overlap: W::load(&geometry.root_overlap),
    };
    let eight = queued.map(|c| &contacts.candidates[c as usize]);
    let i = work.partner::<W, P>(eight.map(|c| (c.i, c.a)));
    let j = work.partner::<W, P>(eight.map(|c| (c.j, c.b)));
    let mut rows =
        <P::Tangential as TangentialLaw>::History::<F64x8>::from_fn(|_| F64x8::default());
    for (n, row) in rows.as_mut_slice().iter_mut().enumerate() {
        for (number, &c) in row.0.iter_mut().zip(queued) {
            *number = contacts.histories[c as usize].as_slice()[n].0[0];
        }
    }
    let mut history =
        <P::Tangential as TangentialLaw>::History::<W>::from_fn(|n| W::load(&rows.as_slice()[n]));
    let action = interact::<W, P>(constants, &geometry, &i, &j, &mut history);
    for (n, row) in rows.as_mut_slice().iter_mut().enumerate() {
        history.as_slice()[n].store(row);
    }
    let forces = fours(action.force);
    let opposite = fours(action.force.scale(W::constant(-1.0)));
    let turning_i = fours_if(P::SPINS, action.torque_i());
    let turning_j = fours_if(P::SPINS, action.torque_j());
    let (i, j) = (eight.map(|c| c.i as usize), eight.map(|c| c.j as usize));
    for e in 0..count {
        let history = contacts.histories[queued[e] as usize].as_mut_slice();
        for (to, row) in history.iter_mut().zip(rows.as_slice()) {
            to.0[0] = row.0[e];
        }
        work.loads[i[e]].add::<P>(&forces[e], &turning_i[e]);
        work.loads[j[e]].add::<P>(&opposite[e], &turning_j[e]);
    }
}

/// Adds the forces of the walls.
#[inline(always)]
fn push_of_walls<P: Physics>(
    motion: &MotionConstants<F64x1>,
    grains: &Grains<F64x1>,
    contacts: &Contacts<F64x1, P::Tangential>,
    walls: &mut Walls<F64x1>,
    loads: &mut [Pair],
) {
    walls.force = [[0.0; MAX_LANES]; WALLS];
    for (i, sum) in loads.iter_mut().enumerate() {
        let candidates = contacts.wall_starts[i] as usize..contacts.wall_starts[i + 1] as usize;
        if candidates.is_empty() {
            continue;
        }
        let at = RowGrain::<F64x1>::load::<P>(grains, i);
        let [force, torque] = sum.0.map(|four| vector(four.map(|x| F64x1([x]))));
        let mut load = Load { force, torque };
        for candidate in &contacts.wall_candidates[candidates] {
            push_of_wall::<F64x1, P>(motion, &at, candidate, walls, &mut load);
        }
        for (four, v) in sum.0.iter_mut().zip([load.force, load.torque]) {
            *four = [v.x.0[0], v.y.0[0], v.z.0[0], 0.0];
        }
    }
}
