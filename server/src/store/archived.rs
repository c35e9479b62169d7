//! Archived outcomes: what a submitted sweep takes instead of waiting for it, and the preparation that it spares.

use std::panic::resume_unwind;
use std::sync::Arc;

use granary_api::id::{LeaseId, WorkerId};
use granary_api::lease::{JobOutcome, Provenance};
use granary_core::stage::StageSpec;
use serde_json::json;
use tokio::task::spawn_blocking;
use uuid::Uuid;

use super::completion::outcome_add;
use super::event::{Wanting, event_finished, event_point};
use super::{Store, StoreError, Writing, job};
use crate::archive::{Archive, Archived};

/// Who computed what an archive holds, as far as it says.
const WORKER: &str = "archive";

/// Jobs looked up at a time: so many outcomes are in memory at once.
const PAGE: i64 = 32;

impl Store {
    /// Ends every open job of `sweep` that nothing needs and whose outcome is archived, then cancels what only those needed;
    /// how many jobs.
    ///
    /// A preparation is taken by the worker that is given it, if it is needed at all.
    pub(super) async fn archived_take(
        &self,
        transaction: &mut Writing,
        sweep: i64,
        dry_run: bool,
    ) -> Result<u64, StoreError> {
        let Some(archive) = &self.config().archive else {
            return Ok(0);
        };
        let (mut spared, mut after) = (0, 0);
        let mut wanting = Wanting::new();
        loop {
            let page = open_ends(transaction, sweep, after).await?;
            let Some(&(last, _)) = page.last() else {
                break;
            };
            after = last;
            for (id, spec, archived) in look_up(archive, page).await {
                self.archived_add(transaction, (id, &spec), (archived, dry_run), &mut wanting)
                    .await?;
                spared += 1;
            }
        }
        if spared > 0 {
            spared += job::job_cancel_needless(transaction, sweep).await?;
            event_finished(transaction, &wanting, self.config().events).await?;
        }
        Ok(spared)
    }

    /// Ends one job as if a worker had completed it; its files are stored unless nothing is to change.
    async fn archived_add(
        &self,
        transaction: &mut Writing,
        (id, spec): (i64, &StageSpec),
        (archived, dry_run): (Archived, bool),
        wanting: &mut Wanting,
    ) -> Result<(), StoreError> {
        let provenance = Provenance {
            engine_version: archived.engine_version,
            physics_version: spec.kind().physics(),
            target: "unknown".to_owned(),
            worker: WorkerId(WORKER.to_owned()),
            steps: 0,
            lanes: 1,
            wall_s: archived.wall_s,
            cpu_s: archived.cpu_s,
        };
        let (outcome, files) = JobOutcome::new(spec.id(), archived.outcome, provenance);
        if !dry_run {
            for bytes in files.into_values() {
                self.artifact_put(bytes).await?;
            }
        }
        outcome_add(transaction, LeaseId(Uuid::nil()), id, &outcome).await?;
        job::job_done(transaction, id).await?;
        let data = json!({"state": "done", "job": outcome.job});
        event_point(transaction, id, &data, self.config().events, wanting).await
    }
}

/// The next open jobs of `sweep` behind the row `after` that nothing needs.
async fn open_ends(
    transaction: &mut Writing,
    sweep: i64,
    after: i64,
) -> Result<Vec<(i64, StageSpec)>, StoreError> {
    const OPEN: &str = "
        select j.id, j.spec from want w join job j on j.id = w.job
         where w.sweep = $1 and j.state in ('blocked', 'ready') and j.id > $2
           and not exists (select 1 from job n where n.needs = j.id)
         order by j.id limit $3";
    let rows: Vec<(i64, String)> = sqlx::query_as(OPEN)
        .bind(sweep)
        .bind(after)
        .bind(PAGE)
        .fetch_all(&mut **transaction)
        .await?;
    rows.into_iter()
        .map(|(id, spec)| {
            let spec = serde_json::from_str(&spec).map_err(StoreError::corrupt("spec"))?;
            Ok((id, spec))
        })
        .collect()
}

/// Those of `jobs` that are archived; files are read on a thread that may wait for them.
async fn look_up(
    archive: &Arc<dyn Archive>,
    jobs: Vec<(i64, StageSpec)>,
) -> Vec<(i64, StageSpec, Archived)> {
    let archive = Arc::clone(archive);
    let found = spawn_blocking(move || {
        let find = |(id, spec)| archive.find(&spec).map(|archived| (id, spec, archived));
        jobs.into_iter().filter_map(find).collect()
    });
    found
        .await
        .unwrap_or_else(|panic| resume_unwind(panic.into_panic()))
}
