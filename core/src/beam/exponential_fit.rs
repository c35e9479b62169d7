//! How the strength grows with friction: Y_b(μ) = (Y⁰ − Y^∞) e^{−aμ} + Y^∞, Eq. (4).
//!
//! For a fixed rate a the model is a straight line in 1 − e^{−aμ}, so its best Y⁰ and Y^∞ ≥ 0 have a closed form (`profile`).
//! Only a is searched: on a scan of its whole range, in place of several starts, and from the best value by golden section.
//! Data that do not determine all three parameters get another [`Shape`], which holds only what they do determine.

use serde::{Deserialize, Serialize};

mod errors;
mod profile;

use errors::parameter_errors;
use profile::{Profile, best_rate};

use super::line::Line;

/// Scatter of Y_b relative to Y_b in the paper: by so much Table I's fits A and B differ at μ = 0.3, where both are the same runs.
pub const PAPER_SCATTER: f64 = 0.03;

/// Where the least friction is at least this, Y⁰ is an extrapolation: the paper's protocol B has no smaller one.
const EXTRAPOLATED_FROM: f64 = 0.3;

/// Three parameters take at least so many strengths to be tested at all.
const LEAST_POINTS: usize = 4;

/// The largest a μ that is resolved: ln 100; beyond, the least friction above 0 is within 1 % of Y^∞.
const LARGEST_PRODUCT: f64 = 4.605_170_185_988_092;

/// The smallest a μ that is resolved: below, e^{−aμ} is straight within 0.05 %.
const LEAST_PRODUCT: f64 = 1e-3;

/// The strength found at one friction coefficient.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StrengthPoint {
    /// μ.
    pub friction_coefficient: f64,
    /// Y_b \[Pa\]; `None` if the run has none.
    pub strength: Option<f64>,
}

/// A number with its standard error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Its standard error in the same unit; `None` if the data cannot tell.
    pub standard_error: Option<f64>,
}

/// What strengths say about Eq. (4).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExponentialFit {
    /// What the data determine.
    pub shape: Shape,
    /// Whether Y⁰ lies outside of the data: no friction coefficient below 0.3.
    pub extrapolated: bool,
    /// The number of strengths fitted.
    pub used: usize,
    /// The number of points left out: no strength, not finite, or μ < 0.
    pub dropped: usize,
}

/// How much of Eq. (4) the data determine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Shape {
    /// All of it.
    Exponential(Exponential),
    /// A step at μ = 0: all frictions above 0 give one strength, so a is unresolved from below.
    Step {
        /// Y⁰ \[Pa\], the mean at μ = 0; `None` without data there.
        zero_friction: Option<Estimate>,
        /// Y^∞ \[Pa\], the mean of the others.
        infinite_friction: Estimate,
        /// a is at least ln(100)/(smallest μ above 0).
        rate_at_least: f64,
    },
    /// A straight line, or one that steepens: no sign of Y^∞.
    Straight {
        /// Y⁰ \[Pa\].
        zero_friction: Estimate,
        /// dY_b/dμ \[Pa\].
        slope: Estimate,
    },
    /// One strength within the scatter, which leaves a and the difference of Y⁰ and Y^∞ undetermined.
    Constant {
        /// The mean \[Pa\].
        strength: Estimate,
    },
    /// Fewer than four strengths, or fewer than three different frictions: nothing is fitted.
    TooFewPoints,
}

/// The three parameters of Eq. (4).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Exponential {
    /// Y⁰ ≥ 0 \[Pa\].
    pub zero_friction: Estimate,
    /// Y^∞ ≥ 0 \[Pa\].
    pub infinite_friction: Estimate,
    /// a.
    pub rate: Estimate,
    /// Condition number of JᵀJ in the 1-norm, the columns of J scaled to length 1 so that units do not matter.
    ///
    /// `None` if JᵀJ is singular.
    pub condition_number: Option<f64>,
    /// Root mean square of the residuals \[Pa\].
    pub residual_rms: f64,
}

/// Fits Eq. (4) to strengths that repeat within the standard deviation `scatter` \[Pa\].
///
/// Where repeats are missing, [`PAPER_SCATTER`] times a typical strength is the paper's own.
/// Standard errors come from the residuals and hold where the model is nearly linear; they ignore the bounds.
#[must_use]
pub fn fit(points: &[StrengthPoint], scatter: f64) -> ExponentialFit {
    let data: Vec<Datum> = points.iter().filter_map(Datum::of).collect();
    let least = data
        .iter()
        .map(|datum| datum.friction)
        .fold(f64::INFINITY, f64::min);
    ExponentialFit {
        shape: shape(&data, scatter),
        extrapolated: least >= EXTRAPOLATED_FROM && !data.is_empty(),
        used: data.len(),
        dropped: points.len() - data.len(),
    }
}

/// A usable point (μ, Y_b).
#[derive(Clone, Copy, Debug)]
struct Datum {
    friction: f64,
    /// \[Pa\].
    strength: f64,
}

impl Datum {
    fn of(point: &StrengthPoint) -> Option<Self> {
        let friction = point.friction_coefficient;
        let strength = point.strength.filter(|strength| strength.is_finite())?;
        (friction.is_finite() && friction >= 0.0).then_some(Self { friction, strength })
    }
}

fn shape(data: &[Datum], scatter: f64) -> Shape {
    let mut frictions: Vec<f64> = data.iter().map(|datum| datum.friction).collect();
    frictions.sort_by(f64::total_cmp);
    frictions.dedup();
    if data.len() < LEAST_POINTS || frictions.len() < 3 {
        return Shape::TooFewPoints;
    }
    let strengths = |keep: fn(f64) -> bool| -> Vec<f64> {
        let kept = data.iter().filter(|datum| keep(datum.friction));
        kept.map(|datum| datum.strength).collect()
    };
    let equal = |strengths: &[f64]| range(strengths) <= 2.0 * scatter;
    let all = strengths(|_| true);
    if equal(&all) {
        let strength = mean(&all).expect("at least four strengths");
        return Shape::Constant { strength };
    }
    let rubbing = strengths(|friction| friction > 0.0);
    let smallest = if frictions[0] > 0.0 {
        frictions[0]
    } else {
        frictions[1]
    };
    let largest = frictions[frictions.len() - 1];
    let (low, high) = (LEAST_PRODUCT / largest, LARGEST_PRODUCT / smallest);
    let rate = best_rate(data, low, high);
    if equal(&rubbing) || rate >= high {
        return Shape::Step {
            zero_friction: mean(&strengths(|friction| friction == 0.0)),
            infinite_friction: mean(&rubbing).expect("two frictions lie above 0"),
            rate_at_least: high,
        };
    }
    if rate <= low {
        return straight(data);
    }
    Shape::Exponential(exponential(data, rate))
}

fn exponential(data: &[Datum], rate: f64) -> Exponential {
    let profile = Profile::at(data, rate);
    let (errors, condition_number) = match parameter_errors(data, &profile) {
        Some((errors, condition_number)) => (errors.map(Some), Some(condition_number)),
        None => ([None; 3], None),
    };
    let estimate = |value, standard_error| Estimate {
        value,
        standard_error,
    };
    Exponential {
        zero_friction: estimate(profile.zero_friction, errors[0]),
        infinite_friction: estimate(profile.infinite_friction, errors[1]),
        rate: estimate(rate, errors[2]),
        condition_number,
        residual_rms: (profile.squared_residuals / data.len() as f64).sqrt(),
    }
}

fn straight(data: &[Datum]) -> Shape {
    let line = Line::through(data.iter().map(|datum| (datum.friction, datum.strength)))
        .expect("there are three different frictions");
    let count = data.len() as f64;
    let variance = line.squared_residuals / (count - 2.0);
    let of_intercept = 1.0 / count + line.mean_x * line.mean_x / line.x_spread;
    Shape::Straight {
        zero_friction: Estimate {
            value: line.intercept,
            standard_error: Some((variance * of_intercept).sqrt()),
        },
        slope: Estimate {
            value: line.slope,
            standard_error: Some((variance / line.x_spread).sqrt()),
        },
    }
}

/// Mean with its standard error; `None` of nothing.
fn mean(values: &[f64]) -> Option<Estimate> {
    let count = values.len() as f64;
    let value = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|v| (v - value) * (v - value)).sum();
    (!values.is_empty()).then_some(Estimate {
        value,
        standard_error: (values.len() > 1).then(|| (squares / (count * (count - 1.0))).sqrt()),
    })
}

/// Largest minus smallest value.
fn range(values: &[f64]) -> f64 {
    let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
    largest - smallest
}

#[cfg(test)]
mod tests;
