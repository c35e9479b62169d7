//! Intake of a large sweep: counts and limits.

use granary_core::stage::StageKind;
use serde_json::json;

use crate::harness::{fresh, fresh_with, sweep_of};

#[tokio::test]
async fn hundred_thousand_points_are_taken_in_and_the_table_shows_them_all() {
    let fresh = fresh().await;
    let spec = json!({
        "name": "large", "model": "memory", "fixed": {"grains": 10},
        "grid": [{"friction_coefficient": {"linspace": [0, 1, 25]}, "waveform": {"suite": "binary_words", "bits": 12}}],
    });
    let submitted = fresh.submit(&spec).await;
    // One pack; for each friction a train, a zero, and an encoding for every eight words.
    assert_eq!(
        (submitted.points, submitted.jobs.total),
        (102_400, 102_400 + 1 + 25 * (1 + 1 + 512))
    );
    let sweep = sweep_of(&submitted);
    let page = fresh
        .get(&format!(
            "/api/v1/sweeps/{sweep}/points?where=friction_coefficient=1&sort=-point&limit=2"
        ))
        .await;
    let page = page.json();
    assert_eq!(page["total"], 4096);
    assert_eq!(page["items"][0]["point"], 102_399);
    assert_eq!(
        page["items"][0]["parameters"]["waveform"],
        "binary_words/12/4095"
    );
    let again = fresh.submit(&spec).await;
    assert_eq!((again.sweep, again.jobs.new), (submitted.sweep, 0));
}

#[tokio::test]
async fn points_that_share_a_job_are_counted_with_it_wherever_they_stand() {
    let fresh = fresh().await;
    // An overlap means nothing to spheres, so three trunks of a thousand points come down to one.
    let spec = |name: &str, overlaps: &[f64]| {
        json!({
            "name": name, "model": "memory", "fixed": {"grains": 10, "shape": "sphere"},
            "grid": [{"overlap": overlaps, "waveform": {"suite": "binary_words", "bits": 10}}],
        })
    };
    let submitted = fresh.submit(&spec("three", &[0.2, 0.4, 0.6])).await;
    // A pack, a train, a zero, and the encodings.
    let jobs = 1024 + 3 + 128;
    assert_eq!((submitted.points, submitted.jobs.total), (3072, jobs));
    assert_eq!(submitted.jobs.new, jobs);
    for _ in 0..2 {
        let grant = fresh.take().await.expect("the pack, then the train");
        fresh.complete(grant.lease, &grant.jobs).await;
    }
    let mut before = 2;
    let recalls = loop {
        let grant = fresh.take().await.expect("encodings, then recalls");
        fresh.complete(grant.lease, &grant.jobs).await;
        if grant.jobs[0].spec.kind() == StageKind::Recall {
            break grant;
        }
        before += grant.jobs.len() as u64;
    };
    let sweep = sweep_of(&submitted);
    let zero = recalls
        .jobs
        .iter()
        .any(|job| job.spec.ensemble_key() == job.job);
    let points = 3 * (recalls.jobs.len() as u64 - u64::from(zero));
    let done = fresh.store.sweep_read(sweep).await.expect("the sweep");
    assert_eq!((done.points.done, done.points.total), (points, 3072));
    let more = fresh.submit(&spec("two", &[0.6, 0.8])).await;
    assert_eq!((more.points, more.jobs.new), (2048, 0));
    assert_eq!(more.points_done, points / 3 * 2);
    assert_eq!(more.jobs.done, before + recalls.jobs.len() as u64);
}

#[tokio::test]
async fn sweep_beyond_the_configured_size_is_refused_with_its_count() {
    let fresh = fresh_with(|config| config.sweep.points = 10).await;
    let spec = json!({"model": "memory", "grid": [{"packing_seed": {"range": [1, 11]}}]});
    let answer = fresh.post("/api/v1/sweeps", &spec).await;
    assert_eq!(answer.status, 422);
    assert_eq!(
        answer.json()["errors"][0]["detail"],
        "11 points: a sweep may have at most 10"
    );
}
