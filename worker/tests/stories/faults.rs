//! Failures of physics, of machines and of permissions.

use std::sync::Arc;

use granary_api::id::ArtifactHash;
use granary_core::stage::StageFailure;
use granary_worker::execute::Engine;

use crate::engines::{instant, outcome, scripted};
use crate::scripted_server::ScriptedServer;
use crate::{Worker, config, grant};

fn unstable() -> StageFailure {
    StageFailure::Stopped {
        kind: "unstable".to_owned(),
        step: 4000,
        detail: "the time step is above the measured critical one".to_owned(),
        remedy: "take time_step below 1.9".to_owned(),
    }
}

#[tokio::test]
async fn a_stopped_lane_fails_and_the_others_complete() {
    let server = ScriptedServer::start().await;
    let lease = grant(3, None);
    let jobs: Vec<_> = lease.jobs.iter().map(|job| job.job).collect();
    server.change(|script| script.grants.push_back(lease));
    let results = vec![Ok(outcome(0)), Err(unstable()), Ok(outcome(2))];
    let worker = Worker::start(&server, scripted(results), config());
    let script = server.until(|script| !script.failures.is_empty()).await;
    assert_eq!(script.outcomes.len(), 2);
    assert_eq!(script.failures[0].job, jobs[1]);
    assert_eq!(script.failures[0].failure, unstable());
    worker.stop().await.expect("a clean end");
}

/// The one failure that a lease with `engine` leads to.
async fn failure_of(engine: Engine, input: Option<ArtifactHash>) -> StageFailure {
    let server = ScriptedServer::start().await;
    server.change(|script| script.grants.push_back(grant(1, input)));
    let worker = Worker::start(&server, engine, config());
    let script = server.until(|script| !script.failures.is_empty()).await;
    assert!(script.outcomes.is_empty());
    worker.stop().await.expect("a clean end");
    script.failures[0].failure.clone()
}

#[tokio::test]
async fn a_missing_input_is_a_fault_of_the_machine() {
    let nowhere = ArtifactHash::of_bytes(b"nowhere");
    let failure = failure_of(instant(), Some(nowhere)).await;
    let StageFailure::Input { detail } = failure else {
        panic!("{failure}");
    };
    assert!(detail.contains("is not stored"), "{detail}");
}

#[tokio::test]
async fn a_panic_of_the_engine_is_a_fault_of_the_machine_and_the_worker_lives() {
    let engine: Engine = Arc::new(|_, _| panic!("grain 7 is missing"));
    let failure = failure_of(engine, None).await;
    assert_eq!(
        failure,
        StageFailure::Input {
            detail: "the engine panicked: grain 7 is missing".to_owned()
        }
    );
}

#[tokio::test]
async fn an_engine_that_stops_unasked_is_not_given_the_job_for_ever() {
    let results = vec![Err(StageFailure::Interrupted { step: 7 })];
    let failure = failure_of(scripted(results), None).await;
    assert!(matches!(failure, StageFailure::Input { .. }), "{failure}");
}

#[tokio::test]
async fn a_damaged_input_is_tried_twice_and_then_a_fault() {
    let server = ScriptedServer::start().await;
    let hash = ArtifactHash::of_bytes(b"whole");
    server.change(|script| {
        script.artifacts.insert(hash, "torn".into());
        script.grants.push_back(grant(1, Some(hash)));
    });
    let worker = Worker::start(&server, instant(), config());
    let script = server.until(|script| !script.failures.is_empty()).await;
    assert!(
        script.failures[0]
            .failure
            .to_string()
            .contains("arrived damaged")
    );
    worker.stop().await.expect("a clean end");
}

#[tokio::test]
async fn a_wrong_token_ends_the_worker_with_the_reason() {
    let server = ScriptedServer::start().await;
    let worker = Worker::with_token(&server, "wrong", instant(), config());
    let error = worker.end().await.expect_err("refused");
    assert!(format!("{error:#}").contains("401"), "{error:#}");
}
