//! Perfectly smooth grains: no force, no memory.

use super::{Contact, Slices, TangentialLaw};
use crate::lanes::{Lane, Row};
use crate::math::Vec3;

/// No tangential force.
#[derive(Clone, Copy, Debug, Default)]
pub struct Frictionless;

impl TangentialLaw for Frictionless {
    type History<T: Copy + Send + Sync> = [T; 0];
    type Slices<R: Row> = ();
    type Constants<L: Lane> = ();
    const TANGENTIAL: bool = false;

    #[inline(always)]
    fn constants<L: Lane>(&self) {}

    #[inline(always)]
    fn force<L: Lane>(
        (): &(),
        _contact: &Contact<L>,
        _history: &mut [L; 0],
        _slices: &mut impl Slices<L::Scalar>,
    ) -> Vec3<L> {
        Vec3::zero()
    }
}
