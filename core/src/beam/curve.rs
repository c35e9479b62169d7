//! The stress–strain curve of a bending run: force and deflection freed from the size of the beam.
//!
//! Four-point bending, the rods at the thirds of the span; positive stress is the outer fiber's tension.

use serde::{Deserialize, Serialize};

/// The outer dimensions of a beam \[m\], all positive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Dimensions {
    /// L, along the beam: the span between the supports.
    pub length: f64,
    /// h, in the direction of bending.
    pub height: f64,
    /// d, along the rods.
    pub depth: f64,
}

impl Dimensions {
    /// σ = F L/(h² d) \[Pa\]: the outer stress under the total force F \[N\] of both rods (App. B).
    #[must_use]
    pub fn stress(&self, force: f64) -> f64 {
        force * self.length / (self.height * self.height * self.depth)
    }

    /// ε = 108 h Δz/(23 L²): the outer strain at the deflection Δz \[m\] of mid-span, Eq. (3).
    ///
    /// Of a slender elastic beam: shear adds 2.4 % to the deflection at L/h = 10, 9.8 % at 5.
    #[must_use]
    pub fn strain(&self, deflection: f64) -> f64 {
        108.0 * self.height * deflection / (23.0 * self.length * self.length)
    }
}

/// One quantity twice, by the two sets of dimensions that a stress can refer to.
///
/// The paper does not say which it means; stresses differ by about 15 %.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ByDimensions<T> {
    /// By the mold, before the grains are compacted; compared with the paper's Table I.
    pub nominal: T,
    /// By the beam as it is when bending starts.
    pub actual: T,
}

impl<T> ByDimensions<T> {
    /// `convert` applied to both.
    #[must_use]
    pub fn map<U>(&self, convert: impl Fn(&T) -> U) -> ByDimensions<U> {
        ByDimensions {
            nominal: convert(&self.nominal),
            actual: convert(&self.actual),
        }
    }
}

/// What is measured at one moment of bending.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Since the rods began to move \[s\].
    pub time: f64,
    /// Way of the rods, positive downward \[m\].
    pub rod_travel: f64,
    /// F, of both rods together, positive when they press the beam down \[N\].
    pub force: f64,
    /// Δz, of the bottom face at mid-span, positive downward \[m\].
    pub deflection: f64,
}

/// The samples before the rods first turn back: the first loading of a cyclic run, all of any other.
///
/// The rods are driven, so their travel, unlike force and deflection, has no noise.
#[must_use]
pub fn first_loading(samples: &[Sample]) -> &[Sample] {
    let turn = samples
        .windows(2)
        .position(|pair| pair[1].rod_travel < pair[0].rod_travel);
    &samples[..turn.map_or(samples.len(), |before| before + 1)]
}

/// One point of the curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// ε.
    pub strain: f64,
    /// σ \[Pa\].
    pub stress: f64,
}

/// Stress over strain in the order of time; every number in it is finite.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Curve(Vec<Point>);

impl Curve {
    /// The curve of `samples` by `dimensions`.
    #[must_use]
    pub fn of(samples: &[Sample], dimensions: &Dimensions) -> Self {
        samples
            .iter()
            .map(|sample| Point {
                strain: dimensions.strain(sample.deflection),
                stress: dimensions.stress(sample.force),
            })
            .collect()
    }

    /// The points in the order of time.
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.0
    }
}

impl FromIterator<Point> for Curve {
    /// Collects the finite points and leaves out the others.
    fn from_iter<I: IntoIterator<Item = Point>>(points: I) -> Self {
        let finite = |point: &Point| point.strain.is_finite() && point.stress.is_finite();
        Self(points.into_iter().filter(finite).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAPER: Dimensions = Dimensions {
        length: 0.40,
        height: 0.04,
        depth: 0.08,
    };

    fn sample(rod_travel: f64, force: f64, deflection: f64) -> Sample {
        Sample {
            time: rod_travel / 2e-4,
            rod_travel,
            force,
            deflection,
        }
    }

    #[test]
    fn an_elastic_beam_has_the_modulus_it_is_made_of() {
        // Third-point bending of a slender beam: Δz = 23 F L³/(1296 E I), I = d h³/12.
        let (modulus, force) = (5e6, 3.0);
        let inertia = PAPER.depth * libm::pow(PAPER.height, 3.0) / 12.0;
        let deflection = 23.0 * force * libm::pow(PAPER.length, 3.0) / (1296.0 * modulus * inertia);
        let ratio = PAPER.stress(force) / PAPER.strain(deflection);
        assert!((ratio / modulus - 1.0).abs() < 1e-14);
    }

    #[test]
    fn the_paper_s_beam_is_bent_68_mm_to_a_strain_of_8_percent() {
        assert!((PAPER.strain(68.15e-3) - 0.08).abs() < 1e-5);
        // 32 N of both rods are 100 kPa.
        assert!((PAPER.stress(32.0) - 100e3).abs() < 1e-6);
    }

    #[test]
    fn stress_and_strain_refer_to_the_dimensions_they_are_given() {
        // All lengths shrunk by λ: σ grows by 1/λ², ε by 1/λ.
        let shrink = 0.93;
        let dimensions = ByDimensions {
            nominal: PAPER,
            actual: Dimensions {
                length: shrink * PAPER.length,
                height: shrink * PAPER.height,
                depth: shrink * PAPER.depth,
            },
        };
        let samples = [sample(1e-3, 2.0, 1.1e-3)];
        let curves = dimensions.map(|dimensions| Curve::of(&samples, dimensions));
        let (nominal, actual) = (curves.nominal.points()[0], curves.actual.points()[0]);
        assert!((actual.stress / nominal.stress * shrink * shrink - 1.0).abs() < 1e-14);
        assert!((actual.strain / nominal.strain * shrink - 1.0).abs() < 1e-14);
    }

    #[test]
    fn the_first_loading_ends_where_the_rods_turn_back() {
        let cycle: Vec<Sample> = [0.0, 1.0, 1.0, 2.0, 1.5, 1.0, 3.0]
            .map(|travel| sample(travel, 0.0, 0.0))
            .to_vec();
        assert_eq!(first_loading(&cycle), &cycle[..4]);
        assert_eq!(first_loading(&cycle[..4]), &cycle[..4]);
        assert!(first_loading(&[]).is_empty());
    }

    #[test]
    fn what_is_not_finite_never_enters_a_curve() {
        let samples = [
            sample(0.0, f64::NAN, 1.0),
            sample(1.0, 1.0, f64::INFINITY),
            sample(2.0, 1.0, 1.0),
        ];
        assert_eq!(Curve::of(&samples, &PAPER).points().len(), 1);
    }
}
