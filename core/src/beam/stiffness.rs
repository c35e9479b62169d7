//! The beam stiffness E_b: the slope of the curve where bending begins.
//!
//! σ = E_b ε + c by ordinary least squares over 0 < ε ≤ 0.002.
//! The intercept c takes up play between rods and beam; without it, [`Stiffness::through_origin`] mixes play and stiffness.

use serde::{Deserialize, Serialize};

use super::curve::{Curve, Point};
use super::line::Line;

/// The largest strain that belongs to the elastic beginning, as in the paper.
pub const ELASTIC_STRAIN: f64 = 0.002;

/// Below this number of samples the fit is flagged.
const ENOUGH_SAMPLES: usize = 20;

/// Below this R² the fit is flagged.
const STRAIGHT_ENOUGH: f64 = 0.98;

/// Above this part of σ(0.002) an intercept counts as slack.
const LARGEST_SLACK: f64 = 0.1;

/// E_b and how well it is founded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stiffness {
    /// E_b \[Pa\].
    pub beam_stiffness: f64,
    /// c, the stress of the line at ε = 0 \[Pa\].
    pub intercept: f64,
    /// E_b of the line through the origin, Σ σε/Σ ε² \[Pa\].
    pub through_origin: f64,
    /// R² of the line with intercept; `None` if the stress never changes.
    pub r_squared: Option<f64>,
    /// Root mean square of the residuals of the line with intercept \[Pa\].
    pub residual_rms: f64,
    /// The number of samples fitted.
    pub samples: usize,
    /// What speaks against the fit, in the order of [`Flag`]; empty if nothing does.
    pub flags: Vec<Flag>,
}

/// What speaks against a fit of E_b.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Flag {
    /// Fewer than 20 samples.
    FewPoints,
    /// R² < 0.98, or no R².
    R2Low,
    /// The beam swings: rods and supports are out of balance by more than 2 %.
    Ringing,
    /// |c| exceeds a tenth of σ(0.002).
    Slack,
}

/// Why there is no E_b.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NoStiffness {
    /// No sample has 0 < ε ≤ 0.002.
    NoSamples,
    /// All samples have the same strain.
    OneStrain,
}

/// E_b of `curve`, which begins after the ramp of the rod velocity and ends before the rods turn back.
///
/// `ringing` says that the balance of rods and supports was violated; only the run knows.
pub fn beam_stiffness(curve: &Curve, ringing: bool) -> Result<Stiffness, NoStiffness> {
    let elastic: Vec<Point> = curve
        .points()
        .iter()
        .copied()
        .filter(|point| point.strain > 0.0 && point.strain <= ELASTIC_STRAIN)
        .collect();
    if elastic.is_empty() {
        return Err(NoStiffness::NoSamples);
    }
    let pairs = elastic.iter().map(|point| (point.strain, point.stress));
    let line = Line::through(pairs.clone()).ok_or(NoStiffness::OneStrain)?;
    let products: f64 = pairs.clone().map(|(strain, stress)| strain * stress).sum();
    let squares: f64 = pairs.map(|(strain, _)| strain * strain).sum();
    let r_squared = (line.squared_deviations > 0.0)
        .then(|| 1.0 - line.squared_residuals / line.squared_deviations);
    let samples = elastic.len();
    Ok(Stiffness {
        beam_stiffness: line.slope,
        intercept: line.intercept,
        through_origin: products / squares,
        r_squared,
        residual_rms: (line.squared_residuals / samples as f64).sqrt(),
        samples,
        flags: flags(&line, r_squared, samples, ringing),
    })
}

fn flags(line: &Line, r_squared: Option<f64>, samples: usize, ringing: bool) -> Vec<Flag> {
    let elastic_stress = line.intercept + line.slope * ELASTIC_STRAIN;
    let raised = [
        (Flag::FewPoints, samples < ENOUGH_SAMPLES),
        (
            Flag::R2Low,
            r_squared.is_none_or(|value| value < STRAIGHT_ENOUGH),
        ),
        (Flag::Ringing, ringing),
        (
            Flag::Slack,
            line.intercept.abs() > LARGEST_SLACK * elastic_stress.abs(),
        ),
    ];
    raised
        .into_iter()
        .filter_map(|(flag, raised)| raised.then_some(flag))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::curve::{Dimensions, Sample, first_loading};
    use crate::beam::noise::gaussian;

    const MODULUS: f64 = 5e6;

    /// `count` samples up to ε = 0.002, then as many beyond, where the curve is flatter.
    fn curve(count: u32, stress: impl Fn(f64) -> f64) -> Curve {
        (1..=2 * count)
            .map(|k| {
                let strain = ELASTIC_STRAIN * f64::from(k) / f64::from(count);
                let beyond = (strain - ELASTIC_STRAIN).max(0.0);
                Point {
                    strain,
                    stress: stress(strain) - 0.5 * MODULUS * beyond,
                }
            })
            .collect()
    }

    #[test]
    fn a_straight_beginning_gives_its_slope_and_no_flag() {
        let stiffness =
            beam_stiffness(&curve(40, |strain| MODULUS * strain), false).expect("samples");
        assert_eq!(stiffness.samples, 40);
        assert!((stiffness.beam_stiffness / MODULUS - 1.0).abs() < 1e-12);
        assert!((stiffness.through_origin / MODULUS - 1.0).abs() < 1e-12);
        assert!(stiffness.r_squared.expect("stress changes") > 1.0 - 1e-12);
        assert!(stiffness.flags.is_empty());
    }

    #[test]
    fn play_moves_the_intercept_and_not_the_slope() {
        // c = −2 kPa of 8 kPa at ε = 0.002.
        let slack =
            beam_stiffness(&curve(40, |strain| MODULUS * strain - 2e3), false).expect("samples");
        assert!((slack.beam_stiffness / MODULUS - 1.0).abs() < 1e-12);
        assert!((slack.intercept + 2e3).abs() < 1e-8);
        assert!(slack.through_origin < 0.8 * MODULUS);
        assert_eq!(slack.flags, [Flag::Slack]);
        let little =
            beam_stiffness(&curve(40, |strain| MODULUS * strain - 0.9e3), false).expect("samples");
        assert!(little.flags.is_empty());
    }

    #[test]
    fn each_flag_has_its_own_cause() {
        let straight = |strain| MODULUS * strain;
        let few = beam_stiffness(&curve(19, straight), false).expect("samples");
        assert_eq!(few.flags, [Flag::FewPoints]);
        let ringing = beam_stiffness(&curve(20, straight), true).expect("samples");
        assert_eq!(ringing.flags, [Flag::Ringing]);
        // Noise of 2 kPa on a line that rises 10 kPa: R² = 8.3/(8.3 + 4) = 0.68, residual rms 2 kPa.
        let rough = |strain: f64| MODULUS * strain + 2e3 * gaussian(5, (strain * 1e7) as u64);
        let rough = beam_stiffness(&curve(1000, rough), false).expect("samples");
        assert_eq!(rough.flags, [Flag::R2Low]);
        assert!((rough.r_squared.expect("stress changes") - 0.68).abs() < 0.05);
        assert!((rough.residual_rms / 2e3 - 1.0).abs() < 0.1);
    }

    #[test]
    fn a_cycle_is_fitted_on_its_first_loading() {
        // Unloading from ε = 0.002 runs 1 kPa below the loading branch.
        let dimensions = Dimensions {
            length: 0.40,
            height: 0.04,
            depth: 0.08,
        };
        let travel = |k: u32| f64::from(if k <= 50 { k } else { 100 - k });
        let samples: Vec<Sample> = (0..=100)
            .map(|k| Sample {
                time: f64::from(k),
                rod_travel: travel(k),
                force: travel(k) - if k > 50 { 3.0 } else { 0.0 },
                deflection: travel(k) * 3e-5,
            })
            .collect();
        let loop_curve = Curve::of(&samples, &dimensions);
        let loading = Curve::of(first_loading(&samples), &dimensions);
        let expected = dimensions.stress(1.0) / dimensions.strain(3e-5);
        let stiffness = beam_stiffness(&loading, false).expect("samples");
        assert!((stiffness.beam_stiffness / expected - 1.0).abs() < 1e-12);
        let mixed = beam_stiffness(&loop_curve, false).expect("samples");
        assert!(mixed.residual_rms > 1e3);
    }

    #[test]
    fn a_force_that_never_changes_has_no_r_squared() {
        let still = curve(40, |strain| {
            0.5 * MODULUS * (strain - ELASTIC_STRAIN).max(0.0)
        });
        let stiffness = beam_stiffness(&still, false).expect("samples");
        assert_eq!((stiffness.beam_stiffness, stiffness.r_squared), (0.0, None));
        assert_eq!(stiffness.flags, [Flag::R2Low]);
    }

    #[test]
    fn without_samples_there_is_a_reason_and_no_number() {
        let at = |strain| Point {
            strain,
            stress: 1.0,
        };
        let none = |points: &[Point]| {
            beam_stiffness(&points.iter().copied().collect(), false).expect_err("no slope")
        };
        assert_eq!(none(&[]), NoStiffness::NoSamples);
        assert_eq!(none(&[at(0.0), at(0.003)]), NoStiffness::NoSamples);
        assert_eq!(none(&[at(0.001), at(0.001)]), NoStiffness::OneStrain);
    }
}
