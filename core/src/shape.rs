//! Shapes: one sphere, or the rigid union of four at the corners of a regular tetrahedron.
//!
//! Lengths in R, masses in ρR³, moments of inertia in ρR⁵.

use crate::math::plain;

/// What the engine needs to know of a shape at compile time.
pub trait Shape: Copy + Send + Sync + 'static {
    /// Spheres per grain.
    const SPHERES: usize;

    /// Whether each grain has a radius and a mass of its own.
    const GRADED: bool = false;
}

/// One sphere: it has no orientation.
#[derive(Clone, Copy, Debug)]
pub struct Sphere;

impl Shape for Sphere {
    const SPHERES: usize = 1;
}

/// One sphere, each of its own size.
#[derive(Clone, Copy, Debug)]
pub struct GradedSphere;

impl Shape for GradedSphere {
    const SPHERES: usize = 1;
    const GRADED: bool = true;
}

/// Four overlapping spheres.
#[derive(Clone, Copy, Debug)]
pub struct Tetrahedron;

impl Shape for Tetrahedron {
    const SPHERES: usize = 4;
}

/// The rigid body of every grain.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Mass of the union.
    pub mass: f64,
    /// Moment of inertia of the union about its center of mass: the same about every axis, by symmetry.
    pub inertia: f64,
    /// Sphere centers from the center of mass, in the body's own frame.
    pub arms: Vec<[f64; 3]>,
}

impl Body {
    /// A sphere: m = 4π/3, I = 2m/5.
    #[must_use]
    pub fn sphere() -> Self {
        let mass = 4.0 / 3.0 * std::f64::consts::PI;
        Self {
            mass,
            inertia: 0.4 * mass,
            arms: vec![[0.0; 3]],
        }
    }

    /// Four spheres with centers 2(1 − 𝒪) apart.
    ///
    /// The union is cut into four congruent cells of the points nearest to each center.
    /// Seen from its center, a cell reaches to r(Ω) = min(1, distance to the three bisecting planes), so
    /// V = 4 ∫ r³/3 dΩ and I = (2/3) ∫ |x|² dV are integrals over directions, done by the midpoint rule (error below 1e-5).
    #[must_use]
    pub fn tetrahedron(overlap: f64) -> Self {
        const CORNERS: [[f64; 3]; 4] = [
            [1.0, 1.0, 1.0],
            [1.0, -1.0, -1.0],
            [-1.0, 1.0, -1.0],
            [-1.0, -1.0, 1.0],
        ];
        let half = 1.0 - overlap;
        // The corners above are 2√2 apart, √3 from the middle.
        let arms: Vec<[f64; 3]> = CORNERS
            .iter()
            .map(|&corner| plain::scale(corner, half * std::f64::consts::FRAC_1_SQRT_2))
            .collect();
        let reach = plain::norm(arms[0]);
        let (mass, second_moment) = union_moments(half, reach);
        Self {
            mass,
            inertia: 2.0 / 3.0 * second_moment,
            arms,
        }
    }

    /// Distance of the sphere centers from the center of mass.
    #[must_use]
    pub fn reach(&self) -> f64 {
        plain::norm(self.arms[0])
    }
}

/// V and ∫ |x|² dV of the union; `half` is half the distance of two centers, `reach` their distance from the middle.
fn union_moments(half: f64, reach: f64) -> (f64, f64) {
    const AZIMUTHS: usize = 256;
    let (mut volume, mut second_moment) = (0.0, 0.0);
    for a in 0..AZIMUTHS {
        // By symmetry the sector within 60° of one other center's azimuth is a sixth, where that center's plane is nearest.
        let azimuth = (a as f64 + 0.5) / AZIMUTHS as f64 * std::f64::consts::FRAC_PI_3;
        let (v, m) = meridian_moments(half, reach, libm::cos(azimuth));
        volume += v;
        second_moment += m;
    }
    // Four cells of six sectors each.
    let weight = 4.0 * 6.0 * std::f64::consts::FRAC_PI_3 / AZIMUTHS as f64;
    (volume * weight, second_moment * weight)
}

/// The same per radian of azimuth, along one meridian of a cell's own sphere.
///
/// The polar axis points outward through the center; the other three lie at cos θ = −√(2/3) from it.
fn meridian_moments(half: f64, reach: f64, cos_azimuth: f64) -> (f64, f64) {
    const NODES: usize = 128;
    let pi = std::f64::consts::PI;
    // The direction θ looks toward the other center by a cos θ + b sin θ = ρ cos(θ − α), and meets the plane at half/that.
    let (a, b) = (-(2.0f64 / 3.0).sqrt(), (1.0f64 / 3.0).sqrt() * cos_azimuth);
    let (amplitude, middle) = ((a * a + b * b).sqrt(), libm::atan2(b, a));
    let width = if half < amplitude {
        libm::acos(half / amplitude)
    } else {
        0.0
    };
    let cuts = [0.0, (middle - width).max(0.0), (middle + width).min(pi), pi];
    let (mut volume, mut second_moment) = (0.0, 0.0);
    for piece in 0..3 {
        let step = (cuts[piece + 1] - cuts[piece]) / NODES as f64;
        for n in 0..NODES {
            let theta = cuts[piece] + (n as f64 + 0.5) * step;
            let toward = amplitude * libm::cos(theta - middle);
            let r = if piece == 1 {
                (half / toward).min(1.0)
            } else {
                1.0
            };
            let weight = libm::sin(theta) * step;
            let cube = r * r * r;
            volume += weight * cube / 3.0;
            let moment = reach * reach / 3.0 + reach * libm::cos(theta) * r / 2.0 + r * r / 5.0;
            second_moment += weight * moment * cube;
        }
    }
    (volume, second_moment)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn union_matches_voxel_counts() {
        // docs/choices.md §1: 200³ voxels give 9.648 and 6.932 for 𝒪 = 0.6, centers 0.4899 from the middle.
        let body = Body::tetrahedron(0.6);
        assert!((body.mass - 9.648).abs() < 1e-3, "{}", body.mass);
        assert!((body.inertia - 6.932).abs() < 1e-3, "{}", body.inertia);
        assert!((body.reach() - 0.4899).abs() < 1e-4);
    }

    #[test]
    fn touching_spheres_keep_their_own_volume_and_inertia() {
        // 𝒪 = 0: four separate unit spheres at √(3/2): V = 16π/3, I = 4 (2/5 + (2/3)(3/2)) 4π/3.
        let body = Body::tetrahedron(0.0);
        let one = 4.0 / 3.0 * std::f64::consts::PI;
        assert!((body.mass / (4.0 * one) - 1.0).abs() < 1e-4);
        assert!((body.inertia / (4.0 * one * 1.4) - 1.0).abs() < 1e-4);
    }

    #[test]
    fn complete_overlap_is_a_sphere() {
        let (body, sphere) = (Body::tetrahedron(1.0), Body::sphere());
        assert!((body.mass / sphere.mass - 1.0).abs() < 1e-4);
        assert!((body.inertia / sphere.inertia - 1.0).abs() < 1e-4);
    }

    #[test]
    fn lens_of_two_neighbors_is_counted_once() {
        // 𝒪 slightly above 0: the union loses six lenses of two spherical caps of height 𝒪 each, none of them common
        // to three spheres while 𝒪 < 1 − √3/2 ≈ 0.134. Cap volume π h² (3 − h)/3.
        let overlap: f64 = 0.1;
        let cap = std::f64::consts::PI * overlap * overlap * (3.0 - overlap) / 3.0;
        let expected = 16.0 / 3.0 * std::f64::consts::PI - 12.0 * cap;
        assert!((Body::tetrahedron(overlap).mass / expected - 1.0).abs() < 1e-4);
    }
}
