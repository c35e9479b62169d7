//! Where the pairs of an ensemble's rows add.

use std::ops::Range;

use crate::lanes::{Lane, Row, prefetch};
use crate::math::Vec3;
use crate::scene::Physics;
use crate::scene::blocks::{Counts, Divide};
use crate::scene::motion::Load;

/// Forces and torques, one for each of some grains or contacts.
#[derive(Clone, Debug, Default)]
pub(super) struct Sums<R> {
    pub(super) force: Vec<Vec3<R>>,
    /// Empty where nothing can spin a grain.
    pub(super) torque: Vec<Vec3<R>>,
}

impl<R: Row> Sums<R> {
    /// Makes them `len` zeros.
    pub(super) fn zero<P: Physics>(&mut self, len: usize) {
        self.force.clear();
        self.force.resize(len, Vec3::default());
        self.torque.clear();
        self.torque
            .resize(if P::SPINS { len } else { 0 }, Vec3::default());
    }

    pub(super) fn lend(&mut self) -> SumsMut<'_, R> {
        SumsMut {
            force: &mut self.force,
            torque: &mut self.torque,
        }
    }

    /// Notes one more.
    #[inline(always)]
    pub(super) fn push<L: Lane<Row = R>, P: Physics>(&mut self, of: Load<L>) {
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
    pub(super) fn add_to<L: Lane<Row = R>, P: Physics>(
        &self,
        range: Range<usize>,
        load: &mut Load<L>,
    ) {
        for n in range {
            load.force = load.force + self.force[n].load();
            if P::SPINS {
                load.torque = load.torque + self.torque[n].load();
            }
        }
    }
}

/// The same, lent.
pub(super) struct SumsMut<'a, R> {
    pub(super) force: &'a mut [Vec3<R>],
    pub(super) torque: &'a mut [Vec3<R>],
}

impl<R: Copy> SumsMut<'_, R> {
    /// Lets the first of them start from `before`.
    pub(super) fn start_from(&mut self, before: &Sums<R>) {
        self.force[..before.force.len()].copy_from_slice(&before.force);
        self.torque[..before.torque.len()].copy_from_slice(&before.torque);
    }
}

impl<R: Row> Divide for SumsMut<'_, R> {
    fn divide(self, counts: &Counts) -> (Self, Self) {
        let (force, other_force) = self.force.split_at_mut(counts.rows);
        let (torque, other_torque) = self.torque.split_at_mut(counts.rows.min(self.torque.len()));
        let sums = |force, torque| SumsMut { force, torque };
        (sums(force, torque), sums(other_force, other_torque))
    }
}

/// Where pairs add.
pub(super) struct Sink<'a, R> {
    /// On grains of the rows at hand, or of the next block.
    pub(super) sums: SumsMut<'a, R>,
    /// Whose sum comes first.
    pub(super) first: usize,
    /// Where what acts on the grains of the rows at hand is noted pair by pair, if it is not summed.
    pub(super) noted: Option<&'a mut Sums<R>>,
}

impl<R: Row> Sink<'_, R> {
    /// What has been summed on grain `i` so far; the sums start at zero again.
    #[inline(always)]
    pub(super) fn take<L: Lane<Row = R>, P: Physics>(&mut self, i: usize) -> Load<L> {
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
    pub(super) fn prefetch<P: Physics>(&self, j: usize) {
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
    pub(super) fn react<L: Lane<Row = R>, P: Physics>(
        &mut self,
        j: usize,
        force: Vec3<L>,
        torque: Vec3<L>,
    ) {
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
    pub(super) fn act<L: Lane<Row = R>, P: Physics>(&mut self, of: Load<L>, load: &mut Load<L>) {
        if let Some(noted) = &mut self.noted {
            noted.push::<L, P>(of);
        } else {
            load.force = load.force + of.force;
            load.torque = load.torque + of.torque;
        }
    }
}
