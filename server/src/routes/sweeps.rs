//! `/sweeps`: submit, list, read and steer.

use axum::extract::{Query, State};
use axum::http::{HeaderMap, StatusCode};
use granary_api::id::SweepId;
use granary_api::problem::Problem;
use granary_api::sweep::{Steered, Submitted, Sweep};
use granary_api::table::Page;
use serde::Deserialize;
use utoipa::IntoParams;

use super::body::{Id, Json};
use super::strict::Strict;
use crate::error::ApiError;
use crate::store::{Store, Submission};

/// How a sweep is submitted.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub(super) struct SubmitQuery {
    /// Count and predict, queue nothing.
    #[serde(default)]
    dry_run: bool,
}

/// Which page of the list.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub(super) struct ListQuery {
    /// The `next` of the page before.
    cursor: Option<SweepId>,
    /// Sweeps of a page, 1 to 1,000.
    limit: Option<u32>,
}

/// Submits a sweep: its spec as JSON, of the same schema as the TOML file.
#[utoipa::path(post, path = "/api/v1/sweeps", params(SubmitQuery, ("Idempotency-Key" = Option<String>, Header)),
    request_body = Object,
    responses((status = 201, body = Submitted), (status = 200, body = Submitted, description = "known, or a dry run"),
        (status = 422, body = Problem, description = "every mistake; nothing queued")))]
pub(super) async fn submit_sweep(
    State(store): State<Store>,
    query: Result<Query<SubmitQuery>, axum::extract::rejection::QueryRejection>,
    headers: HeaderMap,
    Json(Strict(spec)): Json<Strict>,
) -> Result<(StatusCode, axum::Json<Submitted>), ApiError> {
    let Query(query) = query.map_err(|error| ApiError::bad_request(error.body_text()))?;
    let submission = Submission {
        dry_run: query.dry_run,
        idempotency_key: idempotency_key(&headers)?,
    };
    let submitted = crate::submit(&store, &spec, &submission).await?;
    let queued = submitted.created && !submitted.dry_run;
    let status = if queued {
        StatusCode::CREATED
    } else {
        StatusCode::OK
    };
    Ok((status, axum::Json(submitted)))
}

fn idempotency_key(headers: &HeaderMap) -> Result<Option<String>, ApiError> {
    let Some(key) = headers.get("idempotency-key") else {
        return Ok(None);
    };
    let key = key
        .to_str()
        .ok()
        .filter(|key| (1..=200).contains(&key.len()));
    let wrong = || ApiError::bad_request("Idempotency-Key is not a text of 1 … 200 characters");
    key.map(|key| Some(key.to_owned())).ok_or_else(wrong)
}

/// Sweeps, the latest first.
#[utoipa::path(get, path = "/api/v1/sweeps", params(ListQuery), responses((status = 200, body = Page<Sweep>)))]
pub(super) async fn list_sweeps(
    State(store): State<Store>,
    query: Result<Query<ListQuery>, axum::extract::rejection::QueryRejection>,
) -> Result<axum::Json<Page<Sweep>>, ApiError> {
    let Query(query) = query.map_err(|error| ApiError::bad_request(error.body_text()))?;
    let limit = query.limit.unwrap_or(50).clamp(1, 1000);
    Ok(axum::Json(store.sweep_list(query.cursor, limit).await?))
}

/// One sweep.
#[utoipa::path(get, path = "/api/v1/sweeps/{sweep}", params(("sweep" = SweepId, Path)),
    responses((status = 200, body = Sweep), (status = 404, body = Problem)))]
pub(super) async fn read_sweep(
    State(store): State<Store>,
    Id(sweep): Id<SweepId>,
) -> Result<axum::Json<Sweep>, ApiError> {
    Ok(axum::Json(store.sweep_read(sweep).await?))
}

/// The sweep wants its jobs no more; what other sweeps want goes on.
#[utoipa::path(post, path = "/api/v1/sweeps/{sweep}/cancel", params(("sweep" = SweepId, Path)),
    responses((status = 200, body = Steered), (status = 404, body = Problem)))]
pub(super) async fn cancel_sweep(
    State(store): State<Store>,
    Id(sweep): Id<SweepId>,
) -> Result<axum::Json<Steered>, ApiError> {
    Ok(axum::Json(store.sweep_cancel(sweep).await?))
}

/// No more of its jobs are given to workers.
#[utoipa::path(post, path = "/api/v1/sweeps/{sweep}/pause", params(("sweep" = SweepId, Path)),
    responses((status = 200, body = Steered), (status = 404, body = Problem)))]
pub(super) async fn pause_sweep(
    State(store): State<Store>,
    Id(sweep): Id<SweepId>,
) -> Result<axum::Json<Steered>, ApiError> {
    Ok(axum::Json(store.sweep_pause(sweep).await?))
}

/// The sweep goes on after a pause or a cancel.
#[utoipa::path(post, path = "/api/v1/sweeps/{sweep}/resume", params(("sweep" = SweepId, Path)),
    responses((status = 200, body = Steered), (status = 404, body = Problem)))]
pub(super) async fn resume_sweep(
    State(store): State<Store>,
    Id(sweep): Id<SweepId>,
) -> Result<axum::Json<Steered>, ApiError> {
    Ok(axum::Json(store.sweep_resume(sweep).await?))
}

/// Tries again what failed by no fault of its own.
#[utoipa::path(post, path = "/api/v1/sweeps/{sweep}/retry", params(("sweep" = SweepId, Path)),
    responses((status = 200, body = Steered), (status = 404, body = Problem)))]
pub(super) async fn retry_sweep(
    State(store): State<Store>,
    Id(sweep): Id<SweepId>,
) -> Result<axum::Json<Steered>, ApiError> {
    Ok(axum::Json(store.sweep_retry(sweep).await?))
}
