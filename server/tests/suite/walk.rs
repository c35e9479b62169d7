//! A random walk: whatever workers and users do, in whatever order, the queue keeps its promises.

use granary_api::id::SweepId;
use granary_api::lease::{FailureReport, Heartbeat, JobFailure, JobProgress, LeaseGrant, Release};
use granary_core::stage::StageFailure;
use serde_json::{Value, json};
use sqlx::sqlite::{SqliteConnectOptions, SqlitePool};

use crate::harness::{Fresh, fresh_with, sweep_of};

/// What must never be found, each with the promise that it would break.
const BROKEN: [(&str, &str); 7] = [
    (
        "a want follows its job",
        "select count(*) from want w join job j on j.id = w.job where w.state <> j.state",
    ),
    (
        "done means an outcome",
        "select count(*) from job j left join outcome o on o.job = j.id where (j.state = 'done') <> (o.job is not null)",
    ),
    (
        "ready means that what is needed is done",
        "select count(*) from job j join job n on n.id = j.needs where j.state in ('ready', 'leased') and n.state <> 'done'",
    ),
    (
        "blocked means that it is not",
        "select count(*) from job j join job n on n.id = j.needs where j.state = 'blocked' and n.state = 'done'",
    ),
    (
        "a lease holds a job",
        "select count(*) from lease l where not exists (select 1 from job where lease = l.id)",
    ),
    (
        "an open attempt is a leased job",
        "select (select count(*) from attempt where ended_at is null) - (select count(*) from job where state = 'leased')",
    ),
    (
        "what waits is wanted",
        "select count(*) from job where state in ('blocked', 'ready') and not exists (select 1 from want w join sweep s on s.id = w.sweep where w.job = job.id and s.state <> 'cancelled')",
    ),
];

/// A generator with a seed, so that a walk can be walked again (splitmix64).
struct Dice(u64);

impl Dice {
    fn roll(&mut self, sides: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % sides as u64) as usize
    }
}

fn spec(k: usize) -> Value {
    json!({
        "name": format!("sweep {k}"), "model": "memory", "priority": k, "fixed": {"grains": 20},
        "grid": [{"packing_seed": {"range": [1, k + 1]}, "waveform": ["six/1", "six/2", "zero"]}],
    })
}

struct Walk {
    fresh: Fresh,
    dice: Dice,
    sweeps: Vec<SweepId>,
    held: Vec<LeaseGrant>,
}

impl Walk {
    async fn step(&mut self) {
        match self.dice.roll(10) {
            0 => {
                let k = self.dice.roll(3);
                let sweep = sweep_of(&self.fresh.submit(&spec(k)).await);
                if !self.sweeps.contains(&sweep) {
                    self.sweeps.push(sweep);
                }
            }
            1 => self.steer().await,
            2..=4 => self.held.extend(self.fresh.take().await),
            _ => self.answer().await,
        }
    }

    async fn steer(&mut self) {
        if self.sweeps.is_empty() {
            return;
        }
        let sweep = self.sweeps[self.dice.roll(self.sweeps.len())];
        let store = &self.fresh.store;
        let steered = match self.dice.roll(4) {
            0 => store.sweep_cancel(sweep).await,
            1 => store.sweep_pause(sweep).await,
            2 => store.sweep_retry(sweep).await,
            _ => store.sweep_resume(sweep).await,
        };
        steered.expect("a known sweep");
    }

    /// Whatever a worker may say of a lease that it believes to hold; a refusal is an answer too.
    async fn answer(&mut self) {
        if self.held.is_empty() {
            return;
        }
        let grant = self.held.swap_remove(self.dice.roll(self.held.len()));
        let store = &self.fresh.store;
        let at = |job| JobProgress {
            job,
            step: 1,
            steps: 2,
            checkpoint: None,
        };
        let jobs: Vec<JobProgress> = grant.jobs.iter().map(|job| at(job.job)).collect();
        match self.dice.roll(6) {
            0 => drop(
                store
                    .lease_reap(grant.lease, 0)
                    .await
                    .expect("the store answers"),
            ),
            1 => drop(store.lease_release(grant.lease, &Release { jobs }).await),
            2 => {
                let failure = StageFailure::Input {
                    detail: "a disk is full".to_owned(),
                };
                let failures = vec![JobFailure {
                    job: grant.jobs[0].job,
                    failure,
                }];
                drop(
                    store
                        .lease_fail(grant.lease, &FailureReport { failures })
                        .await,
                );
                self.held.push(grant);
            }
            3 => {
                drop(
                    store
                        .lease_heartbeat(grant.lease, &Heartbeat { jobs })
                        .await,
                );
                self.held.push(grant);
            }
            _ => {
                let some = 1 + self.dice.roll(grant.jobs.len());
                let completion = self.fresh.outcomes(&grant.jobs[..some]).await;
                drop(
                    self.fresh
                        .store
                        .lease_complete(grant.lease, &completion)
                        .await,
                );
                self.held.push(grant);
            }
        }
        self.held.truncate(20);
    }
}

async fn check(database: &SqlitePool, step: usize) {
    for (promise, broken) in BROKEN {
        let found: i64 = sqlx::query_scalar(broken)
            .fetch_one(database)
            .await
            .expect("a count");
        assert_eq!(found, 0, "step {step}: {promise}");
    }
}

#[tokio::test]
async fn every_promise_holds_after_every_step_and_all_work_is_done_in_the_end() {
    for seed in 1..=4 {
        let fresh = fresh_with(|_| {}).await;
        let file = fresh.directory.path().join("granary.sqlite");
        let options = SqliteConnectOptions::new().filename(file).read_only(true);
        let database = SqlitePool::connect_with(options).await.expect("a reader");
        let mut walk = Walk {
            fresh,
            dice: Dice(seed),
            sweeps: vec![],
            held: vec![],
        };
        for step in 0..150 {
            walk.step().await;
            check(&database, step).await;
        }
        let store = &walk.fresh.store;
        for (lease, beat) in store.lease_beats().await.expect("leases") {
            store.lease_reap(lease, beat).await.expect("reaped");
        }
        for sweep in &walk.sweeps {
            store.sweep_resume(*sweep).await.expect("resumed");
            store.sweep_retry(*sweep).await.expect("retried");
        }
        walk.fresh.work().await;
        check(&database, usize::MAX).await;
        for sweep in &walk.sweeps {
            let points = store.sweep_read(*sweep).await.expect("the sweep").points;
            assert_eq!(points.done, points.total, "seed {seed}: {points:?}");
        }
    }
}
