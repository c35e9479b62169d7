//! `/models`: the parameters of an experiment, from the one table in `core`.

use axum::Json;
use granary_api::model::{Model, Preset};
use granary_api::table::Page;
use granary_core::memory::classifier::settings::{PRESETS, SETTINGS, defaults};
use granary_core::model;
use granary_core::study::COSTS;
use serde_json::{Map, Value, json};

use super::body::Id;
use crate::error::ApiError;
use crate::presets::measured;

/// The experiments that sweeps can be made of.
#[utoipa::path(get, path = "/api/v1/models", responses((status = 200, body = Page<Model>)))]
pub(super) async fn list_models() -> Json<Page<Model>> {
    Json(Page {
        items: model::Model::ALL.into_iter().map(described).collect(),
        next: None,
        total: model::Model::ALL.len() as u64,
    })
}

/// One experiment.
#[utoipa::path(get, path = "/api/v1/models/{name}", params(("name" = String, Path)),
    responses((status = 200, body = Model), (status = 404)))]
pub(super) async fn read_model(Id(name): Id<String>) -> Result<Json<Model>, ApiError> {
    match model::Model::named(&name) {
        Some(model) => Ok(Json(described(model))),
        None => Err(ApiError::not_found(format!(
            "there is no model {name}: there are memory and beam"
        ))),
    }
}

fn described(model: model::Model) -> Model {
    let parameters = model.parameters().iter();
    let properties: Map<String, Value> = parameters
        .map(|row| (row.name.to_owned(), row.schema()))
        .collect();
    let results = model.results().iter().chain(COSTS);
    let results: Map<String, Value> = results
        .map(|row| (row.name.to_owned(), row.schema()))
        .chain(deviations(model))
        .collect();
    Model {
        name: model.name().to_owned(),
        sentence: model.sentence().to_owned(),
        parameters: json!({"type": "object", "additionalProperties": false, "properties": properties}),
        results: json!({"type": "object", "properties": results}),
        presets: model
            .presets()
            .iter()
            .map(|row| preset(model, row))
            .collect(),
        reductions: reductions(model),
    }
}

/// What a study adds to each result that it judges settings by.
fn deviations(model: model::Model) -> impl Iterator<Item = (String, Value)> {
    model.judged().iter().flat_map(move |judged| {
        let name = judged.name;
        let row = model.results().iter().find(|row| row.name == name);
        let symbol = row.map_or(name, |row| row.symbol);
        let (change, share) = if judged.relative {
            (format!("Δ{symbol}/{symbol}"), ", as a share of it")
        } else {
            (format!("Δ{symbol}"), "")
        };
        let property = |end: &str, symbol: String, sentence: String| {
            let schema = json!({"type": ["number", "null"], "description": sentence, "x-symbol": symbol, "x-unit": ""});
            (format!("{name}_deviation{end}"), schema)
        };
        let bound = "What the deviation from the reference stays below, either way, in 9 of 10 further packings";
        [
            property("", change.clone(), format!("Mean deviation from the reference on the same packings{share}.")),
            property("_bound", format!("|{change}|₉₀"), format!("{bound}{share}.")),
        ]
    })
}

/// The reductions of a model, its usual chain first.
fn reductions(model: model::Model) -> Vec<Value> {
    let means = json!({"kind": "mean_sem", "over": ["packing_seed"]});
    match model {
        model::Model::Memory => vec![
            json!({"kind": "gain_fidelity", "over": ["waveform"], "processing": ["SUB0", "SUB2", "SUB2-BL"]}),
            recognition(),
            means,
        ],
        model::Model::Beam => vec![
            means,
            json!({"kind": "ultimate_strength_fit", "over": ["friction_coefficient"]}),
        ],
    }
}

/// The reduction that asks classifiers, with their presets and the schema of their settings.
fn recognition() -> Value {
    let settings = SETTINGS.iter();
    let properties: Map<String, Value> = settings
        .map(|row| (row.name.to_owned(), row.schema()))
        .collect();
    let presets: Vec<Value> = PRESETS
        .iter()
        .map(|preset| {
            json!({"name": preset.name, "sentence": preset.sentence, "values": defaults(preset.name)})
        })
        .collect();
    json!({
        "kind": "recognition", "over": ["waveform"], "processing": ["SUB2-BL"], "classifier": "draft", "trainings": 1,
        "classifiers": {"presets": presets, "settings": {"type": "object", "properties": properties}},
    })
}

fn preset(model: model::Model, preset: &granary_core::parameter::Preset) -> Preset {
    let all = model.defaults(preset.name).unwrap_or_default();
    let set = preset
        .values
        .iter()
        .map(|(name, _)| ((*name).to_owned(), all[*name].clone()));
    Preset {
        name: preset.name.to_owned(),
        sentence: preset.sentence.to_owned(),
        values: Value::Object(set.collect()),
        measured: measured(model, preset.name),
    }
}
