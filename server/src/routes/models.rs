//! `/models`: the parameters of an experiment, from the one table in `core`.

use axum::Json;
use granary_api::model::{Model, Preset};
use granary_api::table::Page;
use granary_core::model;
use serde_json::{Map, Value, json};

use super::body::Id;
use crate::error::ApiError;

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
    let results: Map<String, Value> = model
        .results()
        .iter()
        .map(|row| (row.name.to_owned(), row.schema()))
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

/// The reductions of a model, its usual chain first.
fn reductions(model: model::Model) -> Vec<Value> {
    let means = json!({"kind": "mean_sem", "over": ["packing_seed"]});
    match model {
        model::Model::Memory => vec![
            json!({"kind": "gain_fidelity", "over": ["waveform"], "processing": ["SUB0", "SUB2", "SUB2-BL"]}),
            means,
        ],
        model::Model::Beam => vec![
            means,
            json!({"kind": "ultimate_strength_fit", "over": ["friction_coefficient"]}),
        ],
    }
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
    }
}
