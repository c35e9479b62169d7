//! What studies found of the presets: `make presets` writes the files that are read here.

use granary_api::model::Measured;
use granary_api::table::SetRow;
use granary_core::model::Model;
use serde::Deserialize;

/// A study as `granary study --json` prints it.
#[derive(Deserialize)]
struct Study {
    name: String,
    items: Vec<SetRow>,
}

/// The study of a model's presets.
fn study(model: Model) -> &'static str {
    match model {
        Model::Memory => include_str!("../../docs/presets/memory.json"),
        Model::Beam => include_str!("../../docs/presets/beam.json"),
    }
}

/// What is known of a preset: a row for each processing, none if it was not studied.
///
/// # Panics
/// Never: a test reads the files.
#[must_use]
pub fn measured(model: Model, preset: &str) -> Vec<Measured> {
    let study: Study = serde_json::from_str(study(model)).expect("a study as it was printed");
    let own = format!("preset {preset}");
    let rows = study.items.into_iter();
    rows.filter(|row| row.setting.as_ref() == Some(&own))
        .map(|row| Measured {
            scene: study.name.clone(),
            processing: row.processing,
            results: row.results,
            n: row.n,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_told_of_a_preset_is_its_error_in_every_judged_number_and_its_cost() {
        let studied = |model: Model| -> Vec<&str> {
            let presets = model.presets().iter().map(|preset| preset.name);
            presets
                .filter(|preset| !measured(model, preset).is_empty())
                .collect()
        };
        assert_eq!(studied(Model::Memory), ["draft", "standard", "paper"]);
        assert_eq!(studied(Model::Beam), ["draft"]);
        for model in Model::ALL {
            for preset in studied(model) {
                for found in measured(model, preset) {
                    let errors = model.judged().iter();
                    let errors = errors.map(|judged| format!("{}_deviation", judged.name));
                    for name in errors.chain(["relative_cost".to_owned()]) {
                        assert!(found.results[&name].is_some(), "{preset}: {name}");
                    }
                }
            }
        }
    }

    /// SUB2 asks more of a preset than SUB0 does.
    #[test]
    fn presets_of_the_memory_are_measured_by_both_processings() {
        for preset in ["draft", "standard", "paper"] {
            let found = measured(Model::Memory, preset);
            let by: Vec<_> = found.iter().map(|row| row.processing.as_deref()).collect();
            assert_eq!(by, [Some("SUB0"), Some("SUB2")], "{preset}");
        }
    }
}
