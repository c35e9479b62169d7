//! The result table of the beam experiment: symbol, unit and meaning of every number of a set or a point.
//!
//! Stresses and strains are nominal, by the dimensions of the mold, as in the paper's Table I, unless their name ends in `_actual`.

use crate::parameter::Quantity;
use crate::study::Judged;

mod bending;

use bending::BENDING;

/// The results of a point that means over packings are taken of.
pub const MEANS: &[&str] = &[
    "beam_stiffness",
    "beam_stiffness_origin",
    "beam_stiffness_actual",
    "ultimate_strength",
    "ultimate_strength_actual",
    "yield_strain",
    "volume_fraction",
    "coordination_number",
    "coordination_number_bulk",
    "coulomb_fraction",
    "mean_normal_force",
    "mean_overlap",
    "imbalance_max",
    "imbalance_mean",
    "periods",
];

/// What studies judge settings by: the relative errors of E_b and Y_b.
pub const JUDGED: &[Judged] = &[
    Judged {
        name: "beam_stiffness",
        relative: true,
    },
    Judged {
        name: "ultimate_strength",
        relative: true,
    },
];

/// The results that may be `null` with a word why: those of [`super::strength::Reason`] and [`super::stiffness::NoStiffness`].
pub const REASONED: &[&str] = &["beam_stiffness", "ultimate_strength"];

/// Every result, those of fits first; a set of means adds `_sem` to a name for its standard error.
pub const RESULTS: &[Quantity] = &joined::<{ FITS.len() + BENDING.len() }>();

const fn joined<const N: usize>() -> [Quantity; N] {
    let mut all = [FITS[0]; N];
    let mut k = 0;
    while k < N {
        all[k] = if k < FITS.len() {
            FITS[k]
        } else {
            BENDING[k - FITS.len()]
        };
        k += 1;
    }
    all
}

/// What a fit of Eq. (4) yields.
pub const FITS: &[Quantity] = &[
    Quantity::new(
        "strength_zero_friction",
        ("Y⁰", "Pa"),
        "Strength without friction, of Eq. (4).",
    ),
    Quantity::new(
        "strength_zero_friction_error",
        ("δY⁰", "Pa"),
        "Its standard error.",
    ),
    Quantity::new(
        "strength_infinite_friction",
        ("Y^∞", "Pa"),
        "Strength at large friction, of Eq. (4).",
    ),
    Quantity::new(
        "strength_infinite_friction_error",
        ("δY^∞", "Pa"),
        "Its standard error.",
    ),
    Quantity::new(
        "strength_rate",
        ("a", ""),
        "Rate of Eq. (4), over friction.",
    ),
    Quantity::new("strength_rate_error", ("δa", ""), "Its standard error."),
    Quantity::new(
        "strength_rate_at_least",
        ("a_min", ""),
        "Least rate that a step at μ_p = 0 leaves possible.",
    ),
    Quantity::new(
        "strength_slope",
        ("dY_b/dμ_p", "Pa"),
        "Slope where the strengths lie on a straight line.",
    ),
    Quantity::new(
        "strength_slope_error",
        ("δ(dY_b/dμ_p)", "Pa"),
        "Its standard error.",
    ),
    Quantity::new(
        "strength_mean",
        ("⟨Y_b⟩", "Pa"),
        "Mean where the strengths are one within their scatter.",
    ),
    Quantity::new(
        "strength_mean_error",
        ("δ⟨Y_b⟩", "Pa"),
        "Its standard error.",
    ),
    Quantity::new(
        "strength_condition_number",
        ("cond JᵀJ", ""),
        "Condition number of the fit; large where the data hardly tell its parameters apart.",
    ),
    Quantity::new(
        "strength_residual",
        ("Y_rms", "Pa"),
        "Root mean square distance of the strengths from the fit.",
    ),
    Quantity::new("strengths_used", ("n", ""), "Strengths fitted."),
    Quantity::new(
        "strengths_dropped",
        ("n₀", ""),
        "Points left out of the fit, as they have no strength.",
    ),
    Quantity::new(
        "strength_extrapolated",
        ("extrapolated", ""),
        "1 if Y⁰ lies outside of the data: no friction below 0.3.",
    ),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_all_different_and_means_are_of_results() {
        for (k, row) in RESULTS.iter().enumerate() {
            let before = &RESULTS[..k];
            assert!(
                before.iter().all(|other| other.name != row.name),
                "{}",
                row.name
            );
        }
        for name in MEANS.iter().chain(REASONED) {
            assert!(BENDING.iter().any(|row| row.name == *name), "{name}");
        }
    }
}
