//! The membrane as a closed surface: its volume, what it holds, and how far away it is.

use std::ops::ControlFlow;

use super::SnapshotError;
use super::cells::{BoxGrid, bounds};
use crate::math::plain::{add, cross, dot, norm, scale, sub};

mod crossing;
mod distance;

pub use crossing::Crossing;
use distance::squared_distance;

/// A closed surface of triangles, turned outward.
#[derive(Clone, Debug)]
pub struct Membrane<'a> {
    vertices: &'a [[f64; 3]],
    /// Counterclockwise when seen from outside.
    triangles: Vec<[usize; 3]>,
    /// \[m³\], positive.
    volume: f64,
    /// Low and high corner of the box around it.
    bounds: [[f64; 3]; 2],
    grid: BoxGrid,
}

impl<'a> Membrane<'a> {
    /// The surface of `triangles`, all turned outward or all inward.
    pub fn new(vertices: &'a [[f64; 3]], triangles: &[[usize; 3]]) -> Result<Self, SnapshotError> {
        check_vertices(vertices.len(), triangles)?;
        check_closed(triangles)?;
        let corners = |triangle: &[usize; 3]| triangle.map(|vertex| vertices[vertex]);
        let used = || triangles.iter().flat_map(corners);
        let bounds = bounds(used()).ok_or(SnapshotError::NoVolume)?;
        let middle = scale(add(bounds[0], bounds[1]), 0.5);
        // V = (1/6) Σ a·(b × c), by the divergence theorem.
        let volume = triangles.iter().map(corners).fold(0.0, |sum, corners| {
            let [a, b, c] = corners.map(|corner| sub(corner, middle));
            sum + dot(a, cross(b, c)) / 6.0
        });
        if volume == 0.0 || !volume.is_finite() {
            return Err(SnapshotError::NoVolume);
        }
        let outward = |&[a, b, c]: &[usize; 3]| if volume > 0.0 { [a, b, c] } else { [a, c, b] };
        let boxes: Vec<_> = triangles.iter().map(|of| around(corners(of))).collect();
        Ok(Self {
            vertices,
            triangles: triangles.iter().map(outward).collect(),
            volume: volume.abs(),
            bounds,
            grid: BoxGrid::new(&boxes, typical_width(&boxes)),
        })
    }

    /// V \[m³\].
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Low and high corner of the box around it \[m\].
    #[must_use]
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        self.bounds
    }

    /// The corners of one triangle, counterclockwise when seen from outside.
    pub(super) fn corners(&self, triangle: usize) -> [[f64; 3]; 3] {
        self.triangles[triangle].map(|vertex| self.vertices[vertex])
    }

    /// Collects the triangles that may reach into the box from `low` to `high`.
    pub(super) fn triangles_near(&self, low: [f64; 3], high: [f64; 3], found: &mut Vec<usize>) {
        found.clear();
        let _ = self.grid.visit(low, high, |triangle| {
            found.push(triangle);
            ControlFlow::Continue(())
        });
    }

    /// Distance \[m\] of `point` from the surface, if it is at most `within`.
    #[must_use]
    pub fn distance(&self, point: [f64; 3], within: f64) -> Option<f64> {
        let mut least = within * within;
        let mut found = false;
        let _ = self.visit_around(point, within, |square| {
            found |= square <= least;
            least = least.min(square);
            ControlFlow::Continue(())
        });
        found.then(|| least.sqrt())
    }

    /// Whether `point` lies inside and farther than `depth` from the surface.
    #[must_use]
    pub fn holds(&self, point: [f64; 3], depth: f64) -> bool {
        let near = self.visit_around(point, depth, |square| {
            if square <= depth * depth {
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        });
        near.is_continue() && self.winding(point) > 0
    }

    /// Calls `visit` with the squared distance of each triangle that may be within `reach`.
    fn visit_around(
        &self,
        point: [f64; 3],
        reach: f64,
        mut visit: impl FnMut(f64) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let (low, high) = (point.map(|x| x - reach), point.map(|x| x + reach));
        self.grid.visit(low, high, |triangle| {
            visit(squared_distance(self.corners(triangle), point))
        })
    }
}

fn around(corners: [[f64; 3]; 3]) -> [[f64; 3]; 2] {
    bounds(corners).expect("a triangle has corners")
}

/// The mean diagonal of `boxes`.
fn typical_width(boxes: &[[[f64; 3]; 2]]) -> f64 {
    let diagonals = boxes.iter().map(|[low, high]| norm(sub(*high, *low)));
    diagonals.sum::<f64>() / boxes.len() as f64
}

fn check_vertices(vertices: usize, triangles: &[[usize; 3]]) -> Result<(), SnapshotError> {
    let unknown = |triangle: &[usize; 3]| triangle.iter().any(|&vertex| vertex >= vertices);
    match triangles.iter().position(unknown) {
        None => Ok(()),
        Some(triangle) => Err(SnapshotError::Vertex { triangle, vertices }),
    }
}

/// Each edge must be run through as often one way as the other.
fn check_closed(triangles: &[[usize; 3]]) -> Result<(), SnapshotError> {
    let ways = |&[a, b, c]: &[usize; 3]| [[a, b], [b, c], [c, a]];
    let mut there: Vec<[usize; 2]> = triangles.iter().flat_map(ways).collect();
    let mut back: Vec<[usize; 2]> = there.iter().map(|&[from, to]| [to, from]).collect();
    there.sort_unstable();
    back.sort_unstable();
    match there.iter().zip(&back).find(|(there, back)| there != back) {
        None => Ok(()),
        Some((&there, &back)) => {
            let [from, to] = there.min(back);
            Err(SnapshotError::OpenMembrane { from, to })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::structure::fixture::{bent, box_membrane};

    #[test]
    fn a_box_has_its_volume_whichever_way_its_triangles_turn() {
        let (vertices, mut triangles) = box_membrane([1.0, -2.0, 3.0], [4.0, 2.0, 5.0], [3, 4, 2]);
        let out = Membrane::new(&vertices, &triangles)
            .expect("closed")
            .volume();
        for triangle in &mut triangles {
            triangle.swap(1, 2);
        }
        let inward = Membrane::new(&vertices, &triangles).expect("closed");
        assert!((out - 24.0).abs() < 1e-12);
        assert!((inward.volume() - 24.0).abs() < 1e-12);
        assert!(inward.holds([2.0, 0.0, 4.0], 0.9) && !inward.holds([2.0, 0.0, 4.0], 1.1));
    }

    #[test]
    fn a_hole_or_a_turned_triangle_is_refused() {
        let (vertices, triangles) = box_membrane([0.0; 3], [1.0; 3], [2; 3]);
        let refused = |triangles: &[[usize; 3]]| {
            Membrane::new(&vertices, triangles).expect_err("it is not closed")
        };
        let open = |error| matches!(error, SnapshotError::OpenMembrane { .. });
        assert!(open(refused(&triangles[1..])));
        let mut turned = triangles.clone();
        turned[5].swap(0, 1);
        assert!(open(refused(&turned)));
        assert_eq!(refused(&[]), SnapshotError::NoVolume);
        let unknown = [[0, 1, 99]];
        assert!(matches!(refused(&unknown), SnapshotError::Vertex { .. }));
        // Twice the same triangle, once each way: closed, and around nothing.
        assert_eq!(refused(&[[0, 1, 2], [0, 2, 1]]), SnapshotError::NoVolume);
    }

    #[test]
    fn distances_from_a_box_are_those_of_geometry() {
        let (vertices, triangles) = box_membrane([0.0; 3], [8.0, 4.0, 2.0], [16, 8, 4]);
        let membrane = Membrane::new(&vertices, &triangles).expect("closed");
        let near = |point, expected: f64| {
            let found = membrane.distance(point, 5.0).expect("near");
            assert!((found - expected).abs() < 1e-14, "{point:?} {found}");
        };
        near([4.0, 2.0, 0.7], 0.7);
        near([7.9, 2.0, 1.0], 0.1);
        near([9.0, 5.0, 3.0], 3.0f64.sqrt());
        near([9.0, 2.0, 3.0], 2.0f64.sqrt());
        assert_eq!(membrane.distance([4.0, 2.0, 1.0], 0.99), None);
        assert!(membrane.holds([4.0, 2.0, 0.7], 0.69) && !membrane.holds([4.0, 2.0, 0.7], 0.71));
        assert!(!membrane.holds([9.0, 2.0, 1.0], 0.1));
    }

    #[test]
    fn a_bent_box_has_the_volume_of_a_ring_s_sector() {
        // Bent about an axis: V = angle × radius of the middle × height × depth, less what chords cut off: angle²/24 n².
        let (vertices, triangles) = box_membrane([0.0; 3], [8.0, 2.0, 1.0], [80, 4, 4]);
        let vertices: Vec<_> = vertices.iter().map(|&at| bent(at, 8.0, 1.0, 1.0)).collect();
        let volume = Membrane::new(&vertices, &triangles)
            .expect("closed")
            .volume();
        assert!((volume / 16.0 - 1.0).abs() < 1e-4, "{volume}");
    }
}
