//! Leases: the workers' side of the API.
//!
//! A worker asks for work, is given the jobs of one ensemble under one lease id, says every ten seconds that it lives,
//! and ends each job by completing, failing or releasing it.
//! Every answer names the lease; under another lease than the job's current one it changes nothing (409).

use std::collections::BTreeMap;

use granary_core::identity::{ArtifactHash, ResultHash, canonical_json};
use granary_core::stage::{Outcome, StageFailure, StageSpec};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::id::{JobId, LeaseId, WorkerId};

/// `POST /leases`: what the worker can do.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LeaseRequest {
    /// Who asks.
    pub worker: WorkerId,
    /// The physics version of its engine; jobs of another are never given to it.
    pub physics_version: u32,
    /// Release of the worker's program.
    pub engine_version: String,
    /// Memory that an ensemble may take \[bytes\].
    pub memory_bytes: u64,
    /// How long to wait for work before answering with none \[s\], at most 30.
    pub wait_s: f64,
}

/// The jobs of one ensemble, under one lease.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct LeaseGrant {
    /// The lease; `jobs` is never empty.
    pub lease: LeaseId,
    /// How often to send a heartbeat \[s\].
    pub heartbeat_s: f64,
    /// The jobs, all with the same ensemble key and, if they have checkpoints, at the same step.
    pub jobs: Vec<LeasedJob>,
}

/// One job of a lease.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct LeasedJob {
    /// The job.
    #[schema(value_type = String)]
    pub job: JobId,
    /// What to compute.
    #[schema(value_type = Object)]
    #[serde(flatten)]
    pub spec: StageSpec,
    /// The state that it starts from; none for `pack`. The same for every job of a lease, but for recalls that go on from encodings.
    #[schema(value_type = Option<String>)]
    pub input: Option<ArtifactHash>,
    /// The latest checkpoint of an earlier attempt.
    #[schema(value_type = Option<String>)]
    pub checkpoint: Option<ArtifactHash>,
}

/// `POST /leases/{lease}/heartbeat`: I live, and this is how far I am.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Heartbeat {
    /// Progress of each job still held.
    pub jobs: Vec<JobProgress>,
}

/// How far one job is.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct JobProgress {
    /// The job.
    #[schema(value_type = String)]
    pub job: JobId,
    /// Steps done.
    pub step: u64,
    /// Steps in all.
    pub steps: u64,
    /// The latest checkpoint, already stored as an artifact.
    #[schema(value_type = Option<String>)]
    pub checkpoint: Option<ArtifactHash>,
}

/// The answer to a heartbeat.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct HeartbeatReply {
    /// Jobs of this lease that the worker should drop: cancelled, or no longer under this lease.
    #[schema(value_type = Vec<String>)]
    pub stop: Vec<JobId>,
}

/// `POST /leases/{lease}/complete`: outcomes of some or all jobs of the lease.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Completion {
    /// One per finished job; all are recorded, or none.
    pub outcomes: Vec<JobOutcome>,
}

/// What one job yielded; its artifacts are already stored.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct JobOutcome {
    /// The job.
    #[schema(value_type = String)]
    pub job: JobId,
    /// Scalars by name.
    pub results: BTreeMap<String, Option<f64>>,
    /// Why a scalar is `null`, in one word, by the scalar's name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub reasons: BTreeMap<String, String>,
    /// Files by name.
    #[schema(value_type = BTreeMap<String, String>)]
    pub artifacts: BTreeMap<String, ArtifactHash>,
    /// What a reader of the numbers should know.
    pub warnings: Vec<String>,
    /// The hash of results, reasons, artifacts, warnings and steps, as [`granary_core::stage::Outcome::hash`] makes it.
    #[schema(value_type = String)]
    pub result_hash: ResultHash,
    /// Where and how it was computed.
    pub provenance: Provenance,
}

/// The part of an outcome that its hash covers, as `granary_core` declares it for [`granary_core::stage::Outcome`].
#[derive(Serialize)]
struct HashedOutcome<'a> {
    results: &'a BTreeMap<String, Option<f64>>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    reasons: &'a BTreeMap<String, String>,
    artifacts: &'a BTreeMap<String, ArtifactHash>,
    warnings: &'a [String],
    steps: u64,
}

impl JobOutcome {
    /// What is reported of `job`, and the files that this names; steps and hash are the outcome's.
    #[must_use]
    pub fn new(
        job: JobId,
        outcome: Outcome,
        provenance: Provenance,
    ) -> (Self, BTreeMap<ArtifactHash, Vec<u8>>) {
        let result_hash = outcome.hash();
        let (mut artifacts, mut files) = (BTreeMap::new(), BTreeMap::new());
        for (name, bytes) in outcome.artifacts {
            let hash = ArtifactHash::of_bytes(&bytes);
            artifacts.insert(name, hash);
            files.insert(hash, bytes);
        }
        let reported = Self {
            job,
            results: outcome.results,
            reasons: outcome.reasons,
            artifacts,
            warnings: outcome.warnings,
            result_hash,
            provenance: Provenance {
                steps: outcome.steps,
                ..provenance
            },
        };
        (reported, files)
    }

    /// The hash that what is reported has, whatever `result_hash` says.
    #[must_use]
    pub fn hash(&self) -> ResultHash {
        let hashed = HashedOutcome {
            results: &self.results,
            reasons: &self.reasons,
            artifacts: &self.artifacts,
            warnings: &self.warnings,
            steps: self.provenance.steps,
        };
        ResultHash::of_bytes(canonical_json(&hashed).as_bytes())
    }
}

/// Where and how an outcome was computed: kept beside it, never part of its hash.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Release of the program.
    pub engine_version: String,
    /// Physics version.
    pub physics_version: u32,
    /// Target and vector width, such as `x86_64-linux avx512`.
    pub target: String,
    /// Who computed it.
    pub worker: WorkerId,
    /// Time steps of this job.
    pub steps: u64,
    /// Jobs side by side in the ensemble.
    pub lanes: u32,
    /// Wall time of the ensemble \[s\], from this attempt's start.
    pub wall_s: f64,
    /// CPU time of the ensemble's thread \[s\].
    pub cpu_s: f64,
}

/// `POST /leases/{lease}/fail`: some jobs cannot be finished.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FailureReport {
    /// One per failed job.
    pub failures: Vec<JobFailure>,
}

/// Why one job failed.
///
/// `stopped` is final (the physics broke down); `input` is a fault of the machine and is tried again.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct JobFailure {
    /// The job.
    #[schema(value_type = String)]
    pub job: JobId,
    /// Why.
    #[schema(value_type = Object)]
    pub failure: StageFailure,
}

/// `POST /leases/{lease}/release`: hands jobs back untouched, with the latest checkpoint of each.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Release {
    /// The jobs handed back, with their progress.
    pub jobs: Vec<JobProgress>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use granary_core::stage::{Outcome, STATE};

    #[test]
    fn report_has_the_hash_of_its_outcome_also_after_the_wire() {
        let bytes = b"grains at rest".to_vec();
        let outcome = Outcome {
            results: BTreeMap::from([
                ("hold_kinetic_energy".to_owned(), Some(1.0 / 3.0 * 1e-15)),
                ("fidelity".to_owned(), None),
            ]),
            reasons: BTreeMap::from([("fidelity".to_owned(), "no_signal".to_owned())]),
            artifacts: BTreeMap::from([(STATE.to_owned(), bytes.clone())]),
            warnings: vec!["γ0 is large".to_owned()],
            steps: 1234,
        };
        let report = JobOutcome {
            job: JobId::of_bytes(b"a stage"),
            results: outcome.results.clone(),
            reasons: outcome.reasons.clone(),
            artifacts: BTreeMap::from([(STATE.to_owned(), ArtifactHash::of_bytes(&bytes))]),
            warnings: outcome.warnings.clone(),
            result_hash: outcome.hash(),
            provenance: Provenance {
                engine_version: String::new(),
                physics_version: 1,
                target: String::new(),
                worker: WorkerId("w".to_owned()),
                steps: 1234,
                lanes: 1,
                wall_s: 1.0,
                cpu_s: 1.0,
            },
        };
        let text = serde_json::to_string(&report).expect("plain data");
        let arrived: JobOutcome = serde_json::from_str(&text).expect("a report");
        assert_eq!(arrived.hash(), outcome.hash());
    }
}
