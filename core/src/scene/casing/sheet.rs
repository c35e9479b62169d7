//! Grains before triangles, as they are in the running step.

use super::foot::{Foot, foot};
use crate::grains::Grains;
use crate::lanes::{F64x8, Lane, Mask, Row};
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
        let outward = vector(quarter(3));
        let center = Vec3 { x, y, z };
        let foot = foot(center, corners);
        let from = center - foot.on(corners);
        Feet {
            radius,
            square: from.dot(from),
            foot,
            from,
            height: (corners[0] - center).dot(outward),
            outward,
            to_corners: [
                center - corners[0],
                center - corners[1],
                center - corners[2],
            ],
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
    /// From the corners to the grain's center.
    to_corners: [Vec3<L>; 3],
}

impl<L: Lane> Feet<L> {
    /// In which lanes the grain reaches each side, but for its ends, and each corner, a bit to a lane.
    #[inline(always)]
    pub(super) fn reached(&self) -> [u32; 6] {
        let [a, b, c] = self.to_corners;
        let square = self.radius * self.radius;
        let over_a = a.dot(a) - square;
        let over_b = b.dot(b) - square;
        let over_c = c.dot(c) - square;
        let zero = L::constant(0.0);
        [
            reaches_between(a, b, over_a),
            reaches_between(b, c, over_b),
            reaches_between(c, a, over_c),
            over_a.lt(zero).bits(),
            over_b.lt(zero).bits(),
            over_c.lt(zero).bits(),
        ]
    }
}

/// In which lanes the nearest point of a side lies between its corners and is reached, from the ways from the corners to the
/// center, with |p|² − R².
///
/// The square of its distance is |p|² − (p·(p − q))²/|p − q|².
#[inline(always)]
fn reaches_between<L: Lane>(p: Vec3<L>, q: Vec3<L>, over: L) -> u32 {
    let zero = L::constant(0.0);
    let along = p - q;
    let (from_p, from_q) = (along.dot(p), -along.dot(q));
    let reached = (over * (from_p + from_q)).lt(from_p * from_p);
    let between = zero.lt(from_p).and(zero.lt(from_q));
    reached.and(between).bits()
}
