//! The server of Granary: planner, queue, store and routes.
//!
//! It plans sweeps, queues their jobs, hands them to workers and answers with tables.
//! It never steps a scene: physics is the workers' business.

mod archive;
mod config;
mod error;
pub mod figures;
mod planner;
pub mod presets;
pub mod queue;
pub mod reaper;
pub mod reduce;
mod routes;
mod serve;
mod store;
pub mod sweep;
pub mod table;

use granary_api::sweep::Submitted;
use serde_json::Value;

pub use archive::{Archive, Archived};
pub use config::Config;
pub use routes::{app, openapi};
pub use serve::{ServeError, Server, background};
pub use store::{ArtifactFile, Store, StoreError, Submission, Tokens};

/// Submits a spec as JSON, the same value that its TOML form converts to; every mistake is in the error, and nothing is queued then.
pub async fn submit(
    store: &Store,
    spec: &Value,
    submission: &Submission,
) -> Result<Submitted, StoreError> {
    let plan = sweep::Plan::read(spec, store.config().sweep).map_err(StoreError::Invalid)?;
    store.sweep_submit(&plan, submission).await
}
