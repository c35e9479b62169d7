//! `/leases`: the workers' side.

use axum::extract::State;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use granary_api::id::LeaseId;
use granary_api::lease::{
    Completion, FailureReport, Heartbeat, HeartbeatReply, LeaseGrant, LeaseRequest, Release,
};
use granary_api::problem::{Mistake, Problem};

use super::App;
use super::body::{Id, Json};
use crate::error::ApiError;
use crate::store::{Store, StoreError};

/// Gives a worker the jobs of one ensemble, or 204 if there were none for as long as it would wait.
#[utoipa::path(post, path = "/api/v1/leases", request_body = LeaseRequest,
    responses((status = 200, body = LeaseGrant), (status = 204, description = "no work")))]
pub(super) async fn take_lease(
    State(app): State<App>,
    Json(request): Json<LeaseRequest>,
) -> Result<Response, ApiError> {
    let length = request.worker.0.chars().count();
    if !(1..=200).contains(&length) {
        let detail = format!("a name of {length} characters is not one of 1 … 200");
        let pointer = "/worker".to_owned();
        return Err(StoreError::Invalid(vec![Mistake { pointer, detail }]).into());
    }
    let grant = tokio::select! {
        grant = app.store.lease_wait(&request) => grant?,
        () = app.shutdown.cancelled() => None,
    };
    Ok(match grant {
        Some(grant) => axum::Json(grant).into_response(),
        None => StatusCode::NO_CONTENT.into_response(),
    })
}

/// A sign of life, with progress; answers which jobs to drop.
#[utoipa::path(post, path = "/api/v1/leases/{lease}/heartbeat", params(("lease" = LeaseId, Path)),
    request_body = Heartbeat, responses((status = 200, body = HeartbeatReply), (status = 409, body = Problem)))]
pub(super) async fn beat_lease(
    State(store): State<Store>,
    Id(lease): Id<LeaseId>,
    Json(beat): Json<Heartbeat>,
) -> Result<axum::Json<HeartbeatReply>, ApiError> {
    Ok(axum::Json(store.lease_heartbeat(lease, &beat).await?))
}

/// Records the outcomes of leased jobs, all or none; 409 `lease_lost` if the lease of one is another.
///
/// 422 `result-mismatch` if an outcome does not have its `result_hash`: the server computes it again.
#[utoipa::path(post, path = "/api/v1/leases/{lease}/complete", params(("lease" = LeaseId, Path)),
    request_body = Completion, responses((status = 204), (status = 409, body = Problem), (status = 422, body = Problem)))]
pub(super) async fn complete_lease(
    State(store): State<Store>,
    Id(lease): Id<LeaseId>,
    Json(completion): Json<Completion>,
) -> Result<StatusCode, ApiError> {
    store.lease_complete(lease, &completion).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Records why jobs cannot be finished.
#[utoipa::path(post, path = "/api/v1/leases/{lease}/fail", params(("lease" = LeaseId, Path)),
    request_body = FailureReport, responses((status = 204), (status = 409, body = Problem)))]
pub(super) async fn fail_lease(
    State(store): State<Store>,
    Id(lease): Id<LeaseId>,
    Json(report): Json<FailureReport>,
) -> Result<StatusCode, ApiError> {
    store.lease_fail(lease, &report).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Takes jobs back untouched, with their latest checkpoints.
#[utoipa::path(post, path = "/api/v1/leases/{lease}/release", params(("lease" = LeaseId, Path)),
    request_body = Release, responses((status = 204), (status = 409, body = Problem)))]
pub(super) async fn release_lease(
    State(store): State<Store>,
    Id(lease): Id<LeaseId>,
    Json(release): Json<Release>,
) -> Result<StatusCode, ApiError> {
    store.lease_release(lease, &release).await?;
    Ok(StatusCode::NO_CONTENT)
}
