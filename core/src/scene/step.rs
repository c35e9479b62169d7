//! One step of an ensemble: every lane is a replica.
//!
//! A row is done in two sweeps, so that long chains of roots and divisions of different contacts overlap:
//! first every candidate is tested and those that any replica touches are noted, then the forces of the noted ones are found.
//!
//! Blocks of rows, one for each thread of the job, first find the forces of their pairs with grains of the next
//! block, and sum what those add there apart; a row's candidates are sorted by the grain that they reach, so these are its last.
//! Then no block needs anything of another's grains, and all sums are added in the order in which one thread adds them.

mod sums;

use crate::contact::{Components, TangentialLaw};
use crate::force::AffineRate;
use crate::grains::Grains;
use crate::lanes::{Kernel, Lane, Mask, Row, dispatch};
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
use sums::{Sink, Sums};

/// Touching pairs that are noted before their forces are found.
const NOTED: usize = 16;

/// How many candidates ahead the other grain is asked for: about two rows of spheres, one of tetrahedra.
const AHEAD: usize = 8;

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
        slices,
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
            slices,
        };
        let with = (pairs, &mut work.across[..]);
        blocks::each(blocks, with, &|block, (pairs, across)| {
            if let [across] = across {
                across.beyond.zero::<P>(block.reached_end - block.rows.end);
                across.here.zero::<P>(0);
                let sink = Sink {
                    sums: across.beyond.lend(),
                    first: block.rows.end,
                    noted: Some(&mut across.here),
                };
                given.run(block, pairs, (sink, Task::Reach(motions)));
            }
        });
    }
    let sums = work.own.lend();
    let pairs = Pairs::<R, P> {
        candidates,
        live,
        histories,
        slices,
    };
    let across = &work.across;
    let with = ((pairs, &mut work.left[..]), (motions, sums));
    blocks::each(
        blocks,
        with,
        &|block, ((pairs, left), (motions, mut sums))| {
            if let [left] = left {
                if let Some(before) = block.number.checked_sub(1) {
                    sums.start_from(&across[before].beyond);
                }
                left.pushes.clear();
                let sink = Sink {
                    sums,
                    first: block.rows.start,
                    noted: None,
                };
                let task = Task::Move(motions, &across[block.number].here, &mut left.pushes);
                left.swept = given.run(block, pairs, (sink, task));
            }
        },
    );
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
    fn run(
        &self,
        block: &Block,
        pairs: Pairs<'_, R, P>,
        (sink, task): (Sink<'_, R>, Task<'_, R>),
    ) -> f64 {
        let rows = Rows {
            given: self,
            block,
            pairs,
            sink,
            task,
        };
        dispatch::<R, _>(self.laws.width, rows)
    }
}

/// The candidates of some neighboring blocks and what they remember.
struct Pairs<'a, R: Row, P: Physics> {
    candidates: &'a [Candidate<R::Scalar>],
    live: &'a mut [bool],
    histories: &'a mut [<P::Tangential as TangentialLaw>::History<R>],
    slices: &'a mut [<P::Tangential as TangentialLaw>::Slices<R>],
}

impl<R: Row, P: Physics> Divide for Pairs<'_, R, P> {
    fn divide(self, counts: &Counts) -> (Self, Self) {
        let (candidates, other_candidates) = self.candidates.split_at(counts.candidates);
        let (live, other_live) = self.live.split_at_mut(counts.candidates);
        let (histories, other_histories) = self.histories.split_at_mut(counts.candidates);
        let (slices, other_slices) = self.slices.split_at_mut(counts.candidates);
        let own = Self {
            candidates,
            live,
            histories,
            slices,
        };
        let other = Self {
            candidates: other_candidates,
            live: other_live,
            histories: other_histories,
            slices: other_slices,
        };
        (own, other)
    }
}

/// The rows of a block.
struct Rows<'a, R: Row, P: Physics> {
    given: &'a Given<'a, R, P>,
    block: &'a Block,
    pairs: Pairs<'a, R, P>,
    sink: Sink<'a, R>,
    task: Task<'a, R>,
}

/// What is to be done with the rows of a block.
enum Task<'a, R: Row> {
    /// Pairs with a grain of the next block; nothing moves.
    Reach(Motions<'a, R>),
    /// All others, and the motion; with what the pairs with the next block do, in order, and where forces on walls are noted.
    Move(MotionsMut<'a, R>, &'a Sums<R>, &'a mut Vec<(u8, R)>),
}

impl<R: Row> Task<'_, R> {
    /// What pairs read.
    #[inline(always)]
    fn seen<'b>(&'b self, fixed: Fixed<'b, R>, block: &Block) -> Seen<'b, R> {
        let (motions, first) = match self {
            Self::Reach(motions) => (*motions, 0),
            Self::Move(motions, ..) => (motions.read(), block.rows.start),
        };
        Seen {
            fixed,
            motions,
            first,
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
            mut sink,
            mut task,
        } = self;
        let constants = Constants::<L, P::Tangential>::new(given.laws);
        let motion = MotionConstants::<L>::new(given.laws);
        let mut fastest = Fastest::none();
        let mut touches = [Touch::<L>::none(); NOTED];
        let tails = &given.tails[block.tails.clone()];
        let reaching = matches!(task, Task::Reach(_));
        let (mut tails_before, mut added) = (0, 0);
        for n in 0..if reaching {
            tails.len()
        } else {
            block.rows.len()
        } {
            let i = if reaching {
                tails[n].row as usize
            } else {
                block.rows.start + n
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
            let seen = task.seen(given.fixed, block);
            let at = seen.row::<L, P>(i);
            let (mut load, mut next, last) = if reaching {
                (Load::none(), tail, end)
            } else {
                (sink.take::<L, P>(i), start, tail)
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
            let Task::Move(motions, across, pushes) = &mut task else {
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
    let memory = (&mut history, &mut pairs.slices[touch.candidate]);
    let action = interact::<L, P>(constants, &geometry, &partner_i, &partner_j, memory);
    for (row, lanes) in rows.iter_mut().zip(history.as_slice()) {
        lanes.keep(touch.touching).store(row);
    }
    let action = action.keep(touch.touching);
    let (mut on_i, mut on_j) = (Vec3::zero(), Vec3::zero());
    if P::SPINS {
        on_i = action.torque_i();
        on_j = action.torque_j();
    }
    sink.react::<L, P>(j, action.force, on_j);
    let of = Load {
        force: action.force,
        torque: on_i,
    };
    sink.act::<L, P>(of, load);
}
