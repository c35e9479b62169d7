//! What a user may say about a classifier: the table of its settings, and named choices of them.

use serde_json::{Map, Value, json};

use super::ClassifierSpec;
use crate::parameter::{self, Bound, DefaultValue, Parameter, Preset, Section};

use Bound::{Closed, Open};
use DefaultValue::Integer;

/// The paper prints the number of transformations, 17,325 = 33 × 21 × 25, and neither their kinds' numbers nor their ranges
/// (docs/choices.md).
pub const PRESETS: &[Preset] = &[
    Preset {
        name: "draft",
        values: &[],
        sentence: "225 transformations of each word, learned from again and again: a minute for words of seven bits on two cores.",
    },
    Preset {
        name: "paper",
        values: &[
            ("shifts", Integer(33)),
            ("amplitudes", Integer(21)),
            ("noises", Integer(25)),
            ("epochs", Integer(2)),
        ],
        sentence: "17,325 transformations of each word, as many as in the paper.",
    },
];

/// Every setting of a classifier but its seed.
pub const SETTINGS: &[Parameter] = &[
    Parameter::integer(
        Section::Numerics,
        ("shifts", "n_u"),
        (1, 1000),
        9,
        "Shifts in u, evenly from minus to plus the largest.",
    ),
    Parameter::integer(
        Section::Numerics,
        ("amplitudes", "n_a"),
        (1, 1000),
        5,
        "Factors, evenly from 1 minus to 1 plus the largest change.",
    ),
    Parameter::integer(
        Section::Numerics,
        ("noises", "n_σ"),
        (1, 1000),
        5,
        "Draws of noise for each shift and factor.",
    ),
    Parameter::real(
        Section::Numerics,
        ("largest_shift", "Δu", ""),
        (Closed(0.0), Closed(0.2)),
        0.02,
        "The largest shift in u.",
    ),
    Parameter::real(
        Section::Numerics,
        ("largest_amplitude_change", "Δa", ""),
        (Closed(0.0), Open(1.0)),
        0.2,
        "The largest change of the factor.",
    ),
    Parameter::real(
        Section::Numerics,
        ("noise", "σ", ""),
        (Closed(0.0), Closed(10.0)),
        0.2,
        "Standard deviation of Gaussian noise, independent at every sample, in units of ⟨|J|⟩ of all words.",
    ),
    Parameter::real(
        Section::Numerics,
        ("learning_rate", "η", ""),
        (Open(0.0), Closed(1.0)),
        0.02,
        "Learning rate of stochastic gradient descent.",
    ),
    Parameter::integer(
        Section::Numerics,
        ("epochs", "n_e"),
        (1, 10_000),
        20,
        "How often every signal is learned from.",
    ),
];

/// The settings of the preset called `name`; `None` if there is no such preset.
#[must_use]
pub fn defaults(name: &str) -> Option<Map<String, Value>> {
    parameter::defaults(SETTINGS, PRESETS, name)
}

impl ClassifierSpec {
    /// The classifier of words of `bits` bits with all its settings, each already checked against the table.
    ///
    /// # Errors
    /// The rule between settings that is broken, in words.
    pub fn from_settings(
        bits: u32,
        classifier_seed: u64,
        mut settings: Map<String, Value>,
    ) -> Result<Self, String> {
        settings.insert("bits".to_owned(), json!(bits));
        settings.insert("classifier_seed".to_owned(), json!(classifier_seed));
        let spec: Self =
            serde_json::from_value(Value::Object(settings)).map_err(|error| error.to_string())?;
        spec.check().map(|()| spec)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_classifiers_and_the_paper_has_as_many_transformations() {
        for preset in PRESETS {
            let mut settings = defaults(preset.name).expect("a preset");
            for row in SETTINGS {
                let value = row.check(&settings[row.name]).expect("allowed");
                settings.insert(row.name.to_owned(), value);
            }
            let spec = ClassifierSpec::from_settings(10, 1, settings).expect("a classifier");
            if preset.name == "paper" {
                assert_eq!(spec.transformations(), 17_325);
            }
        }
    }
}
