//! Body forces: what acts on every grain besides contacts; `()` is none.

use crate::lanes::Lane;
use crate::math::Vec3;

/// The affine motion of the box: v(x) = rate · x, about the middle of the box.
#[derive(Clone, Copy, Debug, Default)]
pub struct AffineRate<R> {
    /// Strain rate along each axis \[1/t_c\].
    pub rate: Vec3<R>,
}

/// A force on every grain, per mass.
pub trait BodyForce: Copy + Send + Sync + 'static {
    /// Acceleration of a grain at `position` \[R/t_c²\] with `velocity`, added to `acceleration`.
    fn linear<L: Lane>(
        &self,
        position: Vec3<L>,
        velocity: Vec3<L>,
        affine: &AffineRate<L::Row>,
        acceleration: Vec3<L>,
    ) -> Vec3<L>;

    /// Angular acceleration of a grain with `spin` \[1/t_c²\], added to `acceleration`.
    fn angular<L: Lane>(&self, spin: Vec3<L>, acceleration: Vec3<L>) -> Vec3<L>;

    /// Takes the drag out of it and returns its rate \[1/t_c\].
    fn take_drag(&mut self) -> f64 {
        0.0
    }
}

impl BodyForce for () {
    #[inline(always)]
    fn linear<L: Lane>(
        &self,
        _: Vec3<L>,
        _: Vec3<L>,
        _: &AffineRate<L::Row>,
        acceleration: Vec3<L>,
    ) -> Vec3<L> {
        acceleration
    }

    #[inline(always)]
    fn angular<L: Lane>(&self, _: Vec3<L>, acceleration: Vec3<L>) -> Vec3<L> {
        acceleration
    }
}

/// Drag η on the velocity that departs from the affine one, and on the spin.
///
/// It damps what a fast ramp stirs up and leaves the slow motion alone (docs/choices.md §4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AffineDrag {
    /// η \[1/t_c\].
    pub rate: f64,
}

impl BodyForce for AffineDrag {
    #[inline(always)]
    fn linear<L: Lane>(
        &self,
        position: Vec3<L>,
        velocity: Vec3<L>,
        affine: &AffineRate<L::Row>,
        acceleration: Vec3<L>,
    ) -> Vec3<L> {
        let rate = affine.rate.load::<L>();
        let departing = Vec3 {
            x: rate.x.neg_mul_add(position.x, velocity.x),
            y: rate.y.neg_mul_add(position.y, velocity.y),
            z: rate.z.neg_mul_add(position.z, velocity.z),
        };
        departing.scale_sub(L::constant(self.rate), acceleration)
    }

    #[inline(always)]
    fn angular<L: Lane>(&self, spin: Vec3<L>, acceleration: Vec3<L>) -> Vec3<L> {
        spin.scale_sub(L::constant(self.rate), acceleration)
    }

    fn take_drag(&mut self) -> f64 {
        std::mem::take(&mut self.rate)
    }
}
