//! How neighboring grains depart from their reference and move: those that a thread reads, and those that it moves.

use crate::grains::{Grains, Pose, Size};
use crate::lanes::{Row, prefetch};
use crate::math::{Quaternion, Vec3};
use crate::scene::Physics;

use super::blocks::{Counts, Divide};

/// What no step changes of all grains.
#[derive(Clone, Copy)]
pub(super) struct Fixed<'a, R: Row> {
    pub(super) reference: &'a [Pose],
    pub(super) lane_arms: &'a [[R::Scalar; 3]],
    pub(super) sizes: &'a [Size],
}

/// How some neighboring grains depart from their reference and move; nothing of a kind that there is none of.
#[derive(Clone, Copy)]
pub(super) struct Motions<'a, R: Copy> {
    pub(super) displacement: &'a [Vec3<R>],
    pub(super) velocity: &'a [Vec3<R>],
    pub(super) turn: &'a [Quaternion<R>],
    pub(super) spin: &'a [Vec3<R>],
}

/// The same, to be changed.
pub(super) struct MotionsMut<'a, R> {
    pub(super) displacement: &'a mut [Vec3<R>],
    pub(super) velocity: &'a mut [Vec3<R>],
    pub(super) turn: &'a mut [Quaternion<R>],
    pub(super) spin: &'a mut [Vec3<R>],
}

impl<R: Row> Grains<R> {
    /// What steps only read, and what they change.
    #[inline(always)]
    pub(super) fn parts(&mut self) -> (Fixed<'_, R>, MotionsMut<'_, R>) {
        let fixed = Fixed {
            reference: &self.reference,
            lane_arms: &self.lane_arms,
            sizes: &self.sizes,
        };
        let motions = MotionsMut {
            displacement: &mut self.displacement,
            velocity: &mut self.velocity,
            turn: &mut self.turn,
            spin: &mut self.spin,
        };
        (fixed, motions)
    }

    /// The same, only to be read.
    #[inline(always)]
    pub(super) fn read(&self) -> (Fixed<'_, R>, Motions<'_, R>) {
        let fixed = Fixed {
            reference: &self.reference,
            lane_arms: &self.lane_arms,
            sizes: &self.sizes,
        };
        let motions = Motions {
            displacement: &self.displacement,
            velocity: &self.velocity,
            turn: &self.turn,
            spin: &self.spin,
        };
        (fixed, motions)
    }
}

impl<R: Copy> Motions<'_, R> {
    /// Asks for all that a contact needs of grain `i`, if there is one, ahead of its use.
    #[inline(always)]
    pub(super) fn prefetch<P: Physics>(&self, i: usize) {
        let Some(displacement) = self.displacement.get(i) else {
            return;
        };
        prefetch(displacement);
        prefetch(&self.velocity[i]);
        if P::ORIENTED {
            prefetch(&self.turn[i]);
        }
        if P::SPINS {
            prefetch(&self.spin[i]);
        }
    }
}

impl<R: Copy> MotionsMut<'_, R> {
    #[inline(always)]
    pub(super) fn read(&self) -> Motions<'_, R> {
        Motions {
            displacement: self.displacement,
            velocity: self.velocity,
            turn: self.turn,
            spin: self.spin,
        }
    }
}

impl<R: Row> Divide for MotionsMut<'_, R> {
    fn divide(self, counts: &Counts) -> (Self, Self) {
        let (displacement, other_displacement) = self.displacement.split_at_mut(counts.rows);
        let (velocity, other_velocity) = self.velocity.split_at_mut(counts.rows);
        let (turn, other_turn) = self.turn.split_at_mut(counts.rows.min(self.turn.len()));
        let (spin, other_spin) = self.spin.split_at_mut(counts.rows.min(self.spin.len()));
        let own = Self {
            displacement,
            velocity,
            turn,
            spin,
        };
        let other = Self {
            displacement: other_displacement,
            velocity: other_velocity,
            turn: other_turn,
            spin: other_spin,
        };
        (own, other)
    }
}
