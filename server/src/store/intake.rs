//! Intake: a plan becomes a sweep, its jobs and its table, in one transaction.

use std::panic::resume_unwind;

use granary_api::id::SweepId;
use granary_api::sweep::{JobCounts, Submitted};
use serde_json::{Value, json};
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

/// A sweep that is in the database already: number, id, state, and whether it waits for a pilot.
type Known = (i64, uuid::Uuid, String, bool);

/// A sweep as it stands in the database now.
struct Entered {
    sweep: i64,
    uuid: uuid::Uuid,
    created: bool,
    /// Whether its pilot has not decided yet.
    waits: bool,
    /// Jobs that were not known before, and are in no archive.
    new: u64,
}

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
        let pilot = match &plan.accuracy {
            Some(accuracy) => {
                let pilot = &accuracy.pilot;
                Some(
                    self.enter(&mut transaction, pilot, None, submission.dry_run)
                        .await?,
                )
            }
            None => None,
        };
        let of_pilot = pilot.as_ref().map(|pilot| pilot.sweep);
        let entered = self.enter(&mut transaction, plan, of_pilot, submission.dry_run);
        let entered = entered.await?;
        if let Some(key) = &submission.idempotency_key {
            key_note(&mut transaction, key, &identity, entered.sweep).await?;
        }
        let mut reply = match pilot.filter(|_| entered.waits) {
            Some(pilot) => waiting(reply(&mut transaction, pilot.sweep, pilot.new).await?, plan),
            None => reply(&mut transaction, entered.sweep, entered.new).await?,
        };
        reply.dry_run = submission.dry_run;
        reply.created = entered.created;
        let exists = !(submission.dry_run && entered.created);
        reply.sweep = exists.then_some(SweepId(entered.uuid));
        if submission.dry_run {
            transaction.rollback().await?;
        } else {
            self.commit(transaction).await?;
        }
        Ok(reply)
    }

    /// Inserts `plan` or finds it again; a plan that waits for `pilot` has no points yet.
    async fn enter(
        &self,
        transaction: &mut Writing,
        plan: &Plan,
        pilot: Option<i64>,
        dry_run: bool,
    ) -> Result<Entered, StoreError> {
        let identity = plan.identity();
        let known = find(transaction, &identity).await?;
        let created = known.is_none();
        let (sweep, uuid, waits, new) = if let Some((sweep, uuid, state, waits)) = known {
            self.take_up(transaction, sweep, &state, plan).await?;
            (sweep, uuid, waits, 0)
        } else {
            let id = SweepId::new();
            let sweep = sweep_add(transaction, plan, id, &identity, pilot).await?;
            let new = match pilot {
                Some(_) => 0,
                None => fill(transaction, plan, sweep).await?,
            };
            (sweep, id.0, pilot.is_some(), new)
        };
        let spared = self.archived_take(transaction, sweep, dry_run).await?;
        Ok(Entered {
            sweep,
            uuid,
            created,
            waits,
            new: new.saturating_sub(spared),
        })
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
    const FIND: &str = "
        select id, uuid, state, pilot is not null and choice is null from sweep where identity = $1";
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

/// Inserts the points of `plan` and all they need; how many jobs were not known before.
pub(super) async fn fill(
    transaction: &mut Writing,
    plan: &Plan,
    sweep: i64,
) -> Result<u64, StoreError> {
    const FINISH: &str = "
        update sweep set warnings = $2, points = (select sum(points) from want where sweep = $1) where id = $1";
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
    Ok(rows.new)
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
    pilot: Option<i64>,
) -> Result<i64, StoreError> {
    const ADD: &str = "
        insert into sweep (uuid, identity, name, model, preset, spec, plan, warnings, priority, state, points, created_at,
                           pilot)
        values ($1, $2, $3, $4, $5, $6, $7, '[]', $8, 'active', $9, $10, $11)";
    let added = sqlx::query(ADD)
        .bind(id.0)
        .bind(&identity[..])
        .bind(&plan.name)
        .bind(plan.model.name())
        .bind(&plan.preset)
        .bind(plan.spec.to_string())
        .bind(resolved(plan).to_string())
        .bind(plan.priority.unwrap_or(0))
        .bind(signed(plan.points))
        .bind(now_ms())
        .bind(pilot)
        .execute(&mut **transaction)
        .await?;
    Ok(added.last_insert_rowid())
}

/// What of a plan its tables need.
pub(super) fn resolved(plan: &Plan) -> Value {
    json!({"axes": plan.axes(), "fixed": plan.fixed, "reductions": plan.reductions})
}

/// The answer for a sweep that waits for its pilot, of which `reply` tells.
fn waiting(reply: Submitted, plan: &Plan) -> Submitted {
    let (done, points) = (reply.points_done, reply.points);
    Submitted {
        points: plan.points,
        points_done: 0,
        message: format!(
            "a pilot of {points} points, {done} of them done, chooses the settings of {} points first",
            plan.points
        ),
        ..reply
    }
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
