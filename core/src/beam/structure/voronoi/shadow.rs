//! How much of a convex cell lies inside the membrane.

use crate::beam::structure::cells::bounds;
use crate::beam::structure::membrane::Membrane;
use crate::beam::structure::polyhedron::Polyhedron;
use crate::math::plain::{add, cross, dot, norm, scale, sub};

/// A point of view this near to a triangle's plane, relative to the cell, sees it edge-on or stands on it.
const EDGE_ON: f64 = 1e-9;

/// Thickness of the slices along the faces of a cube, relative to half its side.
const SLICE: f64 = 1e-3;

/// Clips cells by one membrane.
pub(super) struct Clipper<'a> {
    membrane: &'a Membrane<'a>,
    near: Vec<usize>,
    /// Triangles near the cell, relative to the grain.
    triangles: Vec<[[f64; 3]; 3]>,
    shadow: Polyhedron,
    slice: Polyhedron,
}

impl<'a> Clipper<'a> {
    pub(super) fn new(membrane: &'a Membrane<'a>) -> Self {
        Self {
            membrane,
            near: vec![],
            triangles: vec![],
            shadow: Polyhedron::default(),
            slice: Polyhedron::default(),
        }
    }

    /// Whether a cell that was cut from the cube of half side `half` goes on beyond it inside the membrane.
    pub(super) fn is_inside_at_cube(
        &mut self,
        cell: &Polyhedron,
        half: f64,
        center: [f64; 3],
    ) -> bool {
        let mut slice = std::mem::take(&mut self.slice);
        let found = (0..6).any(|side| {
            let mut inward = [0.0; 3];
            inward[side / 2] = if side % 2 == 0 { 1.0 } else { -1.0 };
            slice.set(cell);
            slice.cut(inward, -half * (1.0 - SLICE), 0);
            self.volume_inside(&slice, center) > EDGE_ON * SLICE * half * half * half
        });
        self.slice = slice;
        found
    }

    /// Volume of the part of `cell` inside the membrane; the cell's coordinates are relative to `center`.
    pub(super) fn volume_inside(&mut self, cell: &Polyhedron, center: [f64; 3]) -> f64 {
        let Some([low, high]) = bounds(cell.points()) else {
            return 0.0;
        };
        self.collect(add(low, center), add(high, center), center);
        self.triangles
            .retain(|triangle| may_meet(*triangle, low, high));
        let view = self.point_of_view(cell, norm(sub(high, low)));
        let winding = f64::from(self.membrane.winding(add(view, center)));
        let mut inside = if winding == 0.0 {
            0.0
        } else {
            winding * cell.volume()
        };
        for at in 0..self.triangles.len() {
            inside -= self.cast(cell, self.triangles[at], view);
        }
        inside
    }

    fn collect(&mut self, low: [f64; 3], high: [f64; 3], center: [f64; 3]) {
        self.membrane.triangles_near(low, high, &mut self.near);
        let relative = |&triangle: &usize| {
            let corners = self.membrane.corners(triangle);
            corners.map(|corner| sub(corner, center))
        };
        self.triangles.clear();
        self.triangles.extend(self.near.iter().map(relative));
    }

    /// A point of the cell that is on no triangle: its middle, or else between there and a corner.
    fn point_of_view(&self, cell: &Polyhedron, size: f64) -> [f64; 3] {
        let (sum, count) = cell.points().fold(([0.0; 3], 0.0), |(sum, count), point| {
            (add(sum, point), count + 1.0)
        });
        let middle = scale(sum, 1.0 / count);
        let off_all = |view: &[f64; 3]| {
            self.triangles.iter().all(|&[a, b, c]| {
                let normal = cross(sub(b, a), sub(c, a));
                dot(normal, sub(a, *view)).abs() >= EDGE_ON * size * norm(normal)
            })
        };
        // Thirds and halves of the way, for cells whose corners lie in one plane with the middle.
        let others = cell.points().enumerate().map(|(k, corner)| {
            let share = if k % 2 == 0 { 0.3 } else { 0.45 };
            add(middle, scale(sub(corner, middle), share))
        });
        let mut views = std::iter::once(middle).chain(others);
        views.find(off_all).unwrap_or(middle)
    }

    /// Volume of the triangle's shadow in the cell, positive where segments from `view` leave the membrane.
    fn cast(&mut self, cell: &Polyhedron, [a, b, c]: [[f64; 3]; 3], view: [f64; 3]) -> f64 {
        let normal = cross(sub(b, a), sub(c, a));
        let ahead = dot(normal, sub(a, view));
        if ahead == 0.0 {
            return 0.0;
        }
        let sign = ahead.signum();
        self.shadow.set(cell);
        self.shadow
            .cut(scale(normal, -sign), -sign * dot(normal, a), 0);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if self.shadow.is_empty() {
                return 0.0;
            }
            // The same two corners give the neighbor exactly the opposite plane.
            let side = scale(cross(sub(from, view), sub(to, view)), -sign);
            self.shadow.cut(side, dot(side, view), 0);
        }
        sign * self.shadow.volume()
    }
}

/// Whether the box around the triangle and the box from `low` to `high` overlap.
fn may_meet(corners: [[f64; 3]; 3], low: [f64; 3], high: [f64; 3]) -> bool {
    let [least, most] = bounds(corners).expect("a triangle has corners");
    (0..3).all(|k| least[k] <= high[k] && most[k] >= low[k])
}
