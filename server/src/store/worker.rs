//! Workers, as they were last heard of.

use granary_api::id::WorkerId;
use granary_api::job::WorkerRow;
use granary_api::lease::LeaseRequest;

use super::{Store, StoreError, Writing, now_ms, rfc3339, signed};

/// After this long without a word a worker is shown as silent \[ms\].
const SILENT_MS: i64 = 60_000;

/// Notes that a worker asked for work.
pub(super) async fn worker_asks(
    transaction: &mut Writing,
    request: &LeaseRequest,
) -> Result<(), StoreError> {
    const ASKS: &str = "
        insert into worker (name, engine, physics, memory_bytes, first_seen, last_seen)
        values ($1, $2, $3, $4, $5, $5)
        on conflict (name) do update
           set engine = excluded.engine, physics = excluded.physics,
               memory_bytes = excluded.memory_bytes, last_seen = excluded.last_seen";
    sqlx::query(ASKS)
        .bind(&request.worker.0)
        .bind(&request.engine_version)
        .bind(request.physics_version)
        .bind(signed(request.memory_bytes))
        .bind(now_ms())
        .execute(&mut **transaction)
        .await?;
    Ok(())
}

/// Notes that the worker of a lease was heard of, and how many jobs it has finished.
pub(super) async fn worker_heard(
    transaction: &mut Writing,
    lease: i64,
    done: usize,
) -> Result<(), StoreError> {
    const HEARD: &str = "
        update worker set last_seen = $2, done = done + $3
         where name = (select worker from lease where id = $1)";
    let heard = sqlx::query(HEARD)
        .bind(lease)
        .bind(now_ms())
        .bind(signed(done as u64));
    heard.execute(&mut **transaction).await?;
    Ok(())
}

impl Store {
    /// Every worker that was ever heard of, the latest first, at most 1,000.
    pub async fn worker_list(&self) -> Result<Vec<WorkerRow>, StoreError> {
        const LIST: &str = "
            select name, engine, physics, memory_bytes, done, first_seen, last_seen,
                   (select count(*) from lease l join job j on j.lease = l.id where l.worker = worker.name)
              from worker order by last_seen desc, name limit 1000";
        type Row = (String, String, i64, i64, i64, i64, i64, i64);
        let rows: Vec<Row> = sqlx::query_as(LIST).fetch_all(self.readers()).await?;
        let now = now_ms();
        let row = |(name, engine, physics, memory, done, first, last, leased): Row| WorkerRow {
            worker: WorkerId(name),
            state: state(now - last, leased).to_owned(),
            engine_version: engine,
            physics_version: physics as u32,
            memory_bytes: memory as u64,
            leased: leased as u64,
            done: done as u64,
            first_seen: rfc3339(first),
            last_seen: rfc3339(last),
        };
        Ok(rows.into_iter().map(row).collect())
    }
}

fn state(silence_ms: i64, leased: i64) -> &'static str {
    match leased {
        _ if silence_ms > SILENT_MS => "silent",
        0 => "idle",
        _ => "working",
    }
}
