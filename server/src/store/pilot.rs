//! Sweeps that wait for a pilot: which of them can go on, and how they do.

use granary_api::id::SweepId;
use granary_api::table::SetRow;
use serde_json::{Value, json};

use super::event::event_add;
use super::intake::{fill, resolved};
use super::{Store, StoreError};
use crate::sweep::Plan;

/// A sweep whose pilot has come to its end.
pub(crate) struct Waiting {
    id: i64,
    spec: String,
    pilot: SweepId,
}

impl Store {
    /// The sweeps that wait for a pilot that has come to its end; a cancelled pilot decides nothing.
    pub(crate) async fn pilot_ended(&self) -> Result<Vec<Waiting>, StoreError> {
        const ENDED: &str = "
            select s.id, s.spec, p.uuid from sweep s join sweep p on p.id = s.pilot
             where s.pilot is not null and s.choice is null and s.state <> 'cancelled' and p.state <> 'cancelled'
               and not exists (select 1 from want w where w.sweep = p.id and w.state in ('blocked', 'ready', 'leased'))
             order by s.id";
        let rows: Vec<(i64, String, uuid::Uuid)> =
            sqlx::query_as(ENDED).fetch_all(self.readers()).await?;
        let waiting = |(id, spec, pilot)| Waiting {
            id,
            spec,
            pilot: SweepId(pilot),
        };
        Ok(rows.into_iter().map(waiting).collect())
    }

    /// Chooses by what the pilot has found and queues the points of the sweep, or finds that this was done meanwhile.
    pub(crate) async fn pilot_settle(&self, waiting: &Waiting) -> Result<(), StoreError> {
        const CHOOSE: &str =
            "update sweep set plan = $2, choice = $3 where id = $1 and choice is null";
        let spec: Value =
            serde_json::from_str(&waiting.spec).map_err(StoreError::corrupt("spec"))?;
        let plan = Plan::read(&spec, self.config().sweep).map_err(StoreError::Invalid)?;
        let Some(accuracy) = &plan.accuracy else {
            return Err(StoreError::NotFound(
                "the accuracy of a waiting sweep".to_owned(),
            ));
        };
        let pilot = self.sweep_plan(waiting.pilot).await?;
        let rows: Vec<SetRow> = self.sets(&pilot).await?;
        let choice = accuracy.choose(&rows, self.core_seconds(pilot.id).await?);
        let plan = plan.settled(&choice);
        let mut transaction = self.begin().await?;
        let chosen = sqlx::query(CHOOSE)
            .bind(waiting.id)
            .bind(resolved(&plan).to_string())
            .bind(json!(choice).to_string());
        if chosen.execute(&mut *transaction).await?.rows_affected() == 0 {
            return Ok(());
        }
        fill(&mut transaction, &plan, waiting.id).await?;
        self.archived_take(&mut transaction, waiting.id, false)
            .await?;
        let data = json!({"state": "active", "chosen": choice.setting});
        event_add(
            &mut transaction,
            waiting.id,
            "state",
            &data,
            self.config().events,
        )
        .await?;
        self.commit(transaction).await
    }

    /// What all jobs that a sweep wants took \[core-seconds\].
    async fn core_seconds(&self, sweep: i64) -> Result<f64, StoreError> {
        const SUM: &str = "
            select total((o.provenance ->> 'cpu_s') / max(1.0, o.provenance ->> 'lanes'))
              from want w join outcome o on o.job = w.job where w.sweep = $1";
        Ok(sqlx::query_scalar(SUM)
            .bind(sweep)
            .fetch_one(self.readers())
            .await?)
    }
}
