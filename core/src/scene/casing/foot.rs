//! The foot of a grain's center on one triangle: the nearest point, and what of the triangle it lies on.

use crate::lanes::{Lane, Mask};
use crate::math::Vec3;

/// What of a triangle a foot lies on; corners and sides by their place in the triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Face,
    Side(usize),
    Corner(usize),
}

impl Part {
    /// As a number that a lane can hold.
    const fn code(self) -> f64 {
        match self {
            Self::Face => 0.0,
            Self::Side(s) => 1.0 + s as f64,
            Self::Corner(c) => 4.0 + c as f64,
        }
    }

    /// The part of that code.
    #[inline(always)]
    pub(super) fn of(code: f64) -> Self {
        match code as usize {
            0 => Self::Face,
            n @ 1..=3 => Self::Side(n - 1),
            n => Self::Corner(n - 4),
        }
    }
}

/// The point of a triangle that is nearest to another point, in every lane.
#[derive(Clone, Copy)]
pub(super) struct Foot<L> {
    /// The code of its [`Part`].
    pub(super) part: L,
    /// Its barycentric coordinates: none below zero, their sum one.
    pub(super) weights: [L; 3],
}

impl<L: Lane> Foot<L> {
    /// The point with these barycentric coordinates.
    #[inline(always)]
    pub(super) fn on(&self, [a, b, c]: [Vec3<L>; 3]) -> Vec3<L> {
        let [u, v, w] = self.weights;
        c.scale_add(w, b.scale_add(v, a.scale(u)))
    }
}

/// What holds in the region of `part`: the shares of the corners, their sum, and the code.
#[inline(always)]
fn region<L: Lane>(part: Part, shares: [L; 3], sum: L) -> ([L; 3], [L; 2]) {
    (shares, [sum, L::constant(part.code())])
}

/// The foot of `point` on the triangle with corners a, b, c.
///
/// Source: C. Ericson, Real-Time Collision Detection (2005), Sec. 5.1.5: the point is in the region of a corner, of a side
/// or of the face; side s joins corner s to the next.
/// Regions are tried from the last to the first, so that the first one counts.
#[inline(always)]
pub(super) fn foot<L: Lane>(point: Vec3<L>, [a, b, c]: [Vec3<L>; 3]) -> Foot<L> {
    let (zero, one) = (L::constant(0.0), L::constant(1.0));
    let (ab, ac) = (b - a, c - a);
    let along = |corner: Vec3<L>| {
        let to = point - corner;
        [ab.dot(to), ac.dot(to)]
    };
    let ([d1, d2], [d3, d4], [d5, d6]) = (along(a), along(b), along(c));
    let (w_a, w_b, w_c) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    let (from_b, from_c) = (d4 - d3, d5 - d6);
    let mut found = region(Part::Face, [w_a, w_b, w_c], w_a + w_b + w_c);
    let mut or = |mask: L::Mask, (shares, last): ([L; 3], [L; 2])| {
        let ([u, v, w], [sum, part]) = (shares, last);
        let ([old_u, old_v, old_w], [old_sum, old_part]) = found;
        found = (
            [
                u.select(mask, old_u),
                v.select(mask, old_v),
                w.select(mask, old_w),
            ],
            [sum.select(mask, old_sum), part.select(mask, old_part)],
        );
    };
    let side = |weight: L, from: L, to: L| weight.le(zero).and(zero.le(from)).and(zero.le(to));
    or(
        side(w_a, from_b, from_c),
        region(Part::Side(1), [zero, from_c, from_b], from_b + from_c),
    );
    or(
        side(w_b, d2, -d6),
        region(Part::Side(2), [-d6, zero, d2], d2 - d6),
    );
    or(
        side(w_c, d1, -d3),
        region(Part::Side(0), [-d3, d1, zero], d1 - d3),
    );
    or(
        zero.le(d6).and(d5.le(d6)),
        region(Part::Corner(2), [zero, zero, one], one),
    );
    or(
        zero.le(d3).and(d4.le(d3)),
        region(Part::Corner(1), [zero, one, zero], one),
    );
    or(
        d1.le(zero).and(d2.le(zero)),
        region(Part::Corner(0), [one, zero, zero], one),
    );
    let (shares, [sum, part]) = found;
    let (inverse, [u, v, w]) = (one / sum, shares);
    Foot {
        part,
        weights: [u * inverse, v * inverse, w * inverse],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::F64x1;
    use crate::math::plain;
    use proptest::prelude::*;

    /// Σ w_k x_k.
    fn at(weights: [f64; 3], [a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
        let [u, v, w] = weights;
        [0, 1, 2].map(|k| u * a[k] + v * b[k] + w * c[k])
    }

    /// The least distance to any of many points of the triangle, spaced by a hundredth of it.
    fn searched(point: [f64; 3], corners: [[f64; 3]; 3]) -> f64 {
        let n = 100;
        let mut least = f64::INFINITY;
        for i in 0..=n {
            for j in 0..=n - i {
                let (v, w) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                let there = at([1.0 - v - w, v, w], corners);
                least = least.min(plain::norm(plain::sub(point, there)));
            }
        }
        least
    }

    proptest! {
        #[test]
        fn foot_is_the_nearest_point_of_the_triangle(
            corners in prop::array::uniform3(prop::array::uniform3(-1.0..1.0f64)),
            point in prop::array::uniform3(-2.0..2.0f64),
        ) {
            let [a, b, c] = corners;
            let area = plain::norm(plain::cross(plain::sub(b, a), plain::sub(c, a)));
            prop_assume!(area > 0.05);
            let lone = Vec3::<F64x1>::splat;
            let foot = foot(lone(point), corners.map(lone));
            let weights = foot.weights.map(|weight| weight.0[0]);
            prop_assert!(weights.iter().all(|w| (-1e-12..=1.0 + 1e-12).contains(w)));
            prop_assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let zeros = weights.iter().filter(|weight| **weight == 0.0).count();
            let expected = match Part::of(foot.part.0[0]) {
                Part::Face => 0,
                Part::Side(_) => 1,
                Part::Corner(_) => 2,
            };
            prop_assert_eq!(zeros, expected);
            let found = plain::norm(plain::sub(point, at(weights, corners)));
            let searched = searched(point, corners);
            // No sampled point is nearer; one is within half a spacing of the foot, and sides are at most 2√3 long.
            prop_assert!(found <= searched + 1e-12);
            prop_assert!(searched <= found + 0.035);
        }
    }
}
