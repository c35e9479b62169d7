//! The parameter table of the beam experiment and its presets.
//!
//! Defaults are the paper's (Table II and Appendix A) but for the size of the beam and the speed of the rods, which presets choose.
//! The paper's two ranges of radii, 1.66–1.84 mm before the grains grow and 2.2–2.5 mm in the test, are not one factor apart.
//! Here the factor is that of their means, 2.35/1.75 = 1.343, and the final radii are the first range times it: 2.229–2.471 mm.

mod fixed;
mod numerics;
mod preparation;

use crate::parameter::{Choices, DefaultValue, Parameter, Preset};

use fixed::FIXED;
use numerics::NUMERICS;
use preparation::PREPARATION;

use DefaultValue::Real;

/// Every parameter of the beam experiment.
pub const PARAMETERS: &[Parameter] =
    &joined::<{ FIXED.len() + PREPARATION.len() + NUMERICS.len() }>();

const fn joined<const N: usize>() -> [Parameter; N] {
    let mut all = [FIXED[0]; N];
    let mut k = 0;
    while k < N {
        all[k] = if k < FIXED.len() {
            FIXED[k]
        } else if k < FIXED.len() + PREPARATION.len() {
            PREPARATION[k - FIXED.len()]
        } else {
            NUMERICS[k - FIXED.len() - PREPARATION.len()]
        };
        k += 1;
    }
    all
}

/// Size of the beam and speed of the rods, cheapest first: `standard` is the table's defaults.
///
/// The membrane's thickness follows the size (`scale_membrane`), and the rods' speed follows `periods`.
pub const PRESETS: &[Preset] = &[
    Preset {
        name: "smoke",
        values: &[
            ("length", Real(0.12)),
            ("height", Real(0.02)),
            ("depth", Real(0.02)),
            ("rod_speed", Real(0.02)),
            ("time_step_fraction", Real(0.4)),
            ("strain_end", Real(0.01)),
        ],
        sentence: "A beam of 440 grains, bent at once and hardly: whether everything runs, not what comes of it.",
    },
    Preset {
        name: "draft",
        values: &[
            ("length", Real(0.24)),
            ("height", Real(0.024)),
            ("depth", Real(0.048)),
            ("periods", Real(2.5)),
            ("strain_end", Real(0.06)),
            ("strain_end_over_yield", Real(1.5)),
        ],
        sentence: "2,500 grains in minutes: trends hold, E_b within 20 % and Y_b within 15 % of the paper's size and speed.",
    },
    Preset {
        name: "standard",
        values: &[],
        sentence: "5,000 grains in half an hour: E_b within 10 %, Y_b within 8 % of the paper's size and speed.",
    },
    Preset {
        name: "paper_fast",
        values: &[
            ("length", Real(0.40)),
            ("height", Real(0.04)),
            ("depth", Real(0.08)),
            ("periods", Real(10.0)),
        ],
        sentence: "The paper's beam of 11,700 grains, bent five times as fast: hours.",
    },
    Preset {
        name: "paper",
        values: &[
            ("length", Real(0.40)),
            ("height", Real(0.04)),
            ("depth", Real(0.08)),
            ("rod_speed", Real(2e-4)),
            ("time_step_fraction", Real(0.4)),
        ],
        sentence: "The paper's beam at the paper's 0.2 mm/s: about a day.",
    },
];

/// The settings among which a sweep with `[accuracy]` may choose, cheapest first, and the reference that they are held
/// against: the same beam, bent more slowly in half the steps.
pub const CHOICES: Choices = Choices {
    names: &["periods", "time_step_fraction"],
    settings: &[
        &[Real(1.25), Real(0.8)],
        &[Real(2.5), Real(0.8)],
        &[Real(5.0), Real(0.8)],
    ],
    reference: &[Real(10.0), Real(0.4)],
};

/// Pairs of parameters that say one thing: a spec that writes the first takes back what a preset says of the second.
pub const TAKEN_BACK: &[(&str, &str)] = &[("periods", "rod_speed")];

/// The parameter called `name`.
#[must_use]
pub fn parameter(name: &str) -> Option<&'static Parameter> {
    PARAMETERS.iter().find(|parameter| parameter.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_all_different() {
        for (k, row) in PARAMETERS.iter().enumerate() {
            assert!(
                PARAMETERS[..k].iter().all(|other| other.name != row.name),
                "{}",
                row.name
            );
        }
    }

    #[test]
    fn presets_and_pairs_name_parameters() {
        for preset in PRESETS {
            for (name, _) in preset.values {
                assert!(parameter(name).is_some(), "{name}");
            }
        }
        for (first, second) in TAKEN_BACK {
            assert!(parameter(first).is_some());
            assert_eq!(
                parameter(second).map(|row| row.default),
                Some(DefaultValue::Derived)
            );
        }
    }
}
