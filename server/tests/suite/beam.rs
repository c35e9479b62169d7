//! Sweeps of beams: what is shared, what is drawn from the points, and how missing numbers are explained.

use granary_api::id::SweepId;
use granary_core::stage::StageKind;
use granary_server::sweep::expansion::Expansion;
use granary_server::sweep::{Limits, Plan};
use serde_json::{Value, json};

use crate::harness::{Fresh, fresh, sweep_of};

/// Protocols A and B of the paper on two packings: 7 + 4 frictions, of which both have 0.3.
fn spec() -> Value {
    json!({
        "name": "friction and strength",
        "model": "beam",
        "preset": "draft",
        "grid": [
            {"protocol": "A", "packing_seed": [1, 2], "friction_coefficient": [0.0, 0.1, 0.2, 0.3, 0.6, 0.9, 1.2]},
            {"protocol": "B", "packing_seed": [1, 2], "friction_coefficient": [0.3, 0.6, 0.9, 1.2]},
        ],
    })
}

async fn table(fresh: &Fresh, sweep: SweepId, what: &str) -> Value {
    let answer = fresh.get(&format!("/api/v1/sweeps/{sweep}/{what}")).await;
    assert_eq!(answer.status, 200, "{}", answer.text());
    answer.json()
}

async fn done() -> (Fresh, SweepId) {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&spec()).await);
    fresh.work().await;
    (fresh, sweep)
}

fn plan(spec: &Value) -> Plan {
    Plan::read(spec, Limits::default()).expect("a valid spec")
}

#[tokio::test]
async fn one_packing_serves_all_of_protocol_b_and_a_at_its_friction() {
    let fresh = fresh().await;
    let submitted = fresh.submit(&spec()).await;
    assert_eq!(submitted.points, 22);
    // For each packing: one growth, 7 packings of A of which B shares one, 7 + 4 beams of which one is the same.
    assert_eq!(submitted.jobs.total, 2 * (1 + 7 + 10));
    assert!(submitted.predicted.core_seconds > 0.0);
    let done = fresh.work().await;
    assert_eq!(done.len(), 36);
}

#[test]
fn each_point_queues_its_three_stages_in_their_order() {
    let plan = plan(&spec());
    let chunk = Expansion::new(&plan).next_chunk(1000).expect("rows");
    let kinds: Vec<StageKind> = chunk.jobs[..3].iter().map(|job| job.spec.kind()).collect();
    assert_eq!(kinds, [StageKind::Grow, StageKind::Jam, StageKind::Bend]);
    let classes: Vec<&str> = chunk.ensembles[..3]
        .iter()
        .map(|ensemble| ensemble.class.as_str())
        .collect();
    assert_eq!(classes, ["grow/beam/f64", "jam/beam/f64", "bend/beam/f64"]);
    assert!(chunk.ensembles.iter().all(|ensemble| ensemble.lanes == 1));
}

#[test]
fn model_is_part_of_what_makes_a_sweep() {
    let of = |model: &str| plan(&json!({"model": model, "name": "one"})).identity();
    assert_ne!(of("memory"), of("beam"));
}

#[test]
fn periods_take_back_the_preset_s_speed_of_the_rods() {
    let speed = |spec: Value| plan(&spec).fixed["rod_speed"].clone();
    assert_eq!(speed(json!({"model": "beam", "preset": "paper"})), 2e-4);
    let periods = json!({"model": "beam", "preset": "paper", "numerics": {"periods": 10}});
    assert_eq!(speed(periods), Value::Null);
    let axis = json!({"model": "beam", "preset": "paper", "grid": [{"periods": [5, 10]}]});
    assert_eq!(speed(axis), Value::Null);
    let written = json!({"model": "beam", "preset": "paper", "numerics": {"rod_speed": 1e-3}});
    assert_eq!(speed(written), 1e-3);
}

#[test]
fn fast_rods_are_allowed_with_a_warning() {
    let plan = plan(&json!({"model": "beam", "numerics": {"rod_speed": 0.01}}));
    let mut expansion = Expansion::new(&plan);
    while expansion.next_chunk(100).is_some() {}
    let warnings = expansion.into_warnings();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("periods"), "{warnings:?}");
}

#[tokio::test]
async fn beam_without_a_strength_has_null_and_the_reason_beside_it() {
    let (fresh, sweep) = done().await;
    let points = table(&fresh, sweep, "points?where=friction_coefficient=0.2").await;
    assert_eq!(points["total"], 2);
    let results = &points["items"][0]["results"];
    assert_eq!(results["ultimate_strength"], Value::Null);
    assert_eq!(results["ultimate_strength_reason"], "not_prominent");
    let others = table(&fresh, sweep, "points?where=friction_coefficient=0.3").await;
    let results = others["items"][0]["results"].as_object().expect("results");
    assert!(results["ultimate_strength"].is_f64());
    assert!(!results.contains_key("ultimate_strength_reason"));
}

#[tokio::test]
async fn points_of_beams_are_filtered_sorted_and_projected() {
    let (fresh, sweep) = done().await;
    let unyielding = "points?where=ultimate_strength_reason=not_prominent";
    assert_eq!(table(&fresh, sweep, unyielding).await["total"], 2);
    let strong = "points?where=protocol=B&where=ultimate_strength%3E=90000&sort=-ultimate_strength\
                  &columns=friction_coefficient,ultimate_strength";
    let rows = table(&fresh, sweep, strong).await;
    assert_eq!(rows["total"], 6);
    let first = &rows["items"][0];
    assert_eq!(first["parameters"], json!({"friction_coefficient": 1.2}));
    assert_eq!(first["results"].as_object().expect("results").len(), 1);
    // Nulls come last whatever the direction.
    for direction in ["", "-"] {
        let sorted = table(
            &fresh,
            sweep,
            &format!("points?sort={direction}ultimate_strength"),
        )
        .await;
        let last = &sorted["items"][21]["results"]["ultimate_strength"];
        assert_eq!(*last, Value::Null);
    }
    let path = format!("/api/v1/sweeps/{sweep}/points?format=csv");
    let csv = fresh.get(&path).await.text();
    let heading = csv.lines().next().expect("a heading");
    assert!(heading.contains("ultimate_strength_reason"), "{heading}");
    assert!(csv.contains("not_prominent"));
}

#[tokio::test]
async fn usual_chain_takes_means_over_packings_and_fits_them_over_friction() {
    let (fresh, sweep) = done().await;
    let means = table(&fresh, sweep, "sets?where=reduce=mean_sem").await;
    assert_eq!(means["total"], 11);
    let mean = &means["items"][0];
    assert_eq!(
        mean["parameters"],
        json!({"protocol": "A", "friction_coefficient": 0.0})
    );
    assert_eq!(mean["results"]["beam_stiffness"], 5e6);
    assert_eq!(mean["results"]["beam_stiffness_sem"], 0.0);
    assert_eq!((&mean["n"], &mean["of"]), (&json!(2), &json!(2)));
    let unyielding = &means["items"][2];
    assert_eq!(unyielding["results"]["ultimate_strength"], Value::Null);
    let reason = unyielding["missing_reason"].as_str().expect("a reason");
    assert_eq!(reason, "ultimate_strength: not_prominent");

    let fits = table(&fresh, sweep, "sets?where=shape=exponential").await;
    assert_eq!(fits["total"], 2);
    let fit = &fits["items"][0];
    assert_eq!(fit["parameters"], json!({"protocol": "A"}));
    assert_eq!((&fit["n"], &fit["of"]), (&json!(6), &json!(7)));
    assert_eq!(fit["results"]["strengths_dropped"], 1.0);
    for (name, expected) in [
        ("strength_zero_friction", 20e3),
        ("strength_infinite_friction", 100e3),
        ("strength_rate", 5.0),
    ] {
        let found = fit["results"][name].as_f64().expect("determined");
        assert!((found / expected - 1.0).abs() < 1e-6, "{name}: {found}");
    }
}

#[tokio::test]
async fn half_done_beams_show_provisional_means_and_fits() {
    let fresh = fresh().await;
    let sweep = sweep_of(&fresh.submit(&spec()).await);
    // Until the first beam is bent.
    while let Some(grant) = fresh.take().await {
        fresh.complete(grant.lease, &grant.jobs).await;
        if grant.jobs[0].spec.kind() == StageKind::Bend {
            break;
        }
    }
    let sets = table(&fresh, sweep, "sets").await;
    let rows = sets["items"].as_array().expect("rows");
    assert!(
        rows.iter()
            .any(|row| row["reduce"] == "mean_sem" && row["n"] == 1)
    );
    for row in rows {
        assert_eq!(row["provisional"], true, "{row}");
        let missing = row["results"].as_object().expect("results").values();
        assert!(missing.clone().all(|value| !value.is_null()) || row["missing_reason"].is_string());
    }
}

#[tokio::test]
async fn without_packings_as_an_axis_points_are_fitted_at_once() {
    let fresh = fresh().await;
    let frictions = json!([0.0, 0.1, 0.3, 0.6, 1.2]);
    let spec = json!({"model": "beam", "grid": [{"friction_coefficient": frictions}]});
    let sweep = sweep_of(&fresh.submit(&spec).await);
    fresh.work().await;
    let sets = table(&fresh, sweep, "sets").await;
    assert_eq!(sets["total"], 1);
    assert_eq!(sets["items"][0]["reduce"], "ultimate_strength_fit");
    assert_eq!(sets["items"][0]["shape"], "exponential");
    let read = fresh.get(&format!("/api/v1/sweeps/{sweep}")).await.json();
    assert_eq!(
        (&read["model"], &read["name"]),
        (&json!("beam"), &json!("beam"))
    );
}
