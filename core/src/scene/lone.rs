//! One step of a lone run: every lane is a contact, or a grain.
//!
//! Candidates are taken eight at a time, across the rows of a block, and their forces found side by side.
//! Grains are placed and moved eight at a time.
//! Forces are added in the order of the list, so the sums are those of an ensemble's lane, bit for bit.

mod eight;
mod records;

use std::marker::PhantomData;

use crate::contact::{Components, TangentialLaw};
use crate::crew;
use crate::force::AffineRate;
use crate::grains::{Grains, Pose, Size};
use crate::lanes::{F64x1, F64x8, Kernel, Lane, Mask, dispatch};
use crate::math::Vec3;
use crate::wall::Walls;

use eight::Eight;
pub(super) use records::Records;
use records::{Adding, Ball, Blank, Read, Sums, records};

use super::blocks::{self, Counts, Divide};
use super::contacts::{Candidate, Contacts};
use super::interact::{Constants, branch, geometry, interact};
use super::motion::{
    Fastest, Load, MotionConstants, Moving, RowGrain, advance, farther, push_of_wall,
};
use super::motions::MotionsMut;
use super::surroundings::{OnGrains, Surroundings};
use super::{Laws, Physics, Scene};

/// Lanes.
const WIDE: usize = 8;

/// Components of histories that become lanes together.
const GROUP: usize = 3;

/// Takes the whole step; returns how far anything can have moved.
///
/// Grains act on each other, block by block, while their surroundings act on them, on the threads of the job:
/// none reads what another writes.
pub(super) fn step<P: Physics>(scene: &mut Scene<F64x1, P>) -> f64 {
    let Scene {
        laws,
        grains,
        walls,
        contacts,
        affine,
        work,
        surroundings,
        ..
    } = scene;
    let (width, time_step) = (laws.width, laws.time_step);
    blocks::each(&contacts.blocks, work.blank(), &|block, blank| {
        let written = Written::<P> {
            grains,
            first: block.rows.start,
            blank,
            physics: PhantomData,
        };
        dispatch::<F64x8, _>(width, written);
    });
    let surroundings_act = || surroundings.act(grains, time_step, width);
    let mut grains_act = || pairs_act(laws, contacts, work);
    if size_of::<P::Surroundings>() > 0 {
        crew::both(surroundings_act, grains_act);
    } else {
        grains_act();
    }
    settle_and_push(laws, grains, walls, contacts, work);
    walls.bear(work.pushes());
    surroundings.push_grains(&mut OnGrains(&mut work.loads));
    let swept = move_grains(laws, grains, (walls, affine), contacts, work);
    farther(swept, surroundings.advance(time_step))
}

/// Writes the records of the grains of a block.
struct Written<'a, P> {
    grains: &'a Grains<F64x1>,
    first: usize,
    blank: Blank<'a>,
    physics: PhantomData<P>,
}

impl<P: Physics> Kernel<F64x8> for Written<'_, P> {
    type Output = ();

    #[inline(always)]
    fn run<W: Lane<Row = F64x8, Scalar = f64>>(self) {
        self.blank.write::<W, P>(self.grains, self.first);
    }
}

/// Adds the forces of all pairs of grains.
fn pairs_act<P: Physics>(
    laws: &Laws<P>,
    contacts: &mut Contacts<F64x1, P::Tangential>,
    work: &mut Records,
) {
    let (read, sums) = work.shared_out(contacts.blocks.len());
    let listed = Listed::<P::Tangential> {
        candidates: &contacts.candidates,
        histories: &mut contacts.histories,
        slices: &mut contacts.slices,
        live: &mut contacts.live,
        sums,
    };
    blocks::each(&contacts.blocks, listed, &|block, listed| {
        let Listed {
            candidates,
            histories,
            slices,
            live,
            sums,
        } = listed;
        if let Some(adding) = sums.of(block) {
            let pairs = Pairs {
                laws,
                candidates,
                memory: (histories, slices, live),
                read,
                adding,
            };
            dispatch::<F64x8, _>(laws.width, pairs);
        }
    });
}

/// The candidates of some neighboring blocks, and where they add.
struct Listed<'a, T: TangentialLaw> {
    candidates: &'a [Candidate<f64>],
    histories: &'a mut [T::History<F64x1>],
    slices: &'a mut [T::Slices<F64x1>],
    live: &'a mut [bool],
    sums: Sums<'a>,
}

impl<T: TangentialLaw> Divide for Listed<'_, T> {
    fn divide(self, counts: &Counts) -> (Self, Self) {
        let (candidates, other_candidates) = self.candidates.split_at(counts.candidates);
        let (histories, other_histories) = self.histories.split_at_mut(counts.candidates);
        let (slices, other_slices) = self.slices.split_at_mut(counts.candidates);
        let (live, other_live) = self.live.split_at_mut(counts.candidates);
        let (sums, other_sums) = self.sums.divide(counts);
        let own = Self {
            candidates,
            histories,
            slices,
            live,
            sums,
        };
        let other = Self {
            candidates: other_candidates,
            histories: other_histories,
            slices: other_slices,
            live: other_live,
            sums: other_sums,
        };
        (own, other)
    }
}

/// What candidates remember, and whether they touched.
type Memory<'a, T> = (
    &'a mut [<T as TangentialLaw>::History<F64x1>],
    &'a mut [<T as TangentialLaw>::Slices<F64x1>],
    &'a mut [bool],
);

/// The same of eight.
type MemoryOfEight<'a, T> = (
    &'a mut [<T as TangentialLaw>::History<F64x1>; WIDE],
    &'a mut [<T as TangentialLaw>::Slices<F64x1>; WIDE],
    &'a mut [bool; WIDE],
);

/// Adds the forces of the pairs of a block.
struct Pairs<'a, P: Physics> {
    laws: &'a Laws<P>,
    candidates: &'a [Candidate<f64>],
    memory: Memory<'a, P::Tangential>,
    read: Read<'a>,
    adding: Adding<'a>,
}

impl<P: Physics> Kernel<F64x8> for Pairs<'_, P> {
    type Output = ();

    #[inline(always)]
    fn run<W: Lane<Row = F64x8, Scalar = f64>>(self) {
        let constants = Constants::<W, P::Tangential>::new(self.laws);
        interact_all::<W, P>(
            &constants,
            self.candidates,
            self.memory,
            (self.read, self.adding),
        );
    }
}

/// Adds what blocks have kept apart, and the forces of the walls.
fn settle_and_push<P: Physics>(
    laws: &Laws<P>,
    grains: &Grains<F64x1>,
    walls: &Walls<F64x1>,
    contacts: &Contacts<F64x1, P::Tangential>,
    work: &mut Records,
) {
    let (kept, settling) = work.unsettled(contacts.blocks.len());
    blocks::each(&contacts.blocks, settling, &|block, mut settling| {
        settling.settle(block, kept);
        if let [pushes] = settling.pushes {
            pushes.clear();
            if contacts.wall_candidates.is_empty() {
                return;
            }
            let pushed = Pushed {
                laws,
                grains,
                walls,
                contacts,
                first: block.rows.start,
                loads: settling.loads,
                pushes,
            };
            dispatch::<F64x1, _>(laws.width, pushed);
        }
    });
}

/// Adds the forces of the walls on the grains of a block.
struct Pushed<'a, P: Physics> {
    laws: &'a Laws<P>,
    grains: &'a Grains<F64x1>,
    walls: &'a Walls<F64x1>,
    contacts: &'a Contacts<F64x1, P::Tangential>,
    first: usize,
    loads: &'a mut [F64x8],
    pushes: &'a mut Vec<(u8, F64x1)>,
}

impl<P: Physics> Kernel<F64x1> for Pushed<'_, P> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lane<Row = F64x1, Scalar = f64>>(self) {
        let Self {
            walls,
            contacts,
            pushes,
            ..
        } = self;
        let motion = MotionConstants::<L>::new(self.laws);
        let (fixed, motions) = self.grains.read();
        let starts = &contacts.wall_starts[self.first..];
        for (n, sum) in self.loads.iter_mut().enumerate() {
            let candidates = starts[n] as usize..starts[n + 1] as usize;
            if candidates.is_empty() {
                continue;
            }
            let i = self.first + n;
            let at = RowGrain::<L>::load::<P>(&fixed, &Moving::load::<P>(&motions, i), i);
            let [force, torque] = sum.halves().map(|&[x, y, z, _]| Vec3 {
                x: L::splat(x),
                y: L::splat(y),
                z: L::splat(z),
            });
            let mut load = Load { force, torque };
            for candidate in &contacts.wall_candidates[candidates] {
                push_of_wall::<L, P>(&motion, &at, candidate, walls, pushes, &mut load);
            }
            let mut sums = [Vec3::<F64x1>::default(); 2];
            load.force.store(&mut sums[0]);
            load.torque.store(&mut sums[1]);
            let sums = sums.map(|v| [v.x.0[0], v.y.0[0], v.z.0[0], 0.0]);
            sum.0.copy_from_slice(sums.as_flattened());
        }
    }
}

/// Moves all grains; returns how far any of them, or a wall, can have moved.
fn move_grains<P: Physics>(
    laws: &Laws<P>,
    grains: &mut Grains<F64x1>,
    (walls, affine): (&Walls<F64x1>, &AffineRate<F64x1>),
    contacts: &Contacts<F64x1, P::Tangential>,
    work: &mut Records,
) -> f64 {
    let (loads, swept) = work.loads_and_swept(contacts.blocks.len());
    let (fixed, motions) = grains.parts();
    let moving = (motions, &mut swept[..]);
    blocks::each(&contacts.blocks, moving, &|block, (motions, swept)| {
        let rows = block.rows.clone();
        let moved = Moved {
            laws,
            walls,
            affine,
            reference: &fixed.reference[rows.clone()],
            sizes: fixed.sizes.get(rows.clone()).unwrap_or_default(),
            motions,
            loads: &loads[rows],
        };
        if let [swept] = swept {
            *swept = dispatch::<F64x8, _>(laws.width, moved);
        }
    });
    swept.iter().copied().fold(0.0, farther)
}

/// Moves the grains of a block; returns how far any of them, or a wall, can have moved.
struct Moved<'a, P: Physics> {
    laws: &'a Laws<P>,
    walls: &'a Walls<F64x1>,
    affine: &'a AffineRate<F64x1>,
    reference: &'a [Pose],
    sizes: &'a [Size],
    motions: MotionsMut<'a, F64x1>,
    loads: &'a [F64x8],
}

impl<P: Physics> Kernel<F64x8> for Moved<'_, P> {
    type Output = f64;

    #[inline(always)]
    fn run<W: Lane<Row = F64x8, Scalar = f64>>(self) -> f64 {
        let Self {
            laws, mut motions, ..
        } = self;
        let motion = MotionConstants::<W>::new(laws);
        let affine = AffineRate {
            rate: everywhere(&self.affine.rate),
        };
        let mut fastest = Fastest::none();
        for first in (0..self.reference.len()).step_by(WIDE) {
            let eight = Eight::from(first, self.reference.len());
            let position = eight.gather::<W>(|i| self.reference[i].position);
            let moved = advance::<W, P>(
                &motion.sized::<P>(|of| eight.numbers(|i| of(&self.sizes[i]))),
                (&laws.body_force, &affine),
                [position.x, position.y, position.z],
                &records::load::<W, P>(self.loads, eight),
                eight.load::<W, P>(&motions.read()),
                &mut fastest,
            );
            eight.store::<W, P>(moved, &mut motions);
        }
        fastest.swept(laws, self.walls)
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

/// Adds the forces of all of these candidates, in their order.
#[inline(always)]
fn interact_all<W: Lane<Row = F64x8, Scalar = f64>, P: Physics>(
    constants: &Constants<W, P::Tangential>,
    candidates: &[Candidate<f64>],
    (histories, slices, live): Memory<'_, P::Tangential>,
    (read, mut adding): (Read<'_>, Adding<'_>),
) {
    let (candidates, last_candidates) = candidates.as_chunks();
    let (histories, last_histories) = histories.as_chunks_mut();
    let (slices, last_slices) = slices.as_chunks_mut();
    let (live, last_live) = live.as_chunks_mut();
    let memories = histories.iter_mut().zip(slices).zip(live);
    for (candidates, ((histories, slices), live)) in candidates.iter().zip(memories) {
        interact_eight::<W, P>(
            constants,
            W::constant(0.0),
            candidates,
            (histories, slices, live),
            (read, &mut adding),
        );
    }
    let count = last_candidates.len();
    if count > 0 {
        let nth = |e: usize| e.min(count - 1);
        let mut histories = std::array::from_fn(|e| last_histories[nth(e)]);
        let mut live = std::array::from_fn(|e| last_live[nth(e)]);
        let mut slices = std::array::from_fn(|e| match last_slices.get_mut(e) {
            Some(slices) => std::mem::take(slices),
            None => Default::default(),
        });
        interact_eight::<W, P>(
            constants,
            excess_below(count),
            &std::array::from_fn(|e| last_candidates[nth(e)]),
            (&mut histories, &mut slices, &mut live),
            (read, &mut adding),
        );
        last_histories.copy_from_slice(&histories[..count]);
        last_live.copy_from_slice(&live[..count]);
        for (last, slices) in last_slices.iter_mut().zip(slices) {
            *last = slices;
        }
    }
}

/// 0 in the first `count` lanes; in the others nothing is smaller.
#[inline(always)]
fn excess_below<W: Lane<Row = F64x8, Scalar = f64>>(count: usize) -> W {
    let bound = |e| if e < count { 0.0 } else { f64::NEG_INFINITY };
    W::load(&F64x8(std::array::from_fn(bound)))
}

/// Adds the forces of those of eight candidates whose excess is below `bound`.
///
/// The others add an exact zero, which changes no sum: a sum that starts at +0 is never −0.
#[inline(always)]
fn interact_eight<W: Lane<Row = F64x8, Scalar = f64>, P: Physics>(
    constants: &Constants<W, P::Tangential>,
    bound: W,
    candidates: &[Candidate<f64>; WIDE],
    (histories, slices, live): MemoryOfEight<'_, P::Tangential>,
    (read, adding): (Read<'_>, &mut Adding<'_>),
) {
    let of_i = candidates.each_ref().map(Ball::i::<P>);
    let of_j = candidates.each_ref().map(Ball::j::<P>);
    let (shifted_i, radius_i) = read.shifted::<W, P>(&of_i);
    let (shifted_j, radius_j) = read.shifted::<W, P>(&of_j);
    let branch = branch::<W, P>(
        W::gather(|e| &candidates[e].reference),
        shifted_i - shifted_j,
        radius_i + radius_j,
    );
    let touching = branch.excess.lt(bound);
    let touches = flags(touching.bits());
    if !touching.any() {
        if *live != touches {
            *live = touches;
            *histories = [Components::from_fn(|_| F64x1::default()); WIDE];
        }
        return;
    }
    *live = touches;
    let mut history = remembered::<W, P::Tangential>(histories);
    let action = interact::<W, P>(
        constants,
        &geometry::<W, P>(branch, [radius_i, radius_j]),
        &read.partner::<W, P>(&of_i, radius_i),
        &read.partner::<W, P>(&of_j, radius_j),
        (&mut history, slices),
    );
    remember::<W, P::Tangential>(&history, touching, histories);
    let action = action.keep(touching);
    let (mut on_i, mut on_j) = (Vec3::zero(), Vec3::zero());
    if P::SPINS {
        on_i = action.torque_i();
        on_j = action.torque_j();
    }
    let spare = [W::constant(0.0); 2];
    let on_i = records(action.force, on_i, spare);
    let on_j = records(action.force.scale(W::constant(-1.0)), on_j, spare);
    adding.add(candidates, [on_i, on_j]);
}

/// One truth value for each of the lowest eight bits, by arithmetic on all at once.
#[inline(always)]
fn flags(bits: u32) -> [bool; WIDE] {
    let each = u64::from(bits).wrapping_mul(0x0101_0101_0101_0101) & 0x8040_2010_0804_0201;
    let highest = each + 0x7F7F_7F7F_7F7F_7F7F;
    (highest >> 7 & 0x0101_0101_0101_0101)
        .to_le_bytes()
        .map(|flag| flag == 1)
}

/// The histories of eight contacts, one to a lane.
#[inline(always)]
fn remembered<W: Lane<Row = F64x8, Scalar = f64>, T: TangentialLaw>(
    histories: &[T::History<F64x1>; WIDE],
) -> T::History<W> {
    let mut history = T::History::<W>::from_fn(|_| W::constant(0.0));
    let all = history.as_mut_slice();
    for first in (0..all.len()).step_by(GROUP) {
        let group = &mut all[first..];
        let mut triples = [[0.0; GROUP]; WIDE];
        for (triple, history) in triples.iter_mut().zip(histories) {
            for (to, from) in triple.iter_mut().zip(&history.as_slice()[first..]) {
                *to = from.0[0];
            }
        }
        for (to, from) in group.iter_mut().zip(W::of_triples(&triples)) {
            *to = from;
        }
    }
    history
}

/// Writes the histories of those of eight contacts that touch, and zero to the others.
#[inline(always)]
fn remember<W: Lane<Row = F64x8, Scalar = f64>, T: TangentialLaw>(
    history: &T::History<W>,
    touching: W::Mask,
    histories: &mut [T::History<F64x1>; WIDE],
) {
    let all = history.as_slice();
    for first in (0..all.len()).step_by(GROUP) {
        let mut vectors = [W::constant(0.0); GROUP];
        for (to, from) in vectors.iter_mut().zip(&all[first..]) {
            *to = from.keep(touching);
        }
        for (history, triple) in histories.iter_mut().zip(W::triples(vectors)) {
            for (to, from) in history.as_mut_slice()[first..].iter_mut().zip(triple) {
                *to = F64x1([from]);
            }
        }
    }
}

#[cfg(test)]
mod tests;
