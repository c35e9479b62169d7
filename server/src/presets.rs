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
fn study(model: Model) -> Option<&'static str> {
    match model {
        Model::Memory => Some(include_str!("../../docs/presets/memory.json")),
        Model::Beam => None,
    }
}

/// What is known of a preset.
///
/// # Panics
/// Never: a test reads the files.
#[must_use]
pub fn measured(model: Model, preset: &str) -> Vec<Measured> {
    let Some(text) = study(model) else {
        return vec![];
    };
    let study: Study = serde_json::from_str(text).expect("a study as it was printed");
    let own = format!("preset {preset}");
    let rows = study.items.into_iter();
    rows.filter(|row| row.setting.as_ref() == Some(&own))
        .map(|row| Measured {
            scene: study.name.clone(),
            results: row.results,
            n: row.n,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_of_a_studied_model_has_an_error_and_a_cost() {
        for model in Model::ALL
            .into_iter()
            .filter(|model| study(*model).is_some())
        {
            for preset in model.presets() {
                let found = measured(model, preset.name);
                assert!(!found.is_empty(), "{}", preset.name);
                for judged in model.judged() {
                    let error = format!("{}_deviation", judged.name);
                    assert!(found[0].results[&error].is_some(), "{}", preset.name);
                }
                assert!(
                    found[0].results["relative_cost"].is_some(),
                    "{}",
                    preset.name
                );
            }
        }
    }
}
