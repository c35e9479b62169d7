//! Figures of the papers as `/figures` tells them: sweeps to submit as they are, or with one number changed.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

/// A figure or table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Figure {
    /// What commands and paths call it.
    pub name: String,
    /// The experiment.
    pub model: String,
    /// What it shows, in a few words.
    pub shows: String,
    /// Its sizes, from a draft for a laptop to the paper's own.
    pub presets: Vec<String>,
}

/// The sweep behind a figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FigureSpec {
    /// The figure.
    pub figure: Figure,
    /// The spec, as `POST /sweeps` takes it.
    #[schema(value_type = Object)]
    pub spec: Value,
    /// The same as TOML, with its comments.
    pub toml: String,
}
