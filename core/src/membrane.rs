//! The elastic sheet of the beam: point masses at the vertices of a triangle mesh, springs along its edges.
//!
//! On a lattice of equilateral triangles with edge a, springs k are an isotropic sheet with C11 = (3√3/4) k, C12 = C11/3:
//! E t = (2/√3) k and Poisson's ratio is 1/3, whatever the material's. Any other mesh takes what
//! [`Springs`] derives from it.
//! Vertices only translate, springs push as well as pull, and nothing stops the sheet from passing through itself.
//!
//! Brackets name SI units; any other consistent set will do.
//!
//! Source: Götz & Pöschel, Granular Matter 25, 61 (2023).

mod cuboid;
mod health;
mod hinge;
mod mesh;
mod pressure;
#[cfg(test)]
mod shapes;
mod spring;
mod stability;
mod topology;

pub use cuboid::{Cuboid, CuboidError, EDGE_TOLERANCE, MOST_VERTICES};
pub use health::{Finding, Rest, findings};
pub use mesh::{Mesh, MeshError};
pub use pressure::{Face, add_pressure};
pub use spring::Springs;
pub use stability::Hold;

use crate::lanes::{F64x8, Lane};
use crate::math::plain;
use hinge::Hinges;
use pressure::note_faces;

/// Poisson's ratio of every sheet of springs on equilateral triangles.
pub const POISSON_RATIO: f64 = 1.0 / 3.0;

/// What a sheet is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheet {
    /// E_m \[Pa\].
    pub youngs_modulus: f64,
    /// t_m \[m\].
    pub thickness: f64,
    /// ρ_m \[kg/m³\].
    pub density: f64,
    /// γ_m: damping of an edge with its two vertices, as a fraction of critical.
    pub damping_ratio: f64,
    /// Resistance to folding; thin sheets have none to speak of.
    pub bending: Option<Bending>,
}

/// Resistance of an edge to a change of the angle between its two triangles.
///
/// Hinges k_θ on a lattice of equilateral triangles are a sheet of flexural rigidity D ≈ (√3/2) k_θ.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Bending {
    /// k_θ \[N m\].
    pub stiffness: f64,
    /// c_θ \[N m s\].
    pub damping: f64,
}

/// Why there is no such sheet.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {value}: must be {rule}")]
pub struct SheetError {
    /// The field.
    pub name: &'static str,
    /// What it is.
    pub value: f64,
    /// What it must be.
    pub rule: &'static str,
}

impl Sheet {
    /// That every number has a meaning.
    pub fn check(&self) -> Result<(), SheetError> {
        let bending = self.bending.unwrap_or(Bending {
            stiffness: 0.0,
            damping: 0.0,
        });
        let positive = [
            ("youngs_modulus", self.youngs_modulus),
            ("thickness", self.thickness),
            ("density", self.density),
        ];
        let not_negative = [
            ("damping_ratio", self.damping_ratio),
            ("bending.stiffness", bending.stiffness),
            ("bending.damping", bending.damping),
        ];
        let wrong = |name, value, rule| Err(SheetError { name, value, rule });
        for (name, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return wrong(name, value, "positive and finite");
            }
        }
        for (name, value) in not_negative {
            if !(value.is_finite() && value >= 0.0) {
                return wrong(name, value, "zero or positive, and finite");
            }
        }
        Ok(())
    }
}

/// A sheet in motion.
///
/// A step is [`begin_step`](Self::begin_step), everything that adds to the forces, [`advance`](Self::advance).
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Membrane {
    mesh: Mesh,
    springs: Springs,
    hinges: Hinges,
    rest_areas: Vec<f64>,
    masses: Vec<f64>,
    /// 1/m along each axis; zero where the vertex is held.
    mobilities: Vec<[f64; 3]>,
    velocities: Vec<[f64; 3]>,
    forces: Vec<[f64; 3]>,
    /// Every vertex as its [`record`] in the running step.
    vertices: Vec<F64x8>,
    faces: Vec<Face>,
}

impl Membrane {
    /// A sheet at rest in the shape of `mesh`, free of stress.
    pub fn new(mesh: Mesh, sheet: &Sheet) -> Result<Self, SheetError> {
        sheet.check()?;
        let masses = vertex_masses(&mesh, sheet);
        Ok(Self {
            springs: Springs::new(&mesh, sheet, &masses),
            hinges: Hinges::new(&mesh, sheet.bending),
            rest_areas: mesh.areas().collect(),
            mobilities: masses.iter().map(|mass| [1.0 / mass; 3]).collect(),
            velocities: vec![[0.0; 3]; masses.len()],
            forces: vec![[0.0; 3]; masses.len()],
            vertices: vec![],
            faces: vec![],
            masses,
            mesh,
        })
    }

    /// The mesh where it is now.
    #[must_use]
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Moves vertices without a step.
    pub fn positions_mut(&mut self) -> &mut [[f64; 3]] {
        self.mesh.positions_mut()
    }

    /// The springs along the edges.
    #[must_use]
    pub fn springs(&self) -> &Springs {
        &self.springs
    }

    /// A of every triangle at rest \[m²\].
    #[must_use]
    pub fn rest_areas(&self) -> &[f64] {
        &self.rest_areas
    }

    /// m of every vertex \[kg\]: ρ t A/3 of each of its triangles.
    #[must_use]
    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// v of every vertex in the last half step \[m/s\].
    #[must_use]
    pub fn velocities(&self) -> &[[f64; 3]] {
        &self.velocities
    }

    /// Changes velocities; a held vertex goes on with what it is given.
    pub fn velocities_mut(&mut self) -> &mut [[f64; 3]] {
        &mut self.velocities
    }

    /// F on every vertex \[N\].
    #[must_use]
    pub fn forces(&self) -> &[[f64; 3]] {
        &self.forces
    }

    /// Where the vertices are, their velocities, and where others add forces.
    pub fn acting(&mut self) -> ([&[[f64; 3]]; 2], &mut [[f64; 3]]) {
        ([self.mesh.positions(), &self.velocities], &mut self.forces)
    }

    /// Where others add their forces \[N\].
    pub fn forces_mut(&mut self) -> &mut [[f64; 3]] {
        &mut self.forces
    }

    /// Changes the springs' rest lengths \[m\]; stiffness and masses stay.
    pub fn set_rest_lengths(&mut self, lengths: impl Iterator<Item = f64>) {
        self.springs.set_rest_lengths(lengths);
    }

    /// Makes the present shape the one that is free of stress; stiffness and masses stay.
    pub fn reset_rest(&mut self) {
        self.springs.reset_rest(&self.mesh);
        self.hinges.reset_rest(&self.mesh);
        self.rest_areas = self.mesh.areas().collect();
    }

    /// Holds `axes` of `vertices` where they are, besides those held already: all three for a pin, y and z for a roller.
    pub fn hold(&mut self, vertices: &[u32], axes: [bool; 3]) {
        for &vertex in vertices {
            for axis in (0..3).filter(|&axis| axes[axis]) {
                self.mobilities[vertex as usize][axis] = 0.0;
                self.velocities[vertex as usize][axis] = 0.0;
            }
        }
    }

    /// Lets `vertices` move again.
    pub fn release(&mut self, vertices: &[u32]) {
        for &vertex in vertices {
            self.mobilities[vertex as usize] = [1.0 / self.masses[vertex as usize]; 3];
        }
    }

    /// What holds `vertices` \[N\]: minus the sum of the forces on them along the axes that are held.
    #[must_use]
    pub fn reaction(&self, vertices: &[u32]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for &vertex in vertices {
            let (force, mobility) = (
                self.forces[vertex as usize],
                self.mobilities[vertex as usize],
            );
            for axis in (0..3).filter(|&axis| mobility[axis] == 0.0) {
                sum[axis] -= force[axis];
            }
        }
        sum
    }

    /// Begins a step: no forces, and vertices where they are now.
    pub fn begin_step(&mut self) {
        self.forces.fill([0.0; 3]);
        self.note_vertices();
    }

    fn note_vertices(&mut self) {
        self.vertices.clear();
        let state = self.mesh.positions().iter().zip(&self.velocities);
        self.vertices.extend(state.map(|(&x, &v)| record(x, v)));
    }

    /// Takes note of all vertices and faces between two steps.
    #[inline(always)]
    pub fn note<W: Lane<Row = F64x8, Scalar = f64>>(&mut self) {
        self.note_vertices();
        let sheet = (self.mesh.triangles(), self.vertices.as_slice());
        note_faces::<W>(sheet, &mut self.faces);
    }

    /// The vertices as they were last noted.
    #[must_use]
    pub fn vertices(&self) -> &[F64x8] {
        &self.vertices
    }

    /// Adds the forces of springs, then of hinges.
    #[inline(always)]
    pub fn add_internal_forces<W: Lane<Row = F64x8, Scalar = f64>>(&mut self) {
        let (ends, places) = (self.mesh.edges(), self.mesh.positions());
        self.springs
            .add_forces::<W>(ends, &self.vertices, &mut self.forces);
        self.hinges
            .add_forces(places, &self.velocities, &mut self.forces);
    }

    /// The triangles as they were last noted.
    #[must_use]
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// Adds a `pressure` from outside \[Pa\]; negative if from inside. Takes note of all faces.
    #[inline(always)]
    pub fn add_pressure<W: Lane<Row = F64x8, Scalar = f64>>(&mut self, pressure: f64) {
        let triangles = self.mesh.triangles();
        note_faces::<W>((triangles, &self.vertices), &mut self.faces);
        add_pressure((triangles, &self.faces), pressure, &mut self.forces);
    }

    /// Adds a drag −α m v \[N\] on every vertex, with α = `rate` \[1/s\].
    pub fn add_drag(&mut self, rate: f64) {
        let state = self.velocities.iter().zip(&self.masses);
        for (force, (&velocity, mass)) in self.forces.iter_mut().zip(state) {
            *force = plain::sub(*force, plain::scale(velocity, rate * mass));
        }
    }

    /// Kicks all vertices by `time_step` \[s\], lets them drift, and returns the largest speed \[m/s\].
    ///
    /// Not a number if any speed is not. Forces stay, for [`reaction`](Self::reaction).
    pub fn advance(&mut self, time_step: f64) -> f64 {
        let mut fastest = 0.0f64;
        let places = self.mesh.positions_mut().iter_mut();
        let acting = self.forces.iter().zip(&self.mobilities);
        for ((place, velocity), (force, mobility)) in places.zip(&mut self.velocities).zip(acting) {
            let kick = [0, 1, 2].map(|axis| time_step * (mobility[axis] * force[axis]));
            let kicked = plain::add(*velocity, kick);
            *velocity = kicked;
            *place = plain::add(*place, plain::scale(kicked, time_step));
            let square = plain::dot(kicked, kicked);
            // What is not a number stays, whatever comes after it.
            let stays = square <= fastest || fastest.is_nan();
            fastest = if stays { fastest } else { square };
        }
        fastest.sqrt()
    }

    /// Σ ½ m v² \[J\], with the velocities of the last half step.
    #[must_use]
    pub fn kinetic_energy(&self) -> f64 {
        self.velocities
            .iter()
            .zip(&self.masses)
            .map(|(&v, mass)| 0.5 * mass * plain::dot(v, v))
            .sum()
    }

    /// What springs and hinges store \[J\].
    #[must_use]
    pub fn elastic_energy(&self) -> f64 {
        self.springs.energy(&self.mesh) + self.hinges.energy(self.mesh.positions())
    }

    /// What a look at the sheet finds, given the triangles' normals now and at the last look.
    #[must_use]
    pub fn findings(&self, normals: [&[[f64; 3]]; 2]) -> Vec<Finding> {
        let rest = Rest {
            lengths: self.springs.rest_lengths(),
            areas: &self.rest_areas,
        };
        findings(&self.mesh, rest, normals)
    }
}

/// A vertex in one line of the cache: where it is and how it moves, a spare number beside each.
#[must_use]
pub fn record([x, y, z]: [f64; 3], [u, v, w]: [f64; 3]) -> F64x8 {
    F64x8([x, y, z, 0.0, u, v, w, 0.0])
}

/// ρ t A/3 of every triangle, on each of its corners \[kg\].
fn vertex_masses(mesh: &Mesh, sheet: &Sheet) -> Vec<f64> {
    let mut masses = vec![0.0; mesh.positions().len()];
    for (corners, area) in mesh.triangles().iter().zip(mesh.areas()) {
        for &vertex in corners {
            masses[vertex as usize] += sheet.density * sheet.thickness * area / 3.0;
        }
    }
    masses
}

#[cfg(test)]
mod tests;
