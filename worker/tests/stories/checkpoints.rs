//! Checkpoints: written while a job runs, read when it is taken up again.

use std::sync::atomic::Ordering;
use std::time::Duration;

use granary_worker::config::Config;

use crate::engines::Gated;
use crate::scripted_server::ScriptedServer;
use crate::{Worker, config, grant};

#[tokio::test]
async fn heartbeats_name_checkpoints_that_are_stored() {
    let server = ScriptedServer::start().await;
    let gate = Gated::new();
    server.change(|script| script.grants.push_back(grant(2, None)));
    let config = Config {
        checkpoint_every: Duration::from_millis(10),
        ..config()
    };
    let worker = Worker::start(&server, gate.engine(), config);
    let script = server
        .until(|script| {
            let beat = script.beats.last();
            beat.is_some_and(|beat| beat.iter().all(|job| job.checkpoint.is_some()))
        })
        .await;
    let beat = script.beats.last().expect("just seen");
    assert_eq!(beat.len(), 2);
    for job in beat {
        assert!(job.step > 0 && job.steps == 1_000_000);
        let hash = job.checkpoint.expect("just seen");
        assert!(script.artifacts[&hash].starts_with(b"state of"));
    }
    gate.open();
    server.until(|script| script.outcomes.len() == 2).await;
    worker.stop().await.expect("a clean end");
}

#[tokio::test]
async fn jobs_whose_checkpoints_cannot_be_read_start_from_scratch() {
    let server = ScriptedServer::start().await;
    let gate = Gated::new();
    let mut lease = grant(1, None);
    lease.jobs[0].checkpoint = Some(server.store(b"no checkpoint of any physics"));
    let mut missing = grant(1, None);
    missing.jobs[0].checkpoint = Some(granary_api::id::ArtifactHash::of_bytes(b"gone"));
    server.change(|script| script.grants.extend([lease, missing]));
    gate.open();
    let worker = Worker::start(&server, gate.engine(), config());
    server.until(|script| script.outcomes.len() == 2).await;
    assert_eq!(gate.resumed.load(Ordering::SeqCst), 0);
    worker.stop().await.expect("a clean end");
}
