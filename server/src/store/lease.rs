//! Leases: one worker's hold on the jobs of one ensemble, and what ends it.

use std::time::Duration;

use granary_api::id::{JobId, LeaseId};
use granary_api::lease::{
    Completion, FailureReport, Heartbeat, HeartbeatReply, JobOutcome, JobProgress, LeaseGrant,
    LeaseRequest, LeasedJob, Release,
};
use granary_api::problem::Mistake;
use granary_core::identity::{ArtifactHash, ResultHash};
use serde_json::json;
use tokio::time::Instant;

use super::event::{Wanting, event_add, event_finished, event_point};
use super::job::{self, Held};
use super::speed::speed_add;
use super::worker::{worker_asks, worker_heard};
use super::{Store, StoreError, Writing, now_ms};
use crate::queue::{Ending, Verdict, verdict};

/// The longest that a request for work may wait.
const LONGEST_WAIT: Duration = Duration::from_secs(30);

impl Store {
    /// Gives a worker the jobs of one ensemble, waiting for some as long as it asked to.
    pub async fn lease_wait(
        &self,
        request: &LeaseRequest,
    ) -> Result<Option<LeaseGrant>, StoreError> {
        let wait = Duration::try_from_secs_f64(request.wait_s).unwrap_or_default();
        let deadline = Instant::now() + wait.min(LONGEST_WAIT);
        let mut changes = self.subscribe();
        loop {
            changes.borrow_and_update();
            if let Some(grant) = self.lease_take(request).await? {
                return Ok(Some(grant));
            }
            match tokio::time::timeout_at(deadline, changes.changed()).await {
                Ok(Ok(())) => {}
                Ok(Err(_)) | Err(_) => return Ok(None),
            }
        }
    }

    /// Gives a worker the ready jobs that it can run as one ensemble, most urgent first; none if there are none.
    ///
    /// One transaction, so two workers can never hold the same job.
    pub async fn lease_take(
        &self,
        request: &LeaseRequest,
    ) -> Result<Option<LeaseGrant>, StoreError> {
        let mut transaction = self.begin().await?;
        worker_asks(&mut transaction, request).await?;
        let Some((sweep, ensemble, step, lanes)) = urgent(&mut transaction, request).await? else {
            // Only the worker's last word has changed: nobody is woken by it.
            transaction.commit().await?;
            return Ok(None);
        };
        let id = LeaseId::new();
        let lease = lease_add(&mut transaction, id, request).await?;
        let key = (ensemble, step);
        let first = job::job_take(&mut transaction, lease, key, Some(sweep), lanes).await?;
        let left = lanes - first as i64;
        if left > 0 {
            job::job_take(&mut transaction, lease, key, None, left).await?;
        }
        attempts_begin(&mut transaction, lease, id, request).await?;
        let jobs = leased(&mut transaction, lease).await?;
        self.commit(transaction).await?;
        Ok(Some(LeaseGrant {
            lease: id,
            heartbeat_s: self.config().heartbeat.as_secs_f64(),
            jobs,
        }))
    }

    /// Counts a sign of life, notes progress, and names the jobs to drop.
    pub async fn lease_heartbeat(
        &self,
        id: LeaseId,
        beat: &Heartbeat,
    ) -> Result<HeartbeatReply, StoreError> {
        self.checkpoints_exist(&beat.jobs).await?;
        let mut transaction = self.begin().await?;
        let lease = lease_row(&mut transaction, id, &beat.jobs).await?;
        const BEAT: &str = "update lease set beat = beat + 1, heard_at = $2 where id = $1";
        let beaten = sqlx::query(BEAT).bind(lease).bind(now_ms());
        beaten.execute(&mut *transaction).await?;
        worker_heard(&mut transaction, lease, 0).await?;
        let (mut stop, replaced) = progress(&mut transaction, lease, &beat.jobs).await?;
        let mut wanting = Wanting::new();
        for held in job::job_held(&mut transaction, lease).await? {
            if !held.wanted {
                let cancelled = Verdict {
                    ending: "cancelled",
                    ..self.verdict(&Ending::Released, &held)
                };
                self.end(&mut transaction, &held, &cancelled, &mut wanting)
                    .await?;
                stop.push(held.job);
            }
        }
        lease_close(&mut transaction, lease).await?;
        self.commit(transaction).await?;
        self.discard(replaced).await;
        Ok(HeartbeatReply { stop })
    }

    /// Records outcomes, all or none; makes what needs them ready.
    pub async fn lease_complete(
        &self,
        id: LeaseId,
        completion: &Completion,
    ) -> Result<(), StoreError> {
        self.artifacts_exist(&completion.outcomes).await?;
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
        let done = fresh
            .iter()
            .filter_map(|(_, held)| held.checkpoint)
            .collect();
        self.discard(done).await;
        Ok(())
    }

    /// Records why jobs cannot be finished; a fault of the machine is tried again a few times.
    pub async fn lease_fail(&self, id: LeaseId, report: &FailureReport) -> Result<(), StoreError> {
        let jobs: Vec<JobId> = report.failures.iter().map(|failure| failure.job).collect();
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

    fn verdict(&self, ending: &Ending, held: &Held) -> Verdict {
        let counts = (held.losses, held.faults);
        verdict(ending, counts, held.wanted, self.config().queue)
    }

    /// Ends a job's attempt without an outcome; a failure takes with it what needs the job.
    async fn end(
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
        let seconds = outcome.provenance.cpu_s / f64::from(outcome.provenance.lanes.max(1));
        if seconds > 0.0 && held.grain_steps > 0 {
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
        const WANTING: &str = "select sweep from want where job = $1";
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

    async fn checkpoints_exist(&self, jobs: &[JobProgress]) -> Result<(), StoreError> {
        let hashes = jobs.iter().enumerate();
        let named =
            hashes.filter_map(|(k, job)| Some((format!("/jobs/{k}/checkpoint"), job.checkpoint?)));
        self.all_exist(named.collect()).await
    }

    async fn artifacts_exist(&self, outcomes: &[JobOutcome]) -> Result<(), StoreError> {
        let named = outcomes.iter().enumerate().flat_map(|(k, outcome)| {
            let place = move |name| format!("/outcomes/{k}/artifacts/{name}");
            outcome
                .artifacts
                .iter()
                .map(move |(name, hash)| (place(name), *hash))
        });
        self.all_exist(named.collect()).await
    }

    async fn all_exist(&self, named: Vec<(String, ArtifactHash)>) -> Result<(), StoreError> {
        let mut mistakes = vec![];
        for (pointer, hash) in named {
            if !self.artifact_exists(&hash).await {
                let detail = format!("there is no artifact {hash}: store it first");
                mistakes.push(Mistake { pointer, detail });
            }
        }
        if mistakes.is_empty() {
            Ok(())
        } else {
            Err(StoreError::Invalid(mistakes))
        }
    }

    /// Removes checkpoints that have been replaced.
    async fn discard(&self, checkpoints: Vec<ArtifactHash>) {
        const NAMED: &str = "select exists (select 1 from job where checkpoint = $1)";
        for hash in checkpoints {
            let named = sqlx::query_scalar(NAMED).bind(&hash.as_bytes()[..]);
            if let Ok(false) = named.fetch_one(self.readers()).await {
                self.artifact_discard(&hash).await;
            }
        }
    }
}

/// The sweep to serve first, and the ensemble of its first job that fits the worker.
async fn urgent(
    transaction: &mut Writing,
    request: &LeaseRequest,
) -> Result<Option<(i64, i64, Option<i64>, i64)>, StoreError> {
    const SWEEPS: &str = "
        select s.id from sweep s
         where s.state = 'active' and exists (select 1 from want w where w.sweep = s.id and w.state = 'ready')
         order by s.priority desc,
                  (select count(*) from want w where w.sweep = s.id and w.state = 'leased'),
                  s.id";
    const FIRST: &str = "
        select j.ensemble, j.checkpoint_step, e.lanes
          from want w join job j on j.id = w.job join ensemble e on e.id = j.ensemble
         where w.sweep = $1 and w.state = 'ready' and e.bytes <= $2 and e.physics = $3
         order by w.job limit 1";
    let sweeps: Vec<i64> = sqlx::query_scalar(SWEEPS)
        .fetch_all(&mut **transaction)
        .await?;
    for sweep in sweeps {
        let first: Option<(i64, Option<i64>, i64)> = sqlx::query_as(FIRST)
            .bind(sweep)
            .bind(super::signed(request.memory_bytes))
            .bind(request.physics_version)
            .fetch_optional(&mut **transaction)
            .await?;
        if let Some((ensemble, step, lanes)) = first {
            return Ok(Some((sweep, ensemble, step, lanes)));
        }
    }
    Ok(None)
}

async fn lease_add(
    transaction: &mut Writing,
    id: LeaseId,
    request: &LeaseRequest,
) -> Result<i64, StoreError> {
    const ADD: &str =
        "insert into lease (uuid, worker, taken_at, heard_at) values ($1, $2, $3, $3)";
    let added = sqlx::query(ADD)
        .bind(id.0)
        .bind(&request.worker.0)
        .bind(now_ms());
    Ok(added.execute(&mut **transaction).await?.last_insert_rowid())
}

async fn lease_find(transaction: &mut Writing, id: LeaseId) -> Result<Option<i64>, StoreError> {
    const FIND: &str = "select id from lease where uuid = $1";
    let found = sqlx::query_scalar(FIND).bind(id.0);
    Ok(found.fetch_optional(&mut **transaction).await?)
}

async fn lease_row(
    transaction: &mut Writing,
    id: LeaseId,
    jobs: &[JobProgress],
) -> Result<i64, StoreError> {
    let lost = || StoreError::LeaseLost(jobs.iter().map(|progress| progress.job).collect());
    lease_find(transaction, id).await?.ok_or_else(lost)
}

/// Forgets a lease that holds no job any more.
async fn lease_close(transaction: &mut Writing, lease: i64) -> Result<(), StoreError> {
    const CLOSE: &str =
        "delete from lease where id = $1 and not exists (select 1 from job where lease = $1)";
    sqlx::query(CLOSE)
        .bind(lease)
        .execute(&mut **transaction)
        .await?;
    Ok(())
}

/// Notes progress; the jobs that are not under this lease, and the checkpoints that were replaced.
async fn progress(
    transaction: &mut Writing,
    lease: i64,
    jobs: &[JobProgress],
) -> Result<(Vec<JobId>, Vec<ArtifactHash>), StoreError> {
    let before = job::job_held(transaction, lease).await?;
    let (mut strange, mut replaced) = (vec![], vec![]);
    for progress in jobs {
        let (step, checkpoint) = (
            (progress.step, progress.steps),
            progress.checkpoint.as_ref(),
        );
        if !job::job_progress(transaction, (lease, &progress.job), step, checkpoint).await? {
            strange.push(progress.job);
            continue;
        }
        let old = before.iter().find(|held| held.job == progress.job);
        let old = old.and_then(|held| held.checkpoint);
        if checkpoint.is_some() && old != progress.checkpoint {
            replaced.extend(old);
        }
    }
    Ok((strange, replaced))
}

async fn attempts_begin(
    transaction: &mut Writing,
    lease: i64,
    id: LeaseId,
    request: &LeaseRequest,
) -> Result<(), StoreError> {
    const BEGIN: &str = "
        insert into attempt (job, attempt, lease, worker, started_at)
        select id, attempts, $2, $3, $4 from job where lease = $1";
    let begin = sqlx::query(BEGIN).bind(lease).bind(id.0);
    let begin = begin.bind(&request.worker.0).bind(now_ms());
    begin.execute(&mut **transaction).await?;
    Ok(())
}

async fn attempt_end(
    transaction: &mut Writing,
    job: i64,
    ending: &str,
    detail: Option<&str>,
) -> Result<(), StoreError> {
    const END: &str = "
        update attempt set ended_at = $2, ending = $3, detail = $4
         where job = $1 and attempt = (select attempts from job where id = $1)";
    let end = sqlx::query(END)
        .bind(job)
        .bind(now_ms())
        .bind(ending)
        .bind(detail);
    end.execute(&mut **transaction).await?;
    Ok(())
}

async fn leased(transaction: &mut Writing, lease: i64) -> Result<Vec<LeasedJob>, StoreError> {
    const JOBS: &str = "
        select j.hash, j.spec, j.checkpoint,
               (select o.artifacts ->> 'state' from outcome o where o.job = j.needs)
          from job j where j.lease = $1 order by j.id";
    type Row = (Vec<u8>, String, Option<Vec<u8>>, Option<String>);
    let rows: Vec<Row> = sqlx::query_as(JOBS)
        .bind(lease)
        .fetch_all(&mut **transaction)
        .await?;
    rows.into_iter()
        .map(|(job, spec, checkpoint, input)| {
            Ok(LeasedJob {
                job: job::stage_id(&job),
                spec: serde_json::from_str(&spec).map_err(StoreError::corrupt("spec"))?,
                input: input.and_then(|hash| hash.parse().ok()),
                checkpoint: checkpoint.as_deref().map(job::hash),
            })
        })
        .collect()
}

async fn outcome_add(
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
        .bind(json!(outcome.results).to_string())
        .bind(json!(outcome.artifacts).to_string())
        .bind(json!(outcome.warnings).to_string())
        .bind(&outcome.result_hash.as_bytes()[..])
        .bind(json!(outcome.provenance).to_string())
        .bind(now_ms())
        .execute(&mut **transaction)
        .await?;
    Ok(())
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
