//! Distance of a point from a triangle.

use crate::math::plain::{cross, dot, scale, sub};

/// The square of the distance of `point` from the triangle of `corners`, which may be degenerate.
pub(super) fn squared_distance(corners: [[f64; 3]; 3], point: [f64; 3]) -> f64 {
    let [a, b, c] = corners;
    let normal = cross(sub(b, a), sub(c, a));
    let square = dot(normal, normal);
    let edges = [[a, b], [b, c], [c, a]];
    let within =
        |[from, to]: [[f64; 3]; 2]| dot(cross(normal, sub(to, from)), sub(point, from)) >= 0.0;
    if square > 0.0 && edges.into_iter().all(within) {
        let height = dot(normal, sub(point, a));
        return height * height / square;
    }
    let from_edge = |[from, to]: [[f64; 3]; 2]| squared_distance_from_edge(from, to, point);
    edges
        .map(from_edge)
        .into_iter()
        .fold(f64::INFINITY, f64::min)
}

fn squared_distance_from_edge(from: [f64; 3], to: [f64; 3], point: [f64; 3]) -> f64 {
    let (edge, arm) = (sub(to, from), sub(point, from));
    let square = dot(edge, edge);
    let share = if square > 0.0 {
        (dot(arm, edge) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let rest = sub(arm, scale(edge, share));
    dot(rest, rest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::plain::add;
    use crate::random::{Purpose, uniform3};

    #[test]
    fn no_point_of_the_triangle_is_nearer_and_one_is_as_near() {
        for n in 0..50 {
            let at = |k| uniform3(n, Purpose::GasVelocity, k);
            let ([a, b, c], point) = ([at(0), at(1), at(2)], at(3));
            let found = squared_distance([a, b, c], point).sqrt();
            let mut least = f64::INFINITY;
            for i in 0..=100 {
                for j in 0..=100 - i {
                    let (u, v) = (f64::from(i) / 100.0, f64::from(j) / 100.0);
                    let place = add(a, add(scale(sub(b, a), u), scale(sub(c, a), v)));
                    let arm = sub(point, place);
                    least = least.min(dot(arm, arm).sqrt());
                }
            }
            // The next place of the grid is at most 0.01 × 2 × √3 away.
            assert!(found <= least + 1e-15 && least < found + 0.035);
        }
    }

    #[test]
    fn a_triangle_that_is_a_line_or_a_point_still_has_a_distance() {
        let line = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        assert!((squared_distance(line, [1.5, 2.0, 0.0]) - 4.0).abs() < 1e-15);
        assert!((squared_distance([[1.0; 3]; 3], [1.0, 1.0, 3.0]) - 4.0).abs() < 1e-15);
    }
}
