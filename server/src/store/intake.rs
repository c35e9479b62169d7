//! Intake: a plan becomes a sweep, its jobs and its table, in one transaction.
//!
//! Rows go in by the thousand, as one JSON array per statement, so that the statements stay constant.

use granary_api::id::SweepId;
use granary_api::sweep::{JobCounts, Submitted};
use granary_core::PHYSICS_VERSION;
use granary_core::identity::canonical_json;
use serde_json::json;

use super::speed::speed_predict;
use super::{Store, StoreError, Writing, job, now_ms, signed};
use crate::sweep::Plan;
use crate::sweep::expansion::{Chunk, Expansion, NewEnsemble, NewJob, NewPoint};

/// Rows per statement.
const CHUNK: usize = 1000;

/// How a sweep is submitted.
#[derive(Clone, Debug, Default)]
pub struct Submission {
    /// Count and predict only.
    pub dry_run: bool,
    /// The client's name for this request: the same key finds the same sweep again.
    pub idempotency_key: Option<String>,
}

/// A sweep that is in the database already.
type Known = (i64, uuid::Uuid, String);

impl Store {
    /// Queues `plan`, or finds the identical sweep again; a cancelled one is taken up again.
    pub async fn sweep_submit(
        &self,
        plan: &Plan,
        submission: &Submission,
    ) -> Result<Submitted, StoreError> {
        let identity = plan.identity();
        let mut transaction = self.begin().await?;
        if let Some(key) = &submission.idempotency_key {
            key_check(&mut transaction, key, &identity).await?;
        }
        let known = find(&mut transaction, &identity).await?;
        let created = known.is_none();
        let (sweep, uuid, new) = match known {
            Some((sweep, uuid, state)) => {
                self.take_up(&mut transaction, sweep, &state, plan).await?;
                (sweep, uuid, 0)
            }
            None => insert(&mut transaction, plan, &identity).await?,
        };
        if let Some(key) = &submission.idempotency_key {
            key_note(&mut transaction, key, &identity, sweep).await?;
        }
        let mut reply = reply(&mut transaction, sweep, new).await?;
        reply.dry_run = submission.dry_run;
        reply.created = created;
        reply.sweep = (!(submission.dry_run && created)).then_some(SweepId(uuid));
        if submission.dry_run {
            transaction.rollback().await?;
        } else {
            self.commit(transaction).await?;
        }
        Ok(reply)
    }

    /// Sets the priority of a known sweep, and wants its jobs again if it was cancelled.
    async fn take_up(
        &self,
        transaction: &mut Writing,
        sweep: i64,
        state: &str,
        plan: &Plan,
    ) -> Result<(), StoreError> {
        const PRIORITY: &str = "update sweep set priority = $2 where id = $1";
        if let Some(priority) = plan.priority {
            let set = sqlx::query(PRIORITY).bind(sweep).bind(priority);
            set.execute(&mut **transaction).await?;
        }
        if state == "cancelled" {
            self.sweep_resume_in(transaction, sweep).await?;
        }
        Ok(())
    }
}

async fn find(transaction: &mut Writing, identity: &[u8; 32]) -> Result<Option<Known>, StoreError> {
    const FIND: &str = "select id, uuid, state from sweep where identity = $1";
    let find = sqlx::query_as(FIND).bind(&identity[..]);
    Ok(find.fetch_optional(&mut **transaction).await?)
}

async fn key_check(
    transaction: &mut Writing,
    key: &str,
    identity: &[u8; 32],
) -> Result<(), StoreError> {
    const KEY: &str = "select identity from idempotency where key = $1";
    let used: Option<Vec<u8>> = sqlx::query_scalar(KEY)
        .bind(key)
        .fetch_optional(&mut **transaction)
        .await?;
    match used {
        Some(used) if used != identity => Err(StoreError::KeyReused),
        _ => Ok(()),
    }
}

async fn key_note(
    transaction: &mut Writing,
    key: &str,
    identity: &[u8; 32],
    sweep: i64,
) -> Result<(), StoreError> {
    const NOTE: &str =
        "insert into idempotency (key, identity, sweep) values ($1, $2, $3) on conflict do nothing";
    let note = sqlx::query(NOTE).bind(key).bind(&identity[..]).bind(sweep);
    note.execute(&mut **transaction).await?;
    Ok(())
}

/// Inserts everything; the sweep's row, its id, and how many jobs were not known before.
async fn insert(
    transaction: &mut Writing,
    plan: &Plan,
    identity: &[u8; 32],
) -> Result<(i64, uuid::Uuid, u64), StoreError> {
    const FINISH: &str = "
        update sweep set warnings = $2, points = (select count(*) from point where sweep = $1) where id = $1";
    let id = SweepId::new();
    let sweep = sweep_add(transaction, plan, id, identity).await?;
    let mut expansion = Expansion::new(plan);
    let mut new = 0;
    while let Some(chunk) = expansion.next_chunk(CHUNK) {
        new += insert_chunk(transaction, sweep, &chunk).await?;
    }
    want_all(transaction, sweep, plan.needs_zero()).await?;
    job::job_revive(transaction, sweep).await?;
    let warnings = json!(expansion.into_warnings()).to_string();
    let finish = sqlx::query(FINISH).bind(sweep).bind(warnings);
    finish.execute(&mut **transaction).await?;
    Ok((sweep, id.0, new))
}

async fn sweep_add(
    transaction: &mut Writing,
    plan: &Plan,
    id: SweepId,
    identity: &[u8; 32],
) -> Result<i64, StoreError> {
    const ADD: &str = "
        insert into sweep (uuid, identity, name, model, preset, spec, plan, warnings, priority, state, points, created_at)
        values ($1, $2, $3, 'memory', $4, $5, $6, '[]', $7, 'active', $8, $9)";
    let resolved = json!({"axes": plan.axes(), "fixed": plan.fixed, "reductions": plan.reductions});
    let added = sqlx::query(ADD)
        .bind(id.0)
        .bind(&identity[..])
        .bind(&plan.name)
        .bind(&plan.preset)
        .bind(plan.spec.to_string())
        .bind(resolved.to_string())
        .bind(plan.priority.unwrap_or(0))
        .bind(signed(plan.points))
        .bind(now_ms())
        .execute(&mut **transaction)
        .await?;
    Ok(added.last_insert_rowid())
}

/// Inserts what is new of a chunk; how many jobs that were.
async fn insert_chunk(
    transaction: &mut Writing,
    sweep: i64,
    chunk: &Chunk,
) -> Result<u64, StoreError> {
    const ENSEMBLES: &str = "
        insert into ensemble (key, kind, class, lanes, steps, grain_steps, bytes, physics)
        select unhex(value ->> 0), value ->> 1, value ->> 2, value ->> 3, value ->> 4, value ->> 5, value ->> 6, $2
          from json_each($1) where true on conflict (key) do nothing";
    const JOBS: &str = "
        insert into job (hash, ensemble, needs, spec, state, failure)
        select unhex(v.value ->> 0), (select id from ensemble where key = unhex(v.value ->> 1)), n.id, v.value ->> 3,
               case when n.id is null or n.state = 'done' then 'ready'
                    when n.state in ('failed', 'poisoned') then 'failed' else 'blocked' end,
               case when n.state in ('failed', 'poisoned')
                    then json_object('reason', 'needs', 'message', 'the stage that it starts from has failed') end
          from json_each($1) v left join job n on n.hash = unhex(v.value ->> 2)
         where true on conflict (hash) do nothing";
    const POINTS: &str = "
        insert into point (sweep, point, job, parameters)
        select $2, value ->> 0, (select id from job where hash = unhex(value ->> 1)), value ->> 2
          from json_each($1)";
    let ensembles = rows(chunk.ensembles.iter().map(ensemble_row));
    let ensembles = sqlx::query(ENSEMBLES).bind(ensembles).bind(PHYSICS_VERSION);
    ensembles.execute(&mut **transaction).await?;
    let mut new = 0;
    // A statement sees the table as it was before it, so what is needed goes in first.
    for kind in granary_core::stage::StageKind::ALL {
        let of_kind = || chunk.jobs.iter().filter(|job| job.spec.kind() == kind);
        if of_kind().next().is_some() {
            let jobs = sqlx::query(JOBS).bind(rows(of_kind().map(job_row)));
            new += jobs.execute(&mut **transaction).await?.rows_affected();
        }
    }
    let points = rows(chunk.points.iter().map(point_row));
    let points = sqlx::query(POINTS).bind(points).bind(sweep);
    points.execute(&mut **transaction).await?;
    Ok(new)
}

/// A JSON array of rows that are JSON arrays already.
fn rows(rows: impl Iterator<Item = String>) -> String {
    let rows: Vec<String> = rows.collect();
    format!("[{}]", rows.join(","))
}

fn ensemble_row(new: &NewEnsemble) -> String {
    let work = new.work;
    let (steps, grain_steps, bytes) = (
        signed(work.steps),
        signed(work.grain_steps),
        signed(work.bytes),
    );
    let (key, kind, class, lanes) = (new.key.to_hex(), new.kind, &new.class, new.lanes);
    canonical_json(&(key, kind, class, lanes, steps, grain_steps, bytes))
}

fn job_row(new: &NewJob) -> String {
    let needs = new.spec.needs().map(|id| id.to_hex());
    canonical_json(&(
        new.id.to_hex(),
        new.ensemble.to_hex(),
        needs,
        canonical_json(&new.spec),
    ))
}

fn point_row(new: &NewPoint) -> String {
    canonical_json(&(new.point, new.job.to_hex(), &new.parameters))
}

/// Notes that the sweep wants the jobs of its points, the zero recalls beside them, and all that these need.
async fn want_all(transaction: &mut Writing, sweep: i64, zero: bool) -> Result<(), StoreError> {
    const POINTS: &str = "
        insert into want (job, sweep, state, points, first_point)
        select p.job, $1, j.state, count(*), min(p.point) from point p join job j on j.id = p.job
         where p.sweep = $1 group by p.job";
    const ZEROS: &str = "
        insert into want (job, sweep, state, points)
        select z.id, $1, z.state, 0
          from (select distinct j.ensemble from want w join job j on j.id = w.job where w.sweep = $1) used
          join ensemble e on e.id = used.ensemble join job z on z.hash = e.key
         where true on conflict do nothing";
    const NEEDS: &str = "
        insert into want (job, sweep, state, points)
        select distinct n.id, $1, n.state, 0
          from want w join job j on j.id = w.job join job n on n.id = j.needs
         where w.sweep = $1 on conflict do nothing";
    sqlx::query(POINTS)
        .bind(sweep)
        .execute(&mut **transaction)
        .await?;
    if zero {
        sqlx::query(ZEROS)
            .bind(sweep)
            .execute(&mut **transaction)
            .await?;
    }
    for _ in 0..2 {
        sqlx::query(NEEDS)
            .bind(sweep)
            .execute(&mut **transaction)
            .await?;
    }
    Ok(())
}

async fn reply(transaction: &mut Writing, sweep: i64, new: u64) -> Result<Submitted, StoreError> {
    const COUNTS: &str = "
        select count(*), coalesce(sum(state = 'done'), 0),
               coalesce(sum(points), 0), coalesce(sum(case when state = 'done' then points end), 0)
          from want where sweep = $1";
    const WARNINGS: &str = "select warnings from sweep where id = $1";
    let counts = sqlx::query_as(COUNTS).bind(sweep);
    let (total, done, points, points_done): (i64, i64, i64, i64) =
        counts.fetch_one(&mut **transaction).await?;
    let warnings: String = sqlx::query_scalar(WARNINGS)
        .bind(sweep)
        .fetch_one(&mut **transaction)
        .await?;
    let jobs = JobCounts {
        total: total as u64,
        new,
        done: done as u64,
        shared: (total - done) as u64 - new,
    };
    Ok(Submitted {
        sweep: None,
        dry_run: false,
        created: false,
        points: points as u64,
        points_done: points_done as u64,
        jobs,
        predicted: speed_predict(transaction, sweep).await?,
        warnings: serde_json::from_str(&warnings)
            .map_err(StoreError::corrupt("list of warnings"))?,
        message: format!("{points_done} of {points} already done"),
    })
}
