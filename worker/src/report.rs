//! What became of a lease's jobs, and its way to the server.

use std::collections::BTreeMap;

use bytes::Bytes;
use granary_api::id::{ArtifactHash, LeaseId, WorkerId};
use granary_api::lease::{
    Completion, FailureReport, Heartbeat, JobFailure, JobOutcome, JobProgress, LeasedJob,
    Provenance,
};
use granary_core::PHYSICS_VERSION;
use granary_core::stage::{Outcome, StageFailure};
use serde::{Deserialize, Serialize};

use crate::backoff::Backoff;
use crate::execute::Finished;
use crate::held::Held;
use crate::lease_client::{ClientError, LeaseClient};
use crate::machine;
use crate::spool::Spool;

/// Everything to be said about the jobs of one lease.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Report {
    pub(crate) lease: LeaseId,
    pub(crate) completion: Completion,
    pub(crate) failures: FailureReport,
    /// The files that the outcomes name; the spool keeps them beside the report.
    #[serde(skip)]
    pub(crate) artifacts: BTreeMap<ArtifactHash, Bytes>,
}

impl Report {
    /// Sorts what the engine left: outcomes and failures; jobs that were interrupted or dropped are not in it.
    pub(crate) fn new(held: &Held, worker: &WorkerId, finished: Finished) -> Self {
        let mut report = Self {
            lease: held.lease,
            completion: Completion { outcomes: vec![] },
            failures: FailureReport { failures: vec![] },
            artifacts: BTreeMap::new(),
        };
        let provenance = Provenance {
            engine_version: env!("CARGO_PKG_VERSION").to_owned(),
            physics_version: PHYSICS_VERSION,
            target: machine::target(),
            worker: worker.clone(),
            steps: 0,
            lanes: held.jobs.len() as u32,
            wall_s: finished.wall.as_secs_f64(),
            cpu_s: finished.cpu.as_secs_f64(),
        };
        for (index, (job, result)) in held.jobs.iter().zip(finished.results).enumerate() {
            match result {
                _ if !held.wants(index) => {}
                Ok(outcome) => report.add_outcome(job, outcome, &provenance),
                Err(StageFailure::Interrupted { .. }) => {}
                Err(failure) => report.failures.failures.push(JobFailure {
                    job: job.job,
                    failure,
                }),
            }
        }
        report
    }

    fn add_outcome(&mut self, job: &LeasedJob, outcome: Outcome, provenance: &Provenance) {
        let provenance = Provenance {
            physics_version: job.spec.kind().physics(),
            ..provenance.clone()
        };
        let (outcome, files) = JobOutcome::new(job.job, outcome, provenance);
        let files = files.into_iter();
        self.artifacts
            .extend(files.map(|(hash, bytes)| (hash, Bytes::from(bytes))));
        self.completion.outcomes.push(outcome);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.completion.outcomes.is_empty() && self.failures.failures.is_empty()
    }

    /// Says everything that has not been said yet.
    async fn send<C: LeaseClient>(&mut self, client: &C) -> Result<(), ClientError> {
        while let Some((hash, bytes)) = self.artifacts.first_key_value() {
            client.artifact_put(*hash, bytes.clone()).await?;
            self.artifacts.pop_first();
        }
        if !self.completion.outcomes.is_empty() {
            self.complete(client).await?;
            self.completion.outcomes.clear();
        }
        if !self.failures.failures.is_empty() {
            client.fail(self.lease, &self.failures).await?;
            self.failures.failures.clear();
        }
        Ok(())
    }

    /// Completes; where some jobs were lost on the way, the others are reported without them.
    async fn complete<C: LeaseClient>(&mut self, client: &C) -> Result<(), ClientError> {
        let answer = client.complete(self.lease, &self.completion).await;
        if !matches!(answer, Err(ClientError::LeaseLost)) || self.completion.outcomes.len() < 2 {
            return answer;
        }
        let jobs = self.completion.outcomes.iter().map(|outcome| JobProgress {
            job: outcome.job,
            step: outcome.provenance.steps,
            steps: outcome.provenance.steps,
            checkpoint: None,
        });
        let heartbeat = Heartbeat {
            jobs: jobs.collect(),
        };
        let stop = client.heartbeat(self.lease, &heartbeat).await?.stop;
        self.completion
            .outcomes
            .retain(|outcome| !stop.contains(&outcome.job));
        if stop.is_empty() || self.completion.outcomes.is_empty() {
            return Err(ClientError::LeaseLost);
        }
        client.complete(self.lease, &self.completion).await
    }
}

/// Brings `report` to the server, however long that takes; from the first failure on it is also in `spool`.
///
/// # Errors
/// If the server does not want it.
pub(crate) async fn deliver<C: LeaseClient>(
    client: &C,
    spool: &Spool,
    mut report: Report,
) -> Result<(), ClientError> {
    let mut backoff = Backoff::new();
    let lease = report.lease;
    loop {
        match report.send(client).await {
            Err(error) if error.is_retryable() => {
                tracing::warn!(error = %error, "report not delivered, will try again");
                spool.keep(&report).await;
                backoff.wait().await;
            }
            answer => {
                spool.forget(lease).await;
                return answer;
            }
        }
    }
}
