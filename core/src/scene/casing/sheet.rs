//! The membrane's triangles and the grains as records of the running step, and the feet of grains on triangles.

use super::foot::{Foot, foot};
use crate::grains::Grains;
use crate::lanes::{F64x8, Lane, Row};
use crate::math::Vec3;

/// A triangle where it is now, in two lines of the cache.
///
/// Its corners and its unit normal, outward; beside each corner the height over the side that is opposite to it.
pub(super) type Face = [F64x8; 2];

/// A grain: where its center is, and its radius.
pub(super) type Ball = [f64; 4];

/// Triangles and grains as they are in one step; keeps its memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Sheet {
    pub(super) faces: Vec<Face>,
    pub(super) balls: Vec<Ball>,
}

/// A grain and a triangle.
pub(super) type Pair = [u32; 2];

impl Sheet {
    /// Takes note of where all grains are.
    pub(super) fn note_grains<R: Row>(&mut self, grains: &Grains<R>) {
        self.balls.clear();
        self.balls.extend((0..grains.len()).map(|i| {
            let [x, y, z] = grains.pose(i, 0).position;
            [x, y, z, grains.radius(i)]
        }));
    }

    /// Takes note of where all `triangles` are; one without area has no normal, and touches nothing.
    #[inline(always)]
    pub(super) fn note_triangles<W: Lane<Row = F64x8, Scalar = f64>>(
        &mut self,
        triangles: &[[u32; 3]],
        vertices: &[F64x8],
    ) {
        self.faces.clear();
        let last = triangles.len().saturating_sub(1);
        for first in (0..triangles.len()).step_by(W::K) {
            let corner = |e: usize, k: usize| triangles[(first + e).min(last)][k] as usize;
            let at = |k: usize| Vec3::<W>::gathered(|e| vertices[corner(e, k)].halves()[0]);
            let (a, b, c) = (at(0), at(1), at(2));
            let area = (b - a).cross(c - a);
            let doubled = area.dot(area).sqrt();
            let outward = area.scale(W::constant(1.0) / doubled);
            let over = |side: Vec3<W>| doubled / side.dot(side).sqrt();
            let (over_a, over_b, over_c) = (over(c - b), over(a - c), over(b - a));
            let lines = [
                W::transposed([a.x, a.y, a.z, over_a, b.x, b.y, b.z, over_b]),
                W::transposed([
                    c.x,
                    c.y,
                    c.z,
                    over_c,
                    outward.x,
                    outward.y,
                    outward.z,
                    W::constant(0.0),
                ]),
            ];
            for e in 0..W::K.min(triangles.len() - first) {
                let mut face = Face::default();
                lines[0][e].store(&mut face[0]);
                lines[1][e].store(&mut face[1]);
                self.faces.push(face);
            }
        }
    }

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
        let [a, b, c, outward] = [quarter(0), quarter(1), quarter(2), quarter(3)];
        let vector = |[x, y, z, _]: [W; 4]| Vec3 { x, y, z };
        let corners = [vector(a), vector(b), vector(c)];
        let center = Vec3 { x, y, z };
        let foot = foot(center, corners);
        let from = center - foot.on(corners);
        Feet {
            radius,
            square: from.dot(from),
            foot,
            from,
            height: (corners[0] - center).dot(vector(outward)),
            outward: vector(outward),
            over_sides: [a[3], b[3], c[3]],
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
    /// Of each corner, its height over the opposite side.
    pub(super) over_sides: [L; 3],
}
