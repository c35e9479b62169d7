//! Triangle meshes: vertices, triangles and what follows from both.
//!
//! A triangle's normal points to the side from which its corners run counterclockwise: outward on a closed mesh.
//! Neighbors run their common edge in opposite directions.

use super::topology::Topology;
use crate::math::plain;

/// Why vertices and triangles are no mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// Nothing to mesh.
    #[error("a mesh needs at least one triangle")]
    Empty,
    /// Numbers of vertices and sides are kept in 32 bits.
    #[error("{count} {what}: a mesh takes at most {most}")]
    TooMany {
        /// `vertices` or `triangles`.
        what: &'static str,
        /// How many were given.
        count: usize,
        /// How many are possible.
        most: usize,
    },
    /// A coordinate is not a number.
    #[error("vertex {vertex} is at {position:?}: coordinates must be finite")]
    NonFinite {
        /// Its number.
        vertex: u32,
        /// Where it is.
        position: [f64; 3],
    },
    /// A corner is no vertex.
    #[error("triangle {triangle} names vertex {vertex}: there are {vertices}")]
    UnknownVertex {
        /// Its number.
        triangle: u32,
        /// The vertex that it names.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
    /// Two corners coincide or all three lie on a line.
    #[error("triangle {triangle} has no area")]
    NoArea {
        /// Its number.
        triangle: u32,
    },
    /// Two triangles run an edge in the same direction: one is turned over, or an edge has more than two triangles.
    #[error("triangles {triangles:?} both run the edge {ends:?} in the same direction")]
    Orientation {
        /// Their numbers.
        triangles: [u32; 2],
        /// The vertices that the edge joins.
        ends: [u32; 2],
    },
    /// A vertex would have no mass.
    #[error("vertex {vertex} belongs to no triangle")]
    UnusedVertex {
        /// Its number.
        vertex: u32,
    },
    /// A mesh that must be closed has a border.
    #[error("the edge {ends:?} has one triangle only: the mesh must be closed")]
    Open {
        /// The vertices that the edge joins.
        ends: [u32; 2],
    },
    /// The normals of a closed mesh point inward.
    #[error(
        "the mesh encloses {volume} m³: its triangles must run counterclockwise seen from outside"
    )]
    InsideOut {
        /// Volume \[m³\].
        volume: f64,
    },
}

/// A conforming, consistently oriented triangle mesh, with or without border.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Mesh {
    pub(super) positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    topology: Topology,
}

impl Mesh {
    /// A mesh of `triangles` between `positions` \[m\].
    pub fn new(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        check_counts(positions.len(), triangles.len())?;
        check_positions(&positions)?;
        check_corners(&triangles, positions.len())?;
        let topology = Topology::of(&triangles, positions.len())?;
        let mesh = Self {
            positions,
            triangles,
            topology,
        };
        let flat = mesh.areas().position(|area| !area.is_normal());
        match flat {
            Some(triangle) => Err(MeshError::NoArea {
                triangle: triangle as u32,
            }),
            None => Ok(mesh),
        }
    }

    /// Where the vertices are \[m\].
    #[must_use]
    pub fn positions(&self) -> &[[f64; 3]] {
        &self.positions
    }

    /// Moves vertices; the topology stays.
    pub fn positions_mut(&mut self) -> &mut [[f64; 3]] {
        &mut self.positions
    }

    /// The corners of every triangle.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The two ends of every edge, the lower first; edges ascend.
    #[must_use]
    pub fn edges(&self) -> &[[u32; 2]] {
        &self.topology.edges
    }

    /// Of every edge, the triangle that runs it from its lower to its higher end, and the one that runs it back.
    #[must_use]
    pub fn edge_triangles(&self) -> &[[Option<u32>; 2]] {
        &self.topology.edge_triangles
    }

    /// The edges of triangle `t`; side s joins corner s to the next.
    #[must_use]
    pub fn sides(&self, t: u32) -> [u32; 3] {
        self.topology.sides[t as usize]
    }

    /// The triangle over each side of triangle `t`; `None` over the border.
    #[must_use]
    pub fn over_sides(&self, t: u32) -> [Option<u32>; 3] {
        self.topology.over_sides[t as usize]
    }

    /// The triangles around `vertex`, ascending.
    #[must_use]
    pub fn fan(&self, vertex: u32) -> &[u32] {
        self.topology.fans.of(vertex)
    }

    /// Whether two triangles are one, or share a corner.
    #[must_use]
    pub fn are_neighbors(&self, a: u32, b: u32) -> bool {
        self.common_corners(a, b) > 0
    }

    /// How many corners two triangles share.
    #[must_use]
    pub fn common_corners(&self, a: u32, b: u32) -> usize {
        let (a, b) = (self.triangles[a as usize], self.triangles[b as usize]);
        a.iter().filter(|vertex| b.contains(vertex)).count()
    }

    /// χ = vertices − edges + triangles: 2 for a sphere, 1 for a disk, 0 for a tube.
    #[must_use]
    pub fn euler_characteristic(&self) -> i64 {
        let count = |number: usize| i64::try_from(number).expect("counted in 32 bits");
        count(self.positions.len()) - count(self.edges().len()) + count(self.triangles.len())
    }

    /// Whether every edge has two triangles.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.topology.closed
    }

    /// That the mesh is closed and its normals point outward.
    pub fn check_closed(&self) -> Result<(), MeshError> {
        if let Some(ends) = self.open_edge() {
            return Err(MeshError::Open { ends });
        }
        let volume = self.volume();
        if volume > 0.0 {
            Ok(())
        } else {
            Err(MeshError::InsideOut { volume })
        }
    }

    fn open_edge(&self) -> Option<[u32; 2]> {
        let triangles = self.edge_triangles();
        let open = triangles.iter().position(|both| both.contains(&None));
        open.map(|edge| self.edges()[edge])
    }

    /// The places of the corners of triangle `t`.
    #[must_use]
    pub fn corners(&self, t: u32) -> [[f64; 3]; 3] {
        self.triangles[t as usize].map(|vertex| self.positions[vertex as usize])
    }
}

fn check_counts(vertices: usize, triangles: usize) -> Result<(), MeshError> {
    // Sides, three to a triangle, and triangles at a triangle's corners are counted in 32 bits.
    const MOST: usize = 1 << 27;
    for (what, count) in [("vertices", vertices), ("triangles", triangles)] {
        if count > MOST {
            return Err(MeshError::TooMany {
                what,
                count,
                most: MOST,
            });
        }
    }
    if triangles == 0 {
        return Err(MeshError::Empty);
    }
    Ok(())
}

fn check_positions(positions: &[[f64; 3]]) -> Result<(), MeshError> {
    let wrong = (0u32..)
        .zip(positions)
        .find(|(_, place)| !place.iter().all(|x| x.is_finite()));
    match wrong {
        Some((vertex, &position)) => Err(MeshError::NonFinite { vertex, position }),
        None => Ok(()),
    }
}

fn check_corners(triangles: &[[u32; 3]], vertices: usize) -> Result<(), MeshError> {
    for (triangle, &[a, b, c]) in (0u32..).zip(triangles) {
        let vertex = a.max(b).max(c);
        if vertex as usize >= vertices {
            return Err(MeshError::UnknownVertex {
                triangle,
                vertex,
                vertices,
            });
        }
        if a == b || b == c || c == a {
            return Err(MeshError::NoArea { triangle });
        }
    }
    Ok(())
}

/// Geometry: sums run in the order of the triangles.
impl Mesh {
    /// A n̂ of triangle `t` = ½ (b − a) × (c − a) \[m²\].
    #[must_use]
    pub fn area_vector(&self, t: u32) -> [f64; 3] {
        let [a, b, c] = self.corners(t);
        plain::scale(plain::cross(plain::sub(b, a), plain::sub(c, a)), 0.5)
    }

    /// A of every triangle \[m²\].
    pub fn areas(&self) -> impl Iterator<Item = f64> + '_ {
        self.numbers().map(|t| plain::norm(self.area_vector(t)))
    }

    /// n̂ of every triangle; zero where there is no area.
    pub fn normals(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.numbers().map(|t| unit(self.area_vector(t)))
    }

    /// Σ A \[m²\].
    #[must_use]
    pub fn area(&self) -> f64 {
        self.areas().sum()
    }

    /// Σ A n̂ \[m²\]: zero, to rounding, on a closed mesh.
    #[must_use]
    pub fn area_vector_sum(&self) -> [f64; 3] {
        self.numbers()
            .map(|t| self.area_vector(t))
            .fold([0.0; 3], plain::add)
    }

    /// V = ⅙ Σ a · (b × c) \[m³\] by the divergence theorem, corners taken from the first vertex.
    ///
    /// Positive if normals point outward; without meaning on an open mesh.
    #[must_use]
    pub fn volume(&self) -> f64 {
        let origin = self.positions[0];
        let six_fold = |t| {
            let [a, b, c] = self.corners(t).map(|corner| plain::sub(corner, origin));
            plain::dot(a, plain::cross(b, c))
        };
        self.numbers().map(six_fold).sum::<f64>() / 6.0
    }

    /// ℓ of every edge \[m\].
    pub fn edge_lengths(&self) -> impl Iterator<Item = f64> + '_ {
        self.edges().iter().map(|&[i, j]| {
            let along = plain::sub(self.positions[j as usize], self.positions[i as usize]);
            plain::norm(along)
        })
    }

    /// The lowest and the highest corner of the box around all vertices.
    #[must_use]
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        let first = self.positions[0];
        let mut bounds = [first, first];
        for place in &self.positions {
            for axis in 0..3 {
                bounds[0][axis] = bounds[0][axis].min(place[axis]);
                bounds[1][axis] = bounds[1][axis].max(place[axis]);
            }
        }
        bounds
    }

    /// The sides of the box around all vertices.
    #[must_use]
    pub fn extent(&self) -> [f64; 3] {
        let [low, high] = self.bounds();
        plain::sub(high, low)
    }

    /// The numbers of the triangles.
    fn numbers(&self) -> impl Iterator<Item = u32> + use<> {
        0..self.triangles.len() as u32
    }
}

/// `a` at length one; zero where `a` is zero.
pub(super) fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = plain::norm(a);
    if length > 0.0 {
        plain::scale(a, 1.0 / length)
    } else {
        [0.0; 3]
    }
}

#[cfg(test)]
mod tests;
