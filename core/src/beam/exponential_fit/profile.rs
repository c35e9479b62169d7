//! The best Y⁰ and Y^∞ for a given rate a, and the search for the best a.

use super::{Datum, Line};

/// The number of rates tried before the search is refined; with the paper's frictions, neighbors differ by less than a third.
const SCAN: u32 = 40;

/// Steps of golden section: 0.618⁸⁰ = 2·10⁻¹⁷ of the bracket is below rounding.
const REFINEMENTS: u32 = 80;

/// A rate nearer than this part of it to an end of the range is the end.
const END: f64 = 1e-6;

/// The best fit of Eq. (4) with a given rate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Profile {
    pub(super) rate: f64,
    /// Y⁰ ≥ 0 \[Pa\].
    pub(super) zero_friction: f64,
    /// Y^∞ ≥ 0 \[Pa\].
    pub(super) infinite_friction: f64,
    /// Sum of squared residuals \[Pa²\].
    pub(super) squared_residuals: f64,
}

impl Profile {
    /// The best fit with `rate` > 0.
    ///
    /// With q = 1 − e^{−aμ} the model is the line Y⁰ + (Y^∞ − Y⁰) q.
    /// If that line wants one of the two below 0, the best point of the quadrant has this one at 0, because the sum of squares is convex.
    pub(super) fn at(data: &[Datum], rate: f64) -> Self {
        let risen = |friction: f64| -libm::expm1(-rate * friction);
        let pairs = data
            .iter()
            .map(|datum| (risen(datum.friction), datum.strength));
        let (mut zero, mut infinite) = match Line::through(pairs.clone()) {
            Some(line) => (line.intercept, line.intercept + line.slope),
            None => (f64::NAN, f64::NAN),
        };
        if zero < 0.0 {
            zero = 0.0;
            infinite = proportional(pairs.clone());
        } else if infinite < 0.0 {
            infinite = 0.0;
            zero = proportional(pairs.clone().map(|(q, strength)| (1.0 - q, strength)));
        }
        let residuals = pairs.map(|(q, strength)| strength - zero - (infinite - zero) * q);
        Self {
            rate,
            zero_friction: zero,
            infinite_friction: infinite,
            squared_residuals: residuals.map(|r| r * r).sum(),
        }
    }
}

/// The factor f ≥ 0 of the best y = f x.
fn proportional(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (xx, xy) = pairs.fold((0.0, 0.0), |(xx, xy), (x, y)| (xx + x * x, xy + x * y));
    (xy / xx).max(0.0)
}

/// The rate between `low` and `high` with the least sum of squares; exactly an end if the sum falls all the way to it.
pub(super) fn best_rate(data: &[Datum], low: f64, high: f64) -> f64 {
    let ratio = libm::log(high / low) / f64::from(SCAN);
    let rate = |k: u32| match k {
        0 => low,
        SCAN => high,
        _ => low * libm::exp(ratio * f64::from(k)),
    };
    let misfit = |rate| Profile::at(data, rate).squared_residuals;
    let best = (0..=SCAN)
        .min_by(|&a, &b| misfit(rate(a)).total_cmp(&misfit(rate(b))))
        .expect("the scan is not empty");
    let bracket = (rate(best.saturating_sub(1)), rate((best + 1).min(SCAN)));
    let inside = golden_section(misfit, bracket.0, bracket.1);
    // Golden section nears an end without ever trying it.
    if inside < low * (1.0 + END) {
        low
    } else if inside > high * (1.0 - END) {
        high
    } else {
        inside
    }
}

/// Where `function` is least between `left` and `right`, if it has one minimum there.
fn golden_section(function: impl Fn(f64) -> f64, mut left: f64, mut right: f64) -> f64 {
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let mut a = right - golden * (right - left);
    let mut b = left + golden * (right - left);
    let (mut at_a, mut at_b) = (function(a), function(b));
    for _ in 0..REFINEMENTS {
        if at_a <= at_b {
            (right, b, at_b) = (b, a, at_a);
            a = right - golden * (right - left);
            at_a = function(a);
        } else {
            (left, a, at_a) = (a, b, at_b);
            b = left + golden * (right - left);
            at_b = function(b);
        }
    }
    0.5 * (left + right)
}
