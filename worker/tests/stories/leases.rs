//! Leases taken, lost, cancelled, and held through a server's absence.

use std::sync::atomic::Ordering;

use crate::engines::{Gated, instant, outcome};
use crate::scripted_server::ScriptedServer;
use crate::{Worker, config, grant};

#[tokio::test]
async fn finished_jobs_are_completed_under_their_lease() {
    let server = ScriptedServer::start().await;
    let input = server.store(b"a trained pack");
    server.change(|script| script.grants.push_back(grant(3, Some(input))));
    let worker = Worker::start(&server, instant(), config());
    let script = server.until(|script| script.outcomes.len() == 3).await;
    for (lane, reported) in script.outcomes.iter().enumerate() {
        assert_eq!(reported.result_hash, outcome(lane).hash());
        assert_eq!(reported.provenance.lanes, 3);
        assert_eq!(reported.provenance.steps, 1000);
    }
    worker.stop().await.expect("a clean end");
}

#[tokio::test]
async fn sixty_four_leases_over_four_slots_are_each_completed_once() {
    let server = ScriptedServer::start().await;
    server.change(|script| script.grants.extend((0..64).map(|_| grant(1, None))));
    let config = granary_worker::config::Config {
        slots: 4,
        ..config()
    };
    let worker = Worker::start(&server, instant(), config);
    let script = server.until(|script| script.outcomes.len() >= 64).await;
    assert_eq!(script.outcomes.len(), 64);
    worker.stop().await.expect("a clean end");
}

#[tokio::test]
async fn lost_lease_stops_the_engine_and_reports_nothing() {
    let server = ScriptedServer::start().await;
    let gate = Gated::new();
    let lost = grant(2, None);
    server.change(|script| {
        script.lost.push(lost.lease);
        script.grants.push_back(lost);
    });
    let worker = Worker::start(&server, gate.engine(), config());
    // The engine begins the next lease only after its thread of the lost one has ended.
    server.change(|script| script.grants.push_back(grant(1, None)));
    gate.until_begun(2).await;
    assert_eq!(gate.interrupted.load(Ordering::SeqCst), 1);
    gate.open();
    let script = server.until(|script| !script.outcomes.is_empty()).await;
    assert_eq!(script.outcomes.len(), 1);
    assert!(script.failures.is_empty() && script.released.is_empty());
    worker.stop().await.expect("a clean end");
}

#[tokio::test]
async fn cancelled_jobs_stop_the_engine_within_a_second_of_the_heartbeat() {
    let server = ScriptedServer::start().await;
    let gate = Gated::new();
    let cancelled = grant(2, None);
    let jobs: Vec<_> = cancelled.jobs.iter().map(|job| job.job).collect();
    server.change(|script| script.grants.push_back(cancelled));
    let worker = Worker::start(&server, gate.engine(), config());
    server.until(|script| !script.beats.is_empty()).await;
    let asked = server.until(|_| true).await.asked;
    let before = std::time::Instant::now();
    server.change(|script| script.stop = jobs);
    let script = server.until(|script| script.asked > asked).await;
    assert!(before.elapsed().as_secs_f64() < 1.0);
    assert!(script.outcomes.is_empty() && script.released.is_empty());
    worker.stop().await.expect("a clean end");
    assert_eq!(gate.interrupted.load(Ordering::SeqCst), 1);
}

#[tokio::test]
async fn neighbors_of_a_cancelled_job_complete() {
    let server = ScriptedServer::start().await;
    let gate = Gated::new();
    let lease = grant(3, None);
    let jobs: Vec<_> = lease.jobs.iter().map(|job| job.job).collect();
    server.change(|script| {
        script.stop = vec![jobs[1]];
        script.grants.push_back(lease);
    });
    let worker = Worker::start(&server, gate.engine(), config());
    server
        .until(|script| script.beats.last().is_some_and(|beat| beat.len() == 2))
        .await;
    gate.open();
    let script = server.until(|script| !script.outcomes.is_empty()).await;
    let completed: Vec<_> = script.outcomes.iter().map(|outcome| outcome.job).collect();
    assert_eq!(completed, [jobs[0], jobs[2]]);
    worker.stop().await.expect("a clean end");
}

#[tokio::test]
async fn a_job_cancelled_while_its_outcome_travels_does_not_cost_its_neighbors() {
    let server = ScriptedServer::start().await;
    let lease = grant(3, None);
    let jobs: Vec<_> = lease.jobs.iter().map(|job| job.job).collect();
    server.change(|script| {
        script.refuse_stopped = true;
        script.stop = vec![jobs[0]];
        script.grants.push_back(lease);
    });
    let worker = Worker::start(&server, instant(), config());
    let script = server.until(|script| !script.outcomes.is_empty()).await;
    let completed: Vec<_> = script.outcomes.iter().map(|outcome| outcome.job).collect();
    assert_eq!(completed, jobs[1..]);
    worker.stop().await.expect("a clean end");
}

#[tokio::test]
async fn a_worker_computes_through_a_server_that_answers_nothing() {
    let server = ScriptedServer::start().await;
    let gate = Gated::new();
    server.change(|script| script.grants.push_back(grant(2, None)));
    let worker = Worker::start(&server, gate.engine(), config());
    server.until(|script| !script.beats.is_empty()).await;
    server.change(|script| script.unwell = true);
    server.until(|script| script.turned_away >= 2).await;
    gate.open();
    let seen = server.until(|_| true).await.turned_away;
    server.until(|script| script.turned_away >= seen + 2).await;
    server.change(|script| script.unwell = false);
    let script = server.until(|script| !script.outcomes.is_empty()).await;
    assert_eq!(script.outcomes.len(), 2);
    assert_eq!(gate.interrupted.load(Ordering::SeqCst), 0);
    worker.stop().await.expect("a clean end");
}

#[tokio::test]
async fn workers_are_busy_soon_after_a_killed_servers_return() {
    let mut server = ScriptedServer::start().await;
    let worker = Worker::start(&server, instant(), config());
    server.until(|script| script.asked > 0).await;
    server.kill().await;
    server.change(|script| {
        script.unwell = false;
        script.grants.push_back(grant(1, None));
    });
    let before = std::time::Instant::now();
    server.begin().await;
    server.until(|script| !script.outcomes.is_empty()).await;
    assert!(before.elapsed().as_secs_f64() < 5.0);
    worker.stop().await.expect("a clean end");
}
