//! Sweeps whose points are archived, in part or as a whole.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use granary_api::sweep::SweepState;
use granary_core::identity::StageId;
use granary_core::stage::{StageKind, StageSpec};
use granary_server::{Archive, Archived, Submission, submit};
use serde_json::{Value, json};

use crate::harness::{Fresh, fresh, fresh_with, outcome, sweep_of};

/// Holds what `work` would yield of some stages.
#[derive(Debug, Default)]
struct Shelf(Mutex<BTreeMap<StageId, StageSpec>>);

impl Archive for Shelf {
    fn find(&self, spec: &StageSpec) -> Option<Archived> {
        let held = self.0.lock().expect("no test panics here");
        held.get(&spec.id()).map(|spec| Archived {
            outcome: outcome(spec),
            engine_version: "0.0.1".to_owned(),
            wall_s: 2.0,
            cpu_s: 1.0,
        })
    }
}

/// Beams of one packing by protocol B.
fn beams(frictions: &[f64]) -> Value {
    json!({
        "name": format!("{frictions:?}"), "model": "beam", "preset": "draft",
        "fixed": {"protocol": "B", "packing_seed": 1},
        "grid": [{"friction_coefficient": frictions}],
    })
}

/// All bends of `frictions`, computed elsewhere, and the table of that sweep.
async fn elsewhere(frictions: &[f64]) -> (Shelf, Value) {
    let other = fresh().await;
    let sweep = sweep_of(&other.submit(&beams(frictions)).await);
    let jobs = other.work().await;
    let bends = { jobs.into_iter() }.filter(|job| job.spec.kind() == StageKind::Bend);
    let shelf = Shelf(Mutex::new(
        bends.map(|job| (job.spec.id(), job.spec)).collect(),
    ));
    (shelf, points(&other, &sweep.to_string()).await)
}

async fn points(fresh: &Fresh, sweep: &str) -> Value {
    let path = format!("/api/v1/sweeps/{sweep}/points");
    fresh.get(&path).await.json()["items"].take()
}

async fn with(shelf: Shelf) -> Fresh {
    fresh_with(|config| config.archive = Some(Arc::new(shelf))).await
}

#[tokio::test]
async fn archived_points_are_done_at_once_and_nothing_is_prepared_for_them() {
    let frictions = [0.3, 0.6, 0.9];
    let (shelf, table) = elsewhere(&frictions).await;
    let fresh = with(shelf).await;
    let submitted = fresh.submit(&beams(&frictions)).await;
    assert_eq!(submitted.message, "3 of 3 already done");
    assert_eq!((submitted.jobs.new, submitted.jobs.done), (0, 3));
    assert!(submitted.predicted.core_seconds <= 0.0);
    assert!(fresh.take().await.is_none());
    let sweep = sweep_of(&submitted);
    let summary = fresh.store.sweep_read(sweep).await.expect("the sweep");
    assert_eq!(summary.state, SweepState::Finished);
    assert_eq!(points(&fresh, &sweep.to_string()).await, table);
    // Who computed it is not this server.
    let job = table[0]["job"].as_str().expect("a job");
    let detail = fresh.get(&format!("/api/v1/jobs/{job}")).await.json();
    let by = ["engine_version", "worker"].map(|name| detail["provenance"][name].clone());
    assert_eq!(by, ["0.0.1", "archive"], "{detail}");
    // The same points in another sweep need no packing either, and where one more is wanted it is made.
    let fewer = fresh.submit(&beams(&[0.3, 0.6])).await;
    assert_eq!((fewer.points_done, fewer.jobs.new), (2, 0));
    assert!(fresh.take().await.is_none());
    let more = fresh.submit(&beams(&[0.3, 1.2])).await;
    assert_eq!(more.points_done, 1);
    let done = fresh.work().await;
    let done: Vec<StageKind> = done.iter().map(|job| job.spec.kind()).collect();
    assert_eq!(done, [StageKind::Grow, StageKind::Jam, StageKind::Bend]);
}

#[tokio::test]
async fn points_that_are_not_archived_are_computed_with_their_preparation() {
    let (shelf, _) = elsewhere(&[0.3, 0.6]).await;
    let (_, table) = elsewhere(&[0.3, 0.6, 0.9]).await;
    let fresh = with(shelf).await;
    let submitted = fresh.submit(&beams(&[0.3, 0.6, 0.9])).await;
    assert_eq!((submitted.points_done, submitted.jobs.new), (2, 3));
    assert_eq!(fresh.work().await.len(), 3);
    let sweep = sweep_of(&submitted).to_string();
    assert_eq!(points(&fresh, &sweep).await, table);
}

#[tokio::test]
async fn a_dry_run_counts_what_is_archived_and_stores_nothing() {
    let (shelf, _) = elsewhere(&[0.3]).await;
    let fresh = with(shelf).await;
    let dry = Submission {
        dry_run: true,
        ..Submission::default()
    };
    let reply = submit(&fresh.store, &beams(&[0.3]), &dry).await;
    let reply = reply.expect("a valid sweep");
    assert_eq!((reply.points_done, reply.sweep), (1, None));
    let artifacts = fresh.directory.path().join("artifacts");
    let shards = std::fs::read_dir(artifacts).expect("a directory");
    let named = |shard: std::io::Result<std::fs::DirEntry>| shard.expect("an entry").file_name();
    let shards: Vec<_> = shards.map(named).collect();
    assert_eq!(shards, ["tmp"]);
}

#[tokio::test]
async fn what_is_archived_meanwhile_is_taken_when_the_sweep_is_submitted_again() {
    let (shelf, _) = elsewhere(&[0.3]).await;
    let late = Arc::new(Shelf::default());
    let archive = late.clone();
    let fresh = fresh_with(|config| config.archive = Some(archive)).await;
    let first = fresh.submit(&beams(&[0.3])).await;
    assert_eq!((first.points_done, first.jobs.new), (0, 3));
    let found = std::mem::take(&mut *shelf.0.lock().expect("ours"));
    late.0.lock().expect("ours").extend(found);
    let again = fresh.submit(&beams(&[0.3])).await;
    assert_eq!((again.sweep, again.points_done), (first.sweep, 1));
    assert!(fresh.take().await.is_none());
}
