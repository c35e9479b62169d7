//! What every lease client must do, told once and run against both: directly and over HTTP.

use std::collections::BTreeMap;
use std::time::Duration;

use axum::body::Bytes;
use granary_api::id::{ArtifactHash, JobId, LeaseId, WorkerId};
use granary_api::lease::{
    Completion, FailureReport, Heartbeat, JobFailure, JobOutcome, JobProgress, LeaseGrant,
    LeaseRequest, LeasedJob, Provenance, Release,
};
use granary_core::PHYSICS_VERSION;
use granary_core::stage::{Outcome, STATE, StageFailure, StageKind};
use granary_server::{Config, Store, Submission};
use granary_worker::lease_client::http::HttpLeaseClient;
use granary_worker::lease_client::{ClientError, LeaseClient};
use serde_json::json;
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

use crate::direct::DirectLeaseClient;

/// A store with one sweep in it: one pack, one trained pack, six recalls and the zero signal.
async fn store(directory: &tempfile::TempDir) -> Store {
    let store = Store::open(Config::new(directory.path()), "a test").await;
    let store = store.expect("a fresh directory");
    let spec = json!({
        "name": "conformance",
        "model": "memory",
        "fixed": {"grains": 5},
        "grid": [{"waveform": {"suite": "six"}}],
    });
    let submitted = granary_server::submit(&store, &spec, &Submission::default()).await;
    assert_eq!(submitted.expect("a valid spec").points, 6);
    store
}

/// Runs `$story` against both clients, each with a store of its own.
macro_rules! conform {
    ($($story:ident),* $(,)?) => {
        mod directly {
            $(#[tokio::test]
            async fn $story() {
                let directory = tempfile::tempdir().expect("temporary directory");
                let store = super::store(&directory).await;
                super::$story(super::DirectLeaseClient::new(store.clone()), store).await;
            })*
        }

        mod over_http {
            $(#[tokio::test]
            async fn $story() {
                let directory = tempfile::tempdir().expect("temporary directory");
                let store = super::store(&directory).await;
                let client = super::serve(&store).await;
                super::$story(client, store).await;
            })*
        }
    };
}

conform!(
    a_worker_is_given_what_is_ready_and_then_nothing,
    a_worker_of_another_physics_is_given_nothing,
    artifacts_are_kept_under_their_hash_alone,
    outcomes_make_what_needs_them_ready,
    recalls_of_one_pack_come_as_lanes_of_one_lease,
    a_completion_said_twice_counts_once,
    an_outcome_whose_files_are_missing_is_refused,
    another_lease_changes_nothing,
    a_machine_fault_is_tried_again_and_broken_physics_is_not,
    a_released_job_comes_back_with_its_checkpoint,
    a_cancelled_job_is_named_at_the_next_heartbeat,
);

/// A client of a server that answers for `store` on a free port.
async fn serve(store: &Store) -> HttpLeaseClient {
    let listener = TcpListener::bind(("127.0.0.1", 0)).await.expect("a port");
    let address = listener.local_addr().expect("bound");
    let app = granary_server::app(store.clone(), CancellationToken::new(), None);
    tokio::spawn(async move { axum::serve(listener, app).await });
    HttpLeaseClient::new(&format!("http://{address}"), None).expect("an address")
}

fn request() -> LeaseRequest {
    LeaseRequest {
        worker: WorkerId("host/1/1".to_owned()),
        physics_version: PHYSICS_VERSION,
        engine_version: "0.0.0".to_owned(),
        memory_bytes: 1 << 40,
        wait_s: 0.0,
    }
}

async fn take<C: LeaseClient>(client: &C) -> Option<LeaseGrant> {
    client.take(&request()).await.expect("an answer")
}

async fn taken<C: LeaseClient>(client: &C) -> LeaseGrant {
    take(client).await.expect("work")
}

/// Stores what `job` yields, and the words for it.
async fn outcome<C: LeaseClient>(client: &C, job: &LeasedJob) -> JobOutcome {
    let bytes = Bytes::from(format!("state of {}", job.job));
    let hash = ArtifactHash::of_bytes(&bytes);
    client
        .artifact_put(hash, bytes.clone())
        .await
        .expect("stored");
    let outcome = Outcome {
        results: BTreeMap::from([("volume_fraction".to_owned(), Some(0.7))]),
        reasons: BTreeMap::new(),
        artifacts: BTreeMap::from([(STATE.to_owned(), bytes.into())]),
        warnings: vec![],
        steps: 1000,
    };
    JobOutcome {
        job: job.job,
        result_hash: outcome.hash(),
        results: outcome.results,
        reasons: outcome.reasons,
        artifacts: BTreeMap::from([(STATE.to_owned(), hash)]),
        warnings: outcome.warnings,
        provenance: Provenance {
            engine_version: "0.0.0".to_owned(),
            physics_version: PHYSICS_VERSION,
            target: "test".to_owned(),
            worker: WorkerId("host/1/1".to_owned()),
            steps: 1000,
            lanes: 1,
            wall_s: 1.0,
            cpu_s: 1.0,
        },
    }
}

/// Finishes every job of `grant`.
async fn finish<C: LeaseClient>(client: &C, grant: &LeaseGrant) -> Completion {
    let mut outcomes = vec![];
    for job in &grant.jobs {
        outcomes.push(outcome(client, job).await);
    }
    let completion = Completion { outcomes };
    let done = client.complete(grant.lease, &completion).await;
    done.expect("the lease is ours");
    completion
}

fn progress(job: JobId, checkpoint: Option<ArtifactHash>) -> JobProgress {
    JobProgress {
        job,
        step: 100,
        steps: 1000,
        checkpoint,
    }
}

async fn a_worker_is_given_what_is_ready_and_then_nothing<C: LeaseClient>(client: C, _: Store) {
    let grant = taken(&client).await;
    assert_eq!(grant.jobs.len(), 1);
    assert_eq!(grant.jobs[0].spec.kind(), StageKind::Pack);
    assert_eq!(grant.jobs[0].spec.id(), grant.jobs[0].job);
    assert_eq!(
        (grant.jobs[0].input, grant.jobs[0].checkpoint),
        (None, None)
    );
    assert!(grant.heartbeat_s > 0.0);
    assert!(take(&client).await.is_none());
}

async fn a_worker_of_another_physics_is_given_nothing<C: LeaseClient>(client: C, _: Store) {
    let stranger = LeaseRequest {
        physics_version: PHYSICS_VERSION + 1,
        ..request()
    };
    assert!(client.take(&stranger).await.expect("an answer").is_none());
}

async fn artifacts_are_kept_under_their_hash_alone<C: LeaseClient>(client: C, _: Store) {
    let bytes = Bytes::from_static(b"a pack of grains");
    let hash = ArtifactHash::of_bytes(&bytes);
    let missing = client.artifact_get(hash).await;
    assert!(matches!(missing, Err(ClientError::ArtifactMissing(h)) if h == hash));
    for _ in 0..2 {
        client
            .artifact_put(hash, bytes.clone())
            .await
            .expect("stored");
    }
    assert_eq!(client.artifact_get(hash).await.expect("stored"), bytes);
    let other = ArtifactHash::of_bytes(b"something else");
    let wrong = client.artifact_put(other, bytes).await;
    assert!(
        matches!(wrong, Err(ClientError::Refused { .. })),
        "{wrong:?}"
    );
}

async fn outcomes_make_what_needs_them_ready<C: LeaseClient>(client: C, _: Store) {
    let pack = taken(&client).await;
    let done = finish(&client, &pack).await;
    let train = taken(&client).await;
    assert_eq!(train.jobs[0].spec.kind(), StageKind::Train);
    assert_eq!(train.jobs[0].input, Some(done.outcomes[0].artifacts[STATE]));
}

async fn recalls_of_one_pack_come_as_lanes_of_one_lease<C: LeaseClient>(client: C, _: Store) {
    finish(&client, &taken(&client).await).await;
    let train = finish(&client, &taken(&client).await).await;
    let recalls = taken(&client).await;
    assert_eq!(recalls.jobs.len(), 7, "six signals and the zero signal");
    let state = train.outcomes[0].artifacts[STATE];
    assert!(recalls.jobs.iter().all(|job| job.input == Some(state)));
    finish(&client, &recalls).await;
    assert!(take(&client).await.is_none());
}

async fn a_completion_said_twice_counts_once<C: LeaseClient>(client: C, _: Store) {
    let pack = taken(&client).await;
    let completion = finish(&client, &pack).await;
    // The first answer may have been lost on the way.
    let again = client.complete(pack.lease, &completion).await;
    again.expect("the same words are no news");
    assert_eq!(taken(&client).await.jobs[0].spec.kind(), StageKind::Train);
    assert!(take(&client).await.is_none());
}

async fn an_outcome_whose_files_are_missing_is_refused<C: LeaseClient>(client: C, _: Store) {
    let pack = taken(&client).await;
    let mut outcome = outcome(&client, &pack.jobs[0]).await;
    let nowhere = ArtifactHash::of_bytes(b"nowhere");
    outcome.artifacts.insert(STATE.to_owned(), nowhere);
    let completion = Completion {
        outcomes: vec![outcome],
    };
    let refused = client.complete(pack.lease, &completion).await;
    assert!(
        matches!(refused, Err(ClientError::Refused { .. })),
        "{refused:?}"
    );
}

async fn another_lease_changes_nothing<C: LeaseClient>(client: C, _: Store) {
    let pack = taken(&client).await;
    let job = pack.jobs[0].job;
    let stranger = LeaseId::new();
    let completion = Completion {
        outcomes: vec![outcome(&client, &pack.jobs[0]).await],
    };
    let jobs = vec![progress(job, None)];
    let lost = |answer: Result<(), ClientError>| {
        assert!(matches!(answer, Err(ClientError::LeaseLost)), "{answer:?}");
    };
    lost(client.complete(stranger, &completion).await);
    let beat = Heartbeat { jobs: jobs.clone() };
    lost(client.heartbeat(stranger, &beat).await.map(drop));
    lost(client.release(stranger, &Release { jobs }).await);
    let failures = vec![JobFailure {
        job,
        failure: StageFailure::Input {
            detail: "no".to_owned(),
        },
    }];
    lost(client.fail(stranger, &FailureReport { failures }).await);
    assert!(take(&client).await.is_none(), "the job is still held");
    client
        .complete(pack.lease, &completion)
        .await
        .expect("ours");
}

async fn a_machine_fault_is_tried_again_and_broken_physics_is_not<C: LeaseClient>(
    client: C,
    _: Store,
) {
    let first = taken(&client).await;
    let job = first.jobs[0].job;
    let report = |failure| FailureReport {
        failures: vec![JobFailure { job, failure }],
    };
    let fault = StageFailure::Input {
        detail: "the disk is gone".to_owned(),
    };
    client
        .fail(first.lease, &report(fault))
        .await
        .expect("ours");
    let second = taken(&client).await;
    assert_eq!(second.jobs[0].job, job);
    assert_ne!(second.lease, first.lease);
    let stopped = StageFailure::Stopped {
        kind: "unstable".to_owned(),
        step: 7,
        detail: "the time step is too large".to_owned(),
        remedy: "take a smaller one".to_owned(),
    };
    client
        .fail(second.lease, &report(stopped))
        .await
        .expect("ours");
    assert!(take(&client).await.is_none());
}

async fn a_released_job_comes_back_with_its_checkpoint<C: LeaseClient>(client: C, _: Store) {
    let first = taken(&client).await;
    let bytes = Bytes::from_static(b"the state at step 100");
    let hash = ArtifactHash::of_bytes(&bytes);
    client.artifact_put(hash, bytes).await.expect("stored");
    let release = Release {
        jobs: vec![progress(first.jobs[0].job, Some(hash))],
    };
    client.release(first.lease, &release).await.expect("ours");
    let second = taken(&client).await;
    assert_eq!(second.jobs[0].job, first.jobs[0].job);
    assert_eq!(second.jobs[0].checkpoint, Some(hash));
}

async fn a_cancelled_job_is_named_at_the_next_heartbeat<C: LeaseClient>(client: C, store: Store) {
    let pack = taken(&client).await;
    let job = pack.jobs[0].job;
    let beat = Heartbeat {
        jobs: vec![progress(job, None)],
    };
    let reply = client.heartbeat(pack.lease, &beat).await.expect("ours");
    assert!(reply.stop.is_empty());
    let sweeps = store.sweep_list(None, 10).await.expect("a list");
    store
        .sweep_cancel(sweeps.items[0].sweep)
        .await
        .expect("cancelled");
    let reply = client.heartbeat(pack.lease, &beat).await.expect("ours");
    assert_eq!(reply.stop, [job]);
    let wait = LeaseRequest {
        wait_s: Duration::from_millis(10).as_secs_f64(),
        ..request()
    };
    assert!(client.take(&wait).await.expect("an answer").is_none());
}
