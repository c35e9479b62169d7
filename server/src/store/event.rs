//! Events of a sweep: stored with a number that rises, the oldest forgotten.

use std::collections::BTreeMap;

use granary_api::sweep::Event;
use serde_json::{Value, json};

use super::{Store, StoreError, Writing, now_ms, rfc3339};

/// The sweeps that want the jobs of a transaction, and how many of their points these are.
pub(super) type Wanting = BTreeMap<i64, u64>;

/// Adds an event to `sweep` and forgets the oldest beyond `keep`.
pub(super) async fn event_add(
    transaction: &mut Writing,
    sweep: i64,
    kind: &str,
    data: &Value,
    keep: u32,
) -> Result<(), StoreError> {
    const ADD: &str = "
        insert into event (sweep, seq, at, kind, data)
        select $1, coalesce(max(seq), 0) + 1, $2, $3, $4 from event where sweep = $1";
    const FORGET: &str = "
        delete from event
         where sweep = $1 and seq <= (select max(seq) from event where sweep = $1) - $2";
    let added = sqlx::query(ADD).bind(sweep).bind(now_ms()).bind(kind);
    added
        .bind(data.to_string())
        .execute(&mut **transaction)
        .await?;
    let forget = sqlx::query(FORGET).bind(sweep).bind(i64::from(keep));
    forget.execute(&mut **transaction).await?;
    Ok(())
}

/// Tells every sweep that has points at `job` that they are in `state` now; adds the sweeps that want it to `wanting`.
pub(super) async fn event_point(
    transaction: &mut Writing,
    job: i64,
    data: &Value,
    keep: u32,
    wanting: &mut Wanting,
) -> Result<(), StoreError> {
    const WANTING: &str = "select sweep, points, first_point from want where job = $1";
    const POINTS: &str = "select point from point where sweep = $1 and job = $2 order by point";
    let rows: Vec<(i64, i64, Option<i64>)> = sqlx::query_as(WANTING)
        .bind(job)
        .fetch_all(&mut **transaction)
        .await?;
    for (sweep, count, first) in rows {
        *wanting.entry(sweep).or_default() += count as u64;
        let Some(first) = first else {
            continue;
        };
        let mut points = vec![first];
        if count > 1 {
            // Few jobs serve several points of one sweep, so there is no index for them.
            let all = sqlx::query_scalar(POINTS).bind(sweep).bind(job);
            points = all.fetch_all(&mut **transaction).await?;
        }
        let mut data = data.clone();
        data["points"] = json!(points);
        event_add(transaction, sweep, "point", &data, keep).await?;
    }
    Ok(())
}

/// Tells those of `sweeps` whose last job has just ended that they are finished.
pub(super) async fn event_finished(
    transaction: &mut Writing,
    sweeps: &Wanting,
    keep: u32,
) -> Result<(), StoreError> {
    const OPEN: &str = "
        select exists (select 1 from want where sweep = $1 and state in ('blocked', 'ready', 'leased'))";
    for &sweep in sweeps.keys() {
        let open: bool = sqlx::query_scalar(OPEN)
            .bind(sweep)
            .fetch_one(&mut **transaction)
            .await?;
        if !open {
            event_add(
                transaction,
                sweep,
                "state",
                &json!({"state": "finished"}),
                keep,
            )
            .await?;
        }
    }
    Ok(())
}

impl Store {
    /// The events of a sweep after `after`, oldest first, at most `most`.
    pub async fn event_list(
        &self,
        sweep: i64,
        after: u64,
        most: u32,
    ) -> Result<Vec<Event>, StoreError> {
        const LIST: &str = "
            select seq, at, kind, data from event where sweep = $1 and seq > $2 order by seq limit $3";
        let rows: Vec<(i64, i64, String, String)> = sqlx::query_as(LIST)
            .bind(sweep)
            .bind(super::signed(after))
            .bind(most)
            .fetch_all(self.readers())
            .await?;
        rows.into_iter()
            .map(|(seq, at, kind, data)| {
                Ok(Event {
                    id: seq as u64,
                    kind,
                    at: rfc3339(at),
                    data: serde_json::from_str(&data).map_err(StoreError::corrupt("event"))?,
                })
            })
            .collect()
    }

    /// The number of the first event that is still known, and of the last.
    pub async fn event_range(&self, sweep: i64) -> Result<(u64, u64), StoreError> {
        const RANGE: &str =
            "select coalesce(min(seq), 0), coalesce(max(seq), 0) from event where sweep = $1";
        let (first, last): (i64, i64) = sqlx::query_as(RANGE)
            .bind(sweep)
            .fetch_one(self.readers())
            .await?;
        Ok((first as u64, last as u64))
    }
}
