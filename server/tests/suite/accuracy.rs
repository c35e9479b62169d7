//! Accuracy: a pilot, what it decides, and the sweep that goes on by it.

use std::collections::BTreeMap;

use granary_api::id::SweepId;
use granary_api::lease::{Completion, FailureReport, JobFailure, LeaseGrant};
use granary_core::memory::score::Signal;
use granary_core::memory::waveform::{SAMPLES, sample_u};
use granary_core::stage::{Outcome, SIGNAL, StageFailure, StageSpec};
use granary_server::sweep::{Limits, Plan};
use serde_json::{Value, json};

use crate::harness::{Fresh, GAIN_E_DELTA0, fresh, outcome, sweep_of};

fn spec(accuracy: &Value) -> Value {
    json!({
        "name": "words",
        "model": "memory",
        "fixed": {"grains": 100},
        "grid": [{
            "friction_coefficient": [0.4, 0.7, 1.0],
            "packing_seed": [11, 12, 13, 14, 15, 16],
            "waveform": ["six/1", "six/2", "six/5"],
        }],
        "accuracy": accuracy,
    })
}

/// A made-up engine in which gain is off by 1.8 t_c over the ramp, relatively, and a bit more in every second packing.
fn hasty(spec: &StageSpec) -> Outcome {
    let StageSpec::Recall(recall) = spec else {
        return outcome(spec);
    };
    let sum: u32 = recall.train.to_string().bytes().map(u32::from).sum();
    let off = 180.0 / recall.ramp * (1.0 + 0.01 * f64::from(sum % 2));
    let curve = recall.waveform.curve();
    let p = |u: f64| -GAIN_E_DELTA0 * (1.0 + off) * recall.gamma0 * curve.integral(u);
    let decode: Vec<f64> = (0..SAMPLES).map(sample_u).map(p).collect();
    let signal = Signal {
        encode: decode.clone(),
        second_decode: vec![0.0; decode.len()],
        decode,
        resolution: Some(0.0),
    };
    let bytes = serde_json::to_vec(&signal).expect("plain data");
    Outcome {
        artifacts: BTreeMap::from([(SIGNAL.to_owned(), bytes)]),
        ..outcome(spec)
    }
}

async fn work(fresh: &Fresh) {
    while let Some(grant) = fresh.take().await {
        let mut outcomes = vec![];
        for job in &grant.jobs {
            outcomes.push(fresh.report(job, &hasty(&job.spec)).await);
        }
        let completion = Completion { outcomes };
        let completed = fresh.store.lease_complete(grant.lease, &completion).await;
        completed.expect("the lease is ours");
    }
}

async fn stop(fresh: &Fresh, grant: &LeaseGrant) {
    let failure = StageFailure::Stopped {
        kind: "unstable".to_owned(),
        step: 1,
        detail: "made up".to_owned(),
        remedy: "none".to_owned(),
    };
    let failures = grant.jobs.iter().map(|job| JobFailure {
        job: job.job,
        failure: failure.clone(),
    });
    let report = FailureReport {
        failures: failures.collect(),
    };
    let reported = fresh.store.lease_fail(grant.lease, &report).await;
    reported.expect("the lease is ours");
}

async fn read(fresh: &Fresh, sweep: SweepId, what: &str) -> Value {
    let answer = fresh.get(&format!("/api/v1/sweeps/{sweep}{what}")).await;
    assert_eq!(answer.status, 200, "{}", answer.text());
    answer.json()
}

/// Lets the planner look until the sweep has points.
async fn settled(fresh: &Fresh, sweep: SweepId) -> Value {
    let stop = tokio_util::sync::CancellationToken::new();
    let mut tasks = granary_server::background(&fresh.store, &stop);
    for _ in 0..200 {
        let found = read(fresh, sweep, "").await;
        if !found["accuracy"]["choice"].is_null() {
            stop.cancel();
            while tasks.join_next().await.is_some() {}
            return found;
        }
        tokio::time::sleep(std::time::Duration::from_millis(20)).await;
    }
    panic!("the planner has not looked");
}

#[test]
fn pilot_is_a_study_of_the_first_packings_at_both_ends_of_the_other_axes() {
    let plan = Plan::read(&spec(&json!({"fidelity": 0.01})), Limits::default()).expect("valid");
    let accuracy = plan.accuracy.expect("asked for");
    let pilot = &accuracy.pilot.spec;
    assert_eq!(pilot["name"], "pilot of words");
    assert_eq!(pilot["grid"].as_array().map(Vec::len), Some(2));
    assert_eq!(pilot["grid"][0]["friction_coefficient"], 0.4);
    assert_eq!(pilot["grid"][1]["friction_coefficient"], 1.0);
    assert_eq!(pilot["grid"][1]["packing_seed"], json!([11, 12, 13, 14]));
    assert_eq!(pilot["study"]["reference"]["precision"], "f64");
    // It can be submitted by itself.
    assert!(Plan::read(pilot, Limits::default()).is_ok());
}

#[test]
fn what_the_spec_says_is_not_chosen_over_and_missing_packings_are_added() {
    let mut spec = spec(&json!({"fidelity": 0.01, "packings": 5}));
    spec["numerics"] = json!({"ramp": 9000, "precision": "f64"});
    spec["grid"][0]["packing_seed"] = json!([3]);
    let plan = Plan::read(&spec, Limits::default()).expect("valid");
    let accuracy = plan.accuracy.expect("asked for");
    assert_eq!(accuracy.names, ["drag", "time_step", "hold"]);
    let pilot = &accuracy.pilot.spec;
    assert_eq!(pilot["grid"][0]["packing_seed"], json!([3, 4, 5, 6, 7]));
    let settings = pilot["study"]["setting"].as_array().expect("a list");
    assert!(settings.iter().all(|setting| setting.get("ramp").is_none()));
}

#[tokio::test]
async fn cheapest_setting_that_keeps_the_target_is_chosen_and_shown_with_its_evidence() {
    let fresh = fresh().await;
    // The full ramp is off by 1 %: half of it by 1 % more, a third by 2 %.
    let spec = spec(&json!({"gain": 0.015, "fidelity": 0.01}));
    let submitted = fresh.submit(&spec).await;
    let sweep = sweep_of(&submitted);
    assert_eq!(submitted.points, 54);
    assert!(
        submitted.message.starts_with("a pilot of "),
        "{}",
        submitted.message
    );
    let waiting = read(&fresh, sweep, "").await;
    assert_eq!(waiting["state"], "active");
    assert_eq!(waiting["points"]["waiting"], 54);
    assert_eq!(waiting["accuracy"]["choice"], Value::Null);
    work(&fresh).await;
    let found = settled(&fresh, sweep).await;
    let choice = &found["accuracy"]["choice"];
    assert_eq!(choice["values"]["ramp"], 9000.0, "{choice:#}");
    assert_eq!(choice["values"]["drag"], 0.1);
    assert_eq!(choice["evidence"].as_array().map(Vec::len), Some(2));
    assert_eq!(choice["reason"], Value::Null);
    work(&fresh).await;
    let finished = read(&fresh, sweep, "").await;
    assert_eq!(
        (&finished["state"], &finished["points"]["done"]),
        (&json!("finished"), &json!(54))
    );
    let points = read(&fresh, sweep, "/points?limit=1").await;
    assert_eq!(points["items"][0]["parameters"]["ramp"], 9000.0);
    let sets = read(&fresh, sweep, "/sets?where=reduce=mean_sem").await;
    let results = &sets["items"][0]["results"];
    let bound = results["gain_deviation_bound"].as_f64().expect("a bound");
    assert!((0.0098..0.015).contains(&bound), "{bound}");
    // The same sweep again is found with its choice, and nothing is to be computed.
    let again = fresh.submit(&spec).await;
    assert_eq!((again.sweep, again.points_done), (Some(sweep), 54));
}

#[tokio::test]
async fn reference_is_taken_where_nothing_cheaper_keeps_the_target() {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&spec(&json!({"gain": 0.01}))).await);
    // Every recall of the pilot stops: no setting has any error to show.
    while let Some(grant) = fresh.take().await {
        if matches!(grant.jobs[0].spec, StageSpec::Recall(_)) {
            stop(&fresh, &grant).await;
        } else {
            fresh.complete(grant.lease, &grant.jobs).await;
        }
    }
    let found = settled(&fresh, sweep).await;
    let choice = &found["accuracy"]["choice"];
    assert_eq!(choice["values"]["precision"], "f64");
    assert!(choice["reason"].is_string());
}

#[tokio::test]
async fn pilot_is_cancelled_and_resumed_with_the_sweep_that_waits_for_it() {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&spec(&json!({"fidelity": 0.01}))).await);
    let pilot: SweepId =
        serde_json::from_value(read(&fresh, sweep, "").await["accuracy"]["pilot"].clone())
            .expect("an id");
    fresh.store.sweep_cancel(sweep).await.expect("cancelled");
    assert_eq!(read(&fresh, pilot, "").await["state"], "cancelled");
    assert!(fresh.take().await.is_none());
    fresh.store.sweep_resume(sweep).await.expect("resumed");
    assert_eq!(read(&fresh, pilot, "").await["state"], "active");
    assert_eq!(read(&fresh, sweep, "").await["state"], "active");
    fresh.store.sweep_pause(sweep).await.expect("paused");
    assert!(fresh.take().await.is_none());
    assert_eq!(read(&fresh, pilot, "").await["state"], "paused");
}

#[tokio::test]
async fn dry_run_tells_what_the_pilot_costs_and_queues_nothing() {
    let fresh = fresh().await;
    let spec = spec(&json!({"fidelity": 0.01}));
    let submission = granary_server::Submission {
        dry_run: true,
        idempotency_key: None,
    };
    let answer = granary_server::submit(&fresh.store, &spec, &submission)
        .await
        .expect("valid");
    assert_eq!((answer.points, answer.sweep), (54, None));
    assert!(answer.predicted.core_seconds > 0.0);
    assert!(fresh.take().await.is_none());
}
