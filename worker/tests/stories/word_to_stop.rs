//! The word to stop: checkpoint, hand back, go.

use std::sync::atomic::Ordering;
use std::time::Duration;

use granary_worker::config::Config;

use crate::engines::{Gated, instant};
use crate::scripted_server::ScriptedServer;
use crate::{Worker, config, grant};

#[tokio::test]
async fn shutdown_mid_job_stores_a_checkpoint_and_hands_the_jobs_back() {
    let server = ScriptedServer::start().await;
    let gate = Gated::new();
    let lease = grant(2, None);
    let jobs: Vec<_> = lease.jobs.iter().map(|job| job.job).collect();
    server.change(|script| script.grants.push_back(lease));
    let worker = Worker::start(&server, gate.engine(), config());
    server.until(|script| !script.beats.is_empty()).await;
    worker.stop().await.expect("a clean end");
    let script = server.until(|_| true).await;
    assert_eq!(gate.interrupted.load(Ordering::SeqCst), 1);
    assert_eq!(script.released.len(), 2);
    for (released, job) in script.released.iter().zip(jobs) {
        assert_eq!(released.job, job);
        let hash = released.checkpoint.expect("checkpoint of the last step");
        let state = String::from_utf8_lossy(&script.artifacts[&hash]).into_owned();
        assert!(state.ends_with(&format!("at {}", released.step)), "{state}");
    }
    assert!(script.outcomes.is_empty() && script.failures.is_empty());
}

#[tokio::test]
async fn an_idle_worker_stops_at_once() {
    let server = ScriptedServer::start().await;
    let config = Config {
        poll: Duration::from_secs(20),
        ..config()
    };
    let worker = Worker::start(&server, instant(), config);
    server.until(|script| script.asked > 0).await;
    let before = std::time::Instant::now();
    worker.stop().await.expect("a clean end");
    assert!(before.elapsed().as_secs_f64() < 2.0);
}

#[tokio::test]
async fn shutdown_without_a_server_ends_within_the_grace() {
    let mut server = ScriptedServer::start().await;
    let gate = Gated::new();
    server.change(|script| script.grants.push_back(grant(1, None)));
    let config = Config {
        grace: Duration::from_millis(300),
        ..config()
    };
    let worker = Worker::start(&server, gate.engine(), config);
    server.until(|script| !script.beats.is_empty()).await;
    server.kill().await;
    let error = worker.stop().await.expect_err("nothing was handed back");
    assert!(error.to_string().contains("handed back"), "{error}");
}
