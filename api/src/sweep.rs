//! Sweeps: what answers a submission, what a list shows, and what happens to one.
//!
//! The submission itself is the spec as JSON, of the same schema as the TOML file.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use crate::id::SweepId;
use crate::table::SetRow;

/// The answer to `POST /sweeps`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Submitted {
    /// The sweep; none for a dry run of a sweep that does not exist yet.
    pub sweep: Option<SweepId>,
    /// Whether this was a dry run: nothing is queued.
    pub dry_run: bool,
    /// Whether the sweep is new; an identical one is found again.
    pub created: bool,
    /// Rows of its table.
    pub points: u64,
    /// Rows that are already done.
    pub points_done: u64,
    /// The jobs it wants, helpers and preparation included.
    pub jobs: JobCounts,
    /// What the jobs that are not done will take.
    pub predicted: Prediction,
    /// What is allowed but unwise.
    pub warnings: Vec<String>,
    /// The above for people: `64 of 64 already done`.
    pub message: String,
}

/// How the jobs of a sweep relate to what the database already holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct JobCounts {
    /// Jobs in all.
    pub total: u64,
    /// Not known before, and in no archive.
    pub new: u64,
    /// Already done, for this sweep or another.
    pub done: u64,
    /// Known but not done: queued, running, failed or cancelled before.
    pub shared: u64,
}

/// Predicted cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Prediction {
    /// Time on one core \[s\].
    pub core_seconds: f64,
    /// Memory of the largest ensemble \[bytes\].
    pub memory_bytes: u64,
    /// Files that will be kept \[bytes\].
    pub storage_bytes: u64,
    /// `measured` (rates of past outcomes here), `default` (no such outcome yet) or `mixed`.
    pub basis: String,
}

/// Where a sweep stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SweepState {
    /// Some job is still to be done.
    Active,
    /// Its jobs are kept from workers.
    Paused,
    /// It wants its jobs no more.
    Cancelled,
    /// Every job has come to its end; some may have failed.
    Finished,
}

/// How many points are in which state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct PointCounts {
    /// All.
    pub total: u64,
    /// With results.
    pub done: u64,
    /// Failed or poisoned, each with its reason.
    pub failed: u64,
    /// At a worker.
    pub running: u64,
    /// Blocked or ready.
    pub waiting: u64,
    /// Wanted no more.
    pub cancelled: u64,
}

/// One row of `GET /sweeps`, and `GET /sweeps/{id}`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Sweep {
    /// The sweep.
    pub sweep: SweepId,
    /// Its name.
    pub name: String,
    /// The experiment.
    pub model: String,
    /// Named choice of numerics.
    pub preset: String,
    /// Where it stands.
    pub state: SweepState,
    /// Sweeps of higher priority are served first.
    pub priority: i64,
    /// RFC 3339.
    pub created_at: String,
    /// Its points by state.
    pub points: PointCounts,
    /// Points finished per second over the last minutes, since this server started.
    pub points_per_second: Option<f64>,
    /// Seconds to the end, at the rate of the jobs that were finished last and the present number of busy engine threads.
    pub eta_s: Option<f64>,
    /// The parameters that vary.
    pub axes: Vec<String>,
    /// What is allowed but unwise.
    pub warnings: Vec<String>,
    /// The accuracy that was asked for, if any was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Accuracy>,
    /// The spec as submitted; only when one sweep is asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Object>)]
    pub spec: Option<Value>,
}

/// The answer to `POST …/cancel`, `/pause`, `/resume` and `/retry`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Steered {
    /// Where the sweep stands now.
    pub state: SweepState,
    /// Jobs that were moved.
    pub jobs: u64,
}

/// How accurate a sweep's results must be, and what its pilot has found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Accuracy {
    /// The largest error of each result; a share of it where its `{name}_deviation` is one.
    pub targets: BTreeMap<String, f64>,
    /// The study that decides, a sweep like any other.
    pub pilot: SweepId,
    /// What it has decided; none while it runs, and no points of this sweep exist until then.
    pub choice: Option<Choice>,
}

/// The settings that a pilot has chosen, and why.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Choice {
    /// In words, such as `ramp 4500, drag 0.01`.
    pub setting: String,
    /// The parameters that were chosen; every point has them.
    #[schema(value_type = Object)]
    pub values: Map<String, Value>,
    /// What the pilot says of them, one row for each scene that it looked at: errors with their bounds, and cost.
    pub evidence: Vec<SetRow>,
    /// Core-seconds of a packing's runs in these settings over those of the reference: what was saved.
    pub relative_cost: Option<f64>,
    /// Core-seconds that the pilot took, packings and reference included.
    pub pilot_core_seconds: f64,
    /// Why it is the reference, if it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// One event of `GET /sweeps/{id}/events`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Event {
    /// Rises within a sweep; `Last-Event-ID` resumes after it.
    pub id: u64,
    /// `point`, `state` or `diverged`; `progress` is never stored.
    pub kind: String,
    /// RFC 3339.
    pub at: String,
    /// What happened.
    #[schema(value_type = Object)]
    pub data: Value,
}
