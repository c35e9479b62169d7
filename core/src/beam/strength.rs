//! The ultimate strength Y_b: the stress at which the beam, softening since it began to bend, becomes stiffer again.
//!
//! The paper smooths σ and ε, differentiates, smooths again and takes the stress where σ'' turns from − to +.
//! With 2 % of noise the first such turn lies far too low, so here Y_b is the stress at the *least slope*, which is the deepest of them:
//! 1. Keep what exceeds every strain before it; resample it every 10⁻⁴ of strain.
//! 2. Smooth σ and ε by a Gaussian of width w; σ' by central differences; smooth σ' likewise.
//! 3. Discard 3w at both ends; find the least σ' inside ε ∈ \[0.004, ε_end − 3w\] and from its neighbors the zero of σ''.
//! 4. It must lie inside, at most at 0.7 of the largest σ' before it, and σ' must rise after it by 5 % of that and by three standard deviations of its noise.
//! 5. Repeat for w = 1, 2, 3, 4·10⁻³: Y_b is the median and must not vary by more than 10 %.
//!
//! White noise of 2 % moves Y_b by less than 3 % where the curve is nearly flat at Y_b.
//! Where its slope there is still 0.3 of the first, 0.5 % moves it by up to 8 % and 2 % by up to 17 %, or the widths disagree.
//! A beam that yields below ε = 0.012, 3w of the widest filter, is `width_sensitive`.

use serde::{Deserialize, Serialize};

use super::curve::{Curve, Point};

mod filter;

use filter::{SPACING, central_differences, gaussian, noise_density, resample, rising, smooth};

/// The widths w of the Gaussian filters, in strain, narrowest first.
const WIDTHS: [f64; 4] = [1e-3, 2e-3, 3e-3, 4e-3];

/// No strength is looked for below this strain.
const FIRST_STRAIN: f64 = 0.004;

/// The least slope is at most this part of the largest slope before it.
const LARGEST_RATIO: f64 = 0.7;

/// The slope rises after its least by at least this part of the largest slope before it.
const LEAST_RISE: f64 = 0.05;

/// The slope rises after its least by at least this many standard deviations of its noise.
const NOISE_DEVIATIONS: f64 = 3.0;

/// The widths may disagree by this part of Y_b.
const LARGEST_SPREAD: f64 = 0.1;

/// Y_b and where it was found: medians over the four widths.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Strength {
    /// Y_b \[Pa\].
    pub ultimate_strength: f64,
    /// Half the difference between the largest and the smallest Y_b of the four widths \[Pa\].
    pub spread: f64,
    /// ε_Y, the strain at Y_b.
    pub strain: f64,
    /// σ' at Y_b, the least slope \[Pa\].
    pub least_slope: f64,
}

/// Why there is no Y_b, and what is known instead.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NoStrength {
    /// What the curve lacks.
    pub reason: Reason,
    /// σ_max, the largest stress measured \[Pa\]: the beam bore it; `None` without a measurement.
    pub lower_bound: Option<f64>,
}

/// What a curve without Y_b lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// The least slope lies at an end: the beam still softens, or never did.
    NoInteriorMinimum,
    /// The slope hardly falls or hardly rises again, as on a straight line.
    NotProminent,
    /// The widths of the filter disagree on Y_b or on whether there is one.
    WidthSensitive,
    /// Nothing is left between the parts discarded for the widest filter.
    RunTooShort,
}

/// Y_b of `curve`; unloading is passed over, so a cyclic run counts once.
pub fn ultimate_strength(curve: &Curve) -> Result<Strength, NoStrength> {
    let points = rising(curve.points());
    let grid = resample(&points);
    let noise = noise_density(&points);
    let trials = WIDTHS.map(|width| least_slope(&grid, width)?.checked(noise));
    judge(&trials).map_err(|reason| NoStrength {
        reason,
        lower_bound: curve
            .points()
            .iter()
            .map(|point| point.stress)
            .reduce(f64::max),
    })
}

/// The verdict of all widths.
fn judge(trials: &[Result<Minimum, Reason>; 4]) -> Result<Strength, Reason> {
    let found: Vec<Minimum> = trials.iter().filter_map(|trial| trial.ok()).collect();
    if found.len() < trials.len() {
        // If none finds it, the widest, which noise troubles least, knows best why.
        return Err(match trials[WIDTHS.len() - 1] {
            Err(reason) if found.is_empty() || reason == Reason::RunTooShort => reason,
            _ => Reason::WidthSensitive,
        });
    }
    let (least, median, largest) = order(&found, |minimum| minimum.at.stress);
    let spread = 0.5 * (largest - least);
    if spread <= LARGEST_SPREAD * median {
        Ok(Strength {
            ultimate_strength: median,
            spread,
            strain: order(&found, |minimum| minimum.at.strain).1,
            least_slope: order(&found, |minimum| minimum.slope).1,
        })
    } else {
        Err(Reason::WidthSensitive)
    }
}

/// Least, median and largest of one number of the four minima.
fn order(minima: &[Minimum], number: impl Fn(&Minimum) -> f64) -> (f64, f64, f64) {
    let mut sorted: Vec<f64> = minima.iter().map(number).collect();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len() - 1;
    let median = 0.5 * (sorted[last / 2] + sorted[sorted.len() / 2]);
    (sorted[0], median, sorted[last])
}

/// The least slope found with one width.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Minimum {
    width: f64,
    /// Where σ'' = 0, by σ and ε smoothed once.
    at: Point,
    slope: f64,
    /// The largest slope before it, at or after 3w.
    before: f64,
    /// The largest slope after it, up to ε_end − 3w.
    after: f64,
}

impl Minimum {
    /// The minimum if it is prominent; `noise` by [`noise_density`].
    fn checked(self, noise: f64) -> Result<Self, Reason> {
        let rise = self.after - self.slope;
        let deviation = slope_deviation(noise, self.width);
        let prominent = self.before > 0.0
            && self.slope <= LARGEST_RATIO * self.before
            && rise >= LEAST_RISE * self.before
            && rise >= NOISE_DEVIATIONS * deviation;
        if prominent {
            Ok(self)
        } else {
            Err(Reason::NotProminent)
        }
    }
}

/// Standard deviation \[Pa\] of σ' smoothed twice by `width`, from the density S \[Pa²\] of white noise on σ.
///
/// Two Gaussians are one of W = √2 w, and ∫ (dG/dε)² dε = 1/(4√π W³), so it is √(S/(4√π W³)).
fn slope_deviation(density: f64, width: f64) -> f64 {
    let both = 2f64.sqrt() * width;
    (density / (4.0 * std::f64::consts::PI.sqrt() * both * both * both)).sqrt()
}

/// The least slope with a filter of `width`, inside but not yet known to be prominent.
fn least_slope(grid: &[Point], width: f64) -> Result<Minimum, Reason> {
    let margin = (3.0 * width / SPACING).round() as usize;
    let end = grid.len().saturating_sub(margin);
    let start = grid.iter().position(|point| point.strain >= FIRST_STRAIN);
    let start = start.unwrap_or(end).max(margin);
    // A minimum inside takes three slopes.
    if end < start + 3 {
        return Err(Reason::RunTooShort);
    }
    let (stress, strain, slope) = smoothed(grid, &gaussian(width));
    let largest = |slopes: &[f64]| slopes.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = (start..end)
        .min_by(|&a, &b| slope[a].total_cmp(&slope[b]))
        .expect("the window holds three slopes");
    // Without a fall anywhere, even a minimum at an end is only the noise of a straight line.
    if slope[least] > LARGEST_RATIO * largest(&slope[margin..end]) {
        return Err(Reason::NotProminent);
    }
    if least == start || least + 1 == end {
        return Err(Reason::NoInteriorMinimum);
    }
    Ok(Minimum {
        width,
        at: turn(&stress, &strain, &slope, least),
        slope: slope[least],
        before: largest(&slope[margin..least]),
        after: largest(&slope[least + 1..end]),
    })
}

/// σ and ε smoothed once, and σ' smoothed twice.
fn smoothed(grid: &[Point], kernel: &[f64]) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let column = |value: fn(&Point) -> f64| -> Vec<f64> {
        smooth(&grid.iter().map(value).collect::<Vec<_>>(), kernel)
    };
    let (stress, strain) = (column(|point| point.stress), column(|point| point.strain));
    let slope = smooth(&central_differences(&stress, &strain), kernel);
    (stress, strain, slope)
}

/// The zero of σ'' beside the least slope: σ'' is ≤ 0 half a step before it and ≥ 0 half a step after it.
fn turn(stress: &[f64], strain: &[f64], slope: &[f64], least: usize) -> Point {
    let (before, after) = (
        slope[least] - slope[least - 1],
        slope[least + 1] - slope[least],
    );
    let shift = if after > before {
        -before / (after - before) - 0.5
    } else {
        0.0
    };
    let neighbor = if shift < 0.0 { least - 1 } else { least + 1 };
    let between = |values: &[f64]| values[least] + shift.abs() * (values[neighbor] - values[least]);
    Point {
        strain: between(strain),
        stress: between(stress),
    }
}

#[cfg(test)]
mod tests;
