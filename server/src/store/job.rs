//! Jobs: the only place that writes a job's state, one statement per move that `queue` allows.

use granary_api::id::JobId;
use granary_api::job::{Failure, JobState};
use granary_core::identity::{ArtifactHash, StageId};

use super::bulk::insert_all;
use super::{StoreError, Writing};
use crate::queue::{Verdict, needs_failed};

/// A job under a lease.
pub(super) struct Held {
    pub(super) id: i64,
    pub(super) job: JobId,
    pub(super) kind: String,
    pub(super) class: String,
    pub(super) grain_steps: i64,
    pub(super) attempts: i64,
    pub(super) losses: u64,
    pub(super) faults: u64,
    pub(super) checkpoint: Option<ArtifactHash>,
    pub(super) wanted: bool,
}

/// A job that is new.
pub(super) struct NewRow {
    pub(super) id: i64,
    pub(super) hash: StageId,
    pub(super) ensemble: i64,
    pub(super) needs: Option<i64>,
    pub(super) state: JobState,
    pub(super) spec: String,
}

/// A hash column as the type that it holds.
pub(super) fn stage_id(bytes: &[u8]) -> StageId {
    hash(bytes)
}

/// A 32-byte column as any of our hashes.
pub(super) fn hash<T: std::str::FromStr<Err = granary_core::identity::HashError>>(
    bytes: &[u8],
) -> T {
    let mut fixed = [0; 32];
    let length = bytes.len().min(32);
    fixed[..length].copy_from_slice(&bytes[..length]);
    let text = format!("b3:{}", blake3::Hash::from_bytes(fixed).to_hex());
    text.parse().expect("64 hexadecimal digits are a hash")
}

/// Inserts jobs that are not known yet, each after the one it needs; one whose need has failed begins as failed.
pub(super) async fn job_add(transaction: &mut Writing, rows: &[NewRow]) -> Result<(), StoreError> {
    const ADD: &str = "insert into job (id, hash, ensemble, needs, state, spec, failure) ";
    const FAILED: &str =
        r#"{"reason":"needs","message":"the stage that it starts from has failed"}"#;
    insert_all(transaction, (ADD, ""), rows, |row, new| {
        let failure = (new.state == JobState::Failed).then_some(FAILED);
        row.push_bind(new.id).push_bind(&new.hash.as_bytes()[..]);
        row.push_bind(new.ensemble).push_bind(new.needs);
        row.push_bind(new.state.name()).push_bind(new.spec.as_str());
        row.push_bind(failure);
    })
    .await
}

/// The jobs of the lease with row `lease`.
pub(super) async fn job_held(
    transaction: &mut Writing,
    lease: i64,
) -> Result<Vec<Held>, StoreError> {
    const HELD: &str = "
        select j.id, j.hash, e.kind, e.class, e.grain_steps, j.attempts, j.losses, j.faults, j.checkpoint,
               exists (select 1 from want w join sweep s on s.id = w.sweep
                        where w.job = j.id and s.state <> 'cancelled')
          from job j join ensemble e on e.id = j.ensemble
         where j.lease = $1 order by j.id";
    type Row = (
        i64,
        Vec<u8>,
        String,
        String,
        i64,
        i64,
        i64,
        i64,
        Option<Vec<u8>>,
        bool,
    );
    let rows: Vec<Row> = sqlx::query_as(HELD)
        .bind(lease)
        .fetch_all(&mut **transaction)
        .await?;
    let held =
        |(id, job, kind, class, grain_steps, attempts, losses, faults, checkpoint, wanted): Row| {
            Held {
                id,
                job: stage_id(&job),
                kind,
                class,
                grain_steps,
                attempts,
                losses: losses as u64,
                faults: faults as u64,
                checkpoint: checkpoint.as_deref().map(hash),
                wanted,
            }
        };
    Ok(rows.into_iter().map(held).collect())
}

/// Jobs that can run side by side.
#[derive(Clone, Copy)]
pub(super) struct Abreast {
    pub(super) ensemble: i64,
    /// The step that they go on from, if they have checkpoints.
    pub(super) checkpoint_step: Option<i64>,
    /// The ensemble of what they need: some go on from encodings, which end at a step of their own.
    pub(super) after: Option<i64>,
}

/// ready → leased, for at most `lanes` jobs of those `abreast` that `sweep` wants; with none, any active sweep.
pub(super) async fn job_take(
    transaction: &mut Writing,
    lease: i64,
    abreast: Abreast,
    sweep: Option<i64>,
    lanes: i64,
) -> Result<u64, StoreError> {
    const TAKE: &str = "
        update job
           set state = 'leased', lease = $1, attempts = attempts + 1, step = coalesce(checkpoint_step, 0)
         where id in (select j.id from job j
                       where j.state = 'ready' and j.ensemble = $2 and j.checkpoint_step is $3
                         and (select n.ensemble from job n where n.id = j.needs) is $6
                         and exists (select 1 from want w join sweep s on s.id = w.sweep
                                      where w.job = j.id and s.state = 'active' and ($4 is null or s.id = $4))
                       order by j.id limit $5)";
    let take = sqlx::query(TAKE)
        .bind(lease)
        .bind(abreast.ensemble)
        .bind(abreast.checkpoint_step);
    let taken = take
        .bind(sweep)
        .bind(lanes)
        .bind(abreast.after)
        .execute(&mut **transaction)
        .await?;
    Ok(taken.rows_affected())
}

/// Notes how far a leased job is.
pub(super) async fn job_progress(
    transaction: &mut Writing,
    (lease, job): (i64, &JobId),
    (step, steps): (u64, u64),
    checkpoint: Option<&ArtifactHash>,
) -> Result<bool, StoreError> {
    const PROGRESS: &str = "
        update job
           set step = $3, steps = $4,
               checkpoint_step = case when $5 is null or $5 = checkpoint then checkpoint_step else $3 end,
               checkpoint = coalesce($5, checkpoint)
         where lease = $1 and hash = $2";
    let progress = sqlx::query(PROGRESS)
        .bind(lease)
        .bind(&job.as_bytes()[..])
        .bind(super::signed(step))
        .bind(super::signed(steps))
        .bind(checkpoint.map(|hash| hash.as_bytes().to_vec()))
        .execute(&mut **transaction)
        .await?;
    Ok(progress.rows_affected() == 1)
}

/// leased → done; or blocked, ready → done, for an archived outcome.
pub(super) async fn job_done(transaction: &mut Writing, id: i64) -> Result<(), StoreError> {
    const DONE: &str = "
        update job set state = 'done', lease = null, checkpoint = null, checkpoint_step = null where id = $1";
    sqlx::query(DONE)
        .bind(id)
        .execute(&mut **transaction)
        .await?;
    Ok(())
}

/// leased → whatever the verdict says; a fault of the machine forgets the checkpoint, which may be its cause.
pub(super) async fn job_end(
    transaction: &mut Writing,
    id: i64,
    verdict: &Verdict,
) -> Result<(), StoreError> {
    const END: &str = "
        update job
           set state = $2, lease = null, losses = losses + $3, faults = faults + $4, failure = $5,
               checkpoint = case when $4 > 0 then null else checkpoint end,
               checkpoint_step = case when $4 > 0 then null else checkpoint_step end
         where id = $1";
    let kept = verdict
        .failure
        .as_ref()
        .filter(|_| matches!(verdict.state.name(), "failed" | "poisoned"));
    sqlx::query(END)
        .bind(id)
        .bind(verdict.state.name())
        .bind(super::signed(verdict.losses))
        .bind(super::signed(verdict.faults))
        .bind(kept.map(failure_json))
        .execute(&mut **transaction)
        .await?;
    Ok(())
}

fn failure_json(failure: &Failure) -> String {
    serde_json::to_string(failure).expect("a failure is plain data")
}

/// blocked → ready, for all that need `id`, which is done.
pub(super) async fn job_unblock(transaction: &mut Writing, id: i64) -> Result<(), StoreError> {
    const UNBLOCK: &str = "update job set state = 'ready' where needs = $1 and state = 'blocked'";
    sqlx::query(UNBLOCK)
        .bind(id)
        .execute(&mut **transaction)
        .await?;
    Ok(())
}

/// blocked → failed, for all that need `held`, which has failed, and for all that need those; how many.
pub(super) async fn job_fail_dependants(
    transaction: &mut Writing,
    held: &Held,
    cause: &str,
) -> Result<u64, StoreError> {
    const FAIL: &str = "
        with recursive below (id) as (
            select id from job where needs = $1
            union all
            select job.id from job join below on job.needs = below.id)
        update job set state = 'failed', failure = $2
         where state = 'blocked' and id in (select id from below)";
    let failure = failure_json(&needs_failed(&held.kind, held.job, cause));
    let failed = sqlx::query(FAIL).bind(held.id).bind(failure);
    Ok(failed.execute(&mut **transaction).await?.rows_affected())
}

/// Jobs moved by one statement: what could undo a failing statement is kept in memory meanwhile.
const SPAN: i64 = 4000;

/// Runs `statement`, which binds a sweep and a span of job numbers, over all jobs that `sweep` wants; the rows changed.
async fn in_spans(
    transaction: &mut Writing,
    sweep: i64,
    statement: &'static str,
) -> Result<u64, StoreError> {
    const ENDS: &str =
        "select coalesce(min(job), 0), coalesce(max(job), -1) from want where sweep = $1";
    let ends = sqlx::query_as(ENDS).bind(sweep);
    let (first, last): (i64, i64) = ends.fetch_one(&mut **transaction).await?;
    let mut moved = 0;
    for from in (first..=last).step_by(SPAN as usize) {
        let span = sqlx::query(statement)
            .bind(sweep)
            .bind(from)
            .bind(from + SPAN);
        moved += span.execute(&mut **transaction).await?.rows_affected();
    }
    Ok(moved)
}

/// blocked, ready → cancelled, for the jobs of `sweep` that no sweep wants.
pub(super) async fn job_cancel_unwanted(
    transaction: &mut Writing,
    sweep: i64,
) -> Result<u64, StoreError> {
    const CANCEL: &str = "
        update job set state = 'cancelled'
         where id >= $2 and id < $3 and state in ('blocked', 'ready')
           and exists (select 1 from want w where w.job = job.id and w.sweep = $1)
           and not exists (select 1 from want w join sweep s on s.id = w.sweep
                            where w.job = job.id and s.state <> 'cancelled')";
    in_spans(transaction, sweep, CANCEL).await
}

/// blocked, ready → cancelled, for what `sweep` wants only for others that need it, once none of those is to be done.
pub(super) async fn job_cancel_needless(
    transaction: &mut Writing,
    sweep: i64,
) -> Result<u64, StoreError> {
    const CANCEL: &str = "
        update job set state = 'cancelled'
         where id >= $2 and id < $3 and state in ('blocked', 'ready')
           and exists (select 1 from want w where w.job = job.id and w.sweep = $1 and w.points = 0)
           and exists (select 1 from job n where n.needs = job.id)
           and not exists (select 1 from job n where n.needs = job.id and n.state in ('blocked', 'ready', 'leased'))
           and not exists (select 1 from want w where w.job = job.id and w.points > 0)";
    // Recalls and bends need trains and jams, and these packs and growths.
    let mut cancelled = 0;
    for _ in 0..2 {
        cancelled += in_spans(transaction, sweep, CANCEL).await?;
    }
    Ok(cancelled)
}

/// cancelled → ready, blocked or failed, for the jobs that `sweep` wants again, but for what only archived outcomes needed.
pub(super) async fn job_revive(transaction: &mut Writing, sweep: i64) -> Result<u64, StoreError> {
    const ANY: &str = "select exists (select 1 from want where sweep = $1 and state = 'cancelled')";
    const REVIVE: &str = "
        update job
           set state = case when needs is null then 'ready'
                            when (select n.state from job n where n.id = job.needs) = 'done' then 'ready'
                            when (select n.state from job n where n.id = job.needs) in ('failed', 'poisoned') then 'failed'
                            else 'blocked' end,
               failure = case when (select n.state from job n where n.id = job.needs) in ('failed', 'poisoned')
                              then json_object('reason', 'needs', 'message', 'the stage that it starts from has failed')
                              end
         where id >= $2 and id < $3 and state = 'cancelled'
           and exists (select 1 from want w where w.job = job.id and w.sweep = $1)";
    let any = sqlx::query_scalar(ANY).bind(sweep);
    if !any.fetch_one(&mut **transaction).await? {
        return Ok(0);
    }
    let revived = in_spans(transaction, sweep, REVIVE).await?;
    Ok(revived - job_cancel_needless(transaction, sweep).await?.min(revived))
}

/// poisoned, failed by the machine → ready, for the jobs of `sweep`; and failed → blocked for all that need such jobs.
pub(super) async fn job_retry(transaction: &mut Writing, sweep: i64) -> Result<u64, StoreError> {
    const RETRY: &str = "
        update job set state = 'ready', failure = null, losses = 0, faults = 0
         where state in ('failed', 'poisoned') and failure ->> 'reason' in ('input', 'poisoned')
           and id in (select job from want where sweep = $1 and state in ('failed', 'poisoned'))";
    const FOLLOW: &str = "
        update job
           set state = case when (select n.state from job n where n.id = job.needs) = 'done' then 'ready' else 'blocked' end,
               failure = null
         where state = 'failed' and failure ->> 'reason' = 'needs'
           and (select n.state from job n where n.id = job.needs) not in ('failed', 'poisoned', 'cancelled')";
    let first = sqlx::query(RETRY).bind(sweep);
    let mut retried = first.execute(&mut **transaction).await?.rows_affected();
    // Trains follow packs, then recalls follow trains.
    for _ in 0..2 {
        let followed = sqlx::query(FOLLOW).execute(&mut **transaction).await?;
        retried += followed.rows_affected();
    }
    Ok(retried)
}
