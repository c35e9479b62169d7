//! Archived outcomes: what a submitted sweep takes instead of waiting for it, and the preparation that it spares.

use std::collections::BTreeMap;

use granary_api::id::{ArtifactHash, JobId, LeaseId, WorkerId};
use granary_api::lease::{JobOutcome, Provenance};
use granary_core::PHYSICS_VERSION;
use granary_core::stage::StageSpec;
use serde_json::json;
use uuid::Uuid;

use super::completion::outcome_add;
use super::event::{Wanting, event_finished, event_point};
use super::{Store, StoreError, Writing, job};
use crate::archive::Archived;

/// Who computed what an archive holds, as far as it says.
const WORKER: &str = "archive";

/// Jobs looked up at a time.
const PAGE: i64 = 1000;

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
        const OPEN: &str = "
            select j.id, j.hash, j.spec from want w join job j on j.id = w.job
             where w.sweep = $1 and j.state in ('blocked', 'ready') and j.id > $2
               and not exists (select 1 from job n where n.needs = j.id)
             order by j.id limit $3";
        let Some(archive) = self.config().archive.clone() else {
            return Ok(0);
        };
        let mut spared = 0;
        let mut wanting = Wanting::new();
        let mut after = 0;
        loop {
            let page: Vec<(i64, Vec<u8>, String)> = sqlx::query_as(OPEN)
                .bind(sweep)
                .bind(after)
                .bind(PAGE)
                .fetch_all(&mut **transaction)
                .await?;
            let Some(&(last, ..)) = page.last() else {
                break;
            };
            after = last;
            for (id, hash, spec) in page {
                let spec: StageSpec =
                    serde_json::from_str(&spec).map_err(StoreError::corrupt("spec"))?;
                if let Some(archived) = archive.find(&spec) {
                    let job = (id, job::stage_id(&hash));
                    let outcome = self.archived_outcome(job.1, archived, dry_run).await?;
                    self.archived_add(transaction, job, &outcome, &mut wanting)
                        .await?;
                    spared += 1;
                }
            }
        }
        if !wanting.is_empty() {
            spared += job::job_cancel_needless(transaction, sweep).await?;
            event_finished(transaction, &wanting, self.config().events).await?;
        }
        Ok(spared)
    }

    /// What a worker would report of `job`, its files stored unless nothing is to change.
    async fn archived_outcome(
        &self,
        job: JobId,
        archived: Archived,
        dry_run: bool,
    ) -> Result<JobOutcome, StoreError> {
        let result_hash = archived.outcome.hash();
        let outcome = archived.outcome;
        let mut artifacts: BTreeMap<String, ArtifactHash> = BTreeMap::new();
        for (name, bytes) in outcome.artifacts {
            let hash = if dry_run {
                ArtifactHash::of_bytes(&bytes)
            } else {
                self.artifact_put(bytes).await?
            };
            artifacts.insert(name, hash);
        }
        Ok(JobOutcome {
            job,
            results: outcome.results,
            reasons: outcome.reasons,
            artifacts,
            warnings: outcome.warnings,
            result_hash,
            provenance: Provenance {
                engine_version: env!("CARGO_PKG_VERSION").to_owned(),
                physics_version: PHYSICS_VERSION,
                target: "unknown".to_owned(),
                worker: WorkerId(WORKER.to_owned()),
                steps: outcome.steps,
                lanes: 1,
                wall_s: archived.wall_s,
                cpu_s: archived.cpu_s,
            },
        })
    }

    async fn archived_add(
        &self,
        transaction: &mut Writing,
        (id, job): (i64, JobId),
        outcome: &JobOutcome,
        wanting: &mut Wanting,
    ) -> Result<(), StoreError> {
        outcome_add(transaction, LeaseId(Uuid::nil()), id, outcome).await?;
        job::job_done(transaction, id).await?;
        job::job_unblock(transaction, id).await?;
        let data = json!({"state": "done", "job": job});
        event_point(transaction, id, &data, self.config().events, wanting).await
    }
}
