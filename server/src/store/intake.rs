//! Intake: a plan becomes a sweep, its jobs and its table, in one transaction.

use std::panic::resume_unwind;

use granary_api::id::SweepId;
use granary_api::sweep::{JobCounts, Submitted};
use serde_json::json;
use tokio::sync::mpsc;
use tokio::task::{JoinHandle, spawn_blocking};

use super::chunk::Rows;
use super::speed::speed_predict;
use super::{Store, StoreError, Writing, job, now_ms, signed};
use crate::sweep::Plan;
use crate::sweep::expansion::{Chunk, Expansion};

/// Jobs expanded and inserted at a time.
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
        let spared = self.archived_take(&mut transaction, sweep, submission.dry_run);
        let new = new.saturating_sub(spared.await?);
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
        update sweep set warnings = $2, points = (select sum(points) from want where sweep = $1) where id = $1";
    let id = SweepId::new();
    let sweep = sweep_add(transaction, plan, id, identity).await?;
    let (expanding, mut chunks) = expand(plan.clone());
    let mut rows = Rows::begin(transaction, sweep).await?;
    while let Some(chunk) = chunks.recv().await {
        rows.insert(transaction, &chunk).await?;
    }
    job::job_revive(transaction, sweep).await?;
    let warnings = expanding
        .await
        .unwrap_or_else(|panic| resume_unwind(panic.into_panic()));
    let warnings = json!(warnings).to_string();
    let finish = sqlx::query(FINISH).bind(sweep).bind(warnings);
    finish.execute(&mut **transaction).await?;
    Ok((sweep, id.0, rows.new))
}

/// Expands beside the insertion, one chunk ahead of it; the chunks, and in the end the warnings.
fn expand(plan: Plan) -> (JoinHandle<Vec<String>>, mpsc::Receiver<Chunk>) {
    let (ready, chunks) = mpsc::channel(1);
    let expanding = spawn_blocking(move || {
        let mut expansion = Expansion::new(&plan);
        while let Some(chunk) = expansion.next_chunk(CHUNK) {
            if ready.blocking_send(chunk).is_err() {
                // The insertion failed and wants no more.
                break;
            }
        }
        expansion.into_warnings()
    });
    (expanding, chunks)
}

async fn sweep_add(
    transaction: &mut Writing,
    plan: &Plan,
    id: SweepId,
    identity: &[u8; 32],
) -> Result<i64, StoreError> {
    const ADD: &str = "
        insert into sweep (uuid, identity, name, model, preset, spec, plan, warnings, priority, state, points, created_at)
        values ($1, $2, $3, $4, $5, $6, $7, '[]', $8, 'active', $9, $10)";
    let resolved = json!({"axes": plan.axes(), "fixed": plan.fixed, "reductions": plan.reductions});
    let added = sqlx::query(ADD)
        .bind(id.0)
        .bind(&identity[..])
        .bind(&plan.name)
        .bind(plan.model.name())
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

async fn reply(transaction: &mut Writing, sweep: i64, new: u64) -> Result<Submitted, StoreError> {
    const COUNTS: &str =
        "select state = 'done', count(*), sum(points) from want where sweep = $1 group by state";
    const WARNINGS: &str = "select warnings from sweep where id = $1";
    let counts = sqlx::query_as(COUNTS).bind(sweep);
    let counts: Vec<(bool, i64, i64)> = counts.fetch_all(&mut **transaction).await?;
    let (mut total, mut done, mut points, mut points_done) = (0, 0, 0, 0);
    for (is_done, jobs, of_points) in counts {
        (total, points) = (total + jobs, points + of_points);
        if is_done {
            (done, points_done) = (done + jobs, points_done + of_points);
        }
    }
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
