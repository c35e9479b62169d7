//! `/figures`: the sweeps behind the figures of the papers.

use axum::Json;
use axum::extract::Query;
use axum::extract::rejection::QueryRejection;
use granary_api::figure::{Figure, FigureSpec};
use granary_api::table::Page;
use serde::Deserialize;
use utoipa::IntoParams;

use super::body::Id;
use crate::error::ApiError;
use crate::figures::{self, FIGURES};

/// The most packings of a figure.
const MOST_PACKINGS: u64 = 1000;

/// The size of a figure.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct Size {
    /// A preset of its model; `draft` without.
    preset: Option<String>,
    /// Packings of each combination, 1 to 1,000; one without.
    packings: Option<u64>,
}

/// The figures that there are.
#[utoipa::path(get, path = "/api/v1/figures", responses((status = 200, body = Page<Figure>)))]
pub(super) async fn list_figures() -> Json<Page<Figure>> {
    Json(Page {
        items: FIGURES.iter().map(described).collect(),
        next: None,
        total: FIGURES.len() as u64,
    })
}

/// The sweep behind one.
#[utoipa::path(get, path = "/api/v1/figures/{name}", params(("name" = String, Path), Size),
    responses((status = 200, body = FigureSpec), (status = 400), (status = 404)))]
pub(super) async fn read_figure(
    Id(name): Id<String>,
    size: Result<Query<Size>, QueryRejection>,
) -> Result<Json<FigureSpec>, ApiError> {
    let figure = figures::Figure::named(&name).ok_or_else(|| {
        ApiError::not_found(format!("there is no figure {name}: /figures lists them"))
    })?;
    let Query(size) = size.map_err(|error| ApiError::bad_request(error.body_text()))?;
    let preset = size.preset.as_deref().unwrap_or("draft");
    if !figure.has_preset(preset) {
        let presets = described(figure).presets.join(", ");
        return Err(ApiError::bad_request(format!(
            "preset={preset} is not one of {presets}"
        )));
    }
    let packings = size.packings.unwrap_or(1);
    if !(1..=MOST_PACKINGS).contains(&packings) {
        return Err(ApiError::bad_request(format!(
            "packings={packings} is not in 1 … {MOST_PACKINGS}"
        )));
    }
    Ok(Json(FigureSpec {
        figure: described(figure),
        spec: figure.json(preset, packings),
        toml: figure.spec(preset, packings),
    }))
}

fn described(figure: &figures::Figure) -> Figure {
    let presets = figure.model.presets().iter();
    Figure {
        name: figure.name.to_owned(),
        model: figure.model.name().to_owned(),
        shows: figure.shows.to_owned(),
        presets: presets.map(|preset| preset.name.to_owned()).collect(),
    }
}
