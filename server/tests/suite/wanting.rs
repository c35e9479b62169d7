//! Wanting: shared stages, cancelling, pausing, resuming, extending.

use granary_api::lease::{Heartbeat, JobProgress};
use granary_api::sweep::SweepState;
use serde_json::{Value, json};

use crate::harness::{fresh, spec, sweep_of};

/// `seeds` packings under one friction, two waveforms.
fn packings(name: &str, seeds: u64) -> Value {
    json!({
        "name": name,
        "model": "memory",
        "fixed": {"grains": 100},
        "grid": [{"packing_seed": {"range": [1, seeds]}, "waveform": ["six/1", "six/2"]}],
    })
}

#[tokio::test]
async fn same_sweep_again_is_the_same_sweep_and_computes_nothing() {
    let fresh = fresh().await;
    let first = fresh.submit(&spec()).await;
    assert_eq!(
        (first.points, first.jobs.total, first.jobs.new),
        (12, 22, 22)
    );
    fresh.work().await;
    let again = fresh.submit(&spec()).await;
    assert_eq!(
        (again.sweep, again.created, again.jobs.new),
        (first.sweep, false, 0)
    );
    assert_eq!(
        (again.jobs.done, again.message.as_str()),
        (22, "12 of 12 already done")
    );
    assert!(fresh.take().await.is_none());
}

#[tokio::test]
async fn extending_three_packings_to_five_computes_two() {
    let fresh = fresh().await;
    fresh.submit(&packings("three", 3)).await;
    assert_eq!(fresh.work().await.len(), 3 * 5);
    let five = fresh.submit(&packings("five", 5)).await;
    // A packing is a pack, a train, a zero and two waveforms.
    assert_eq!(
        (five.jobs.done, five.jobs.new, five.points_done),
        (15, 10, 6)
    );
    assert_eq!(fresh.work().await.len(), 10);
}

#[tokio::test]
async fn cancelling_half_way_and_submitting_again_computes_the_rest() {
    let fresh = fresh().await;
    let first = fresh.submit(&spec()).await;
    for _ in 0..5 {
        let grant = fresh.take().await.expect("work");
        fresh.complete(grant.lease, &grant.jobs).await;
    }
    let before = fresh.submit(&spec()).await.jobs.done;
    fresh
        .store
        .sweep_cancel(sweep_of(&first))
        .await
        .expect("cancelled");
    assert!(fresh.take().await.is_none());
    let summary = fresh
        .store
        .sweep_read(sweep_of(&first))
        .await
        .expect("the sweep");
    assert_eq!(summary.state, SweepState::Cancelled);
    let again = fresh.submit(&spec()).await;
    assert_eq!(
        (again.sweep, again.jobs.new, again.jobs.done),
        (first.sweep, 0, before)
    );
    assert_eq!(fresh.work().await.len() as u64, 22 - before);
}

#[tokio::test]
async fn job_that_another_sweep_wants_survives_a_cancel() {
    let fresh = fresh().await;
    let small = fresh.submit(&packings("small", 1)).await;
    let large = fresh.submit(&packings("large", 2)).await;
    let cancelled = fresh
        .store
        .sweep_cancel(sweep_of(&large))
        .await
        .expect("cancelled");
    assert_eq!(cancelled.jobs, 5);
    assert_eq!(fresh.work().await.len(), 5);
    let summary = fresh
        .store
        .sweep_read(sweep_of(&small))
        .await
        .expect("the sweep");
    assert_eq!(
        (summary.points.done, summary.state),
        (2, SweepState::Finished)
    );
}

#[tokio::test]
async fn running_job_that_nobody_wants_is_dropped_at_its_next_heartbeat() {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&packings("one", 1)).await);
    let grant = fresh.take().await.expect("the pack");
    fresh.store.sweep_cancel(sweep).await.expect("cancelled");
    let at = JobProgress {
        job: grant.jobs[0].job,
        step: 5,
        steps: 10,
        checkpoint: None,
    };
    let beat = Heartbeat { jobs: vec![at] };
    let reply = fresh
        .store
        .lease_heartbeat(grant.lease, &beat)
        .await
        .expect("ours");
    assert_eq!(reply.stop, [grant.jobs[0].job]);
    fresh.store.sweep_resume(sweep).await.expect("resumed");
    assert_eq!(fresh.work().await.len(), 5);
}

#[tokio::test]
async fn paused_sweep_gives_no_work_until_it_is_resumed() {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&packings("one", 1)).await);
    assert_eq!(
        fresh.store.sweep_pause(sweep).await.expect("paused").state,
        SweepState::Paused
    );
    assert!(fresh.take().await.is_none());
    assert_eq!(
        fresh
            .store
            .sweep_resume(sweep)
            .await
            .expect("resumed")
            .state,
        SweepState::Active
    );
    assert_eq!(fresh.work().await.len(), 5);
}

#[tokio::test]
async fn dry_run_counts_and_queues_nothing() {
    let fresh = fresh().await;
    let answer = fresh.post("/api/v1/sweeps?dry_run=true", &spec()).await;
    assert_eq!(answer.status, 200);
    let reply = answer.json();
    assert_eq!(
        (&reply["points"], &reply["jobs"]["new"], &reply["sweep"]),
        (&json!(12), &json!(22), &Value::Null)
    );
    assert!(
        reply["predicted"]["core_seconds"]
            .as_f64()
            .expect("a number")
            > 0.0
    );
    assert_eq!(reply["predicted"]["basis"], "default");
    assert!(fresh.take().await.is_none());
    assert_eq!(fresh.get("/api/v1/sweeps").await.json()["total"], 0);
}

#[tokio::test]
async fn prediction_follows_what_was_measured_here() {
    let fresh = fresh().await;
    fresh.submit(&packings("one", 1)).await;
    fresh.work().await;
    // Every made-up job took one second, so ten jobs like them take ten.
    let more = fresh.submit(&packings("three", 3)).await;
    assert_eq!(more.predicted.basis, "measured");
    assert!(
        (more.predicted.core_seconds - 10.0).abs() < 1e-6,
        "{:?}",
        more.predicted
    );
}

#[tokio::test]
async fn idempotency_key_finds_its_sweep_again_and_refuses_another() {
    let fresh = fresh().await;
    let submission = granary_server::Submission {
        dry_run: false,
        idempotency_key: Some("k1".to_owned()),
    };
    let submit = |spec: Value| {
        let (store, submission) = (fresh.store.clone(), submission.clone());
        async move { granary_server::submit(&store, &spec, &submission).await }
    };
    let first = submit(spec()).await.expect("queued");
    assert_eq!(submit(spec()).await.expect("found").sweep, first.sweep);
    let other = submit(packings("other", 1)).await;
    assert!(matches!(other, Err(granary_server::StoreError::KeyReused)));
}

#[tokio::test]
async fn zero_waveform_that_the_user_lists_is_the_helper_too() {
    let fresh = fresh().await;
    let mut spec = packings("with zero", 1);
    spec["grid"][0]["waveform"] = json!(["zero", "six/1"]);
    let submitted = fresh.submit(&spec).await;
    assert_eq!((submitted.points, submitted.jobs.total), (2, 4));
}

#[tokio::test]
async fn sub2_alone_plans_no_zero() {
    let fresh = fresh().await;
    let mut spec = packings("sub2", 1);
    spec["reduce"] =
        json!([{"kind": "gain_fidelity", "over": ["waveform"], "processing": ["SUB2"]}]);
    assert_eq!(fresh.submit(&spec).await.jobs.total, 4);
}
