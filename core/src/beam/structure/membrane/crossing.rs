//! Where a vertical line crosses the membrane, and by that, what is inside.
//!
//! Each edge is asked the same question by both of its triangles, bit by bit, so that no line slips through between them.

use std::ops::ControlFlow;

use super::Membrane;
use crate::math::plain::{cross, sub};

/// One crossing of the membrane by a vertical line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Height \[m\].
    pub height: f64,
    /// +1 where the line leaves the inside on its way up, −1 where it enters.
    pub sign: i32,
}

impl Membrane<'_> {
    /// The crossings by the vertical line at (x, y), in no particular order.
    pub fn visit_crossings(&self, x: f64, y: f64, mut visit: impl FnMut(Crossing)) {
        let [low, high] = self.bounds;
        let _ = self
            .grid
            .visit([x, y, low[2]], [x, y, high[2]], |triangle| {
                let corners = self.corners(triangle);
                let sign = winding(corners, x, y);
                if sign != 0 {
                    let height = height(corners, x, y);
                    visit(Crossing { height, sign });
                }
                ControlFlow::Continue(())
            });
    }

    /// How often the membrane goes around `point`: 1 inside, 0 outside, other numbers where it is folded through itself.
    #[must_use]
    pub fn winding(&self, point: [f64; 3]) -> i32 {
        let [low, high] = self.bounds;
        if (0..3).any(|k| point[k] < low[k] || point[k] > high[k]) {
            return 0;
        }
        let mut winding = 0;
        self.visit_crossings(point[0], point[1], |crossing| {
            if crossing.height > point[2] {
                winding += crossing.sign;
            }
        });
        winding
    }
}

/// How often the triangle, seen from above, goes around (x, y): 1 counterclockwise, −1 clockwise, 0 not at all.
fn winding([a, b, c]: [[f64; 3]; 3], x: f64, y: f64) -> i32 {
    let passes = |from: [f64; 3], to: [f64; 3]| {
        if (from[1] <= y) == (to[1] <= y) {
            return 0;
        }
        let (low, high, sign) = if from[1] <= y {
            (from, to, 1)
        } else {
            (to, from, -1)
        };
        let side = (high[0] - low[0]) * (y - low[1]) - (x - low[0]) * (high[1] - low[1]);
        if side > 0.0 { sign } else { 0 }
    };
    passes(a, b) + passes(b, c) + passes(c, a)
}

/// Height of the triangle's plane at (x, y), kept between its corners: on a steep one rounding would send it anywhere.
fn height([a, b, c]: [[f64; 3]; 3], x: f64, y: f64) -> f64 {
    let normal = cross(sub(b, a), sub(c, a));
    let (low, high) = (a[2].min(b[2]).min(c[2]), a[2].max(b[2]).max(c[2]));
    let rise = (normal[0] * (x - a[0]) + normal[1] * (y - a[1])) / normal[2];
    if rise.is_finite() {
        (a[2] - rise).clamp(low, high)
    } else {
        0.5 * (low + high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::structure::fixture::{bent, box_membrane};

    #[test]
    fn a_line_through_vertices_and_edges_crosses_once_up_and_once_down() {
        // Every line of this lattice meets vertices, edges or their projections.
        let (vertices, triangles) = box_membrane([0.0; 3], [4.0, 4.0, 1.0], [8, 8, 2]);
        let membrane = Membrane::new(&vertices, &triangles).expect("closed");
        for i in 1..16 {
            for j in 1..16 {
                let (x, y) = (0.25 * f64::from(i), 0.25 * f64::from(j));
                let mut found = vec![];
                membrane.visit_crossings(x, y, |crossing| found.push(crossing));
                found.sort_by(|a, b| a.height.total_cmp(&b.height));
                let at = |height, sign| Crossing { height, sign };
                assert_eq!(found, [at(0.0, -1), at(1.0, 1)]);
                assert_eq!(membrane.winding([x, y, 0.5]), 1);
                assert_eq!(membrane.winding([x, y, 1.5]), 0);
                assert_eq!(membrane.winding([x, y, -0.5]), 0);
            }
        }
    }

    #[test]
    fn above_the_trough_of_a_bent_box_is_outside() {
        let (vertices, triangles) = box_membrane([0.0; 3], [8.0, 2.0, 1.0], [40, 8, 4]);
        let vertices: Vec<_> = vertices.iter().map(|&at| bent(at, 8.0, 1.0, 2.0)).collect();
        let membrane = Membrane::new(&vertices, &triangles).expect("closed");
        let [low, high] = membrane.bounds();
        assert_eq!(membrane.winding([0.0, 1.03, low[2] + 0.5]), 1);
        assert_eq!(membrane.winding([0.0, 1.03, high[2] - 0.1]), 0);
        let end = bent([0.3, 1.03, 0.5], 8.0, 1.0, 2.0);
        assert!(membrane.holds(end, 0.2));
    }
}
