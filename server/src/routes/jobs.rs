//! `/jobs`: one job, its attempts and its log.

use axum::Json;
use axum::extract::State;
use granary_api::id::JobId;
use granary_api::job::{JobDetail, LogLine};
use granary_api::problem::Problem;
use granary_api::table::Page;

use super::body::Id;
use crate::error::ApiError;
use crate::store::Store;

/// Everything about one job.
#[utoipa::path(get, path = "/api/v1/jobs/{job}", params(("job" = String, Path)),
    responses((status = 200, body = JobDetail), (status = 404, body = Problem)))]
pub(super) async fn read_job(
    State(store): State<Store>,
    Id(job): Id<JobId>,
) -> Result<Json<JobDetail>, ApiError> {
    Ok(Json(store.job_read(&job).await?))
}

/// What happened to it, line by line.
#[utoipa::path(get, path = "/api/v1/jobs/{job}/log", params(("job" = String, Path)),
    responses((status = 200, body = Page<LogLine>), (status = 404, body = Problem)))]
pub(super) async fn read_job_log(
    State(store): State<Store>,
    Id(job): Id<JobId>,
) -> Result<Json<Page<LogLine>>, ApiError> {
    let items = store.job_log(&job).await?;
    let total = items.len() as u64;
    Ok(Json(Page {
        items,
        next: None,
        total,
    }))
}
