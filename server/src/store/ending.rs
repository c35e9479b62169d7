//! Endings without an outcome: failures, jobs handed back, workers lost.

use granary_api::id::{JobId, LeaseId};
use granary_api::lease::{FailureReport, JobProgress, Release};
use serde_json::json;

use super::event::{Wanting, event_add, event_finished, event_point};
use super::job::{self, Held};
use super::lease::{attempt_end, each_once, lease_close, lease_find, progress};
use super::worker::worker_heard;
use super::{Store, StoreError, Writing};
use crate::queue::{Ending, Verdict, verdict};

impl Store {
    /// Records why jobs cannot be finished; a fault of the machine is tried again a few times.
    pub async fn lease_fail(&self, id: LeaseId, report: &FailureReport) -> Result<(), StoreError> {
        let jobs: Vec<JobId> = report.failures.iter().map(|failure| failure.job).collect();
        each_once(jobs.iter().copied(), "failures")?;
        let endings = report
            .failures
            .iter()
            .map(|failure| Ending::Failed(failure.failure.clone()));
        self.lease_end(id, &jobs, endings.collect(), &[]).await
    }

    /// Takes jobs back untouched, with their latest checkpoints.
    pub async fn lease_release(&self, id: LeaseId, release: &Release) -> Result<(), StoreError> {
        self.checkpoints_exist(&release.jobs).await?;
        let jobs: Vec<JobId> = release.jobs.iter().map(|progress| progress.job).collect();
        each_once(jobs.iter().copied(), "jobs")?;
        let endings = vec![Ending::Released; jobs.len()];
        self.lease_end(id, &jobs, endings, &release.jobs).await
    }

    /// The signs of life counted on every lease.
    pub async fn lease_beats(&self) -> Result<Vec<(LeaseId, u64)>, StoreError> {
        const BEATS: &str = "select uuid, beat from lease";
        let rows: Vec<(uuid::Uuid, i64)> = sqlx::query_as(BEATS).fetch_all(self.readers()).await?;
        Ok(rows
            .into_iter()
            .map(|(id, beat)| (LeaseId(id), beat as u64))
            .collect())
    }

    /// The leases of the workers whose names begin with `prefix`, and their counts of heartbeats.
    pub async fn lease_beats_of(&self, prefix: &str) -> Result<Vec<(LeaseId, u64)>, StoreError> {
        const BEATS: &str = "select uuid, beat from lease where substr(worker, 1, length($1)) = $1";
        let rows: Vec<(uuid::Uuid, i64)> = sqlx::query_as(BEATS)
            .bind(prefix)
            .fetch_all(self.readers())
            .await?;
        Ok(rows
            .into_iter()
            .map(|(id, beat)| (LeaseId(id), beat as u64))
            .collect())
    }

    /// Takes back a lease whose count is still `beat`; how many jobs it held.
    pub async fn lease_reap(&self, id: LeaseId, beat: u64) -> Result<usize, StoreError> {
        const STALE: &str = "select id from lease where uuid = $1 and beat = $2";
        let mut transaction = self.begin().await?;
        let stale: Option<i64> = sqlx::query_scalar(STALE)
            .bind(id.0)
            .bind(super::signed(beat))
            .fetch_optional(&mut *transaction)
            .await?;
        let Some(lease) = stale else {
            return Ok(0);
        };
        let held = job::job_held(&mut transaction, lease).await?;
        let mut wanting = Wanting::new();
        for held in &held {
            let lost = self.verdict(&Ending::Lost, held);
            self.end(&mut transaction, held, &lost, &mut wanting)
                .await?;
        }
        event_finished(&mut transaction, &wanting, self.config().events).await?;
        lease_close(&mut transaction, lease).await?;
        self.commit(transaction).await?;
        Ok(held.len())
    }

    async fn lease_end(
        &self,
        id: LeaseId,
        jobs: &[JobId],
        endings: Vec<Ending>,
        last: &[JobProgress],
    ) -> Result<(), StoreError> {
        let mut transaction = self.begin().await?;
        let Some(lease) = lease_find(&mut transaction, id).await? else {
            return Err(StoreError::LeaseLost(jobs.to_vec()));
        };
        let (_, replaced) = progress(&mut transaction, lease, last).await?;
        let held = job::job_held(&mut transaction, lease).await?;
        let strange = jobs
            .iter()
            .filter(|job| !held.iter().any(|held| held.job == **job));
        let lost: Vec<JobId> = strange.copied().collect();
        if !lost.is_empty() {
            return Err(StoreError::LeaseLost(lost));
        }
        let mut wanting = Wanting::new();
        for (job, ending) in jobs.iter().zip(&endings) {
            let found = held.iter().find(|held| held.job == *job);
            let held = found.expect("strange jobs were refused above");
            let verdict = self.verdict(ending, held);
            self.end(&mut transaction, held, &verdict, &mut wanting)
                .await?;
        }
        worker_heard(&mut transaction, lease, 0).await?;
        event_finished(&mut transaction, &wanting, self.config().events).await?;
        lease_close(&mut transaction, lease).await?;
        self.commit(transaction).await?;
        self.discard(replaced).await;
        Ok(())
    }

    pub(super) fn verdict(&self, ending: &Ending, held: &Held) -> Verdict {
        let counts = (held.losses, held.faults);
        verdict(ending, counts, held.wanted, self.config().queue)
    }

    /// Ends a job's attempt without an outcome; a failure takes with it what needs the job.
    pub(super) async fn end(
        &self,
        transaction: &mut Writing,
        held: &Held,
        verdict: &Verdict,
        wanting: &mut Wanting,
    ) -> Result<(), StoreError> {
        let keep = self.config().events;
        job::job_end(transaction, held.id, verdict).await?;
        let detail = verdict
            .failure
            .as_ref()
            .map(|failure| failure.message.clone());
        attempt_end(transaction, held.id, verdict.ending, detail.as_deref()).await?;
        let mut data = json!({"state": verdict.state, "job": held.job});
        if verdict.state.is_final()
            && let Some(failure) = &verdict.failure
        {
            data["failure"] = json!(failure);
            let dependants = job::job_fail_dependants(transaction, held, &failure.message).await?;
            data["dependants"] = json!(dependants);
            if dependants > 0 {
                event_dependants(transaction, held.id, &data, keep).await?;
            }
        }
        event_point(transaction, held.id, &data, keep, wanting).await
    }
}

/// Tells the sweeps that want what needs `job` that it failed with it: one event each, however many jobs.
async fn event_dependants(
    transaction: &mut Writing,
    job: i64,
    data: &serde_json::Value,
    keep: u32,
) -> Result<(), StoreError> {
    const WANTING: &str = "select sweep from want where job = $1";
    let sweeps: Vec<i64> = sqlx::query_scalar(WANTING)
        .bind(job)
        .fetch_all(&mut **transaction)
        .await?;
    for sweep in sweeps {
        event_add(transaction, sweep, "point", data, keep).await?;
    }
    Ok(())
}
