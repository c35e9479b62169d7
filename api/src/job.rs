//! Jobs as readers see them: state, attempts, what happened and why it failed.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use granary_core::identity::{ArtifactHash, ResultHash};
use granary_core::stage::StageSpec;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::id::{JobId, LeaseId, SweepId, WorkerId};
use crate::lease::Provenance;
use crate::table::Scalar;

/// Where a job stands; it is in exactly one state.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum JobState {
    /// Waits for the stage that it needs.
    Blocked,
    /// Waits for a worker.
    Ready,
    /// Held by a worker.
    Leased,
    /// Has an outcome.
    Done,
    /// The physics broke down, the machine failed too often, or what it needs has failed.
    Failed,
    /// Set aside: it outlived too many workers.
    Poisoned,
    /// Wanted by no sweep.
    Cancelled,
}

impl JobState {
    /// Every state.
    pub const ALL: [Self; 7] = [
        Self::Blocked,
        Self::Ready,
        Self::Leased,
        Self::Done,
        Self::Failed,
        Self::Poisoned,
        Self::Cancelled,
    ];

    /// The name in the database and on the wire.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Blocked => "blocked",
            Self::Ready => "ready",
            Self::Leased => "leased",
            Self::Done => "done",
            Self::Failed => "failed",
            Self::Poisoned => "poisoned",
            Self::Cancelled => "cancelled",
        }
    }

    /// Whether nothing more will happen unless somebody asks.
    #[must_use]
    pub fn is_final(self) -> bool {
        !matches!(self, Self::Blocked | Self::Ready | Self::Leased)
    }
}

impl fmt::Display for JobState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A text that names no state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JobStateError(pub String);

impl fmt::Display for JobStateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` is not a state of a job", self.0)
    }
}

impl std::error::Error for JobStateError {}

impl FromStr for JobState {
    type Err = JobStateError;

    fn from_str(text: &str) -> Result<Self, JobStateError> {
        let found = Self::ALL.into_iter().find(|state| state.name() == text);
        found.ok_or_else(|| JobStateError(text.to_owned()))
    }
}

/// Why a job failed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Failure {
    /// `stopped` (physics, final), `input` (machine), `needs` (what it needs has failed) or `poisoned`.
    pub reason: String,
    /// The whole story in one sentence.
    pub message: String,
    /// What stopped the run: `unstable`, `non_finite`, `overlap` or `not_at_rest`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kind: Option<String>,
    /// The step at which it stopped.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step: Option<u64>,
    /// What to change.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remedy: Option<String>,
    /// The failed job that this one needs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>)]
    pub job: Option<JobId>,
}

/// How far a running job is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Progress {
    /// Steps done.
    pub step: u64,
    /// Steps in all.
    pub steps: u64,
    /// Who runs it.
    pub worker: WorkerId,
    /// The worker's last word, RFC 3339.
    pub last_heartbeat: String,
}

/// One worker's try at a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Attempt {
    /// 1, 2, …
    pub attempt: u64,
    /// The lease it ran under.
    pub lease: LeaseId,
    /// Who tried.
    pub worker: WorkerId,
    /// RFC 3339.
    pub started_at: String,
    /// RFC 3339; none while it runs.
    pub ended_at: Option<String>,
    /// `done`, `failed`, `lost`, `released` or `cancelled`; none while it runs.
    pub ending: Option<String>,
    /// More about the ending.
    pub detail: Option<String>,
}

/// `GET /jobs/{id}`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct JobDetail {
    /// The job.
    #[schema(value_type = String)]
    pub job: JobId,
    /// What it computes: `kind` and `spec`.
    #[serde(flatten)]
    #[schema(value_type = Object)]
    pub spec: StageSpec,
    /// Where it stands.
    pub state: JobState,
    /// The job whose state it starts from.
    #[schema(value_type = Option<String>)]
    pub needs: Option<JobId>,
    /// Every try.
    pub attempts: Vec<Attempt>,
    /// Workers lost while running it.
    pub losses: u64,
    /// Faults of machines while running it.
    pub faults: u64,
    /// How far it is, while it runs.
    pub progress: Option<Progress>,
    /// Why it failed.
    pub failure: Option<Failure>,
    /// Scalars by name.
    pub results: BTreeMap<String, Scalar>,
    /// Files by name.
    #[schema(value_type = BTreeMap<String, String>)]
    pub artifacts: BTreeMap<String, ArtifactHash>,
    /// What a reader of the numbers should know.
    pub warnings: Vec<String>,
    /// Hash of the outcome.
    #[schema(value_type = Option<String>)]
    pub result_hash: Option<ResultHash>,
    /// Where and how it was computed.
    pub provenance: Option<Provenance>,
    /// Other results that were reported for the same stage: a bug, ours or a machine's.
    #[schema(value_type = Vec<String>)]
    pub diverged: Vec<ResultHash>,
    /// The sweeps that want it.
    pub sweeps: Vec<SweepId>,
}

/// One line of `GET /jobs/{id}/log`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LogLine {
    /// RFC 3339.
    pub at: String,
    /// What happened.
    pub message: String,
}

/// One row of `GET /workers`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WorkerRow {
    /// Its name.
    pub worker: WorkerId,
    /// `working`, `idle` or `silent` (not heard of for a minute).
    pub state: String,
    /// Release of its program.
    pub engine_version: String,
    /// Physics version of its engine.
    pub physics_version: u32,
    /// Memory that its ensembles may take \[bytes\].
    pub memory_bytes: u64,
    /// Jobs that it holds.
    pub leased: u64,
    /// Jobs that it has finished.
    pub done: u64,
    /// RFC 3339.
    pub first_seen: String,
    /// RFC 3339.
    pub last_seen: String,
}
