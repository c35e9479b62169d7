//! Leases: who gets what, and whose answer counts.

use std::time::Duration;

use granary_api::id::LeaseId;
use granary_api::job::JobState;
use granary_api::lease::{Heartbeat, JobProgress, LeasedJob};
use granary_core::stage::{StageKind, StageSpec};
use granary_server::StoreError;
use granary_server::reaper::Reaper;
use serde_json::json;

use crate::harness::{asking, fresh, outcome, single, spec, sweep_of};

fn progress(job: &LeasedJob, step: u64) -> JobProgress {
    JobProgress {
        job: job.job,
        step,
        steps: 1000,
        checkpoint: None,
    }
}

#[tokio::test]
async fn jobs_come_in_the_order_of_their_needs_and_recalls_of_one_pack_together() {
    let fresh = fresh().await;
    fresh.submit(&spec()).await;
    let mut kinds = vec![];
    while let Some(grant) = fresh.take().await {
        let kind = grant.jobs[0].spec.kind();
        assert!(
            grant
                .jobs
                .iter()
                .all(|job| job.spec.ensemble_key() == grant.jobs[0].spec.ensemble_key())
        );
        assert_eq!(grant.jobs[0].input.is_some(), kind != StageKind::Pack);
        kinds.push((kind, grant.jobs.len()));
        fresh.complete(grant.lease, &grant.jobs).await;
    }
    let of = |kind| {
        kinds
            .iter()
            .filter(|(k, _)| *k == kind)
            .map(|(_, n)| *n)
            .collect::<Vec<_>>()
    };
    assert_eq!(of(StageKind::Pack), [1, 1]);
    assert_eq!(of(StageKind::Train), [1; 4]);
    // Three waveforms and the zero beside them, in each of four trained packs.
    assert_eq!(of(StageKind::Recall), [4; 4]);
}

#[tokio::test]
async fn words_go_on_from_encodings_and_never_beside_what_begins_elsewhere() {
    let fresh = fresh().await;
    let spec = json!({
        "name": "words", "model": "memory", "fixed": {"grains": 10}, "preset": "paper",
        "grid": [
            {"waveform": {"suite": "binary_words", "bits": 5}},
            {"waveform": {"suite": "binary_words", "bits": 6}},
            {"waveform": {"suite": "six"}},
        ],
    });
    let submitted = fresh.submit(&spec).await;
    // A pack, a train and a zero; an encoding for every eight words.
    assert_eq!(submitted.jobs.total, 32 + 64 + 6 + 3 + 4 + 8);
    let mut counts = std::collections::BTreeMap::new();
    while let Some(grant) = fresh.take().await {
        let needs = |job: &LeasedJob| job.spec.needs();
        let goes_on = grant.jobs[0].spec.goes_on();
        for job in &grant.jobs {
            // What is side by side begins at one step: of one trained pack, or of encodings of one length.
            assert_eq!(job.spec.goes_on(), goes_on);
            assert!(goes_on || needs(job) == needs(&grant.jobs[0]));
            assert_eq!(steps_before(job), steps_before(&grant.jobs[0]));
            assert_eq!(job.input.is_some(), job.spec.kind() != StageKind::Pack);
        }
        let kind = grant.jobs[0].spec.kind();
        *counts.entry((kind, goes_on)).or_insert(0) += grant.jobs.len();
        fresh.complete(grant.lease, &grant.jobs).await;
    }
    assert_eq!(counts[&(StageKind::Encode, false)], 4 + 8);
    assert_eq!(counts[&(StageKind::Recall, true)], 32 + 64);
    assert_eq!(counts[&(StageKind::Recall, false)], 6 + 1);
    let sweep = sweep_of(&submitted);
    let done = fresh.store.sweep_read(sweep).await.expect("the sweep");
    assert_eq!(done.points.done, 32 + 64 + 6);
}

fn steps_before(job: &LeasedJob) -> u64 {
    match &job.spec {
        StageSpec::Recall(recall) => recall.steps_before(),
        _ => 0,
    }
}

#[tokio::test]
async fn no_job_is_given_twice() {
    let fresh = fresh().await;
    fresh.submit(&spec()).await;
    let first = fresh.take().await.expect("a pack");
    let second = fresh.take().await.expect("the other pack");
    assert_ne!(first.jobs[0].job, second.jobs[0].job);
    assert!(fresh.take().await.is_none());
}

#[tokio::test]
async fn answer_under_another_lease_changes_nothing() {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&single("six/1")).await);
    let stale = fresh.take().await.expect("the pack");
    assert_eq!(
        fresh
            .store
            .lease_reap(stale.lease, 0)
            .await
            .expect("reaped"),
        1
    );
    let current = fresh.take().await.expect("the pack again");
    assert_eq!(stale.jobs[0].job, current.jobs[0].job);
    let late = fresh.outcomes(&stale.jobs).await;
    let refused = fresh.store.lease_complete(stale.lease, &late).await;
    assert!(matches!(refused, Err(StoreError::LeaseLost(jobs)) if jobs == [stale.jobs[0].job]));
    let job = fresh
        .store
        .job_read(&stale.jobs[0].job)
        .await
        .expect("a job");
    assert_eq!(
        (job.state, job.losses, job.attempts.len()),
        (JobState::Leased, 1, 2)
    );
    fresh.complete(current.lease, &current.jobs).await;
    fresh.work().await;
    let done = fresh.store.sweep_read(sweep).await.expect("the sweep");
    assert_eq!(done.points.done, 1);
}

#[tokio::test]
async fn lost_lease_is_409_with_a_problem_document() {
    let fresh = fresh().await;
    fresh.submit(&single("six/1")).await;
    let grant = fresh.take().await.expect("the pack");
    let completion = json!(fresh.outcomes(&grant.jobs).await);
    let path = format!("/api/v1/leases/{}/complete", LeaseId::new());
    let answer = fresh.post(&path, &completion).await;
    assert_eq!(answer.status, 409);
    assert_eq!(answer.json()["type"], "/problems/lease_lost");
    assert_eq!(answer.headers["content-type"], "application/problem+json");
}

#[tokio::test]
async fn completion_said_twice_is_recorded_once_and_accepted_again() {
    let fresh = fresh().await;
    fresh.submit(&single("six/1")).await;
    let grant = fresh.take().await.expect("the pack");
    fresh.complete(grant.lease, &grant.jobs).await;
    fresh.complete(grant.lease, &grant.jobs).await;
    let job = fresh
        .store
        .job_read(&grant.jobs[0].job)
        .await
        .expect("a job");
    assert_eq!((job.state, job.attempts.len()), (JobState::Done, 1));
}

#[tokio::test]
async fn second_result_for_a_stage_is_told_and_never_written_over_the_first() {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&single("six/1")).await);
    let slow = fresh.take().await.expect("the pack");
    fresh.store.lease_reap(slow.lease, 0).await.expect("reaped");
    let quick = fresh.take().await.expect("the pack again");
    fresh.complete(quick.lease, &quick.jobs).await;
    let mut other = outcome(&slow.jobs[0].spec);
    other.steps += 1;
    let report = fresh.report(&slow.jobs[0], &other).await;
    let completion = granary_api::lease::Completion {
        outcomes: vec![report],
    };
    assert!(
        fresh
            .store
            .lease_complete(slow.lease, &completion)
            .await
            .is_err()
    );
    let job = fresh
        .store
        .job_read(&slow.jobs[0].job)
        .await
        .expect("a job");
    assert_eq!(job.result_hash, Some(outcome(&slow.jobs[0].spec).hash()));
    assert_eq!(job.diverged, [other.hash()]);
    let events = fresh.get(&format!("/api/v1/jobs/{}", job.job)).await.json();
    assert_eq!(events["sweeps"], json!([sweep]));
    fresh.work().await;
}

#[tokio::test]
async fn outcome_without_its_artifact_is_refused() {
    let fresh = fresh().await;
    fresh.submit(&single("six/1")).await;
    let grant = fresh.take().await.expect("the pack");
    let mut completion = fresh.outcomes(&grant.jobs).await;
    let missing = granary_api::id::ArtifactHash::of_bytes(b"never stored");
    completion.outcomes[0]
        .artifacts
        .insert("state".to_owned(), missing);
    let refused = fresh.store.lease_complete(grant.lease, &completion).await;
    assert!(
        matches!(refused, Err(StoreError::Invalid(mistakes)) if mistakes[0].pointer == "/outcomes/0/artifacts/state")
    );
    fresh.complete(grant.lease, &grant.jobs).await;
}

#[tokio::test]
async fn outcome_that_is_not_the_one_that_was_hashed_is_refused() {
    let fresh = fresh().await;
    fresh.submit(&single("six/1")).await;
    let grant = fresh.take().await.expect("the pack");
    let good = fresh.outcomes(&grant.jobs).await;
    let path = format!("/api/v1/leases/{}/complete", grant.lease);
    let mut other = good.clone();
    let results = &mut other.outcomes[0].results;
    results.insert(
        "encode_correlation".to_owned(),
        Some(0.900_000_000_000_000_1),
    );
    let mut steps = good.clone();
    steps.outcomes[0].provenance.steps += 1;
    let mut warned = good.clone();
    warned.outcomes[0].warnings.push("all is well".to_owned());
    for damaged in [other, steps, warned] {
        let answer = fresh.post(&path, &json!(damaged)).await;
        assert_eq!(answer.status, 422, "{}", answer.text());
        let problem = answer.json();
        assert_eq!(problem["type"], "/problems/result-mismatch");
        assert_eq!(problem["errors"][0]["pointer"], "/outcomes/0/result_hash");
    }
    let job = fresh.store.job_read(&grant.jobs[0].job).await;
    assert_eq!(job.expect("a job").state, JobState::Leased);
    assert_eq!(fresh.post(&path, &json!(good)).await.status, 204);
}

#[tokio::test]
async fn silent_worker_loses_its_jobs_after_a_full_term_and_a_beating_one_keeps_them() {
    let fresh = fresh().await;
    fresh.submit(&spec()).await;
    let (silent, beating) = (
        fresh.take().await.expect("a pack"),
        fresh.take().await.expect("a pack"),
    );
    let mut reaper = Reaper::default();
    let clock = Duration::from_secs;
    assert_eq!(
        reaper.sweep(&fresh.store, clock(0)).await.expect("looked"),
        0
    );
    let beat = Heartbeat {
        jobs: vec![progress(&beating.jobs[0], 10)],
    };
    fresh
        .store
        .lease_heartbeat(beating.lease, &beat)
        .await
        .expect("ours");
    assert_eq!(
        reaper.sweep(&fresh.store, clock(29)).await.expect("looked"),
        0
    );
    assert_eq!(
        reaper.sweep(&fresh.store, clock(30)).await.expect("looked"),
        1
    );
    let back = fresh.take().await.expect("the silent worker's pack");
    assert_eq!(back.jobs[0].job, silent.jobs[0].job);
    fresh.complete(beating.lease, &beating.jobs).await;
}

#[tokio::test]
async fn beat_that_arrives_before_the_reaper_acts_saves_the_lease() {
    let fresh = fresh().await;
    fresh.submit(&single("six/1")).await;
    let grant = fresh.take().await.expect("the pack");
    let beat = Heartbeat {
        jobs: vec![progress(&grant.jobs[0], 1)],
    };
    fresh
        .store
        .lease_heartbeat(grant.lease, &beat)
        .await
        .expect("ours");
    // The reaper saw beat 0 go stale, but beat 1 has come in meanwhile.
    assert_eq!(
        fresh
            .store
            .lease_reap(grant.lease, 0)
            .await
            .expect("looked"),
        0
    );
    fresh.complete(grant.lease, &grant.jobs).await;
}

#[tokio::test]
async fn checkpoint_goes_to_the_next_worker_and_only_equal_steps_run_together() {
    let fresh = fresh().await;
    fresh.submit(&single("six/1")).await;
    for _ in 0..2 {
        let grant = fresh.take().await.expect("pack, then train");
        fresh.complete(grant.lease, &grant.jobs).await;
    }
    let grant = fresh.take().await.expect("a recall and its zero");
    assert_eq!(grant.jobs.len(), 2);
    let checkpoint = fresh
        .store
        .artifact_put(b"half way".to_vec())
        .await
        .expect("stored");
    let half = JobProgress {
        checkpoint: Some(checkpoint),
        ..progress(&grant.jobs[0], 500)
    };
    let beat = Heartbeat {
        jobs: vec![half, progress(&grant.jobs[1], 500)],
    };
    fresh
        .store
        .lease_heartbeat(grant.lease, &beat)
        .await
        .expect("ours");
    fresh
        .store
        .lease_reap(grant.lease, 1)
        .await
        .expect("reaped");
    let (one, two) = (
        fresh.take().await.expect("one"),
        fresh.take().await.expect("two"),
    );
    let mut checkpoints = [one.jobs[0].checkpoint, two.jobs[0].checkpoint];
    checkpoints.sort();
    assert_eq!(
        (one.jobs.len(), two.jobs.len(), checkpoints),
        (1, 1, [None, Some(checkpoint)])
    );
}

#[tokio::test]
async fn replaced_checkpoint_is_removed_and_the_current_one_stays() {
    let fresh = fresh().await;
    fresh.submit(&single("six/1")).await;
    let grant = fresh.take().await.expect("the pack");
    let (old, new) = (
        fresh
            .store
            .artifact_put(b"old".to_vec())
            .await
            .expect("stored"),
        fresh
            .store
            .artifact_put(b"new".to_vec())
            .await
            .expect("stored"),
    );
    for (step, checkpoint) in [(1, old), (2, new)] {
        let at = JobProgress {
            checkpoint: Some(checkpoint),
            ..progress(&grant.jobs[0], step)
        };
        let beat = Heartbeat { jobs: vec![at] };
        fresh
            .store
            .lease_heartbeat(grant.lease, &beat)
            .await
            .expect("ours");
    }
    assert!(!fresh.store.artifact_exists(&old).await);
    assert!(fresh.store.artifact_exists(&new).await);
    fresh.complete(grant.lease, &grant.jobs).await;
    assert!(!fresh.store.artifact_exists(&new).await);
}

#[tokio::test]
async fn worker_of_another_physics_or_with_too_little_memory_gets_nothing() {
    let fresh = fresh().await;
    fresh.submit(&single("six/1")).await;
    let mut other = asking("worker");
    other.physics_version += 1;
    assert!(
        fresh
            .store
            .lease_take(&other)
            .await
            .expect("answered")
            .is_none()
    );
    let mut small = asking("worker");
    small.memory_bytes = 10;
    assert!(
        fresh
            .store
            .lease_take(&small)
            .await
            .expect("answered")
            .is_none()
    );
    assert!(fresh.take().await.is_some());
}

#[tokio::test]
async fn waiting_worker_is_woken_by_a_submission() {
    let fresh = fresh().await;
    let store = fresh.store.clone();
    let mut request = asking("patient");
    request.wait_s = 30.0;
    let waiting = tokio::spawn(async move { store.lease_wait(&request).await });
    fresh.submit(&single("six/1")).await;
    let woken = tokio::time::timeout(Duration::from_secs(20), waiting).await;
    assert!(
        woken
            .expect("in time")
            .expect("no panic")
            .expect("answered")
            .is_some()
    );
}

#[tokio::test]
async fn higher_priority_first_then_the_sweep_with_fewest_leases() {
    let fresh = fresh().await;
    let sweep = |name: &str, seed: u64, priority: i64| {
        json!({"name": name, "model": "memory", "priority": priority, "fixed": {"grains": 50},
               "grid": [{"packing_seed": {"range": [seed, seed + 2]}}]})
    };
    for (name, seed, priority) in [("a", 10, 0), ("b", 20, 0), ("urgent", 30, 5)] {
        fresh.submit(&sweep(name, seed, priority)).await;
    }
    let mut seeds = vec![];
    while let Some(grant) = fresh.take().await {
        if let granary_core::stage::StageSpec::Pack(pack) = &grant.jobs[0].spec {
            seeds.push(pack.packing_seed);
        }
    }
    assert_eq!(seeds, [30, 31, 32, 10, 20, 11, 21, 12, 22]);
}

#[tokio::test]
async fn workers_are_listed_with_what_they_hold() {
    let fresh = fresh().await;
    fresh.submit(&single("six/1")).await;
    let grant = fresh.take_as("busy").await.expect("the pack");
    fresh.take_as("idle").await;
    let answer = fresh.get("/api/v1/workers").await.json();
    let state = |name: &str| {
        let rows = answer["items"].as_array().expect("rows");
        rows.iter().find(|row| row["worker"] == name).expect(name)["state"].clone()
    };
    assert_eq!(
        (state("busy"), state("idle")),
        (json!("working"), json!("idle"))
    );
    fresh.complete(grant.lease, &grant.jobs).await;
}

#[tokio::test]
async fn report_that_names_a_job_twice_is_refused_whole() {
    let fresh = fresh().await;
    fresh.submit(&single("six/1")).await;
    let grant = fresh.take().await.expect("the pack");
    let mut completion = fresh.outcomes(&grant.jobs).await;
    completion.outcomes.push(completion.outcomes[0].clone());
    let refused = fresh.store.lease_complete(grant.lease, &completion).await;
    assert!(
        matches!(refused, Err(StoreError::Invalid(mistakes)) if mistakes[0].pointer == "/outcomes/1/job")
    );
    fresh.complete(grant.lease, &grant.jobs).await;
}
