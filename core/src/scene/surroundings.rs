//! What grains lie in besides the walls of a box; `()` is nothing.

use std::fmt::Debug;

use crate::grains::Grains;
use crate::lanes::{F64x1, F64x8, Row, VectorWidth};

/// Something that touches grains and moves by itself; in lone runs only, unless it is nothing.
pub trait Surroundings: Clone + Debug + Default + Send + Sync + 'static {
    /// Whether it can spin a grain.
    const SPINS: bool;

    /// Finds what each grain may touch before anything has moved by half of `skin`.
    fn renew<R: Row>(&mut self, grains: &Grains<R>, skin: f64, width: VectorWidth);

    /// How far anything of it has moved since the last renewal.
    fn moved(&self) -> f64;

    /// Finds all forces at the present positions; only reads the grains.
    fn act(&mut self, grains: &Grains<F64x1>, time_step: f64, width: VectorWidth);

    /// Adds the forces just found on the grains, always in the same order.
    fn push_grains(&self, on: &mut OnGrains<'_>);

    /// Takes a step; returns how far anything of it moved, not a number if anything is none.
    fn advance(&mut self, time_step: f64) -> f64;
}

impl Surroundings for () {
    const SPINS: bool = false;

    fn renew<R: Row>(&mut self, _: &Grains<R>, _: f64, _: VectorWidth) {}

    fn moved(&self) -> f64 {
        0.0
    }

    #[inline(always)]
    fn act(&mut self, _: &Grains<F64x1>, _: f64, _: VectorWidth) {}

    #[inline(always)]
    fn push_grains(&self, _: &mut OnGrains<'_>) {}

    #[inline(always)]
    fn advance(&mut self, _: f64) -> f64 {
        0.0
    }
}

/// The sums of force and torque on all grains, as the step keeps them.
#[derive(Debug)]
pub struct OnGrains<'a>(pub(super) &'a mut [F64x8]);

impl OnGrains<'_> {
    /// Adds a force and a torque on grain `i`, a spare number beside each.
    #[inline(always)]
    pub fn add(&mut self, i: usize, push: &F64x8) {
        let sum = &mut self.0[i].0;
        for (sum, part) in sum.iter_mut().zip(push.0) {
            *sum += part;
        }
    }
}
