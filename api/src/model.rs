//! Experiments as `/models` describes them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

/// An experiment and its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Model {
    /// The name in a sweep's `model`.
    pub name: String,
    /// What it is, in one sentence.
    pub sentence: String,
    /// Every parameter, as the properties of a JSON Schema with `x-symbol`, `x-unit` and `x-section`.
    #[schema(value_type = Object)]
    pub parameters: Value,
    /// Every result, as the properties of a JSON Schema with `x-symbol` and `x-unit`.
    #[schema(value_type = Object)]
    pub results: Value,
    /// Named choices of numerics.
    pub presets: Vec<Preset>,
    /// Reductions that it allows, the usual chain first.
    pub reductions: Vec<Value>,
}

/// A named choice of numerics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Preset {
    /// The name in a sweep's `preset`.
    pub name: String,
    /// What it is for.
    pub sentence: String,
    /// The parameters that it sets.
    #[schema(value_type = Object)]
    pub values: Value,
    /// What it costs in accuracy and in time, as studies found on scenes that they name.
    pub measured: Vec<Measured>,
}

/// What a study found of a preset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Measured {
    /// On which scene.
    pub scene: String,
    /// How what was recalled became a signal, of a model that has several ways.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub processing: Option<String>,
    /// Deviations from the study's reference, their uncertainty and the cost, by name.
    pub results: BTreeMap<String, Option<f64>>,
    /// Packings.
    pub n: u64,
}
