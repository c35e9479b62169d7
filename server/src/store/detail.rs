//! One job in full: its attempts, what happened, and why it failed.

use granary_api::id::{JobId, LeaseId, SweepId, WorkerId};
use granary_api::job::{Attempt, JobDetail, LogLine, Progress};

use super::point::read_or_default;
use super::{Store, StoreError, job, rfc3339};

/// A job's columns: id, spec, state, needs, losses, faults, step, steps, failure, worker, last heartbeat.
type JobColumns = (
    i64,
    String,
    String,
    Option<Vec<u8>>,
    i64,
    i64,
    i64,
    i64,
    Option<String>,
    Option<String>,
    Option<i64>,
);

/// An outcome's columns: results, artifacts, warnings, hash, provenance.
type OutcomeColumns = (String, String, String, Vec<u8>, String);

impl Store {
    /// Everything about one job.
    pub async fn job_read(&self, id: &JobId) -> Result<JobDetail, StoreError> {
        const JOB: &str = "
            select j.id, j.spec, j.state, (select hash from job n where n.id = j.needs), j.losses, j.faults,
                   j.step, j.steps, j.failure, l.worker, l.heard_at
              from job j left join lease l on l.id = j.lease where j.hash = $1";
        const OUTCOME: &str = "
            select results, artifacts, warnings, result_hash, provenance from outcome where job = $1";
        let row: Option<JobColumns> = sqlx::query_as(JOB)
            .bind(&id.as_bytes()[..])
            .fetch_optional(self.readers())
            .await?;
        let row = row.ok_or_else(|| StoreError::NotFound(format!("job {id}")))?;
        let (job, spec, state, needs, losses, faults, step, steps, failure, worker, heard) = row;
        let outcome: Option<OutcomeColumns> = sqlx::query_as(OUTCOME)
            .bind(job)
            .fetch_optional(self.readers())
            .await?;
        let outcome = outcome.as_ref();
        let provenance = outcome.map(|o| serde_json::from_str(&o.4)).transpose();
        let failure = failure.as_deref().map(serde_json::from_str).transpose();
        Ok(JobDetail {
            job: *id,
            spec: serde_json::from_str(&spec).map_err(StoreError::corrupt("spec"))?,
            state: state
                .parse()
                .map_err(|_| StoreError::NotFound(format!("job state {state}")))?,
            needs: needs.as_deref().map(job::stage_id),
            attempts: self.attempts(job).await?,
            losses: losses as u64,
            faults: faults as u64,
            progress: worker.zip(heard).map(|(worker, heard)| Progress {
                step: step as u64,
                steps: steps as u64,
                worker: WorkerId(worker),
                last_heartbeat: rfc3339(heard),
            }),
            failure: failure.map_err(StoreError::corrupt("failure"))?,
            results: read_or_default(outcome.map(|o| o.0.as_str()), "result")?,
            artifacts: read_or_default(outcome.map(|o| o.1.as_str()), "list of artifacts")?,
            warnings: read_or_default(outcome.map(|o| o.2.as_str()), "list of warnings")?,
            result_hash: outcome.map(|o| job::hash(&o.3)),
            provenance: provenance.map_err(StoreError::corrupt("provenance"))?,
            diverged: self.divergences(job).await?,
            sweeps: self.sweeps_of(job).await?,
        })
    }

    /// What happened to a job, line by line.
    pub async fn job_log(&self, id: &JobId) -> Result<Vec<LogLine>, StoreError> {
        let detail = self.job_read(id).await?;
        let mut lines = vec![];
        for attempt in detail.attempts {
            let (number, worker) = (attempt.attempt, &attempt.worker);
            lines.push(LogLine {
                at: attempt.started_at,
                message: format!("attempt {number}: {worker} took it"),
            });
            if let (Some(at), Some(ending)) = (attempt.ended_at, attempt.ending) {
                let more = attempt
                    .detail
                    .map_or(String::new(), |detail| format!(": {detail}"));
                lines.push(LogLine {
                    at,
                    message: format!("attempt {number}: {ending}{more}"),
                });
            }
        }
        Ok(lines)
    }

    /// How many jobs are in each state.
    pub async fn job_counts(&self) -> Result<Vec<(String, u64)>, StoreError> {
        const COUNTS: &str = "select state, count(*) from job group by state order by state";
        let rows: Vec<(String, i64)> = sqlx::query_as(COUNTS).fetch_all(self.readers()).await?;
        Ok(rows
            .into_iter()
            .map(|(state, count)| (state, count as u64))
            .collect())
    }

    async fn attempts(&self, job: i64) -> Result<Vec<Attempt>, StoreError> {
        const ATTEMPTS: &str = "
            select attempt, lease, worker, started_at, ended_at, ending, detail
              from attempt where job = $1 order by attempt desc limit 100";
        type Row = (
            i64,
            uuid::Uuid,
            String,
            i64,
            Option<i64>,
            Option<String>,
            Option<String>,
        );
        let rows: Vec<Row> = sqlx::query_as(ATTEMPTS)
            .bind(job)
            .fetch_all(self.readers())
            .await?;
        let attempt = |(attempt, lease, worker, started, ended, ending, detail): Row| Attempt {
            attempt: attempt as u64,
            lease: LeaseId(lease),
            worker: WorkerId(worker),
            started_at: rfc3339(started),
            ended_at: ended.map(rfc3339),
            ending,
            detail,
        };
        Ok(rows.into_iter().rev().map(attempt).collect())
    }

    async fn divergences(&self, job: i64) -> Result<Vec<granary_api::id::ResultHash>, StoreError> {
        const DIVERGENCES: &str = "select result_hash from divergence where job = $1 limit 100";
        let rows: Vec<Vec<u8>> = sqlx::query_scalar(DIVERGENCES)
            .bind(job)
            .fetch_all(self.readers())
            .await?;
        Ok(rows.iter().map(|bytes| job::hash(bytes)).collect())
    }

    async fn sweeps_of(&self, job: i64) -> Result<Vec<SweepId>, StoreError> {
        const SWEEPS: &str = "
            select s.uuid from want w join sweep s on s.id = w.sweep
             where w.job = $1 and s.state <> 'cancelled' order by s.id limit 1000";
        let rows: Vec<uuid::Uuid> = sqlx::query_scalar(SWEEPS)
            .bind(job)
            .fetch_all(self.readers())
            .await?;
        Ok(rows.into_iter().map(SweepId).collect())
    }
}
