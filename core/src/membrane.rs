//! The elastic sheet of the beam: triangle meshes.
//!
//! Brackets name SI units; any other consistent set will do.

mod cuboid;
mod mesh;
#[cfg(test)]
mod shapes;
mod topology;

pub use cuboid::{Cuboid, CuboidError, EDGE_TOLERANCE, MOST_VERTICES};
pub use mesh::{Mesh, MeshError};
