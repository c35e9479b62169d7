//! Convex polyhedron that planes cut pieces from.
//!
//! Faces keep their corners, so a cut is plain polygon clipping: planes that meet in one point, or lie on each other, leave slivers and never a hole.

use crate::math::plain::{add, cross, dot, scale, sub};

/// The label of the faces that a polyhedron starts with.
pub(super) const OUTER: usize = usize::MAX;

/// A face: its corners counterclockwise when seen from outside.
#[derive(Clone, Copy, Debug)]
struct Face {
    label: usize,
    from: usize,
    to: usize,
}

/// The polyhedron, and memory that cuts use again.
#[derive(Clone, Debug, Default)]
pub(super) struct Polyhedron {
    points: Vec<[f64; 3]>,
    faces: Vec<Face>,
    /// Height of each point above the plane at hand.
    heights: Vec<f64>,
    /// Corners of the new face.
    rim: Vec<[f64; 3]>,
    /// Corners of the new face by the angle at which they stand around its middle.
    sorted: Vec<(f64, [f64; 3])>,
    next_points: Vec<[f64; 3]>,
    next_faces: Vec<Face>,
}

impl Polyhedron {
    /// Becomes the cube from −`half` to `half` along each axis.
    pub(super) fn set_cube(&mut self, half: f64) {
        self.points.clear();
        self.faces.clear();
        for axis in 0..3 {
            for side in [-half, half] {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                for (a, b) in [(-half, -side), (half, -side), (half, side), (-half, side)] {
                    let mut corner = [0.0; 3];
                    (corner[axis], corner[u], corner[v]) = (side, a, b);
                    self.points.push(corner);
                }
                let to = self.points.len();
                self.faces.push(Face {
                    label: OUTER,
                    from: to - 4,
                    to,
                });
            }
        }
    }

    /// Becomes a copy of `other`.
    pub(super) fn set(&mut self, other: &Self) {
        self.points.clone_from(&other.points);
        self.faces.clone_from(&other.faces);
    }

    /// Cuts away what lies above the plane, where x·`normal` > `offset`; says whether that was anything.
    ///
    /// The new face gets the `label`.
    pub(super) fn cut(&mut self, normal: [f64; 3], offset: f64, label: usize) -> bool {
        self.heights.clear();
        let height = |&point: &[f64; 3]| dot(point, normal) - offset;
        self.heights.extend(self.points.iter().map(height));
        if self.heights.iter().all(|&height| height <= 0.0) {
            return false;
        }
        self.next_points.clear();
        self.next_faces.clear();
        self.rim.clear();
        for face in 0..self.faces.len() {
            self.clip(self.faces[face]);
        }
        self.close(normal, label);
        std::mem::swap(&mut self.points, &mut self.next_points);
        std::mem::swap(&mut self.faces, &mut self.next_faces);
        true
    }

    /// Keeps the part of one face below the plane; both faces of an edge find the same new corner on it.
    fn clip(&mut self, face: Face) {
        let from = self.next_points.len();
        for at in face.from..face.to {
            let after = if at + 1 == face.to { face.from } else { at + 1 };
            let (below, next_below) = (self.heights[at] <= 0.0, self.heights[after] <= 0.0);
            if below {
                self.next_points.push(self.points[at]);
            }
            if below != next_below {
                let (kept, lost) = if below { (at, after) } else { (after, at) };
                let share = self.heights[kept] / (self.heights[kept] - self.heights[lost]);
                let way = sub(self.points[lost], self.points[kept]);
                let corner = add(self.points[kept], scale(way, share));
                self.next_points.push(corner);
                self.rim.push(corner);
            }
        }
        if self.next_points.len() < from + 3 {
            self.next_points.truncate(from);
        } else {
            let to = self.next_points.len();
            self.next_faces.push(Face { from, to, ..face });
        }
    }

    /// Adds the face in the plane: the corners on the rim, in order around their middle.
    fn close(&mut self, normal: [f64; 3], label: usize) {
        if self.rim.len() < 3 {
            return;
        }
        let sum = self
            .rim
            .iter()
            .fold([0.0; 3], |sum, &corner| add(sum, corner));
        let middle = scale(sum, 1.0 / self.rim.len() as f64);
        let (u, v) = across(normal);
        self.sorted.clear();
        self.sorted.extend(self.rim.iter().map(|&corner| {
            let arm = sub(corner, middle);
            (turn(dot(arm, u), dot(arm, v)), corner)
        }));
        self.sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Each corner was found from both sides.
        self.sorted.dedup_by(|a, b| a.1 == b.1);
        let from = self.next_points.len();
        self.next_points
            .extend(self.sorted.iter().map(|corner| corner.1));
        let to = self.next_points.len();
        self.next_faces.push(Face { label, from, to });
    }

    /// The volume; 0 if nothing is left.
    pub(super) fn volume(&self) -> f64 {
        let faces = self.faces.iter();
        faces.map(|face| self.six_volumes(*face)).sum::<f64>() / 6.0
    }

    /// Six times the volume of the pyramid from the origin to a face.
    fn six_volumes(&self, face: Face) -> f64 {
        let first = self.points[face.from];
        (face.from + 1..face.to - 1).fold(0.0, |sum, at| {
            sum + dot(first, cross(self.points[at], self.points[at + 1]))
        })
    }

    /// Its corners, each as often as faces share it.
    pub(super) fn points(&self) -> &[[f64; 3]] {
        &self.points
    }

    /// Whether a face that it started with is left.
    pub(super) fn has_outer_face(&self) -> bool {
        self.faces.iter().any(|face| face.label == OUTER)
    }

    /// The square of the distance of the farthest corner from the origin.
    pub(super) fn squared_reach(&self) -> f64 {
        let squares = self.points.iter().map(|&point| dot(point, point));
        squares.fold(0.0, f64::max)
    }
}

/// Two vectors across `normal` and each other, so that u, v, `normal` are right-handed; u and v are equally long.
fn across(normal: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let [x, y, z] = normal.map(f64::abs);
    let axis = if x <= y && x <= z {
        [1.0, 0.0, 0.0]
    } else if y <= z {
        [0.0, 1.0, 0.0]
    } else {
        [0.0, 0.0, 1.0]
    };
    let u = scale(cross(axis, normal), dot(normal, normal).sqrt());
    (u, cross(normal, cross(axis, normal)))
}

/// A number that grows with the angle of (x, y), from −2 to 2.
fn turn(x: f64, y: f64) -> f64 {
    let length = x.abs() + y.abs();
    if length == 0.0 {
        return 0.0;
    }
    let part = x / length;
    if y >= 0.0 { 1.0 - part } else { part - 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::plain::norm;
    use crate::random::{Purpose, uniform3};

    fn cube(half: f64) -> Polyhedron {
        let mut cube = Polyhedron::default();
        cube.set_cube(half);
        cube
    }

    #[test]
    fn a_cube_has_its_volume_and_a_plane_beyond_it_cuts_nothing() {
        let mut cube = cube(1.5);
        assert!((cube.volume() - 27.0).abs() < 1e-13);
        assert!(!cube.cut([1.0, 0.0, 0.0], 1.5, 0));
        assert!(cube.has_outer_face());
    }

    #[test]
    fn cutting_corners_off_a_cube_leaves_an_octahedron() {
        let mut cube = cube(1.0);
        for x in [-1.0, 1.0] {
            for y in [-1.0, 1.0] {
                for z in [-1.0, 1.0] {
                    assert!(cube.cut([x, y, z], 1.0, 0));
                }
            }
        }
        // Four of its planes meet in each corner.
        assert!((cube.volume() - 4.0 / 3.0).abs() < 1e-14);
    }

    #[test]
    fn the_two_parts_of_a_cut_make_the_whole() {
        for n in 0..200 {
            let mut whole = cube(1.0);
            for k in 0..20 {
                let [x, y, z] = uniform3(n, Purpose::GasVelocity, k);
                let normal = [x - 0.5, y - 0.5, z - 0.5];
                whole.cut(normal, 0.9 * norm(normal), k as usize);
            }
            let [x, y, z] = uniform3(n, Purpose::GasOrientation, 0);
            let (normal, offset) = ([x - 0.5, y - 0.5, z - 0.5], 0.3 * (x - 0.5));
            let (mut below, mut above) = (whole.clone(), whole.clone());
            below.cut(normal, offset, 0);
            above.cut(scale(normal, -1.0), -offset, 0);
            let sum = below.volume() + above.volume();
            assert!((sum / whole.volume() - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn a_plane_below_all_of_it_leaves_nothing() {
        let mut cube = cube(1.0);
        assert!(cube.cut([0.0, 0.0, 1.0], -2.0, 0));
        assert!(cube.volume().abs() < f64::MIN_POSITIVE && cube.points().is_empty());
        assert!(!cube.cut([0.0, 0.0, 1.0], -3.0, 0));
    }

    #[test]
    fn cutting_along_a_face_or_twice_changes_no_volume() {
        let mut cube = cube(1.0);
        let normal = [0.1, 0.7, 0.3];
        cube.cut(normal, 0.4, 0);
        let volume = cube.volume();
        cube.cut(normal, 0.4, 1);
        cube.cut(normal, 0.4 - 1e-17, 2);
        cube.cut([0.0, 0.0, 1.0], 1.0 - 1e-16, 3);
        assert!((cube.volume() - volume).abs() < 1e-14);
    }
}
