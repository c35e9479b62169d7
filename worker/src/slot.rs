//! One slot: an engine thread, and the lease that it works on.

use std::sync::Arc;
use std::time::Duration;

use anyhow::Context;
use granary_api::id::{JobId, WorkerId};
use granary_api::lease::{LeaseGrant, LeaseRequest, Release};
use granary_core::PHYSICS_VERSION;
use granary_core::model::Model;
use granary_core::stage::StageFailure;
use tokio::sync::Semaphore;
use tokio_util::sync::CancellationToken;
use tracing::Instrument;

use crate::backoff::{Backoff, persist};
use crate::checkpoint;
use crate::config::Config;
use crate::execute::{self, Engine, Finished, Running};
use crate::held::{Held, Word};
use crate::lease_client::{ClientError, LeaseClient};
use crate::report::{Report, deliver};
use crate::spool::Spool;

/// The wait after a heartbeat that got no answer.
const MISSED: Duration = Duration::from_secs(2);

/// How the work on a lease ended.
#[derive(Debug, PartialEq, Eq)]
enum End {
    /// Everything was said.
    Reported,
    /// The machine is at fault: give it time before the next try.
    MachineFault,
}

/// One engine thread and the lease that it works on.
pub(crate) struct Slot<C> {
    pub(crate) client: C,
    pub(crate) engine: Engine,
    pub(crate) worker: WorkerId,
    pub(crate) config: Config,
    pub(crate) shutdown: CancellationToken,
    pub(crate) spool: Spool,
    /// Held by the engine thread while it lives, so that a slot never runs two.
    pub(crate) thread: Arc<Semaphore>,
}

impl<C: LeaseClient> Slot<C> {
    pub(crate) async fn run(self) -> anyhow::Result<()> {
        let mut faults = Backoff::new();
        while !self.shutdown.is_cancelled() {
            let grant = tokio::select! {
                biased;
                () = self.shutdown.cancelled() => break,
                grant = persist(|| self.take()) => grant.context("the server gives this worker no work")?,
            };
            let Some(grant) = grant else { continue };
            if self.work_on(grant).await == End::Reported {
                faults = Backoff::new();
            } else {
                tokio::select! {
                    () = self.shutdown.cancelled() => {}
                    () = faults.wait() => {}
                }
            }
        }
        // The engine looks up every hundred steps, so its thread ends soon after the word to stop.
        let _ = self.thread.acquire().await;
        Ok(())
    }

    async fn take(&self) -> Result<Option<LeaseGrant>, ClientError> {
        let request = LeaseRequest {
            worker: self.worker.clone(),
            physics_version: PHYSICS_VERSION,
            engine_version: env!("CARGO_PKG_VERSION").to_owned(),
            memory_bytes: self.config.memory_bytes,
            wait_s: self.config.poll.as_secs_f64(),
        };
        self.client.take(&request).await
    }

    /// Works on a lease until it is reported, lost or handed back.
    async fn work_on(&self, grant: LeaseGrant) -> End {
        let Some(first) = grant.jobs.first() else {
            return End::MachineFault;
        };
        let span = tracing::info_span!(
            "job",
            job.id = %first.job,
            lease.id = %grant.lease,
            model = Model::of(first.spec.kind()).name(),
            kind = first.spec.kind().name(),
            lanes = grant.jobs.len(),
        );
        let held = Held::new(grant);
        async {
            let end = tokio::select! {
                () = self.keep(&held) => {
                    tracing::info!("lease lost or jobs cancelled");
                    End::Reported
                }
                end = self.process(&held) => end,
            };
            held.signals.say(Word::Drop);
            end
        }
        .instrument(span)
        .await
    }

    /// Heartbeats; returns when the server wants no job of the lease any more.
    async fn keep(&self, held: &Held) {
        let mut pause = held.heartbeat;
        loop {
            tokio::time::sleep(pause).await;
            pause = held.heartbeat;
            match self.client.heartbeat(held.lease, &held.beat()).await {
                Ok(reply) if held.drop_jobs(&reply.stop) => {}
                Ok(_) | Err(ClientError::LeaseLost) => return,
                // A server that comes back gives every lease a full term, which must not be slept away.
                Err(error) if error.is_retryable() => pause = held.heartbeat.min(MISSED),
                Err(error) => {
                    tracing::warn!(error = %error, "heartbeat refused");
                    return;
                }
            }
        }
    }

    /// Fetches, computes, reports, and hands back what was interrupted.
    async fn process(&self, held: &Held) -> End {
        let finished = match self.compute(held).await {
            Ok(finished) => finished,
            Err(detail) => Finished {
                results: execute::all_failed(held.jobs.len(), &detail),
                wall: Duration::ZERO,
                cpu: Duration::ZERO,
            },
        };
        let fault = |r: &execute::StageResult| matches!(r, Err(StageFailure::Input { .. }));
        let end = if finished.results.iter().any(fault) {
            End::MachineFault
        } else {
            End::Reported
        };
        let interrupted: Vec<_> = held
            .jobs
            .iter()
            .zip(&finished.results)
            .filter(|(_, result)| matches!(result, Err(StageFailure::Interrupted { .. })))
            .map(|(job, _)| job.job)
            .collect();
        let report = Report::new(held, &self.worker, finished);
        if !report.is_empty()
            && let Err(error) = deliver(&self.client, &self.spool, report).await
        {
            tracing::warn!(error = %error, "report not wanted");
        }
        self.release(held, &interrupted).await;
        end
    }

    /// What the engine makes of the lease; the error says why it could not even start.
    async fn compute(&self, held: &Held) -> Result<Finished, String> {
        let inputs = tokio::select! {
            inputs = checkpoint::fetch(&self.client, held) => inputs.map_err(|e| e.to_string())?,
            () = self.shutdown.cancelled() => return Ok(untouched(held)),
        };
        let thread = Arc::clone(&self.thread).acquire_owned().await;
        let thread = thread.map_err(|e| e.to_string())?;
        let mut running = execute::start(
            Arc::clone(&self.engine),
            inputs,
            Arc::clone(&held.signals),
            (self.config.checkpoint_every, self.config.archive.clone()),
            thread,
        )
        .map_err(|error| format!("no engine thread: {error}"))?;
        let finished = self.follow(held, &mut running).await?;
        if finished.results.len() == held.jobs.len() {
            Ok(finished)
        } else {
            Err("the engine answered for another number of jobs".to_owned())
        }
    }

    /// Stores checkpoints as they come, until the engine is done or has been told to stop and did.
    async fn follow(&self, held: &Held, running: &mut Running) -> Result<Finished, String> {
        let mut stopping = false;
        let finished = loop {
            tokio::select! {
                biased;
                finished = &mut running.finished => {
                    break finished.map_err(|_| "the engine thread died".to_owned())?;
                }
                () = self.shutdown.cancelled(), if !stopping => {
                    stopping = true;
                    held.signals.say(Word::HandBack);
                }
                Ok(()) = running.checkpoints.changed(), if !stopping => {
                    let latest = running.checkpoints.borrow_and_update().clone();
                    let stored = tokio::select! {
                        stored = checkpoint::store(&self.client, held, &latest) => stored,
                        () = self.shutdown.cancelled() => Ok(()),
                    };
                    if let Err(error) = stored {
                        tracing::warn!(error = %error, "checkpoint not stored, the next one may be");
                    }
                }
            }
        };
        let latest = running.checkpoints.borrow_and_update().clone();
        if stopping && !latest.is_empty() {
            let stored = persist(|| checkpoint::store(&self.client, held, &latest)).await;
            if let Err(error) = stored {
                tracing::warn!(error = %error, "last checkpoint not stored");
            }
        } else if !stopping {
            return Ok(unasked_interruptions_are_faults(finished));
        }
        Ok(finished)
    }

    /// Hands `jobs` back, with their latest checkpoints.
    async fn release(&self, held: &Held, jobs: &[JobId]) {
        let mut progress = held.progress();
        progress.retain(|progress| jobs.contains(&progress.job));
        if progress.is_empty() {
            return;
        }
        let release = Release { jobs: progress };
        match persist(|| self.client.release(held.lease, &release)).await {
            Ok(()) => tracing::info!("jobs handed back"),
            Err(error) => tracing::warn!(error = %error, "jobs not handed back"),
        }
    }
}

/// A lease that was interrupted before its first step.
fn untouched(held: &Held) -> Finished {
    Finished {
        results: vec![Err(StageFailure::Interrupted { step: 0 }); held.jobs.len()],
        wall: Duration::ZERO,
        cpu: Duration::ZERO,
    }
}

/// An engine that stops though nobody asked would be given the same jobs for ever; let the server count it.
fn unasked_interruptions_are_faults(mut finished: Finished) -> Finished {
    for result in &mut finished.results {
        if let Err(StageFailure::Interrupted { step }) = result {
            *result = Err(StageFailure::Input {
                detail: format!("the engine stopped unasked at step {step}"),
            });
        }
    }
    finished
}
