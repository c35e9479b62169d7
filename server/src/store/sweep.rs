//! Sweeps: lists, counts, and the ways to steer one.

use granary_api::id::SweepId;
use granary_api::sweep::{Accuracy, Choice, PointCounts, Steered, Sweep, SweepState};
use granary_api::table::Page;
use granary_core::model::Model;
use serde_json::{Value, json};

use super::event::event_add;
use super::speed::speed_remaining;
use super::{Store, StoreError, Writing, job, rfc3339};
use crate::sweep::reduction::Reduction;

/// A sweep's row, as the rest of the store needs it.
pub(crate) struct SweepPlan {
    pub(crate) id: i64,
    pub(crate) model: Model,
    pub(crate) axes: Vec<String>,
    pub(crate) fixed: serde_json::Map<String, Value>,
    pub(crate) reductions: Vec<Reduction>,
    pub(crate) points: u64,
    /// What its pilot has chosen, if it has one that has.
    pub(crate) choice: Option<Choice>,
}

/// The columns of a sweep's row that its summary shows.
type Row = (
    i64,
    uuid::Uuid,
    String,
    String,
    String,
    String,
    i64,
    i64,
    String,
    String,
    String,
);

impl Store {
    /// Sweeps, the latest first, after the cursor of the page before.
    pub async fn sweep_list(
        &self,
        cursor: Option<SweepId>,
        limit: u32,
    ) -> Result<Page<Sweep>, StoreError> {
        const LIST: &str = "
            select id, uuid, name, model, preset, state, priority, created_at, warnings, plan, spec from sweep
             where $1 is null or id < (select id from sweep where uuid = $1)
             order by id desc limit $2";
        const TOTAL: &str = "select count(*) from sweep";
        let total: i64 = sqlx::query_scalar(TOTAL).fetch_one(self.readers()).await?;
        let rows: Vec<Row> = sqlx::query_as(LIST)
            .bind(cursor.map(|cursor| cursor.0))
            .bind(limit)
            .fetch_all(self.readers())
            .await?;
        let mut items = vec![];
        for row in rows {
            items.push(Sweep {
                spec: None,
                ..self.summary(row).await?
            });
        }
        let full = items.len() == limit as usize;
        let next = items
            .last()
            .filter(|_| full)
            .map(|last| last.sweep.to_string());
        Ok(Page {
            items,
            next,
            total: total as u64,
        })
    }

    /// One sweep.
    pub async fn sweep_read(&self, sweep: SweepId) -> Result<Sweep, StoreError> {
        const READ: &str = "
            select id, uuid, name, model, preset, state, priority, created_at, warnings, plan, spec from sweep
             where uuid = $1";
        let row = sqlx::query_as(READ).bind(sweep.0);
        let row = row
            .fetch_optional(self.readers())
            .await?
            .ok_or_else(|| missing(sweep))?;
        self.summary(row).await
    }

    /// The plan of one sweep as it was resolved.
    pub(crate) async fn sweep_plan(&self, sweep: SweepId) -> Result<SweepPlan, StoreError> {
        const PLAN: &str = "select id, model, plan, points, choice from sweep where uuid = $1";
        let row: Option<(i64, String, String, i64, Option<String>)> = sqlx::query_as(PLAN)
            .bind(sweep.0)
            .fetch_optional(self.readers())
            .await?;
        let (id, model, plan, points, choice) = row.ok_or_else(|| missing(sweep))?;
        let mut plan: Value = serde_json::from_str(&plan).map_err(StoreError::corrupt("plan"))?;
        let model = Model::named(&model);
        let model = model.ok_or_else(|| StoreError::NotFound("such a model".to_owned()))?;
        Ok(SweepPlan {
            id,
            model,
            axes: serde_json::from_value(plan["axes"].take())
                .map_err(StoreError::corrupt("plan"))?,
            fixed: serde_json::from_value(plan["fixed"].take())
                .map_err(StoreError::corrupt("plan"))?,
            reductions: serde_json::from_value(plan["reductions"].take())
                .map_err(StoreError::corrupt("plan"))?,
            points: points as u64,
            choice: read_choice(choice.as_deref())?,
        })
    }

    async fn summary(&self, row: Row) -> Result<Sweep, StoreError> {
        let (id, uuid, name, model, preset, state, priority, created_at, warnings, plan, spec) =
            row;
        // In this order: once a pilot has chosen, points are there, and once nothing is open, the counts are final, so a finished sweep never shows old ones.
        let (accuracy, planned) = self.sweep_accuracy(id, &spec).await?;
        let waits = accuracy.as_ref().is_some_and(|of| of.choice.is_none());
        let (open, running) = self.sweep_open(id).await?;
        let mut points = self.sweep_counts(id).await?;
        if waits {
            (points.total, points.waiting) = (planned, planned);
        }
        let plan: Value = serde_json::from_str(&plan).map_err(StoreError::corrupt("plan"))?;
        let state = shown_state(&state, open || waits);
        let eta_s = if state == SweepState::Active && running > 0 {
            let mut reader = self.readers().acquire().await?;
            let taken = self.inner.pace.taken(id);
            Some(speed_remaining(&mut reader, id, &taken).await? / running as f64)
        } else {
            None
        };
        Ok(Sweep {
            sweep: SweepId(uuid),
            name,
            model,
            preset,
            state,
            priority,
            created_at: rfc3339(created_at),
            points,
            points_per_second: self.inner.pace.rate(id),
            eta_s,
            axes: serde_json::from_value(plan["axes"].clone())
                .map_err(StoreError::corrupt("plan"))?,
            warnings: serde_json::from_str(&warnings)
                .map_err(StoreError::corrupt("list of warnings"))?,
            accuracy,
            spec: Some(serde_json::from_str(&spec).map_err(StoreError::corrupt("spec"))?),
        })
    }

    /// A text that changes whenever the sweep's tables may have: cheap, and steady once it is finished.
    pub(crate) async fn sweep_version(&self, sweep: SweepId) -> Result<String, StoreError> {
        let id = self.sweep_plan(sweep).await?.id;
        let (_, last) = self.event_range(id).await?;
        let (open, _) = self.sweep_open(id).await?;
        let open = open || self.sweep_waits(id).await?;
        let count = *self.inner.changed.borrow();
        Ok(if open {
            format!("{id} {last} {count} {:?}", self.inner.opened)
        } else {
            format!("{id} {last}")
        })
    }

    /// The accuracy that a sweep was asked for, if it has a pilot, and the points that it will have.
    async fn sweep_accuracy(
        &self,
        id: i64,
        spec: &str,
    ) -> Result<(Option<Accuracy>, u64), StoreError> {
        const READ: &str = "
            select p.uuid, s.choice, s.points from sweep s join sweep p on p.id = s.pilot where s.id = $1";
        let row = sqlx::query_as(READ).bind(id);
        let row: Option<(uuid::Uuid, Option<String>, i64)> =
            row.fetch_optional(self.readers()).await?;
        let Some((pilot, choice, points)) = row else {
            return Ok((None, 0));
        };
        let spec: Value = serde_json::from_str(spec).map_err(StoreError::corrupt("spec"))?;
        let targets = spec["accuracy"].as_object().into_iter().flatten();
        let accuracy = Accuracy {
            targets: targets
                .filter(|(name, _)| *name != "packings")
                .filter_map(|(name, value)| Some((name.clone(), value.as_f64()?)))
                .collect(),
            pilot: SweepId(pilot),
            choice: read_choice(choice.as_deref())?,
        };
        Ok((Some(accuracy), points as u64))
    }

    async fn sweep_counts(&self, id: i64) -> Result<PointCounts, StoreError> {
        const COUNTS: &str = "select state, sum(points) from want where sweep = $1 group by state";
        let rows: Vec<(String, i64)> = sqlx::query_as(COUNTS)
            .bind(id)
            .fetch_all(self.readers())
            .await?;
        let mut counts = PointCounts::default();
        for (state, points) in rows {
            let points = points as u64;
            counts.total += points;
            match state.as_str() {
                "done" => counts.done += points,
                "failed" | "poisoned" => counts.failed += points,
                "leased" => counts.running += points,
                "cancelled" => counts.cancelled += points,
                _ => counts.waiting += points,
            }
        }
        Ok(counts)
    }

    /// Whether the sweep's pilot has not decided yet.
    async fn sweep_waits(&self, id: i64) -> Result<bool, StoreError> {
        const WAITS: &str = "select pilot is not null and choice is null from sweep where id = $1";
        Ok(sqlx::query_scalar(WAITS)
            .bind(id)
            .fetch_one(self.readers())
            .await?)
    }

    /// Whether some job of the sweep is still to be done, and how many ensembles of it are running.
    async fn sweep_open(&self, id: i64) -> Result<(bool, i64), StoreError> {
        const OPEN: &str = "
            select exists (select 1 from want where sweep = $1 and state in ('blocked', 'ready', 'leased')),
                   (select count(distinct j.lease) from want w join job j on j.id = w.job
                     where w.sweep = $1 and w.state = 'leased')";
        Ok(sqlx::query_as(OPEN)
            .bind(id)
            .fetch_one(self.readers())
            .await?)
    }

    /// The row of a sweep and its stored state.
    async fn sweep_row(
        transaction: &mut Writing,
        sweep: SweepId,
    ) -> Result<(i64, String), StoreError> {
        const ROW: &str = "select id, state from sweep where uuid = $1";
        let row = sqlx::query_as(ROW).bind(sweep.0);
        row.fetch_optional(&mut **transaction)
            .await?
            .ok_or_else(|| missing(sweep))
    }

    /// The sweep wants its jobs no more: those that no other sweep wants are cancelled, a running one at its next heartbeat.
    pub async fn sweep_cancel(&self, sweep: SweepId) -> Result<Steered, StoreError> {
        let mut transaction = self.begin().await?;
        let (id, before) = Self::sweep_row(&mut transaction, sweep).await?;
        self.set_state(&mut transaction, id, &before, "cancelled")
            .await?;
        let mut jobs = job::job_cancel_unwanted(&mut transaction, id).await?;
        if let Some((pilot, before)) = pilot_of(&mut transaction, id, true).await? {
            self.set_state(&mut transaction, pilot, &before, "cancelled")
                .await?;
            jobs += job::job_cancel_unwanted(&mut transaction, pilot).await?;
        }
        self.commit(transaction).await?;
        Ok(Steered {
            state: SweepState::Cancelled,
            jobs,
        })
    }

    /// No more of the sweep's jobs are given to workers; what runs goes on.
    pub async fn sweep_pause(&self, sweep: SweepId) -> Result<Steered, StoreError> {
        let mut transaction = self.begin().await?;
        let (id, before) = Self::sweep_row(&mut transaction, sweep).await?;
        if before == "active" {
            self.set_state(&mut transaction, id, &before, "paused")
                .await?;
            let pilot = pilot_of(&mut transaction, id, true).await?;
            if let Some((pilot, before)) = pilot.filter(|(_, before)| before == "active") {
                self.set_state(&mut transaction, pilot, &before, "paused")
                    .await?;
            }
        }
        self.commit(transaction).await?;
        self.steered(sweep, 0).await
    }

    /// The sweep goes on, or wants its jobs again if it was cancelled.
    pub async fn sweep_resume(&self, sweep: SweepId) -> Result<Steered, StoreError> {
        let mut transaction = self.begin().await?;
        let (id, _) = Self::sweep_row(&mut transaction, sweep).await?;
        let jobs = self.sweep_resume_in(&mut transaction, id).await?;
        self.commit(transaction).await?;
        self.steered(sweep, jobs).await
    }

    pub(super) async fn sweep_resume_in(
        &self,
        transaction: &mut Writing,
        id: i64,
    ) -> Result<u64, StoreError> {
        const STATE: &str = "select state from sweep where id = $1";
        let before: String = sqlx::query_scalar(STATE)
            .bind(id)
            .fetch_one(&mut **transaction)
            .await?;
        self.set_state(transaction, id, &before, "active").await?;
        let mut jobs = job::job_revive(transaction, id).await?;
        if let Some((pilot, before)) = pilot_of(transaction, id, false).await? {
            self.set_state(transaction, pilot, &before, "active")
                .await?;
            jobs += job::job_revive(transaction, pilot).await?;
        }
        Ok(jobs)
    }

    /// Tries again what failed by no fault of its own: poisoned jobs, faults of machines, and what needs them.
    pub async fn sweep_retry(&self, sweep: SweepId) -> Result<Steered, StoreError> {
        let mut transaction = self.begin().await?;
        let (id, _) = Self::sweep_row(&mut transaction, sweep).await?;
        let jobs = job::job_retry(&mut transaction, id).await?;
        if jobs > 0 {
            let data = json!({"state": "active", "retried": jobs});
            event_add(&mut transaction, id, "state", &data, self.config().events).await?;
        }
        self.commit(transaction).await?;
        self.steered(sweep, jobs).await
    }

    async fn set_state(
        &self,
        transaction: &mut Writing,
        id: i64,
        before: &str,
        state: &str,
    ) -> Result<(), StoreError> {
        const SET: &str = "update sweep set state = $2 where id = $1";
        if before == state {
            return Ok(());
        }
        let set = sqlx::query(SET).bind(id).bind(state);
        set.execute(&mut **transaction).await?;
        event_add(
            transaction,
            id,
            "state",
            &json!({"state": state}),
            self.config().events,
        )
        .await
    }

    async fn steered(&self, sweep: SweepId, jobs: u64) -> Result<Steered, StoreError> {
        let state = self.sweep_read(sweep).await?.state;
        Ok(Steered { state, jobs })
    }
}

/// What a pilot has chosen, as it was stored.
fn read_choice(text: Option<&str>) -> Result<Option<Choice>, StoreError> {
    let read = text.map(serde_json::from_str).transpose();
    read.map_err(StoreError::corrupt("choice"))
}

/// The pilot that a sweep waits for, and its state; with `alone`, only if no other sweep that goes on waits for it.
async fn pilot_of(
    transaction: &mut Writing,
    sweep: i64,
    alone: bool,
) -> Result<Option<(i64, String)>, StoreError> {
    const PILOT: &str = "
        select p.id, p.state from sweep s join sweep p on p.id = s.pilot
         where s.id = $1 and s.choice is null
           and not ($2 and exists (select 1 from sweep o where o.pilot = p.id and o.choice is null and o.id <> s.id
                                      and o.state = 'active'))";
    let pilot = sqlx::query_as(PILOT).bind(sweep).bind(alone);
    Ok(pilot.fetch_optional(&mut **transaction).await?)
}

fn shown_state(stored: &str, open: bool) -> SweepState {
    match stored {
        "cancelled" => SweepState::Cancelled,
        _ if !open => SweepState::Finished,
        "paused" => SweepState::Paused,
        _ => SweepState::Active,
    }
}

fn missing(sweep: SweepId) -> StoreError {
    StoreError::NotFound(format!("sweep {sweep}"))
}
