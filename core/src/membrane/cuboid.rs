//! The closed cuboid of the beam's sheet: length along x, depth along y, height along z, centered at the origin.
//!
//! Lattice rows run along x and wrap around the four long faces, evenly spaced on each; every second row is shifted by half
//! an edge.
//! The number of rows around the girth, 2 (rows across h + rows across d), is even, so the shift alternates all the way around.
//! A shifted row ends in two half edges, so the last triangles of every strip are halved by the end plane.
//! The rows' ends are the rim of a rectangular grid that closes the end; its cells are cut along the diagonals that
//! radiate from its middle.
//! Edges and corners are sharp: all vertices lie on the cuboid, those on its edges on both faces.
//!
//! The mesh is its own mirror image under x → −x, to the bit; under y → −y and z → −z where both numbers of rows are even.

use super::mesh::{Mesh, MeshError};

/// How far edges of the long faces may be from the wanted length, relative to it.
///
/// Free of it are the half edges at the ends and the rim of the ends, whose edges are as long as rows are apart.
pub const EDGE_TOLERANCE: f64 = 0.1;

/// The largest number of vertices: three thousand times those of the beam.
pub const MOST_VERTICES: u32 = 1 << 24;

/// A cuboid and how finely it is meshed.
///
/// ```
/// use granary_core::membrane::Cuboid;
/// let beam = Cuboid { length: 0.4, height: 0.04, depth: 0.08, edge_length: 4.7e-3 };
/// let mesh = beam.mesh().unwrap();
/// assert_eq!(mesh.euler_characteristic(), 2);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    /// L \[m\], along x.
    pub length: f64,
    /// h \[m\], along z.
    pub height: f64,
    /// d \[m\], along y.
    pub depth: f64,
    /// a \[m\]: about how long the edges of the long faces are.
    pub edge_length: f64,
}

/// Why a cuboid has no mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CuboidError {
    /// A length is no length.
    #[error("{name} = {value} m: must be positive and finite")]
    NotPositive {
        /// The field.
        name: &'static str,
        /// What it is.
        value: f64,
    },
    /// The sides are no multiples of anything near the edge length.
    #[error(
        "edges of {edge_length} m do not fit {length} m × {height} m × {depth} m: the nearest lattice is off by {deviation:.2} of \
         an edge, more than {EDGE_TOLERANCE}; sides of four edges and more in height and depth and 20 in length always fit"
    )]
    Unfit {
        /// L \[m\].
        length: f64,
        /// h \[m\].
        height: f64,
        /// d \[m\].
        depth: f64,
        /// a \[m\].
        edge_length: f64,
        /// The largest relative departure of an edge.
        deviation: f64,
    },
    /// Too fine to keep in memory.
    #[error("edges of {edge_length} m take {vertices} vertices: at most {MOST_VERTICES}")]
    TooFine {
        /// a \[m\].
        edge_length: f64,
        /// About how many.
        vertices: f64,
    },
    /// Sides so long or so short that areas are no numbers.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

impl Cuboid {
    /// The mesh, its normals outward.
    pub fn mesh(&self) -> Result<Mesh, CuboidError> {
        let grid = Grid::of(self)?;
        Ok(Mesh::new(grid.positions(), grid.triangles())?)
    }

    /// That there is a mesh, without making it.
    pub fn check(&self) -> Result<(), CuboidError> {
        Grid::of(self).map(|_| ())
    }

    fn check_fields(&self) -> Result<(), CuboidError> {
        let fields = [
            ("length", self.length),
            ("height", self.height),
            ("depth", self.depth),
            ("edge_length", self.edge_length),
        ];
        for (name, value) in fields {
            if !(value.is_finite() && value > 0.0) {
                return Err(CuboidError::NotPositive { name, value });
            }
        }
        Ok(())
    }
}

/// How many edges and rows there are, and how vertices are numbered: row by row, then the insides of both ends.
#[derive(Clone, Copy, Debug)]
struct Grid {
    cuboid: Cuboid,
    /// Edges in a row that is not shifted.
    length: u32,
    /// Strips between rows across the depth.
    depth: u32,
    /// Strips between rows across the height.
    height: u32,
}

impl Grid {
    /// The grid whose rows are nearest to √3/2 a apart, with edges along x that make its triangles equilateral on average.
    fn of(cuboid: &Cuboid) -> Result<Self, CuboidError> {
        // Edges along x stay this near to a, so that rounding their number leaves them within the tolerance.
        const NEAR: f64 = 0.07;
        cuboid.check_fields()?;
        let (a, row) = (cuboid.edge_length, 0.75f64.sqrt() * cuboid.edge_length);
        let count = |side: f64, step: f64| (side / step).round().max(1.0);
        let [across_depth, across_height] = [cuboid.depth, cuboid.height].map(|x| count(x, row));
        let spacing = (cuboid.depth + cuboid.height) / (across_depth + across_height);
        let equilateral = spacing / 0.75f64.sqrt();
        let along = equilateral.clamp((1.0 - NEAR) * a, (1.0 + NEAR) * a);
        let length = count(cuboid.length, along);
        let vertices = 2.0 * (across_depth + across_height) * (length + 1.5)
            + 2.0 * (across_depth - 1.0) * (across_height - 1.0);
        if vertices > f64::from(MOST_VERTICES) {
            return Err(CuboidError::TooFine {
                edge_length: a,
                vertices,
            });
        }
        let grid = Self {
            cuboid: *cuboid,
            length: length as u32,
            depth: across_depth as u32,
            height: across_height as u32,
        };
        grid.check()
    }

    /// Itself if all edges are about as long as wanted.
    fn check(self) -> Result<Self, CuboidError> {
        let deviation = self.deviation();
        if deviation <= EDGE_TOLERANCE {
            return Ok(self);
        }
        Err(CuboidError::Unfit {
            length: self.cuboid.length,
            height: self.cuboid.height,
            depth: self.cuboid.depth,
            edge_length: self.cuboid.edge_length,
            deviation,
        })
    }

    /// The largest relative departure of an edge of the long faces from the wanted length.
    fn deviation(&self) -> f64 {
        let cuboid = &self.cuboid;
        let along = cuboid.length / f64::from(self.length);
        let slanted = |side: f64, strips: u32| {
            let row = side / f64::from(strips);
            (0.25 * along * along + row * row).sqrt()
        };
        let edges = [
            along,
            slanted(cuboid.depth, self.depth),
            slanted(cuboid.height, self.height),
        ];
        edges
            .map(|edge| (edge / cuboid.edge_length - 1.0).abs())
            .into_iter()
            .fold(0.0, f64::max)
    }

    /// Rows around the girth.
    fn rows(&self) -> u32 {
        2 * (self.depth + self.height)
    }

    /// The first vertex of a row; the number of all rows' vertices for the row after the last.
    fn row_start(&self, row: u32) -> u32 {
        (row / 2) * (2 * self.length + 3) + (row % 2) * (self.length + 1)
    }

    /// The last vertex of a row.
    fn row_end(&self, row: u32) -> u32 {
        self.row_start(row + 1) - 1
    }

    /// Where a row is in the grid of the ends: from (−y, −z) along the bottom, up at +y, back along the top, down at −y.
    fn row_place(&self, row: u32) -> [u32; 2] {
        let (d, h) = (self.depth, self.height);
        match row {
            r if r < d => [r, 0],
            r if r < d + h => [d, r - d],
            r if r < 2 * d + h => [2 * d + h - r, h],
            r => [0, 2 * (d + h) - r],
        }
    }

    /// The row that ends at a place of the rim; `None` inside.
    fn rim_row(&self, [y, z]: [u32; 2]) -> Option<u32> {
        let (d, h) = (self.depth, self.height);
        match [y, z] {
            [y, 0] => Some(y),
            [y, z] if y == d => Some(d + z),
            [y, z] if z == h => Some(2 * d + h - y),
            [0, z] => Some(2 * (d + h) - z),
            _ => None,
        }
    }

    /// The vertex at a place of the grid of the end at −x or, if `far`, +x.
    fn end_vertex(&self, far: bool, place: [u32; 2]) -> u32 {
        match self.rim_row(place) {
            Some(row) if far => self.row_end(row),
            Some(row) => self.row_start(row),
            None => {
                let inside = (self.depth - 1) * (self.height - 1);
                let within = (place[1] - 1) * (self.depth - 1) + place[0] - 1;
                self.row_start(self.rows()) + u32::from(far) * inside + within
            }
        }
    }

    fn positions(&self) -> Vec<[f64; 3]> {
        let cuboid = &self.cuboid;
        let at = |[y, z]: [u32; 2]| {
            let y = place(2 * y, self.depth, cuboid.depth);
            (y, place(2 * z, self.height, cuboid.height))
        };
        let mut positions = vec![];
        for row in 0..self.rows() {
            let (y, z) = at(self.row_place(row));
            let places = half_edges(row, self.length);
            positions.extend(places.map(|half| [place(half, self.length, cuboid.length), y, z]));
        }
        for x in [-0.5 * cuboid.length, 0.5 * cuboid.length] {
            for z in 1..self.height {
                for y in 1..self.depth {
                    let (y, z) = at([y, z]);
                    positions.push([x, y, z]);
                }
            }
        }
        positions
    }

    fn triangles(&self) -> Vec<[u32; 3]> {
        let mut triangles = vec![];
        for row in 0..self.rows() {
            self.strip(row, &mut triangles);
        }
        for far in [false, true] {
            self.end(far, &mut triangles);
        }
        triangles
    }

    /// The triangles between a row and the next, which is +girth: e_girth × e_x points outward.
    fn strip(&self, row: u32, triangles: &mut Vec<[u32; 3]>) {
        let next = (row + 1) % self.rows();
        let shifted = !row.is_multiple_of(2);
        let (even, odd) = if shifted { (next, row) } else { (row, next) };
        let (even, odd) = (self.row_start(even), self.row_start(odd));
        // Counterclockwise from outside if the even row is the lower one.
        let oriented = |[a, b, c]: [u32; 3]| if shifted { [a, c, b] } else { [a, b, c] };
        for i in 0..=self.length {
            triangles.push(oriented([odd + i, odd + i + 1, even + i]));
            if i < self.length {
                triangles.push(oriented([even + i, odd + i + 1, even + i + 1]));
            }
        }
    }

    /// The triangles of one end.
    fn end(&self, far: bool, triangles: &mut Vec<[u32; 3]>) {
        for z in 0..self.height {
            for y in 0..self.depth {
                let corner = |dy, dz| self.end_vertex(far, [y + dy, z + dz]);
                let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                // Quadrants in which y and z have the same sign are cut along the rising diagonal.
                let rising = (2 * y + 1 > self.depth) == (2 * z + 1 > self.height);
                let halves = if rising {
                    [[a, b, c], [a, c, d]]
                } else {
                    [[a, b, d], [b, c, d]]
                };
                let oriented = |[a, b, c]: [u32; 3]| if far { [a, b, c] } else { [a, c, b] };
                triangles.extend(halves.map(oriented));
            }
        }
    }
}

/// Where half step `half` of 2 `steps` across `extent` is, from the middle: exact at both ends and mirrored to the bit.
fn place(half: u32, steps: u32, extent: f64) -> f64 {
    let from_middle = i64::from(half) - i64::from(steps);
    extent * (from_middle as f64 / (2.0 * f64::from(steps)))
}

/// The vertices of a row in half edges from −x: 0, 2, 4 … 2n, or 0, 1, 3 … 2n − 1, 2n.
fn half_edges(row: u32, length: u32) -> impl Iterator<Item = u32> {
    let shifted = row % 2;
    (0..=length + shifted).map(move |i| (2 * i).saturating_sub(shifted).min(2 * length))
}

#[cfg(test)]
mod tests;
