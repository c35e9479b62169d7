//! `/workers`, `/healthz`, `/metrics`: operations.

use std::fmt::Write;

use axum::Json;
use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use granary_api::job::WorkerRow;
use granary_api::table::Page;
use serde_json::{Value, json as object};

use crate::error::ApiError;
use crate::store::Store;

/// Every worker that was ever heard of.
#[utoipa::path(get, path = "/api/v1/workers", responses((status = 200, body = Page<WorkerRow>)))]
pub(super) async fn list_workers(
    State(store): State<Store>,
) -> Result<Json<Page<WorkerRow>>, ApiError> {
    let items = store.worker_list().await?;
    let total = items.len() as u64;
    Ok(Json(Page {
        items,
        next: None,
        total,
    }))
}

/// 200 if the database answers.
#[utoipa::path(get, path = "/api/v1/healthz", responses((status = 200)))]
pub(super) async fn is_healthy(State(store): State<Store>) -> Result<Json<Value>, ApiError> {
    store.job_counts().await?;
    Ok(Json(
        object!({"status": "ok", "version": env!("CARGO_PKG_VERSION")}),
    ))
}

/// Counts as Prometheus reads them.
#[utoipa::path(get, path = "/api/v1/metrics", responses((status = 200, content_type = "text/plain")))]
pub(super) async fn read_metrics(State(store): State<Store>) -> Result<Response, ApiError> {
    let mut text = String::from("# HELP granary_jobs Jobs by state.\n# TYPE granary_jobs gauge\n");
    for (state, count) in store.job_counts().await? {
        // Writing to a String never fails.
        let _ = writeln!(text, "granary_jobs{{state=\"{state}\"}} {count}");
    }
    let workers = store.worker_list().await?;
    text.push_str("# HELP granary_workers Workers by state.\n# TYPE granary_workers gauge\n");
    for state in ["working", "idle", "silent"] {
        let count = workers
            .iter()
            .filter(|worker| worker.state == state)
            .count();
        let _ = writeln!(text, "granary_workers{{state=\"{state}\"}} {count}");
    }
    Ok(([(header::CONTENT_TYPE, "text/plain; version=0.0.4")], text).into_response())
}

/// A ready-made JSON text.
pub(super) fn json(text: String) -> Response {
    ([(header::CONTENT_TYPE, "application/json")], text).into_response()
}
