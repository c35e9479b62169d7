//! The state of one step as records, so that a contact finds what it needs in few places.

use crate::grains::Grains;
use crate::lanes::{F64x1, F64x8, Lane};
use crate::math::Vec3;
use crate::scene::contacts::Candidate;
use crate::scene::interact::Partner;
use crate::scene::motion::Load;
use crate::scene::{Physics, Work};
use crate::shape::Shape;

use super::WIDE;
use super::eight::Eight;
use crate::scene::blocks::{Block, Counts, Divide};

/// The state of the running step, remade in every step.
///
/// A record is one line of the cache: two vectors that are wanted together, each with a number beside it.
#[derive(Clone, Debug)]
pub struct Records {
    /// Of every sphere: its center's displacement from the reference and its radius, and its center from the center of mass.
    spheres: Vec<F64x8>,
    /// Of every grain: velocity and inverse mass, and spin.
    motions: Vec<F64x8>,
    /// Of every grain: the sums of force and torque.
    pub(super) loads: Vec<F64x8>,
    /// Of every block: what it does to grains that it shares.
    kept: Vec<Kept>,
    /// Of every block: the forces of its grains on walls, in order.
    pushes: Vec<Vec<(u8, F64x1)>>,
    /// Of every block: how far its grains have moved.
    swept: Vec<f64>,
}

/// What the rows of a block do to grains that they share with the next block, or share with the one before.
#[derive(Clone, Debug, Default)]
pub(super) struct Kept {
    /// The sums on the first grains of the next block.
    beyond: Vec<F64x8>,
    /// What is to be added to the block's own first grains, in this order.
    later: Vec<(u32, F64x8)>,
}

/// The records of some neighboring grains.
pub(super) struct Blank<'a> {
    spheres: &'a mut [F64x8],
    motions: &'a mut [F64x8],
    loads: &'a mut [F64x8],
}

impl Divide for Blank<'_> {
    fn divide(self, counts: &Counts) -> (Self, Self) {
        let per_grain = self.spheres.len() / self.motions.len().max(1);
        let (spheres, other_spheres) = self.spheres.split_at_mut(per_grain * counts.rows);
        let (motions, other_motions) = self.motions.split_at_mut(counts.rows);
        let (loads, other_loads) = self.loads.split_at_mut(counts.rows);
        let blank = |spheres, motions, loads| Blank {
            spheres,
            motions,
            loads,
        };
        (
            blank(spheres, motions, loads),
            blank(other_spheres, other_motions, other_loads),
        )
    }
}

/// What contacts read of all grains.
#[derive(Clone, Copy)]
pub(super) struct Read<'a> {
    spheres: &'a [F64x8],
    motions: &'a [F64x8],
}

/// Where the contacts of some neighboring blocks add.
pub(super) struct Sums<'a> {
    own: &'a mut [F64x8],
    kept: &'a mut [Kept],
}

impl Divide for Sums<'_> {
    fn divide(self, counts: &Counts) -> (Self, Self) {
        let (own, other) = self.own.split_at_mut(counts.rows);
        let (kept, other_kept) = self.kept.split_at_mut(counts.blocks);
        let others = Sums {
            own: other,
            kept: other_kept,
        };
        (Sums { own, kept }, others)
    }
}

/// Where the contacts of one block add.
pub(super) struct Adding<'a> {
    first: usize,
    shared_end: usize,
    own: &'a mut [F64x8],
    kept: &'a mut Kept,
}

impl<'a> Sums<'a> {
    /// Those of `block`, which is all that is left.
    pub(super) fn of(self, block: &Block) -> Option<Adding<'a>> {
        let kept = self.kept.first_mut()?;
        kept.later.clear();
        kept.beyond.clear();
        let reached = block.reached_end - block.rows.end;
        kept.beyond.resize(reached, F64x8::default());
        Some(Adding {
            first: block.rows.start,
            shared_end: block.shared_end,
            own: self.own,
            kept,
        })
    }
}

impl Adding<'_> {
    /// Adds a force and a torque to the sums of both grains of eight pairs, pair after pair.
    #[inline(always)]
    pub(super) fn add<W: Lane<Row = F64x8>>(
        &mut self,
        pairs: &[Candidate<f64>; WIDE],
        [on_i, on_j]: [[W; WIDE]; 2],
    ) {
        // Pairs stand by rows, and the other grain comes later: the first is the first of all.
        let end = self.first + self.own.len();
        let last = pairs.iter().fold(0, |last, pair| pair.j.max(last));
        if (pairs[0].i as usize) < self.shared_end || last as usize >= end {
            let mut rows = [[F64x8::default(); WIDE]; 2];
            for (rows, on) in rows.iter_mut().zip([on_i, on_j]) {
                for (row, load) in rows.iter_mut().zip(on) {
                    load.store(row);
                }
            }
            self.keep(pairs, &rows);
            return;
        }
        for (e, pair) in pairs.iter().enumerate() {
            for (grain, load) in [(pair.i, on_i[e]), (pair.j, on_j[e])] {
                let sum = &mut self.own[grain as usize - self.first];
                (W::load(sum) + load).store(sum);
            }
        }
    }

    /// The same where another block has a part in some of the grains.
    #[cold]
    #[inline(never)]
    fn keep(&mut self, pairs: &[Candidate<f64>; WIDE], [on_i, on_j]: &[[F64x8; WIDE]; 2]) {
        for (e, pair) in pairs.iter().enumerate() {
            for (grain, load) in [(pair.i, on_i[e]), (pair.j, on_j[e])] {
                if (grain as usize) < self.shared_end {
                    self.kept.later.push((grain, load));
                    continue;
                }
                let at = grain as usize - self.first;
                let sum = match self.own.get_mut(at) {
                    Some(sum) => sum,
                    None => &mut self.kept.beyond[at - self.own.len()],
                };
                add_to(sum, &load);
            }
        }
    }
}

/// A sphere of a grain, by the places of their records.
#[derive(Clone, Copy)]
pub(super) struct Ball {
    pub(super) grain: usize,
    sphere: usize,
}

impl Ball {
    /// The one in the candidate's row.
    #[inline(always)]
    pub(super) fn i<P: Physics>(candidate: &Candidate<f64>) -> Self {
        Self::new::<P>(candidate.i, candidate.a)
    }

    /// The other one.
    #[inline(always)]
    pub(super) fn j<P: Physics>(candidate: &Candidate<f64>) -> Self {
        Self::new::<P>(candidate.j, candidate.b)
    }

    #[inline(always)]
    fn new<P: Physics>(grain: u32, sphere: u8) -> Self {
        let grain = grain as usize;
        Self {
            grain,
            sphere: P::Shape::SPHERES * grain + usize::from(sphere),
        }
    }
}

impl Work<F64x1> for Records {
    fn new<P: Physics>(grains: &Grains<F64x1>) -> Self {
        let n = grains.len();
        Self {
            spheres: vec![F64x8::default(); P::Shape::SPHERES * n],
            motions: vec![F64x8::default(); n],
            loads: vec![F64x8::default(); n],
            kept: vec![],
            pushes: vec![],
            swept: vec![],
        }
    }

    fn bytes(&self) -> usize {
        size_of::<F64x8>() * (self.spheres.len() + self.motions.len() + self.loads.len())
    }
}

impl Records {
    /// The records of all grains, to be written.
    pub(super) fn blank(&mut self) -> Blank<'_> {
        Blank {
            spheres: &mut self.spheres,
            motions: &mut self.motions,
            loads: &mut self.loads,
        }
    }

    /// What contacts read, and where those of `count` blocks add.
    pub(super) fn shared_out(&mut self, count: usize) -> (Read<'_>, Sums<'_>) {
        self.kept.resize_with(count, Kept::default);
        let read = Read {
            spheres: &self.spheres,
            motions: &self.motions,
        };
        let sums = Sums {
            own: &mut self.loads,
            kept: &mut self.kept,
        };
        (read, sums)
    }

    /// The sums on all grains, and where each of `count` blocks notes how far its grains have moved.
    pub(super) fn loads_and_swept(&mut self, count: usize) -> (&[F64x8], &mut [f64]) {
        self.swept.resize(count, 0.0);
        (&self.loads, &mut self.swept)
    }

    /// What `count` blocks have kept, the sums that it is added to, and where the forces on walls are noted.
    pub(super) fn unsettled(&mut self, count: usize) -> (&[Kept], Settling<'_>) {
        self.pushes.resize_with(count, Vec::new);
        let settling = Settling {
            loads: &mut self.loads,
            pushes: &mut self.pushes,
        };
        (&self.kept, settling)
    }

    /// The forces on walls that were noted, in order.
    pub(super) fn pushes(&self) -> impl Iterator<Item = &(u8, F64x1)> {
        self.pushes.iter().flatten()
    }
}

/// The sums on the grains of some neighboring blocks, and their forces on walls.
pub(super) struct Settling<'a> {
    pub(super) loads: &'a mut [F64x8],
    pub(super) pushes: &'a mut [Vec<(u8, F64x1)>],
}

impl Divide for Settling<'_> {
    fn divide(self, counts: &Counts) -> (Self, Self) {
        let (loads, other_loads) = self.loads.split_at_mut(counts.rows);
        let (pushes, other_pushes) = self.pushes.split_at_mut(counts.blocks);
        let settling = |loads, pushes| Settling { loads, pushes };
        (settling(loads, pushes), settling(other_loads, other_pushes))
    }
}

impl Settling<'_> {
    /// Adds up what was kept apart of the sums of `block`, which is all that is left.
    pub(super) fn settle(&mut self, block: &Block, kept: &[Kept]) {
        let Some(before) = block.number.checked_sub(1) else {
            return;
        };
        let reached = &kept[before].beyond;
        self.loads[..reached.len()].copy_from_slice(reached);
        for (grain, load) in &kept[block.number].later {
            add_to(&mut self.loads[*grain as usize - block.rows.start], load);
        }
    }
}

impl Blank<'_> {
    /// Writes what contacts need of the grains from `first` on, and sets the sums to zero.
    #[inline(always)]
    pub(super) fn write<W: Lane<Row = F64x8, Scalar = f64>, P: Physics>(
        self,
        grains: &Grains<F64x1>,
        first_row: usize,
    ) {
        let spheres = P::Shape::SPHERES;
        let end = first_row + self.motions.len();
        for first in (first_row..end).step_by(WIDE) {
            let eight = Eight::from(first, end);
            let moving = eight.load::<W, P>(&grains.read().1);
            let zero = W::constant(0.0);
            let (mut radius, mut inverse_mass) = (zero, zero);
            if P::GRADED {
                radius = eight.numbers(|i| grains.sizes[i].radius);
                inverse_mass = eight.numbers(|i| grains.sizes[i].inverse_mass);
            }
            let at = first - first_row;
            for a in 0..spheres {
                let arm = if P::ORIENTED {
                    eight.gather(|i| grains.lane_arms[spheres * i + a])
                } else {
                    Vec3::zero()
                };
                let (shifted, arm) = moving.sphere::<P>(arm);
                let records = records(shifted, arm, [radius, zero]);
                for (e, record) in records.into_iter().enumerate().take(eight.count) {
                    record.store(&mut self.spheres[spheres * (at + e) + a]);
                }
            }
            let records = records(moving.velocity, moving.spin, [inverse_mass, zero]);
            for (e, record) in records.into_iter().enumerate().take(eight.count) {
                record.store(&mut self.motions[at + e]);
                self.loads[at + e] = F64x8::default();
            }
        }
    }
}

impl Read<'_> {
    /// Displacements from the reference of the centers of eight spheres, and their radii.
    #[inline(always)]
    pub(super) fn shifted<W: Lane<Row = F64x8, Scalar = f64>, P: Physics>(
        &self,
        eight: &[Ball; WIDE],
    ) -> (Vec3<W>, W) {
        let numbers = W::gather(|e| self.spheres[eight[e].sphere].halves()[0]);
        let radius = if P::GRADED {
            numbers[3]
        } else {
            W::constant(1.0)
        };
        (vector(numbers), radius)
    }

    /// One of the two grains, and its sphere, of eight pairs.
    #[inline(always)]
    pub(super) fn partner<W: Lane<Row = F64x8, Scalar = f64>, P: Physics>(
        &self,
        eight: &[Ball; WIDE],
        radius: W,
    ) -> Partner<W> {
        let motion = |e: usize| self.motions[eight[e].grain].halves();
        let moving = W::gather(|e| motion(e)[0]);
        Partner {
            arm: if P::ORIENTED {
                vector(W::gather(|e| self.spheres[eight[e].sphere].halves()[1]))
            } else {
                Vec3::zero()
            },
            velocity: vector(moving),
            spin: if P::SPINS {
                vector(W::gather(|e| motion(e)[1]))
            } else {
                Vec3::zero()
            },
            radius,
            inverse_mass: moving[3],
        }
    }
}

/// Adds a force and a torque to a sum.
#[inline(always)]
fn add_to(sum: &mut F64x8, load: &F64x8) {
    for (sum, part) in sum.0.iter_mut().zip(load.0) {
        *sum += part;
    }
}

/// What acts on eight grains, of these sums of force and torque.
#[inline(always)]
pub(super) fn load<W: Lane<Row = F64x8, Scalar = f64>, P: Physics>(
    loads: &[F64x8],
    eight: Eight,
) -> Load<W> {
    let load = |e: usize| loads[eight.nth(e)].halves();
    Load {
        force: vector(W::gather(|e| load(e)[0])),
        torque: if P::SPINS {
            vector(W::gather(|e| load(e)[1]))
        } else {
            Vec3::zero()
        },
    }
}

/// Two vectors of eight, and the numbers beside them, as eight records.
#[inline(always)]
pub(super) fn records<W: Lane<Row = F64x8>>(
    first: Vec3<W>,
    second: Vec3<W>,
    [beside_first, beside_second]: [W; 2],
) -> [W; WIDE] {
    W::transposed([
        first.x,
        first.y,
        first.z,
        beside_first,
        second.x,
        second.y,
        second.z,
        beside_second,
    ])
}

#[inline(always)]
fn vector<L>([x, y, z, _]: [L; 4]) -> Vec3<L> {
    Vec3 { x, y, z }
}
