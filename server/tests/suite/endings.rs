//! Endings: failures, losses, poisoned jobs, and what comes of what needs them.

use granary_api::job::JobState;
use granary_api::lease::{FailureReport, JobFailure, LeaseGrant, Release};
use granary_core::stage::StageFailure;
use serde_json::json;

use crate::harness::{Fresh, fresh, single, spec, sweep_of};

fn stopped() -> StageFailure {
    StageFailure::Stopped {
        kind: "unstable".to_owned(),
        step: 812,
        detail: "grain 17 moves at 3.1 R/t_c".to_owned(),
        remedy: "shorten time_step below 1.9".to_owned(),
    }
}

fn input() -> StageFailure {
    StageFailure::Input {
        detail: "the checkpoint ends early".to_owned(),
    }
}

async fn fail(fresh: &Fresh, grant: &LeaseGrant, failure: &StageFailure) {
    let failures = grant.jobs.iter().map(|job| JobFailure {
        job: job.job,
        failure: failure.clone(),
    });
    let report = FailureReport {
        failures: failures.collect(),
    };
    fresh
        .store
        .lease_fail(grant.lease, &report)
        .await
        .expect("the lease is ours");
}

#[tokio::test]
async fn failure_of_physics_is_cached_and_fails_what_needs_it_with_a_reason() {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&single("six/1")).await);
    let pack = fresh.take().await.expect("the pack");
    fail(&fresh, &pack, &stopped()).await;
    assert!(fresh.take().await.is_none(), "nothing is left to do");
    let rows = fresh
        .get(&format!("/api/v1/sweeps/{sweep}/points"))
        .await
        .json();
    let row = &rows["items"][0];
    assert_eq!(row["state"], "failed");
    assert_eq!(row["failure"]["reason"], "needs");
    assert_eq!(row["failure"]["job"], json!(pack.jobs[0].job));
    let message = row["failure"]["message"].as_str().expect("a message");
    assert!(message.contains("unstable at step 812"), "{message}");
    // The same physics again fails at once, in a new sweep too, and nothing is run.
    let again = fresh.submit(&single("six/2")).await;
    assert!(fresh.take().await.is_none());
    let summary = fresh
        .store
        .sweep_read(sweep_of(&again))
        .await
        .expect("the sweep");
    assert_eq!(
        (summary.points.failed, summary.state),
        (1, granary_api::sweep::SweepState::Finished)
    );
}

#[tokio::test]
async fn one_failed_point_leaves_the_others_alone() {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&spec()).await);
    let mut failed = false;
    while let Some(grant) = fresh.take().await {
        if grant.jobs.len() > 1 && !failed {
            failed = true;
            // The first waveform of this pack breaks down; the rest of its ensemble goes on.
            let point = grant
                .jobs
                .iter()
                .position(|job| job.spec.id() != job.spec.ensemble_key());
            let broken = grant.jobs[point.expect("not only the zero")].job;
            let failures = vec![JobFailure {
                job: broken,
                failure: stopped(),
            }];
            fresh
                .store
                .lease_fail(grant.lease, &FailureReport { failures })
                .await
                .expect("ours");
            let rest: Vec<_> = grant
                .jobs
                .iter()
                .filter(|job| job.job != broken)
                .cloned()
                .collect();
            fresh.complete(grant.lease, &rest).await;
        } else {
            fresh.complete(grant.lease, &grant.jobs).await;
        }
    }
    let summary = fresh.store.sweep_read(sweep).await.expect("the sweep");
    assert_eq!((summary.points.done, summary.points.failed), (11, 1));
}

#[tokio::test]
async fn fault_of_the_machine_is_tried_three_times_and_retry_tries_again() {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&single("six/1")).await);
    for _ in 0..3 {
        let pack = fresh.take().await.expect("tried again");
        fail(&fresh, &pack, &input()).await;
    }
    assert!(fresh.take().await.is_none());
    let steered = fresh.store.sweep_retry(sweep).await.expect("retried");
    // The pack, the training, the recall and its zero.
    assert_eq!(steered.jobs, 4);
    assert_eq!(fresh.work().await.len(), 4);
    assert_eq!(
        fresh
            .store
            .sweep_read(sweep)
            .await
            .expect("the sweep")
            .points
            .done,
        1
    );
}

#[tokio::test]
async fn retry_leaves_failures_of_physics_alone() {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&single("six/1")).await);
    let pack = fresh.take().await.expect("the pack");
    fail(&fresh, &pack, &stopped()).await;
    assert_eq!(
        fresh.store.sweep_retry(sweep).await.expect("answered").jobs,
        0
    );
    assert!(fresh.take().await.is_none());
}

#[tokio::test]
async fn job_that_outlives_five_workers_is_set_aside_and_released_ones_never_are() {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&single("six/1")).await);
    for _ in 0..20 {
        let grant = fresh.take().await.expect("the pack");
        let release = Release {
            jobs: vec![granary_api::lease::JobProgress {
                job: grant.jobs[0].job,
                step: 1,
                steps: 10,
                checkpoint: None,
            }],
        };
        fresh
            .store
            .lease_release(grant.lease, &release)
            .await
            .expect("ours");
    }
    let mut job = None;
    for _ in 0..5 {
        let grant = fresh.take().await.expect("the pack");
        job = Some(grant.jobs[0].job);
        fresh
            .store
            .lease_reap(grant.lease, 0)
            .await
            .expect("reaped");
    }
    assert!(fresh.take().await.is_none());
    let detail = fresh
        .store
        .job_read(&job.expect("a pack"))
        .await
        .expect("a job");
    assert_eq!((detail.state, detail.losses), (JobState::Poisoned, 5));
    assert_eq!(
        fresh
            .store
            .sweep_read(sweep)
            .await
            .expect("the sweep")
            .points
            .failed,
        1
    );
    fresh.store.sweep_retry(sweep).await.expect("retried");
    assert_eq!(fresh.work().await.len(), 4);
}

#[tokio::test]
async fn attempts_and_log_tell_what_happened() {
    let fresh = fresh().await;
    fresh.submit(&single("six/1")).await;
    let first = fresh.take_as("node 7").await.expect("the pack");
    fresh
        .store
        .lease_reap(first.lease, 0)
        .await
        .expect("reaped");
    let second = fresh.take_as("node 8").await.expect("the pack");
    fail(&fresh, &second, &stopped()).await;
    let job = second.jobs[0].job;
    let log = fresh.get(&format!("/api/v1/jobs/{job}/log")).await.json();
    let lines: Vec<&str> = log["items"]
        .as_array()
        .expect("lines")
        .iter()
        .map(|line| line["message"].as_str().expect("text"))
        .collect();
    assert_eq!(
        lines,
        [
            "attempt 1: node 7 took it",
            "attempt 1: lost",
            "attempt 2: node 8 took it",
            "attempt 2: failed: unstable at step 812: grain 17 moves at 3.1 R/t_c; shorten time_step below 1.9",
        ]
    );
}
