//! Springs and dampers along the edges of a mesh.
//!
//! # Stiffness
//! Each triangle T of area A gives each of its edges the stiffness E t A/ℓ². Stretched by the edges' strains ε_e, T
//! then stores ½ E t A Σ ε_e², which for an equilateral triangle is what a sheet with modulus E and ν = 1/3 stores.
//! An edge between two equilateral triangles has k = (√3/2) E t, an edge of the border half of it.

use super::Sheet;
use super::mesh::Mesh;
use crate::lanes::{F64x8, Lane};
use crate::math::{Vec3, plain};

/// One spring and one damper for every edge.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Springs {
    /// ℓ₀ \[m\].
    rest_lengths: Vec<f64>,
    /// k \[N/m\].
    stiffness: Vec<f64>,
    /// c \[N s/m\].
    damping: Vec<f64>,
}

impl Springs {
    /// The springs of `sheet` along the edges of `mesh`, at rest: k = E t Σ A_T/ℓ², c = 2 γ √(m* k), m* = m₁m₂/(m₁ + m₂).
    #[must_use]
    pub fn new(mesh: &Mesh, sheet: &Sheet, masses: &[f64]) -> Self {
        let areas: Vec<f64> = mesh.areas().collect();
        let rest_lengths: Vec<f64> = mesh.edge_lengths().collect();
        let modulus = sheet.youngs_modulus * sheet.thickness;
        let stiffness: Vec<f64> = mesh
            .edge_triangles()
            .iter()
            .zip(&rest_lengths)
            .map(|(both, length)| {
                let area: f64 = both.iter().flatten().map(|&t| areas[t as usize]).sum();
                modulus * area / (length * length)
            })
            .collect();
        let damping = mesh
            .edges()
            .iter()
            .zip(&stiffness)
            .map(|(&[i, j], k)| {
                let [a, b] = [i, j].map(|vertex| masses[vertex as usize]);
                2.0 * sheet.damping_ratio * (a * b / (a + b) * k).sqrt()
            })
            .collect();
        Self {
            rest_lengths,
            stiffness,
            damping,
        }
    }

    /// ℓ₀ of every edge \[m\].
    #[must_use]
    pub fn rest_lengths(&self) -> &[f64] {
        &self.rest_lengths
    }

    /// k of every edge \[N/m\].
    #[must_use]
    pub fn stiffness(&self) -> &[f64] {
        &self.stiffness
    }

    /// c of every edge \[N s/m\].
    #[must_use]
    pub fn damping(&self) -> &[f64] {
        &self.damping
    }

    /// Changes the rest lengths; the stiffness stays.
    pub fn set_rest_lengths(&mut self, lengths: impl Iterator<Item = f64>) {
        for (rest, length) in self.rest_lengths.iter_mut().zip(lengths) {
            *rest = length;
        }
    }

    /// Makes the present lengths the rest lengths; the stiffness stays.
    pub fn reset_rest(&mut self, mesh: &Mesh) {
        self.rest_lengths = mesh.edge_lengths().collect();
    }

    /// Adds F₁ = [k (ℓ − ℓ₀) + c (v₂ − v₁)·u] u and F₂ = −F₁ of every edge, in the order of the edges.
    ///
    /// u is the unit vector from the first end to the second; zero if they coincide.
    #[inline(always)]
    pub fn add_forces<W: Lane<Row = F64x8, Scalar = f64>>(
        &self,
        ends: &[[u32; 2]],
        vertices: &[F64x8],
        forces: &mut [[f64; 3]],
    ) {
        let (eights, rest) = ends.as_chunks();
        let numbers = [&self.rest_lengths, &self.stiffness, &self.damping];
        let mut from = 0;
        for eight in eights {
            let of = |n: usize| W::load(&row(&numbers[n][from..from + W::K]));
            pull(eight, eight, [of(0), of(1), of(2)], vertices, forces);
            from += W::K;
        }
        if let Some(&last) = rest.last() {
            let mut eight = [last; 8];
            eight[..rest.len()].copy_from_slice(rest);
            let of = |n: usize| {
                let mut row = F64x8::default();
                row.0[..rest.len()].copy_from_slice(&numbers[n][from..]);
                W::load(&row)
            };
            pull(&eight, rest, [of(0), of(1), of(2)], vertices, forces);
        }
    }

    /// k (ℓ − ℓ₀) of every edge \[N\], tension positive; without the dampers.
    pub fn tensions<'a>(&'a self, mesh: &'a Mesh) -> impl Iterator<Item = f64> + 'a {
        mesh.edge_lengths()
            .zip(&self.rest_lengths)
            .zip(&self.stiffness)
            .map(|((length, rest), stiffness)| stiffness * (length - rest))
    }

    /// Σ ½ k (ℓ − ℓ₀)² \[J\].
    #[must_use]
    pub fn energy(&self, mesh: &Mesh) -> f64 {
        self.tensions(mesh)
            .zip(&self.stiffness)
            .map(|(tension, stiffness)| 0.5 * tension * tension / stiffness)
            .sum()
    }
}

/// Eight numbers of a list.
#[inline(always)]
fn row(numbers: &[f64]) -> F64x8 {
    let mut row = F64x8::default();
    row.0.copy_from_slice(numbers);
    row
}

/// Adds the forces of eight edges, with their rest lengths, stiffness and damping, to the ends of those in `real`.
#[inline(always)]
fn pull<W: Lane<Row = F64x8, Scalar = f64>>(
    eight: &[[u32; 2]; 8],
    real: &[[u32; 2]],
    [rest_length, stiffness, damping]: [W; 3],
    vertices: &[F64x8],
    forces: &mut [[f64; 3]],
) {
    let part = |end: usize, half: usize| -> Vec3<W> {
        Vec3::gathered(|e| vertices[eight[e][end] as usize].halves()[half])
    };
    let along = part(1, 0) - part(0, 0);
    // Not fused, as rest lengths are not: a sheet at rest pulls nowhere.
    let square = along.x * along.x + along.y * along.y + along.z * along.z;
    let length = square.sqrt();
    let inverse = (W::constant(1.0) / length).keep(W::constant(0.0).lt(length));
    let closing = (part(1, 1) - part(0, 1)).dot(along) * inverse;
    let tension = stiffness * (length - rest_length) + damping * closing;
    let mut pulls = Vec3::default();
    along.scale(tension * inverse).store(&mut pulls);
    for (e, &[i, j]) in real.iter().enumerate() {
        let pull = pulls.lane(e);
        let (i, j) = (i as usize, j as usize);
        forces[i] = plain::add(forces[i], pull);
        forces[j] = plain::sub(forces[j], pull);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::membrane::shapes::{SHEET, strip};
    use crate::membrane::{Membrane, record};

    #[test]
    fn lattice_of_equilateral_triangles_has_the_springs_of_the_paper() {
        let mesh = strip(6, 4, 4.7e-3);
        let membrane = Membrane::new(mesh, &SHEET).unwrap();
        let springs = membrane.springs();
        // (√3/2) E t = 2598 N/m, half of it at the border; ρ t (√3/2) a² = 1.15e-5 kg; 0.037 N s/m.
        let k = 0.75f64.sqrt() * 3000.0;
        let both = membrane.mesh().edge_triangles();
        for (stiffness, both) in springs.stiffness().iter().zip(both) {
            let full = if both.contains(&None) { 0.5 * k } else { k };
            assert!((stiffness / full - 1.0).abs() < 1e-12, "{stiffness}");
        }
        let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
        assert!((largest(membrane.masses()) - 1.148e-5).abs() < 1e-8);
        assert!((largest(springs.damping()) - 0.0366).abs() < 1e-4);
        let total: f64 = membrane.masses().iter().sum();
        assert!((total / (0.6 * membrane.mesh().area()) - 1.0).abs() < 1e-12);
    }

    /// M7: two masses on one damped spring, their gap over one period.
    #[test]
    fn edge_pair_decays_with_the_damping_ratio() {
        let (k, masses, ratio) = (2598.0f64, [1.1e-5, 2.3e-5], 0.15);
        let reduced = masses[0] * masses[1] / (masses[0] + masses[1]);
        let springs = Springs {
            rest_lengths: vec![1.0],
            stiffness: vec![k],
            damping: vec![2.0 * ratio * (reduced * k).sqrt()],
        };
        let omega = (k / reduced).sqrt();
        let time_step = 1e-4 / omega;
        let mut positions = [[0.0; 3], [0.6006, 0.8008, 0.0]];
        let mut velocities = [[0.0; 3]; 2];
        let (mut gap, mut peaks) = (vec![1e-3], vec![]);
        while peaks.len() < 3 {
            let mut forces = [[0.0; 3]; 2];
            let vertices: Vec<F64x8> = (0..2)
                .map(|i| record(positions[i], velocities[i]))
                .collect();
            springs.add_forces::<F64x8>(&[[0, 1]], &vertices, &mut forces);
            for i in 0..2 {
                let kick = plain::scale(forces[i], time_step / masses[i]);
                velocities[i] = plain::add(velocities[i], kick);
                positions[i] = plain::add(positions[i], plain::scale(velocities[i], time_step));
            }
            gap.push(plain::norm(plain::sub(positions[1], positions[0])) - 1.0);
            if let [.., a, b, c] = gap[..]
                && a < b
                && b >= c
            {
                peaks.push(b);
            }
        }
        // δ = ln(x₁/x₂) = 2π γ/√(1 − γ²).
        let decrement = libm::log(peaks[1] / peaks[2]);
        let measured = decrement / (std::f64::consts::TAU.powi(2) + decrement * decrement).sqrt();
        println!("M7: damping ratio {measured:.6}, should be {ratio}");
        assert!((measured / ratio - 1.0).abs() < 0.02, "{measured}");
    }
}
