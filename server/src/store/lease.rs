//! Leases: one worker's hold on the jobs of one ensemble, and what ends it.

use std::collections::BTreeSet;
use std::time::Duration;

use granary_api::id::{JobId, LeaseId};
use granary_api::lease::{
    Heartbeat, HeartbeatReply, JobOutcome, JobProgress, LeaseGrant, LeaseRequest, LeasedJob,
};
use granary_api::problem::Mistake;
use granary_core::PHYSICS_VERSION;
use granary_core::identity::ArtifactHash;
use granary_core::stage::StageKind;
use serde_json::Value;
use tokio::time::Instant;

use super::event::Wanting;
use super::job::{self, Abreast};
use super::worker::{worker_asks, worker_heard};
use super::{Store, StoreError, Writing, now_ms};
use crate::queue::{Ending, Verdict};

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
        changes.borrow_and_update();
        let mut ready = true;
        loop {
            // Most changes are other workers' heartbeats: only a reader looks at those.
            if ready && let Some(grant) = self.lease_take(request).await? {
                return Ok(Some(grant));
            }
            match tokio::time::timeout_at(deadline, changes.changed()).await {
                Ok(Ok(())) => ready = self.any_ready().await?,
                Ok(Err(_)) | Err(_) => return Ok(None),
            }
        }
    }

    /// Whether some job may be taken by somebody.
    async fn any_ready(&self) -> Result<bool, StoreError> {
        const READY: &str = "
            select exists (select 1 from sweep s where s.state = 'active'
                              and exists (select 1 from want w where w.sweep = s.id and w.state = 'ready'))";
        Ok(sqlx::query_scalar(READY).fetch_one(self.readers()).await?)
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
        let Some((sweep, abreast, lanes)) = urgent(&mut transaction, request).await? else {
            // Only the worker's last word has changed: nobody is woken by it.
            transaction.commit().await?;
            return Ok(None);
        };
        let id = LeaseId::new();
        let lease = lease_add(&mut transaction, id, request).await?;
        let first = job::job_take(&mut transaction, lease, abreast, Some(sweep), lanes).await?;
        let left = lanes - super::signed(first);
        if left > 0 {
            job::job_take(&mut transaction, lease, abreast, None, left).await?;
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
        const BEAT: &str = "update lease set beat = beat + 1, heard_at = $2 where id = $1";
        each_once(beat.jobs.iter().map(|progress| progress.job), "jobs")?;
        self.checkpoints_exist(&beat.jobs).await?;
        let mut transaction = self.begin().await?;
        let lease = lease_row(&mut transaction, id, &beat.jobs).await?;
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

    pub(super) async fn checkpoints_exist(&self, jobs: &[JobProgress]) -> Result<(), StoreError> {
        let hashes = jobs.iter().enumerate();
        let named =
            hashes.filter_map(|(k, job)| Some((format!("/jobs/{k}/checkpoint"), job.checkpoint?)));
        self.all_exist(named.collect()).await
    }

    pub(super) async fn artifacts_exist(&self, outcomes: &[JobOutcome]) -> Result<(), StoreError> {
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
    pub(super) async fn discard(&self, checkpoints: Vec<ArtifactHash>) {
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
) -> Result<Option<(i64, Abreast, i64)>, StoreError> {
    const SWEEPS: &str = "
        select s.id from sweep s
         where s.state = 'active' and exists (select 1 from want w where w.sweep = s.id and w.state = 'ready')
         order by s.priority desc,
                  (select count(*) from want w where w.sweep = s.id and w.state = 'leased'),
                  s.id";
    const FIRST: &str = "
        select j.ensemble, j.checkpoint_step, (select n.ensemble from job n where n.id = j.needs), e.lanes
          from want w join job j on j.id = w.job join ensemble e on e.id = j.ensemble
         where w.sweep = $1 and w.state = 'ready' and e.bytes <= $2 and e.physics = $3 ->> e.kind
         order by w.job limit 1";
    let physics = physics_by_kind(request.physics_version);
    let sweeps: Vec<i64> = sqlx::query_scalar(SWEEPS)
        .fetch_all(&mut **transaction)
        .await?;
    for sweep in sweeps {
        let first: Option<(i64, Option<i64>, Option<i64>, i64)> = sqlx::query_as(FIRST)
            .bind(sweep)
            .bind(super::signed(request.memory_bytes))
            .bind(&physics)
            .fetch_optional(&mut **transaction)
            .await?;
        if let Some((ensemble, checkpoint_step, after, lanes)) = first {
            let abreast = Abreast {
                ensemble,
                checkpoint_step,
                after,
            };
            return Ok(Some((sweep, abreast, lanes)));
        }
    }
    Ok(None)
}

/// The physics version of each kind of stage that an engine of `version` computes, as JSON.
///
/// Of an engine of another version it is known only that it computes what changed with that version; it is given no more.
fn physics_by_kind(version: u32) -> String {
    let of = |kind: StageKind| {
        let known = version == PHYSICS_VERSION;
        let physics = if known { kind.physics() } else { version };
        (kind.name().to_owned(), physics.into())
    };
    Value::Object(StageKind::ALL.into_iter().map(of).collect()).to_string()
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

pub(super) async fn lease_find(
    transaction: &mut Writing,
    id: LeaseId,
) -> Result<Option<i64>, StoreError> {
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
pub(super) async fn lease_close(transaction: &mut Writing, lease: i64) -> Result<(), StoreError> {
    const CLOSE: &str =
        "delete from lease where id = $1 and not exists (select 1 from job where lease = $1)";
    sqlx::query(CLOSE)
        .bind(lease)
        .execute(&mut **transaction)
        .await?;
    Ok(())
}

/// Notes progress; the jobs that are not under this lease, and the checkpoints that were replaced.
pub(super) async fn progress(
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

pub(super) async fn attempt_end(
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

/// Refuses a report that names a job twice.
pub(super) fn each_once(jobs: impl Iterator<Item = JobId>, list: &str) -> Result<(), StoreError> {
    let mut seen = BTreeSet::new();
    let mut mistakes = vec![];
    for (k, job) in jobs.enumerate() {
        if !seen.insert(job) {
            let pointer = format!("/{list}/{k}/job");
            mistakes.push(Mistake {
                pointer,
                detail: format!("{job} is named twice"),
            });
        }
    }
    if mistakes.is_empty() {
        Ok(())
    } else {
        Err(StoreError::Invalid(mistakes))
    }
}
