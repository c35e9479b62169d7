//! `/models`: the parameters of an experiment, from the one table in `core`.

use axum::Json;
use granary_api::model::{Model, Preset};
use granary_api::table::Page;
use granary_core::memory::parameters::{PARAMETERS, PRESETS};
use granary_core::memory::results::RESULTS;
use granary_core::memory::spec::MemoryPoint;
use serde_json::{Map, Value, json};

use super::body::Id;
use crate::error::ApiError;

/// The experiments that sweeps can be made of.
#[utoipa::path(get, path = "/api/v1/models", responses((status = 200, body = Page<Model>)))]
pub(super) async fn list_models() -> Json<Page<Model>> {
    Json(Page {
        items: vec![memory()],
        next: None,
        total: 1,
    })
}

/// One experiment.
#[utoipa::path(get, path = "/api/v1/models/{name}", params(("name" = String, Path)),
    responses((status = 200, body = Model), (status = 404)))]
pub(super) async fn read_model(Id(name): Id<String>) -> Result<Json<Model>, ApiError> {
    match name.as_str() {
        "memory" => Ok(Json(memory())),
        _ => Err(ApiError::not_found(format!(
            "there is no model {name}: there is memory"
        ))),
    }
}

fn memory() -> Model {
    let properties: Map<String, Value> = PARAMETERS
        .iter()
        .map(|row| (row.name.to_owned(), row.schema()))
        .collect();
    let results: Map<String, Value> = RESULTS
        .iter()
        .map(|row| (row.name.to_owned(), row.schema()))
        .collect();
    Model {
        name: "memory".to_owned(),
        sentence: "A waveform of shear is stored in a pack of grains while it is compressed, and recalled when it is released.".to_owned(),
        parameters: json!({"type": "object", "additionalProperties": false, "properties": properties}),
        results: json!({"type": "object", "properties": results}),
        presets: PRESETS.iter().map(preset).collect(),
        reductions: vec![
            json!({"kind": "gain_fidelity", "over": ["waveform"], "processing": ["SUB0", "SUB2", "SUB2-BL"]}),
            json!({"kind": "mean_sem", "over": ["packing_seed"]}),
        ],
    }
}

fn preset(preset: &granary_core::memory::parameters::Preset) -> Preset {
    let all = MemoryPoint::defaults(preset.name).unwrap_or_default();
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
