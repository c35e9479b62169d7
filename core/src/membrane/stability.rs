//! How large a time step the sheet takes by itself.
//!
//! # The bound
//! Springs and dampers act on differences: xᵀK x = Σ_e (x_i − x_j)ᵀ B_e (x_i − x_j) with
//! B_e = k u uᵀ + (T/ℓ)(1 − u uᵀ), T the tension. Leaving out compression only raises B_e, which is then positive, so
//! (x_i − x_j)ᵀ B (x_i − x_j) ≤ 2 x_iᵀ B x_i + 2 x_jᵀ B x_j, and
//!
//! ω_max² ≤ max_i (2/m_i) λ_max(Σ_{e at i} B_e).
//!
//! This is Gershgorin's theorem with 3 × 3 blocks. On an unstressed lattice of equilateral triangles Σ B = 3k in the plane:
//! the bound is 6k/m, the exact frequency of its fastest mode. Held vertices only lower it.
//! A hinge adds 2 k_θ g gᵀ to each of its corners' sums, g = ∂θ/∂x; its own tension is left out.
//! Dampers obey the same bound with c u uᵀ; it is called δ.
//!
//! What touches the sheet at a point with weights w_k of vertices, Σ w = 1, acts on x − Σ w_k x_k. By convexity
//! |x − Σ w_k x_k|² ≤ 2 |x|² + 2 Σ w_k |x_k|² in the norm of its stiffness B_c, so each vertex gets w_k B_c beside its springs.
//!
//! # The step
//! Kick and drift with velocities of the last half step are stable while 4 − 2 δ Δt − ω² Δt² > 0 for every mode, so
//! Δt_crit = (2/ω) (√(1 + ζ²) − ζ), ζ = δ/2ω: damping shortens the step.

use super::Membrane;
use crate::math::plain;

/// A symmetric 3 × 3 tensor: xx, yy, zz, yz, zx, xy.
type Tensor = [f64; 6];

/// What holds on to a vertex from outside the sheet: its share w of a contact's stiffness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// The vertex.
    pub vertex: u32,
    /// The contact's normal.
    pub normal: [f64; 3],
    /// w k_n \[N/m\].
    pub along: f64,
    /// w k_t \[N/m\].
    pub across: f64,
}

impl Membrane {
    /// A bound of ω_max \[1/s\], the angular frequency of the fastest mode, where the sheet is now, under these `holds`.
    #[must_use]
    pub fn fastest_frequency(&self, holds: &[Hold]) -> f64 {
        let mut sums = vec![[0.0; 6]; self.masses.len()];
        let tensions = self.springs.tensions(&self.mesh);
        for ((along, k), tension) in self.edges().zip(self.springs.stiffness()).zip(tensions) {
            let length = plain::norm(along.vector);
            let across = if length > 0.0 { tension / length } else { 0.0 };
            let across = across.max(0.0);
            for vertex in along.ends {
                add_dyad(&mut sums[vertex as usize], along.unit(), k - across);
                add_isotropic(&mut sums[vertex as usize], across);
            }
        }
        self.add_hinges(&mut sums, self.hinges.bending().stiffness);
        for hold in holds {
            let sum = &mut sums[hold.vertex as usize];
            add_dyad(sum, hold.normal, hold.along - hold.across);
            add_isotropic(sum, hold.across);
        }
        self.largest_rate(&sums).sqrt()
    }

    /// A bound of δ \[1/s\], the rate at which the fastest mode loses speed.
    #[must_use]
    pub fn fastest_decay(&self) -> f64 {
        let mut sums = vec![[0.0; 6]; self.masses.len()];
        for (along, c) in self.edges().zip(self.springs.damping()) {
            for vertex in along.ends {
                add_dyad(&mut sums[vertex as usize], along.unit(), *c);
            }
        }
        self.add_hinges(&mut sums, self.hinges.bending().damping);
        self.largest_rate(&sums)
    }

    /// Δt_crit \[s\]: no shorter step is unstable while the sheet feels only its own forces and these `holds`.
    #[must_use]
    pub fn critical_time_step(&self, holds: &[Hold]) -> f64 {
        let frequency = self.fastest_frequency(holds);
        let ratio = 0.5 * self.fastest_decay() / frequency;
        // √(1 + ζ²) − ζ without cancellation.
        2.0 / frequency / ((1.0 + ratio * ratio).sqrt() + ratio)
    }

    fn edges(&self) -> impl Iterator<Item = Along> + '_ {
        let places = self.mesh.positions();
        self.mesh.edges().iter().map(|&[i, j]| Along {
            ends: [i, j],
            vector: plain::sub(places[j as usize], places[i as usize]),
        })
    }

    fn add_hinges(&self, sums: &mut [Tensor], strength: f64) {
        for (corners, fold) in self.hinges.folds(self.mesh.positions()) {
            for (vertex, gradient) in corners.into_iter().zip(fold.gradients) {
                add_dyad(&mut sums[vertex as usize], gradient, 2.0 * strength);
            }
        }
    }

    /// The largest 2 λ_max/m.
    fn largest_rate(&self, sums: &[Tensor]) -> f64 {
        sums.iter()
            .zip(&self.masses)
            .map(|(sum, mass)| 2.0 * largest_eigenvalue(sum) / mass)
            .fold(0.0, f64::max)
    }
}

/// An edge and the vector along it.
struct Along {
    ends: [u32; 2],
    vector: [f64; 3],
}

impl Along {
    fn unit(&self) -> [f64; 3] {
        super::mesh::unit(self.vector)
    }
}

/// Adds s v vᵀ.
fn add_dyad(tensor: &mut Tensor, [x, y, z]: [f64; 3], s: f64) {
    let dyad = [x * x, y * y, z * z, y * z, z * x, x * y];
    for (part, product) in tensor.iter_mut().zip(dyad) {
        *part += s * product;
    }
}

/// Adds s times the unit tensor.
fn add_isotropic(tensor: &mut Tensor, s: f64) {
    for part in &mut tensor[..3] {
        *part += s;
    }
}

/// λ_max = q + 2p cos(arccos(r)/3), with the mean q, the spread p of the deviator D, and r = det(D/p)/2.
fn largest_eigenvalue(&[xx, yy, zz, yz, zx, xy]: &Tensor) -> f64 {
    let mean = (xx + yy + zz) / 3.0;
    let [a, b, c] = [xx - mean, yy - mean, zz - mean];
    let spread = ((a * a + b * b + c * c + 2.0 * (yz * yz + zx * zx + xy * xy)) / 6.0).sqrt();
    if spread <= 0.0 {
        return mean;
    }
    let determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * zx) + zx * (xy * yz - b * zx);
    let third = (0.5 * determinant / (spread * spread * spread)).clamp(-1.0, 1.0);
    mean + 2.0 * spread * libm::cos(libm::acos(third) / 3.0)
}

#[cfg(test)]
mod tests;
