//! Grains before triangles, as they are in the running step.

use super::foot::{Foot, foot};
use crate::grains::Grains;
use crate::lanes::{F64x8, Lane, Row};
use crate::math::Vec3;
use crate::membrane::Face;

/// A grain: where its center is, and its radius.
pub(super) type Ball = [f64; 4];

/// A grain and a triangle.
pub(super) type Pair = [u32; 2];

/// Triangles and grains as they are in one step.
#[derive(Clone, Copy)]
pub(super) struct Sheet<'a> {
    pub(super) faces: &'a [Face],
    pub(super) balls: &'a [Ball],
}

/// Takes note of where all grains are.
#[inline(always)]
pub(super) fn note<R: Row>(grains: &Grains<R>, balls: &mut Vec<Ball>) {
    balls.clear();
    balls.extend((0..grains.len()).map(|i| {
        let [x, y, z] = grains.place(i, 0);
        [x, y, z, grains.radius(i)]
    }));
}

impl Sheet<'_> {
    /// Unit normal of triangle `t`.
    pub(super) fn outward(&self, t: u32) -> [f64; 3] {
        let &[x, y, z, _] = self.faces[t as usize][1].halves()[1];
        [x, y, z]
    }

    /// Up to eight grains before their triangles.
    #[inline(always)]
    pub(super) fn feet<W: Lane<Row = F64x8, Scalar = f64>>(&self, pairs: &[Pair]) -> Feet<W> {
        let last = pairs.len() - 1;
        let part = |e: usize, half: usize| {
            self.faces[pairs[e.min(last)][1] as usize][half / 2].halves()[half % 2]
        };
        let [x, y, z, radius] = W::gather(|e| &self.balls[pairs[e.min(last)][0] as usize]);
        let quarter = |half: usize| W::gather(|e| part(e, half));
        let vector = |[x, y, z, _]: [W; 4]| Vec3 { x, y, z };
        let corners = [vector(quarter(0)), vector(quarter(1)), vector(quarter(2))];
        let [n_x, n_y, n_z, doubled_area] = quarter(3);
        let outward = vector([n_x, n_y, n_z, doubled_area]);
        let center = Vec3 { x, y, z };
        let foot = foot(center, corners);
        let from = center - foot.on(corners);
        Feet {
            radius,
            square: from.dot(from),
            foot,
            from,
            height: (corners[0] - center).dot(outward),
            corners,
            outward,
            doubled_area,
        }
    }
}

/// Grains before triangles, one pair to a lane.
pub(super) struct Feet<L> {
    /// R.
    pub(super) radius: L,
    pub(super) foot: Foot<L>,
    /// From the foot to the grain's center.
    pub(super) from: Vec3<L>,
    /// The square of its length.
    pub(super) square: L,
    /// How far the center is inside of the triangle's plane.
    pub(super) height: L,
    /// The triangle's normal.
    pub(super) outward: Vec3<L>,
    /// Of the triangle.
    pub(super) doubled_area: L,
    pub(super) corners: [Vec3<L>; 3],
}

impl<L: Lane> Feet<L> {
    /// The square of how far the foot is from the nearest side of its triangle, in units of `length_square`.
    ///
    /// A corner with barycentric coordinate u is 2A/ℓ high over its side of length ℓ, and the foot u 2A/ℓ.
    #[inline(always)]
    pub(super) fn square_from_side(&self, length_square: L) -> L {
        let [a, b, c] = self.corners;
        let [u, v, w] = self.foot.weights;
        let square = |side: Vec3<L>| side.dot(side);
        let (over_a, over_b, over_c) = (square(c - b), square(a - c), square(b - a));
        let of = |weight: L, others: L| weight * weight * others;
        // One division for all three: each is (u 2A)² times the squares of both other sides.
        let least = -(-of(u, over_b * over_c))
            .max(-of(v, over_c * over_a))
            .max(-of(w, over_a * over_b));
        let doubled = self.doubled_area * self.doubled_area;
        least * doubled / (over_a * over_b * over_c * length_square)
    }
}
