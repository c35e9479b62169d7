//! What is known of a beam before it is made: from scaling laws, good to some ten percent.
//!
//! Predictions set the default speed of the rods and tell a sweep's cost; no result depends on them otherwise.
//! Sources: frictionless growth and bulk packings at 90 kPa, μ = 0.3 and 5 to 100 MPa, 1000 grains each.
//! By dimensions, everything depends on E_p/Δp.

use std::f64::consts::PI;

use super::curve::Dimensions;
use super::spec::GrowSpec;

/// E_b/E_p^0.47/Δp^0.53: 5 MPa at E_p = 100 MPa and Δp = 90 kPa, and 1.2 MPa at 5 MPa.
const STIFFNESS: f64 = 2.06;
const STIFFNESS_EXPONENT: f64 = 0.47;

/// φ of the compacted beam times (E_p/Δp)^0.1: 0.62 at 100 MPa, 0.83 at 5 MPa, and never less than random loose packing.
const VOLUME_FRACTION: f64 = 1.25;
const LEAST_VOLUME_FRACTION: f64 = 0.55;

/// Δt_crit over R √(ρ/E_p) (E_p/Δp)^0.2: 20 µs at 100 MPa, 49 µs at 5 MPa.
const TIME_STEP: f64 = 0.468;

/// E_p/Δp of grains that merely touch now and then, as in growth.
const LOOSE: f64 = 1e3;

/// A beam before it is made.
#[derive(Clone, Copy, Debug)]
pub struct Prediction<'a> {
    /// The grains in their mold.
    pub grow: &'a GrowSpec,
    /// Δp \[Pa\]; `None` while they grow.
    pub confining_pressure: Option<f64>,
    /// t_m \[m\].
    pub membrane_thickness: f64,
    /// ρ_m \[kg/m³\].
    pub membrane_density: f64,
}

impl Prediction<'_> {
    /// N = φ_init L h d/(4π⟨R³⟩/3), of radii drawn evenly.
    #[must_use]
    pub fn grains(&self) -> f64 {
        grains(
            &self.grow.dimensions(),
            self.grow.initial_volume_fraction,
            (self.grow.radius_min, self.grow.radius_max),
        )
    }

    /// Vertices of the membrane.
    #[must_use]
    pub fn vertices(&self) -> f64 {
        vertices(&self.grow.dimensions(), self.grow.membrane_edge)
    }

    /// E_p/Δp, at least 1.
    fn hardness(&self) -> f64 {
        let ratio = |pressure: f64| (self.grow.youngs_modulus / pressure.abs()).max(1.0);
        self.confining_pressure.map_or(LOOSE, ratio)
    }

    /// φ once the beam is compacted.
    #[must_use]
    pub fn volume_fraction(&self) -> f64 {
        (VOLUME_FRACTION * libm::pow(self.hardness(), -0.1)).max(LEAST_VOLUME_FRACTION)
    }

    /// E_b \[Pa\]: of the grains, or of the membrane alone, E_m t_m (6/h + 2/d), if that is more.
    #[must_use]
    pub fn beam_stiffness(&self) -> f64 {
        let grow = self.grow;
        let grains =
            STIFFNESS * grow.youngs_modulus * libm::pow(self.hardness(), STIFFNESS_EXPONENT - 1.0);
        let tension = grow.membrane_youngs_modulus * self.membrane_thickness;
        grains.max(tension * (6.0 / grow.height + 2.0 / grow.depth))
    }

    /// f_1 = (π/2) √(E_b/ρ_b) (h/√12)/L² \[Hz\]: the beam's first mode.
    #[must_use]
    pub fn first_frequency(&self) -> f64 {
        let grow = self.grow;
        let sound = (self.beam_stiffness() / (self.volume_fraction() * grow.density)).sqrt();
        0.5 * PI * sound * grow.height / 12f64.sqrt() / (grow.length * grow.length)
    }

    /// The critical time step \[s\], the smaller one of grains and membrane.
    #[must_use]
    pub fn critical_time_step(&self) -> f64 {
        let grow = self.grow;
        let radius = 0.5 * (grow.radius_min + grow.radius_max);
        let grains = TIME_STEP
            * radius
            * (grow.density / grow.youngs_modulus).sqrt()
            * libm::pow(self.hardness(), 0.2);
        // 2/ω with ω² = 6k/m, k = (√3/2) E_m t_m and m = ρ_m t_m (√3/2) a².
        let membrane = 2.0
            * grow.membrane_edge
            * (self.membrane_density / (6.0 * grow.membrane_youngs_modulus)).sqrt();
        grains.min(membrane)
    }
}

/// N = φ L h d/(4π⟨R³⟩/3), of radii drawn evenly from a range.
pub(super) fn grains(mold: &Dimensions, volume_fraction: f64, (low, high): (f64, f64)) -> f64 {
    let mean_cube = 0.25 * (low * low + high * high) * (low + high);
    volume_fraction * mold.length * mold.height * mold.depth / (4.0 / 3.0 * PI * mean_cube)
}

/// Vertices of triangles with this edge on all six faces.
pub(super) fn vertices(mold: &Dimensions, edge: f64) -> f64 {
    let area = mold.length * (mold.height + mold.depth) + mold.height * mold.depth;
    2.0 * area / (0.5 * 3f64.sqrt() * edge * edge)
}

/// Way of the rods \[m\] at the strain ε: that of the deflection 23 L² ε/(108 h) times 20/23, by the elastic line.
#[must_use]
pub fn rod_travel(mold: &Dimensions, strain: f64) -> f64 {
    20.0 * mold.length * mold.length * strain / (108.0 * mold.height)
}

#[cfg(test)]
mod tests {
    use crate::beam::point::BeamPoint;

    fn paper(youngs_modulus: f64) -> BeamPoint {
        let map = BeamPoint::defaults("paper").expect("a preset");
        let point = BeamPoint::from_parameters(map).expect("valid defaults");
        BeamPoint {
            youngs_modulus,
            ..point
        }
    }

    #[test]
    fn paper_s_beam_has_its_grains_and_vertices() {
        let point = paper(1e8);
        let grow = point.grow();
        let beam = point.prediction(&grow);
        assert!((beam.grains() / 11_744.0 - 1.0).abs() < 1e-3);
        assert!((beam.vertices() / 5_350.0 - 1.0).abs() < 2e-3);
    }

    /// E_p, f_1, Δt_crit and φ as measured on bulk packings, within 10 %.
    #[test]
    fn scaling_laws_meet_what_they_were_made_from() {
        let near = |found: f64, expected: f64| {
            assert!((found / expected - 1.0).abs() < 0.1, "{found} {expected}");
        };
        for (youngs_modulus, frequency, step, fraction) in [
            (1e8, 7.0, 20e-6, 0.62),
            (1e7, 3.7, 40e-6, 0.74),
            (5e6, 3.0, 49e-6, 0.83),
        ] {
            let point = paper(youngs_modulus);
            let grow = point.grow();
            let beam = point.prediction(&grow);
            near(beam.first_frequency(), frequency);
            near(beam.critical_time_step(), step);
            near(beam.volume_fraction(), fraction);
        }
    }

    #[test]
    fn loose_beam_has_the_stiffness_of_its_membrane() {
        let point = BeamPoint {
            confining_pressure: 0.0,
            ..paper(1e8)
        };
        let grow = point.grow();
        // 10 MPa · 0.3 mm · (6/4 cm + 2/8 cm) = 0.525 MPa.
        assert!((point.prediction(&grow).beam_stiffness() / 0.525e6 - 1.0).abs() < 1e-12);
    }
}
