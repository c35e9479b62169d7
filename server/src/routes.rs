//! Every route in one table, which is the OpenAPI document too.

mod artifacts;
mod body;
mod events;
mod figures;
mod gate;
mod health;
mod jobs;
mod leases;
mod models;
mod points;
mod sets;
mod strict;
mod sweeps;
mod tables;

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::middleware;
use axum::routing::get;
use tokio_util::sync::CancellationToken;
use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::error::ApiError;
use crate::store::Store;

/// What every handler may see.
#[derive(Clone)]
pub(crate) struct App {
    /// The database and the files.
    pub(crate) store: Store,
    /// Ends streams and long polls.
    pub(crate) shutdown: CancellationToken,
}

impl axum::extract::FromRef<App> for Store {
    fn from_ref(app: &App) -> Self {
        app.store.clone()
    }
}

#[derive(OpenApi)]
#[openapi(info(
    title = "Granary",
    description = "Sweeps of jammed granular materials: submit, watch, read.",
    license(name = "MIT OR Apache-2.0")
))]
struct Document;

fn table() -> OpenApiRouter<App> {
    OpenApiRouter::with_openapi(Document::openapi())
        .routes(routes!(models::list_models))
        .routes(routes!(models::read_model))
        .routes(routes!(figures::list_figures))
        .routes(routes!(figures::read_figure))
        .routes(routes!(sweeps::submit_sweep, sweeps::list_sweeps))
        .routes(routes!(sweeps::read_sweep))
        .routes(routes!(sweeps::cancel_sweep))
        .routes(routes!(sweeps::pause_sweep))
        .routes(routes!(sweeps::resume_sweep))
        .routes(routes!(sweeps::retry_sweep))
        .routes(routes!(points::list_points))
        .routes(routes!(sets::list_sets))
        .routes(routes!(events::follow_sweep))
        .routes(routes!(jobs::read_job))
        .routes(routes!(jobs::read_job_log))
        .routes(routes!(leases::take_lease))
        .routes(routes!(leases::beat_lease))
        .routes(routes!(leases::complete_lease))
        .routes(routes!(leases::fail_lease))
        .routes(routes!(leases::release_lease))
        .routes(routes!(health::list_workers))
        .routes(routes!(health::is_healthy))
        .routes(routes!(health::read_metrics))
}

/// The OpenAPI document of every route.
#[must_use]
pub fn openapi() -> utoipa::openapi::OpenApi {
    let (_, document) = with_artifacts().split_for_parts();
    document
}

fn with_artifacts() -> OpenApiRouter<App> {
    // An artifact is streamed to disk and has a limit of its own.
    let artifacts = OpenApiRouter::new()
        .routes(routes!(artifacts::read_artifact, artifacts::store_artifact))
        .layer(DefaultBodyLimit::disable());
    table().merge(artifacts)
}

/// The whole service; `page` answers every path that is not the API's.
pub fn app(store: Store, shutdown: CancellationToken, page: Option<Router>) -> Router {
    let limit = store.config().body_bytes;
    let app = App { store, shutdown };
    let (routes, document) = with_artifacts().split_for_parts();
    let document = document.to_json().unwrap_or_default();
    let openapi = move || async move { health::json(document) };
    let api = routes
        .route("/api/v1/openapi.json", get(openapi))
        .route("/api/{*path}", axum::routing::any(no_route))
        .method_not_allowed_fallback(no_method)
        .with_state(app.clone());
    let all = match page {
        Some(page) => api.fallback_service(page),
        None => api.fallback(no_route),
    };
    all.layer(DefaultBodyLimit::max(limit))
        .layer(middleware::from_fn_with_state(app, gate::pass))
        .layer(middleware::from_fn(gate::record))
}

async fn no_route(uri: axum::http::Uri) -> ApiError {
    ApiError::not_found(format!("there is no route {}", uri.path()))
}

async fn no_method(method: axum::http::Method, uri: axum::http::Uri) -> ApiError {
    let status = axum::http::StatusCode::METHOD_NOT_ALLOWED;
    let detail = format!("{} does not answer to {method}", uri.path());
    ApiError::new(
        status,
        "method-not-allowed",
        "The method is not allowed",
        detail,
    )
}
