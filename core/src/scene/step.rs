//! One step of an ensemble: every lane is a replica.
//!
//! A row is done in two sweeps, so that long chains of roots and divisions of different contacts overlap:
//! first every candidate is tested and those that any replica touches are noted, then the forces of the noted ones are found.
//!
//! Blocks of rows, one for each thread of the job, first find the forces of their pairs with grains of the next
//! block, and sum what those add there apart; a row's candidates are sorted by the grain that they reach, so these are its last.
//! Then no block needs anything of another's grains, and all sums are added in the order in which one thread adds them.

use std::ops::Range;

use crate::contact::{Components, TangentialLaw};
use crate::force::AffineRate;
use crate::grains::Grains;
use crate::lanes::{Kernel, Lane, Mask, Row, dispatch, prefetch};
use crate::math::Vec3;
use crate::shape::Shape;
use crate::wall::Walls;

use super::blocks::{self, Block, Counts, Divide, Tail};
use super::contacts::{Candidate, Contacts, WallCandidate};
use super::interact::{Branch, Constants, Partner, branch, geometry, interact};
use super::motion::{
    Fastest, Load, MotionConstants, Moving, RowGrain, advance, farther, push_of_wall, size,
};
use super::motions::{Fixed, Motions, MotionsMut};
use super::{Laws, Physics, Replicas, Scene, Work};

/// Touching pairs that are noted before their forces are found.
const NOTED: usize = 16;

/// How many candidates ahead the other grain is asked for: about two rows of spheres, one of tetrahedra.
const AHEAD: usize = 8;

/// Forces and torques, one for each of some grains or contacts.
#[derive(Clone, Debug, Default)]
struct Sums<R> {
    force: Vec<Vec3<R>>,
    /// Empty where nothing can spin a grain.
    torque: Vec<Vec3<R>>,
}

impl<R: Row> Sums<R> {
    /// Makes them `len` zeros.
    fn zero<P: Physics>(&mut self, len: usize) {
        self.force.clear();
        self.force.resize(len, Vec3::default());
        self.torque.clear();
        self.torque
            .resize(if P::SPINS { len } else { 0 }, Vec3::default());
    }

    fn lend(&mut self) -> SumsMut<'_, R> {
        SumsMut {
            force: &mut self.force,
            torque: &mut self.torque,
        }
    }

    /// Notes one more.
    #[inline(always)]
    fn push<L: Lane<Row = R>, P: Physics>(&mut self, of: Load<L>) {
        let mut row = Vec3::default();
        of.force.store(&mut row);
        self.force.push(row);
        if P::SPINS {
            of.torque.store(&mut row);
            self.torque.push(row);
        }
    }

    /// Adds some of them to `load`, one after the other.
    #[inline(always)]
    fn add_to<L: Lane<Row = R>, P: Physics>(&self, range: Range<usize>, load: &mut Load<L>) {
        for n in range {
            load.force = load.force + self.force[n].load();
            if P::SPINS {
                load.torque = load.torque + self.torque[n].load();
            }
        }
    }
}

/// The same, lent.
struct SumsMut<'a, R> {
    force: &'a mut [Vec3<R>],
    torque: &'a mut [Vec3<R>],
}

impl<R: Row> Divide for SumsMut<'_, R> {
    fn divide(self, counts: &Counts) -> (Self, Self) {
        let (force, other_force) = self.force.split_at_mut(counts.rows);
        let (torque, other_torque) = self.torque.split_at_mut(counts.rows.min(self.torque.len()));
        let sums = |force, torque| SumsMut { force, torque };
        (sums(force, torque), sums(other_force, other_torque))
    }
}

/// What a step sums.
#[derive(Clone, Debug)]
pub struct Loads<R: Row> {
    /// On every grain; zero between steps.
    own: Sums<R>,
    /// Of every block, what its pairs with grains of the next do.
    across: Vec<Across<R>>,
    /// Of every block, what else its rows leave behind.
    left: Vec<Left<R>>,
}

/// What a block's pairs with grains of the next do.
#[derive(Clone, Debug, Default)]
struct Across<R> {
    /// The sums on the first grains of the next block.
    beyond: Sums<R>,
    /// The force and torque of each pair that touches on its grain of the block, in order.
    here: Sums<R>,
}

/// What the rows of a block leave behind besides how their grains move.
#[derive(Clone, Debug, Default)]
struct Left<R> {
    /// The forces of grains on walls, in order.
    pushes: Vec<(u8, R)>,
    /// How far anything can have moved.
    swept: f64,
}

impl<R: Row> Work<R> for Loads<R> {
    fn new<P: Physics>(grains: &Grains<R>) -> Self {
        let mut own = Sums::default();
        own.zero::<P>(grains.len());
        Self {
            own,
            across: vec![],
            left: vec![],
        }
    }

    fn bytes(&self) -> usize {
        std::mem::size_of::<Vec3<R>>() * (self.own.force.len() + self.own.torque.len())
    }
}

/// The whole step; returns how far anything can have moved.
pub(super) fn step<R: Replicas<Work = Loads<R>>, P: Physics>(scene: &mut Scene<R, P>) -> f64 {
    const {
        assert!(
            size_of::<P::Surroundings>() == 0,
            "only lone runs have surroundings"
        );
    }
    let Scene {
        laws,
        grains,
        walls,
        contacts,
        affine,
        work,
        ..
    } = scene;
    let Contacts {
        blocks,
        starts,
        candidates,
        tails,
        wall_starts,
        wall_candidates,
        live,
        histories,
        ..
    } = contacts;
    let (fixed, motions) = grains.parts();
    let given = Given {
        laws,
        fixed,
        walls,
        affine,
        starts,
        tails,
        wall_starts,
        wall_candidates,
    };
    work.across.resize_with(blocks.len(), Across::default);
    work.left.resize_with(blocks.len(), Left::default);
    if blocks.len() > 1 {
        let motions = motions.read();
        let pairs = Pairs::<R, P> {
            candidates,
            live,
            histories,
        };
        let with = (pairs, &mut work.across[..]);
        blocks::each(blocks, with, &|block, (pairs, across)| {
            if let [across] = across {
                given.run(block, pairs, Part::Across(motions, across));
            }
        });
    }
    let sums = work.own.lend();
    let pairs = Pairs::<R, P> {
        candidates,
        live,
        histories,
    };
    let across = &work.across;
    let with = ((pairs, &mut work.left[..]), (motions, sums));
    blocks::each(blocks, with, &|block, ((pairs, left), (motions, sums))| {
        if let [left] = left {
            let before = block.number.checked_sub(1);
            let own = Own {
                motions,
                sums,
                before: before.map(|before| &across[before].beyond),
                here: &across[block.number].here,
                pushes: &mut left.pushes,
            };
            left.swept = given.run(block, pairs, Part::Own(own));
        }
    });
    walls.bear(work.left.iter().flat_map(|left| &left.pushes));
    work.left.iter().map(|left| left.swept).fold(0.0, farther)
}

/// What all rows only read.
struct Given<'a, R: Row, P: Physics> {
    laws: &'a Laws<P>,
    fixed: Fixed<'a, R>,
    walls: &'a Walls<R>,
    affine: &'a AffineRate<R>,
    starts: &'a [u32],
    tails: &'a [Tail],
    wall_starts: &'a [u32],
    wall_candidates: &'a [WallCandidate<R::Scalar>],
}

impl<R: Row, P: Physics> Given<'_, R, P> {
    fn run(&self, block: &Block, pairs: Pairs<'_, R, P>, part: Part<'_, R>) -> f64 {
        let rows = Rows {
            given: self,
            block,
            pairs,
            part,
        };
        dispatch::<R, _>(self.laws.width, rows)
    }
}

/// The candidates of some neighboring blocks and what they remember.
struct Pairs<'a, R: Row, P: Physics> {
    candidates: &'a [Candidate<R::Scalar>],
    live: &'a mut [bool],
    histories: &'a mut [<P::Tangential as TangentialLaw>::History<R>],
}

impl<R: Row, P: Physics> Divide for Pairs<'_, R, P> {
    fn divide(self, counts: &Counts) -> (Self, Self) {
        let (candidates, other_candidates) = self.candidates.split_at(counts.candidates);
        let (live, other_live) = self.live.split_at_mut(counts.candidates);
        let (histories, other_histories) = self.histories.split_at_mut(counts.candidates);
        let own = Self {
            candidates,
            live,
            histories,
        };
        let other = Self {
            candidates: other_candidates,
            live: other_live,
            histories: other_histories,
        };
        (own, other)
    }
}

/// The rows of a block.
struct Rows<'a, R: Row, P: Physics> {
    given: &'a Given<'a, R, P>,
    block: &'a Block,
    pairs: Pairs<'a, R, P>,
    part: Part<'a, R>,
}

/// Which pairs of a block are at hand.
enum Part<'a, R: Row> {
    /// Those with a grain of the next block; nothing moves.
    Across(Motions<'a, R>, &'a mut Across<R>),
    /// All others, and the motion.
    Own(Own<'a, R>),
}

/// All of a block but its pairs with grains of the next.
struct Own<'a, R> {
    motions: MotionsMut<'a, R>,
    sums: SumsMut<'a, R>,
    /// What the block before has summed on the first grains.
    before: Option<&'a Sums<R>>,
    /// What the pairs with grains of the next block do, in order.
    here: &'a Sums<R>,
    pushes: &'a mut Vec<(u8, R)>,
}

impl<'a, R: Row> Part<'a, R> {
    /// The motions at hand, where pairs add, and, unless nothing moves, what the other pairs do and where walls' forces go.
    #[inline(always)]
    fn taken<P: Physics>(self, block: &Block) -> (Lent<'a, R>, Sink<'a, R>, Option<Rest<'a, R>>) {
        match self {
            Self::Across(motions, across) => {
                across.beyond.zero::<P>(block.reached_end - block.rows.end);
                across.here.zero::<P>(0);
                let sink = Sink {
                    sums: across.beyond.lend(),
                    first: block.rows.end,
                    noted: Some(&mut across.here),
                };
                (Lent::Read(motions), sink, None)
            }
            Self::Own(Own {
                motions,
                sums,
                before,
                here,
                pushes,
            }) => {
                if let Some(before) = before {
                    sums.force[..before.force.len()].copy_from_slice(&before.force);
                    sums.torque[..before.torque.len()].copy_from_slice(&before.torque);
                }
                pushes.clear();
                let sink = Sink {
                    sums,
                    first: block.rows.start,
                    noted: None,
                };
                (Lent::Move(motions), sink, Some((here, pushes)))
            }
        }
    }
}

/// What pairs with grains of the next block do, in order, and where forces on walls are noted.
type Rest<'a, R> = (&'a Sums<R>, &'a mut Vec<(u8, R)>);

/// Motions that may be changed or not.
enum Lent<'a, R: Row> {
    Read(Motions<'a, R>),
    Move(MotionsMut<'a, R>),
}

impl<R: Row> Lent<'_, R> {
    #[inline(always)]
    fn read(&self) -> Motions<'_, R> {
        match self {
            Self::Read(motions) => *motions,
            Self::Move(motions) => motions.read(),
        }
    }
}

/// Where pairs add.
struct Sink<'a, R> {
    /// On grains of the rows at hand, or of the next block.
    sums: SumsMut<'a, R>,
    /// Whose sum comes first.
    first: usize,
    /// Where what acts on the grains of the rows at hand is noted pair by pair, if it is not summed.
    noted: Option<&'a mut Sums<R>>,
}

impl<R: Row> Sink<'_, R> {
    /// What has been summed on grain `i` so far; the sums start at zero again.
    #[inline(always)]
    fn take<L: Lane<Row = R>, P: Physics>(&mut self, i: usize) -> Load<L> {
        let i = i - self.first;
        let force = self.sums.force[i].load();
        Vec3::<L>::zero().store(&mut self.sums.force[i]);
        let mut torque = Vec3::zero();
        if P::SPINS {
            torque = self.sums.torque[i].load();
            Vec3::<L>::zero().store(&mut self.sums.torque[i]);
        }
        Load { force, torque }
    }

    /// Asks for the sum on grain `j`, if it is here, ahead of its use.
    #[inline(always)]
    fn prefetch<P: Physics>(&self, j: usize) {
        let j = j.wrapping_sub(self.first);
        let Some(force) = self.sums.force.get(j) else {
            return;
        };
        prefetch(force);
        if P::SPINS {
            prefetch(&self.sums.torque[j]);
        }
    }

    /// Adds the opposite of `force` and `torque` on grain `j`.
    #[inline(always)]
    fn react<L: Lane<Row = R>, P: Physics>(&mut self, j: usize, force: Vec3<L>, torque: Vec3<L>) {
        let j = j - self.first;
        let sum = &mut self.sums.force[j];
        (sum.load::<L>() - force).store(sum);
        if P::SPINS {
            let sum = &mut self.sums.torque[j];
            (sum.load::<L>() + torque).store(sum);
        }
    }

    /// Adds what acts on the row's grain to `load`, or notes it.
    #[inline(always)]
    fn act<L: Lane<Row = R>, P: Physics>(&mut self, of: Load<L>, load: &mut Load<L>) {
        if let Some(noted) = &mut self.noted {
            noted.push::<L, P>(of);
        } else {
            load.force = load.force + of.force;
            load.torque = load.torque + of.torque;
        }
    }
}

/// What a pair reads.
struct Seen<'a, R: Row> {
    fixed: Fixed<'a, R>,
    motions: Motions<'a, R>,
    /// Whose motion comes first.
    first: usize,
}

impl<R: Row> Seen<'_, R> {
    #[inline(always)]
    fn row<L: Lane<Row = R, Scalar = R::Scalar>, P: Physics>(&self, i: usize) -> RowGrain<L> {
        let moving = Moving::load::<P>(&self.motions, i - self.first);
        RowGrain::load::<P>(&self.fixed, &moving, i)
    }
}

/// A pair that touches in some replica.
#[derive(Clone, Copy)]
struct Touch<L: Lane> {
    candidate: usize,
    touching: L::Mask,
    branch: Branch<L>,
    arm_j: Vec3<L>,
}

impl<L: Lane> Touch<L> {
    #[inline(always)]
    fn none() -> Self {
        let zero = L::constant(0.0);
        Self {
            candidate: 0,
            touching: zero.lt(zero),
            branch: Branch {
                vector: Vec3::zero(),
                excess: zero,
            },
            arm_j: Vec3::zero(),
        }
    }
}

impl<R: Row, P: Physics> Kernel<R> for Rows<'_, R, P> {
    type Output = f64;

    #[inline(always)]
    fn run<L: Lane<Row = R, Scalar = R::Scalar>>(self) -> f64 {
        let Self {
            given,
            block,
            mut pairs,
            part,
        } = self;
        let constants = Constants::<L, P::Tangential>::new(given.laws);
        let motion = MotionConstants::<L>::new(given.laws);
        let mut fastest = Fastest::none();
        let mut touches = [Touch::<L>::none(); NOTED];
        let tails = &given.tails[block.tails.clone()];
        let (mut lent, mut sink, mut rest) = part.taken::<P>(block);
        let rows = match rest {
            Some(_) => block.rows.len(),
            None => tails.len(),
        };
        let (mut tails_before, mut added) = (0, 0);
        for n in 0..rows {
            let i = match rest {
                Some(_) => block.rows.start + n,
                None => tails[n].row as usize,
            };
            let here = |start: u32| start as usize - block.candidates.start;
            let (start, end) = (here(given.starts[i]), here(given.starts[i + 1]));
            let mut tail = end;
            if let Some(at) = tails.get(tails_before)
                && at.row as usize == i
            {
                tail = here(at.start);
                tails_before += 1;
            }
            let seen = Seen {
                fixed: given.fixed,
                motions: lent.read(),
                first: if rest.is_some() { block.rows.start } else { 0 },
            };
            let at = seen.row::<L, P>(i);
            let (mut load, mut next, last) = match rest {
                Some(_) => (sink.take::<L, P>(i), start, tail),
                None => (Load::none(), tail, end),
            };
            while next < last {
                let noted = note::<L, P>(
                    &at,
                    (&mut next, last),
                    (&seen, &sink),
                    &mut pairs,
                    &mut touches,
                );
                for touch in &touches[..noted] {
                    let adding = (&mut sink, &mut load);
                    act::<L, P>(&constants, &at, touch, &seen, &mut pairs, adding);
                }
            }
            let (Lent::Move(motions), Some((across, pushes))) = (&mut lent, &mut rest) else {
                continue;
            };
            let touching = pairs.live[tail..end].iter().filter(|live| **live).count();
            across.add_to::<L, P>(added..added + touching, &mut load);
            added += touching;
            for c in given.wall_starts[i]..given.wall_starts[i + 1] {
                let candidate = &given.wall_candidates[c as usize];
                push_of_wall::<L, P>(&motion, &at, candidate, given.walls, pushes, &mut load);
            }
            let moved = advance::<L, P>(
                &motion.sized::<P>(|of| L::constant(of(&given.fixed.sizes[i]))),
                (&given.laws.body_force, given.affine),
                given.fixed.reference[i].position.map(L::constant),
                &load,
                Moving::load::<P>(&motions.read(), n),
                &mut fastest,
            );
            moved.store::<P>(motions, n);
        }
        fastest.swept(given.laws, given.walls)
    }
}

/// Tests candidates from `next` on until `touches` is full or the row ends; returns how many touch.
#[inline(always)]
fn note<L: Lane, P: Physics>(
    at: &RowGrain<L>,
    (next, end): (&mut usize, usize),
    (seen, sink): (&Seen<'_, L::Row>, &Sink<'_, L::Row>),
    pairs: &mut Pairs<'_, L::Row, P>,
    touches: &mut [Touch<L>; NOTED],
) -> usize {
    let mut noted = 0;
    while *next < end && noted < NOTED {
        let c = *next;
        *next += 1;
        if let Some(ahead) = pairs.candidates.get(c + AHEAD) {
            let at_ahead = (ahead.j as usize).wrapping_sub(seen.first);
            seen.motions.prefetch::<P>(at_ahead);
            sink.prefetch::<P>(ahead.j as usize);
        }
        let candidate = &pairs.candidates[c];
        let (j, a, b) = (
            candidate.j as usize,
            usize::from(candidate.a),
            usize::from(candidate.b),
        );
        let at_j = j - seen.first;
        let (mut shifted_j, mut arm_j) = (seen.motions.displacement[at_j].load(), Vec3::zero());
        if P::ORIENTED {
            let arm = Vec3::broadcast(seen.fixed.lane_arms[P::Shape::SPHERES * j + b]);
            let shift = seen.motions.turn[at_j].load::<L>().shift(arm);
            shifted_j = shifted_j + shift;
            arm_j = arm + shift;
        }
        let change = at.shifted[a] - shifted_j;
        let (radius_j, _) = size::<L, P>(seen.fixed.sizes, j);
        let branch = branch::<L, P>(
            candidate.reference.map(L::splat),
            change,
            at.radius + radius_j,
        );
        let touching = branch.excess.lt(L::constant(0.0));
        touches[noted] = Touch {
            candidate: c,
            touching,
            branch,
            arm_j,
        };
        let any = touching.any();
        if pairs.live[c] && !any {
            pairs.histories[c] = Components::from_fn(|_| L::Row::default());
        }
        pairs.live[c] = any;
        noted += usize::from(any);
    }
    noted
}

/// Adds the force of one touching pair.
#[inline(always)]
fn act<L: Lane, P: Physics>(
    constants: &Constants<L, P::Tangential>,
    at: &RowGrain<L>,
    touch: &Touch<L>,
    seen: &Seen<'_, L::Row>,
    pairs: &mut Pairs<'_, L::Row, P>,
    (sink, load): (&mut Sink<'_, L::Row>, &mut Load<L>),
) {
    let candidate = &pairs.candidates[touch.candidate];
    let (j, a) = (candidate.j as usize, usize::from(candidate.a));
    let rows = pairs.histories[touch.candidate].as_mut_slice();
    let mut history =
        <P::Tangential as TangentialLaw>::History::<L>::from_fn(|n| L::load(&rows[n]));
    let (radius_j, inverse_mass_j) = size::<L, P>(seen.fixed.sizes, j);
    let at_j = j - seen.first;
    let geometry = geometry::<L, P>(touch.branch, [at.radius, radius_j]);
    let partner_i = Partner {
        arm: at.arms[a],
        velocity: at.velocity,
        spin: at.spin,
        radius: at.radius,
        inverse_mass: at.inverse_mass,
    };
    let partner_j = Partner {
        arm: touch.arm_j,
        velocity: seen.motions.velocity[at_j].load(),
        spin: if P::SPINS {
            seen.motions.spin[at_j].load()
        } else {
            Vec3::zero()
        },
        radius: radius_j,
        inverse_mass: inverse_mass_j,
    };
    let action = interact::<L, P>(constants, &geometry, &partner_i, &partner_j, &mut history);
    for (row, lanes) in rows.iter_mut().zip(history.as_slice()) {
        lanes.keep(touch.touching).store(row);
    }
    // Lanes that do not touch may hold what is not a number, and add nothing.
    let force = action.force.keep(touch.touching);
    let (mut on_i, mut on_j) = (Vec3::zero(), Vec3::zero());
    if P::SPINS {
        on_i = action.torque_i().keep(touch.touching);
        on_j = action.torque_j().keep(touch.touching);
    }
    sink.react::<L, P>(j, force, on_j);
    let of = Load {
        force,
        torque: on_i,
    };
    sink.act::<L, P>(of, load);
}
