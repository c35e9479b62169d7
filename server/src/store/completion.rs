//! Completion: what ends a lease well. Outcome, state, dependants, speed and events in one transaction.

use granary_api::id::{LeaseId, ResultHash};
use granary_api::lease::{Completion, JobOutcome};
use granary_api::problem::Mistake;
use serde_json::{Value, json};

use super::event::{Wanting, event_add, event_finished, event_point};
use super::job::{self, Held};
use super::lease::{attempt_end, each_once, lease_close, lease_find};
use super::speed::speed_add;
use super::worker::worker_heard;
use super::{Store, StoreError, Writing, now_ms};

impl Store {
    /// Records outcomes, all or none; makes what needs them ready.
    pub async fn lease_complete(
        &self,
        id: LeaseId,
        completion: &Completion,
    ) -> Result<(), StoreError> {
        each_once(
            completion.outcomes.iter().map(|outcome| outcome.job),
            "outcomes",
        )?;
        self.artifacts_exist(&completion.outcomes).await?;
        hashes_agree(&completion.outcomes)?;
        let mut transaction = self.begin().await?;
        let lease = lease_find(&mut transaction, id).await?;
        let held = match lease {
            Some(lease) => job::job_held(&mut transaction, lease).await?,
            None => vec![],
        };
        let mut lost = vec![];
        let mut fresh: Vec<(&JobOutcome, &Held)> = vec![];
        for outcome in &completion.outcomes {
            match held.iter().find(|held| held.job == outcome.job) {
                Some(held) => fresh.push((outcome, held)),
                None if self.known(&mut transaction, id, outcome).await? => {}
                None => lost.push(outcome.job),
            }
        }
        if !lost.is_empty() {
            // Nothing is recorded but what a late answer says about the same stage.
            self.commit(transaction).await?;
            return Err(StoreError::LeaseLost(lost));
        }
        let Some(lease) = lease else {
            return Ok(());
        };
        let mut wanting = Wanting::new();
        for (outcome, held) in &fresh {
            self.record(&mut transaction, id, held, outcome, &mut wanting)
                .await?;
        }
        worker_heard(&mut transaction, lease, fresh.len()).await?;
        event_finished(&mut transaction, &wanting, self.config().events).await?;
        lease_close(&mut transaction, lease).await?;
        self.commit(transaction).await?;
        for (sweep, points) in wanting {
            self.inner.pace.note(sweep, points);
            for (outcome, held) in &fresh {
                if let Some(seconds) = whole_job(held, outcome, outcome.provenance.wall_s) {
                    let work = held.grain_steps as f64;
                    self.inner
                        .pace
                        .note_taken(sweep, &held.class, work, seconds);
                }
            }
        }
        let done = fresh
            .iter()
            .filter_map(|(_, held)| held.checkpoint)
            .collect();
        self.discard(done).await;
        Ok(())
    }

    /// Writes one outcome: job, attempt, dependants, speed and events.
    async fn record(
        &self,
        transaction: &mut Writing,
        lease: LeaseId,
        held: &Held,
        outcome: &JobOutcome,
        wanting: &mut Wanting,
    ) -> Result<(), StoreError> {
        outcome_add(transaction, lease, held.id, outcome).await?;
        job::job_done(transaction, held.id).await?;
        attempt_end(transaction, held.id, "done", None).await?;
        job::job_unblock(transaction, held.id).await?;
        if let Some(seconds) = whole_job(held, outcome, outcome.provenance.cpu_s) {
            speed_add(transaction, &held.class, held.grain_steps as f64 / seconds).await?;
        }
        let data = json!({"state": "done", "job": held.job});
        event_point(transaction, held.id, &data, self.config().events, wanting).await
    }

    /// Whether this very outcome was recorded under this lease before; notes one that contradicts a recorded outcome.
    async fn known(
        &self,
        transaction: &mut Writing,
        lease: LeaseId,
        outcome: &JobOutcome,
    ) -> Result<bool, StoreError> {
        const RECORDED: &str = "
            select j.id, o.lease, o.result_hash,
                   exists (select 1 from attempt a where a.job = j.id and a.lease = $2)
              from job j join outcome o on o.job = j.id where j.hash = $1";
        type Row = (i64, uuid::Uuid, Vec<u8>, bool);
        let recorded: Option<Row> = sqlx::query_as(RECORDED)
            .bind(&outcome.job.as_bytes()[..])
            .bind(lease.0)
            .fetch_optional(&mut **transaction)
            .await?;
        let Some((id, under, hash, attempted)) = recorded else {
            return Ok(false);
        };
        let hash: ResultHash = job::hash(&hash);
        if attempted && hash != outcome.result_hash {
            self.diverged(transaction, id, outcome, hash).await?;
        }
        Ok(under == lease.0 && hash == outcome.result_hash)
    }

    /// Notes a second result for a stage that has one: never overwritten, always told.
    async fn diverged(
        &self,
        transaction: &mut Writing,
        id: i64,
        outcome: &JobOutcome,
        recorded: ResultHash,
    ) -> Result<(), StoreError> {
        const WANTING: &str = "select sweep from want where job = $1";
        const NOTE: &str = "
            insert into divergence (job, result_hash, provenance, reported_at) values ($1, $2, $3, $4)
            on conflict do nothing";
        let noted = sqlx::query(NOTE)
            .bind(id)
            .bind(&outcome.result_hash.as_bytes()[..])
            .bind(json!(outcome.provenance).to_string())
            .bind(now_ms())
            .execute(&mut **transaction)
            .await?;
        if noted.rows_affected() == 0 {
            return Ok(());
        }
        tracing::error!(job.id = %outcome.job, recorded = %recorded, reported = %outcome.result_hash, "two results for one stage");
        let sweeps: Vec<i64> = sqlx::query_scalar(WANTING)
            .bind(id)
            .fetch_all(&mut **transaction)
            .await?;
        let data =
            json!({"job": outcome.job, "recorded": recorded, "reported": outcome.result_hash});
        for sweep in sweeps {
            event_add(transaction, sweep, "diverged", &data, self.config().events).await?;
        }
        Ok(())
    }
}

/// One job's share of the `seconds` of its ensemble, if they were spent on the whole of it.
///
/// A second attempt may have gone on from a checkpoint: its time says nothing.
fn whole_job(held: &Held, outcome: &JobOutcome, seconds: f64) -> Option<f64> {
    let share = seconds / f64::from(outcome.provenance.lanes.max(1));
    (held.attempts == 1 && held.grain_steps > 0 && share > 0.0).then_some(share)
}

/// Refuses outcomes that were damaged on their way, or whose worker hashes differently.
fn hashes_agree(outcomes: &[JobOutcome]) -> Result<(), StoreError> {
    let mistake = |(k, outcome): (usize, &JobOutcome)| {
        let (named, actual) = (outcome.result_hash, outcome.hash());
        (named != actual).then(|| Mistake {
            pointer: format!("/outcomes/{k}/result_hash"),
            detail: format!(
                "the outcome of {} has the hash {actual}, not {named}",
                outcome.job
            ),
        })
    };
    let mistakes: Vec<Mistake> = outcomes.iter().enumerate().filter_map(mistake).collect();
    if mistakes.is_empty() {
        Ok(())
    } else {
        Err(StoreError::ResultMismatch(mistakes))
    }
}

/// The results as tables hold them: a number that is missing has its reason beside it.
fn scalars(outcome: &JobOutcome) -> Value {
    let mut scalars = json!(outcome.results);
    for (name, reason) in &outcome.reasons {
        scalars[format!("{name}_reason")] = json!(reason);
    }
    scalars
}

pub(super) async fn outcome_add(
    transaction: &mut Writing,
    lease: LeaseId,
    job: i64,
    outcome: &JobOutcome,
) -> Result<(), StoreError> {
    const ADD: &str = "
        insert into outcome (job, lease, results, artifacts, warnings, result_hash, provenance, finished_at)
        values ($1, $2, $3, $4, $5, $6, $7, $8)";
    sqlx::query(ADD)
        .bind(job)
        .bind(lease.0)
        .bind(scalars(outcome).to_string())
        .bind(json!(outcome.artifacts).to_string())
        .bind(json!(outcome.warnings).to_string())
        .bind(&outcome.result_hash.as_bytes()[..])
        .bind(json!(outcome.provenance).to_string())
        .bind(now_ms())
        .execute(&mut **transaction)
        .await?;
    Ok(())
}
