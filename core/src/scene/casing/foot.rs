//! The foot of a grain's center on one triangle: the nearest point, and what of the triangle it lies on.

use crate::math::plain;

/// What of a triangle a foot lies on; corners and sides by their place in the triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Face,
    Side(usize),
    Corner(usize),
}

/// The point of a triangle that is nearest to another point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Foot {
    pub(super) part: Part,
    /// Its barycentric coordinates: none below zero, their sum one.
    pub(super) weights: [f64; 3],
}

/// The foot of `point` on the triangle with corners a, b, c.
///
/// Source: C. Ericson, Real-Time Collision Detection (2005), Sec. 5.1.5: the point is in the region of a corner, of a side
/// or of the face; side s joins corner s to the next.
pub(super) fn foot(point: [f64; 3], [a, b, c]: [[f64; 3]; 3]) -> Foot {
    let (ab, ac) = (plain::sub(b, a), plain::sub(c, a));
    let along = |corner: [f64; 3]| {
        let to = plain::sub(point, corner);
        [plain::dot(ab, to), plain::dot(ac, to)]
    };
    let ([d1, d2], [d3, d4], [d5, d6]) = (along(a), along(b), along(c));
    let of = |part, weights| Foot { part, weights };
    if d1 <= 0.0 && d2 <= 0.0 {
        return of(Part::Corner(0), [1.0, 0.0, 0.0]);
    }
    if d3 >= 0.0 && d4 <= d3 {
        return of(Part::Corner(1), [0.0, 1.0, 0.0]);
    }
    if d6 >= 0.0 && d5 <= d6 {
        return of(Part::Corner(2), [0.0, 0.0, 1.0]);
    }
    let w_c = d1 * d4 - d3 * d2;
    if w_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let share = d1 / (d1 - d3);
        return of(Part::Side(0), [1.0 - share, share, 0.0]);
    }
    let w_b = d5 * d2 - d1 * d6;
    if w_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let share = d2 / (d2 - d6);
        return of(Part::Side(2), [1.0 - share, 0.0, share]);
    }
    let w_a = d3 * d6 - d5 * d4;
    let (from_b, from_c) = (d4 - d3, d5 - d6);
    if w_a <= 0.0 && from_b >= 0.0 && from_c >= 0.0 {
        let share = from_b / (from_b + from_c);
        return of(Part::Side(1), [0.0, 1.0 - share, share]);
    }
    let inverse = 1.0 / (w_a + w_b + w_c);
    let (v, w) = (w_b * inverse, w_c * inverse);
    of(Part::Face, [1.0 - v - w, v, w])
}

/// Σ w_k x_k.
pub(super) fn at(weights: [f64; 3], [a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let [u, v, w] = weights;
    [0, 1, 2].map(|k| u * a[k] + v * b[k] + w * c[k])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

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
            let foot = foot(point, corners);
            prop_assert!(foot.weights.iter().all(|w| (-1e-12..=1.0 + 1e-12).contains(w)));
            prop_assert!((foot.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let found = plain::norm(plain::sub(point, at(foot.weights, corners)));
            let searched = searched(point, corners);
            // No sampled point is nearer; one is within half a spacing of the foot, and sides are at most 2√3 long.
            prop_assert!(found <= searched + 1e-12);
            prop_assert!(searched <= found + 0.035);
        }
    }
}
