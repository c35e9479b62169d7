//! The elongation of a friction spring, carried from one step to the next.

use crate::lanes::Lane;
use crate::math::Vec3;

/// The spring of the last step, turned with the pair into today's contact plane: projected, then given its old length back.
///
/// √(1 + x) is expanded for x = (n̂·ξ)²/|ξ − n̂(n̂·ξ)|², the squared tangent of the turn since the last step.
#[inline(always)]
pub(super) fn carried<L: Lane>(elongation: Vec3<L>, normal: Vec3<L>) -> Vec3<L> {
    let out_of_plane = elongation.dot(normal);
    let projected = normal.scale_sub(out_of_plane, elongation);
    let tiny = L::constant(1e-35);
    let x = (out_of_plane * out_of_plane) / projected.dot(projected).max(tiny);
    // Turns of more than 45° a step mean nothing; the cut keeps the series bounded.
    let x = -((-x).max(L::constant(-1.0)));
    let series = x.mul_add(L::constant(0.0625), L::constant(-0.125));
    let series = series.mul_add(x, L::constant(0.5));
    projected.scale_add(series * x, projected)
}

/// The same to rounding, sooner found: what has to be divided by does not wait for the normal.
///
/// 1/√(1 − t) is expanded for t = (n̂·ξ)²/|ξ|², the squared sine of the turn since the last step; the next term is 35/128 t⁴.
/// (Beams keep the other: their outcomes are those of its bits.)
#[inline(always)]
pub(super) fn turned<L: Lane>(elongation: Vec3<L>, normal: Vec3<L>) -> Vec3<L> {
    let (projected, _, longer) = by_series(elongation, normal);
    projected.scale_add(longer, projected)
}

/// What [`turned`] changes, to be added with care where digits are few.
#[inline(always)]
pub(super) fn turn<L: Lane>(elongation: Vec3<L>, normal: Vec3<L>) -> Vec3<L> {
    let (projected, out_of_plane, longer) = by_series(elongation, normal);
    normal.scale_sub(out_of_plane, projected.scale(longer))
}

/// The spring in the plane, what of it is out of the plane, and by which share the one in the plane is too short.
#[inline(always)]
fn by_series<L: Lane>(elongation: Vec3<L>, normal: Vec3<L>) -> (Vec3<L>, L, L) {
    let tiny = L::constant(1e-35);
    let inverse_square = L::constant(1.0) / elongation.dot(elongation).max(tiny);
    let out_of_plane = elongation.dot(normal);
    let projected = normal.scale_sub(out_of_plane, elongation);
    let t = out_of_plane * out_of_plane * inverse_square;
    let series = t.mul_add(L::constant(0.3125), L::constant(0.375));
    let series = series.mul_add(t, L::constant(0.5));
    (projected, out_of_plane, series * t)
}
