//! Springs and dampers along the edges of a mesh.
//!
//! # Stiffness
//! Each triangle T of area A gives each of its edges the stiffness E t A/ℓ². Stretched by the edges' strains ε_e, T
//! then stores ½ E t A Σ ε_e², which for an equilateral triangle is what a sheet with modulus E and ν = 1/3 stores.
//! An edge between two equilateral triangles has k = (√3/2) E t, an edge of the border half of it.

use super::Sheet;
use super::mesh::Mesh;
use crate::math::plain;

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

    /// Makes the present lengths the rest lengths; the stiffness stays.
    pub fn reset_rest(&mut self, mesh: &Mesh) {
        self.rest_lengths = mesh.edge_lengths().collect();
    }

    /// Adds F₁ = [k (ℓ − ℓ₀) + c (v₂ − v₁)·u] u and F₂ = −F₁ of every edge, in the order of the edges.
    ///
    /// u is the unit vector from the first end to the second; zero if they coincide.
    pub fn add_forces(
        &self,
        ends: &[[u32; 2]],
        positions: &[[f64; 3]],
        velocities: &[[f64; 3]],
        forces: &mut [[f64; 3]],
    ) {
        for (e, &[i, j]) in ends.iter().enumerate() {
            let (i, j) = (i as usize, j as usize);
            let along = plain::sub(positions[j], positions[i]);
            let length = plain::norm(along);
            let inverse = if length > 0.0 { 1.0 / length } else { 0.0 };
            let closing = plain::dot(plain::sub(velocities[j], velocities[i]), along) * inverse;
            let tension =
                self.stiffness[e] * (length - self.rest_lengths[e]) + self.damping[e] * closing;
            let pull = plain::scale(along, tension * inverse);
            forces[i] = plain::add(forces[i], pull);
            forces[j] = plain::sub(forces[j], pull);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::membrane::Membrane;
    use crate::membrane::shapes::{SHEET, strip};

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
            springs.add_forces(&[[0, 1]], &positions, &velocities, &mut forces);
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
