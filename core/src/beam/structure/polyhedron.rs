//! Convex polyhedron that planes cut pieces from.
//!
//! A face is the set of its directed edges, so a cut needs no order and no angle, only that edges add up to closed lines.
//! They do so bit by bit: planes that meet in one point, or lie on each other, leave slivers and never a hole.

use crate::math::plain::{add, cross, dot, scale, sub};

/// The label of the faces that a polyhedron starts with.
pub(super) const OUTER: usize = usize::MAX;

/// A face: its edges, counterclockwise when seen from outside, in no particular order.
#[derive(Clone, Copy, Debug)]
struct Face {
    label: usize,
    from: usize,
    to: usize,
}

/// The polyhedron, and memory that cuts use again.
#[derive(Clone, Debug, Default)]
pub(super) struct Polyhedron {
    /// The edges, each from one corner to another.
    edges: Vec<[[f64; 3]; 2]>,
    faces: Vec<Face>,
    /// Heights of the ends of each edge above the plane at hand.
    heights: Vec<[f64; 2]>,
    /// Where the plane cuts into the face at hand, and out of it.
    crossings: [Vec<[f64; 3]>; 2],
    /// Edges of the new face.
    rim: Vec<[[f64; 3]; 2]>,
    next_edges: Vec<[[f64; 3]; 2]>,
    next_faces: Vec<Face>,
}

impl Polyhedron {
    /// Becomes the cube from −`half` to `half` along each axis.
    pub(super) fn set_cube(&mut self, half: f64) {
        self.edges.clear();
        self.faces.clear();
        for axis in 0..3 {
            for side in [-half, half] {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let corner = |(a, b): (f64, f64)| {
                    let mut corner = [0.0; 3];
                    (corner[axis], corner[u], corner[v]) = (side, a, b);
                    corner
                };
                let corners = [(-half, -side), (half, -side), (half, side), (-half, side)];
                let corners = corners.map(corner);
                let edge = |k: usize| [corners[k], corners[(k + 1) % 4]];
                let from = self.edges.len();
                self.edges.extend((0..4).map(edge));
                let to = self.edges.len();
                let label = OUTER;
                self.faces.push(Face { label, from, to });
            }
        }
    }

    /// Becomes a copy of `other`.
    pub(super) fn set(&mut self, other: &Self) {
        self.edges.clone_from(&other.edges);
        self.faces.clone_from(&other.faces);
    }

    /// Cuts away what lies above the plane, where x·`normal` > `offset`; says whether that was anything.
    ///
    /// The new face gets the `label`.
    pub(super) fn cut(&mut self, normal: [f64; 3], offset: f64, label: usize) -> bool {
        let height = |point: [f64; 3]| dot(point, normal) - offset;
        // Most planes cut nothing, and each corner is the start of some edge.
        let highest = self.points().map(height).fold(f64::NEG_INFINITY, f64::max);
        if highest <= 0.0 || self.is_empty() {
            return false;
        }
        self.heights.clear();
        self.heights
            .extend(self.edges.iter().map(|edge| edge.map(height)));
        self.next_edges.clear();
        self.next_faces.clear();
        self.rim.clear();
        for face in 0..self.faces.len() {
            self.clip(self.faces[face]);
        }
        let from = self.next_edges.len();
        self.next_edges.append(&mut self.rim);
        self.finish(from, label);
        std::mem::swap(&mut self.edges, &mut self.next_edges);
        std::mem::swap(&mut self.faces, &mut self.next_faces);
        true
    }

    /// Keeps the part of one face below the plane; both faces of an edge find the same new corner on it.
    fn clip(&mut self, face: Face) {
        let from = self.next_edges.len();
        let [into, out] = &mut self.crossings;
        into.clear();
        out.clear();
        for at in face.from..face.to {
            let ([start, end], [first, second]) = (self.edges[at], self.heights[at]);
            match (first <= 0.0, second <= 0.0) {
                (true, true) => self.next_edges.push([start, end]),
                (true, false) => {
                    let corner = between(start, end, first, second);
                    self.next_edges.push([start, corner]);
                    out.push(corner);
                }
                (false, true) => {
                    let corner = between(end, start, second, first);
                    self.next_edges.push([corner, end]);
                    into.push(corner);
                }
                (false, false) => {}
            }
        }
        // A closed line crosses the plane as often one way as the other, and all crossings lie on one straight line.
        for (&into, &out) in into.iter().zip(out.iter()) {
            self.next_edges.push([out, into]);
            self.rim.push([into, out]);
        }
        self.finish(from, face.label);
    }

    /// Makes a face of the edges from `from` on, unless they enclose nothing.
    fn finish(&mut self, from: usize, label: usize) {
        let mut to = from;
        for at in from..self.next_edges.len() {
            let [start, end] = self.next_edges[at];
            if start.map(f64::to_bits) != end.map(f64::to_bits) {
                self.next_edges[to] = [start, end];
                to += 1;
            }
        }
        if to < from + 3 {
            to = from;
        } else {
            self.next_faces.push(Face { label, from, to });
        }
        self.next_edges.truncate(to);
    }

    /// The volume; 0 if nothing is left.
    pub(super) fn volume(&self) -> f64 {
        let faces = self.faces.iter();
        faces.map(|face| self.six_volumes(*face)).sum::<f64>() / 6.0
    }

    /// Six times the volume of the pyramid from the origin to a face: Σ p·(a × b) over its edges, p any of its points.
    fn six_volumes(&self, face: Face) -> f64 {
        let edges = &self.edges[face.from..face.to];
        let areas = edges
            .iter()
            .fold([0.0; 3], |sum, &[a, b]| add(sum, cross(a, b)));
        dot(edges[0][0], areas)
    }

    /// Its corners, each as often as faces share it.
    pub(super) fn points(&self) -> impl Iterator<Item = [f64; 3]> {
        self.edges.iter().map(|edge| edge[0])
    }

    /// Whether nothing is left.
    pub(super) fn is_empty(&self) -> bool {
        self.edges.is_empty()
    }

    /// Whether a face that it started with is left.
    pub(super) fn has_outer_face(&self) -> bool {
        self.faces.iter().any(|face| face.label == OUTER)
    }

    /// The square of the distance of the farthest corner from the origin.
    pub(super) fn squared_reach(&self) -> f64 {
        self.points()
            .map(|point| dot(point, point))
            .fold(0.0, f64::max)
    }
}

/// The point of the plane between `below` and `above`, whose heights are given.
fn between(below: [f64; 3], above: [f64; 3], lower: f64, higher: f64) -> [f64; 3] {
    add(below, scale(sub(above, below), lower / (lower - higher)))
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
        assert!(cube.volume().abs() < f64::MIN_POSITIVE && cube.is_empty());
        assert!(!cube.cut([0.0, 0.0, 1.0], -3.0, 0));
    }

    #[test]
    fn planes_on_each_other_up_to_rounding_cut_as_one() {
        // Corners of the first face lie above or below the second plane by chance, in any order around it.
        for n in 0..500 {
            let mut once = cube(1.0);
            let [x, y, z] = uniform3(n, Purpose::GasVelocity, 0);
            let normal = [x - 0.5, y - 0.5, z - 0.5];
            let offset = 0.4 * norm(normal);
            once.cut(normal, offset, 0);
            let mut twice = once.clone();
            for k in 0..5 {
                let [part, shift, _] = uniform3(n, Purpose::GasOrientation, k);
                let factor = 0.1 + part;
                let rounding = 1e-16 * (shift - 0.5);
                twice.cut(scale(normal, factor), factor * (offset + rounding), 1);
            }
            assert!((once.volume() - twice.volume()).abs() < 1e-14);
        }
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
