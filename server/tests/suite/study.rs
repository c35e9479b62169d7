//! Studies: which settings they compare, on which packings, and what stands in their table.

use granary_server::sweep::expansion::Expansion;
use granary_server::sweep::{Limits, Plan};
use serde_json::{Value, json};

use crate::harness::{Fresh, fresh, sweep_of};

/// Two packings, three waveforms, and what `study` compares.
fn spec(study: &Value) -> Value {
    json!({
        "name": "what haste costs",
        "model": "memory",
        "fixed": {"grains": 100},
        "grid": [{"packing_seed": [1, 2], "waveform": ["six/1", "six/2", "six/5"]}],
        "study": study,
    })
}

/// The settings that a study compares, the reference first, as the points of one packing and waveform show them.
fn settings(study: &Value) -> Vec<Value> {
    let plan = Plan::read(&spec(study), Limits::default()).expect("a valid study");
    let mut expansion = Expansion::new(&plan);
    let mut points = vec![];
    while let Some(chunk) = expansion.next_chunk(7) {
        points.extend(chunk.points);
    }
    points.sort_by_key(|point| point.point);
    let read = |text: &str| -> Value { serde_json::from_str(text).expect("JSON") };
    let mut all: Vec<Value> = points.iter().map(|point| read(&point.parameters)).collect();
    all.retain(|point| point["packing_seed"] == 1 && point["waveform"] == "six/1");
    for point in &mut all {
        let table = point.as_object_mut().expect("a table");
        table.retain(|name, _| name != "packing_seed" && name != "waveform");
    }
    all
}

async fn rows(fresh: &Fresh, spec: &Value, query: &str) -> Vec<Value> {
    let sweep = sweep_of(&fresh.submit(spec).await);
    fresh.work().await;
    let path = format!("/api/v1/sweeps/{sweep}/sets?{query}");
    let answer = fresh.get(&path).await;
    assert_eq!(answer.status, 200, "{}", answer.text());
    answer.json()["items"].as_array().expect("rows").clone()
}

#[test]
fn knobs_vary_one_at_a_time_from_the_spec_which_is_the_reference_itself_where_none_is_named() {
    let found = settings(&json!({"time_step": [0.5, 1.5], "ramp": [4500]}));
    let expected = [
        json!({"time_step": 1.5, "ramp": 18_000.0}),
        json!({"time_step": 0.5, "ramp": 18_000.0}),
        json!({"time_step": 1.5, "ramp": 4_500.0}),
    ];
    assert_eq!(found, expected);
}

#[test]
fn reference_comes_first_and_the_spec_as_it_stands_is_compared_with_it() {
    let found =
        settings(&json!({"hold": [2], "reference": {"time_step": 0.5, "precision": "f64"}}));
    let expected = [
        json!({"time_step": 0.5, "precision": "f64", "hold": 0.2}),
        json!({"time_step": 1.5, "precision": "f32", "hold": 0.2}),
        json!({"time_step": 1.5, "precision": "f32", "hold": 2.0}),
    ];
    assert_eq!(found, expected);
}

#[test]
fn setting_changes_several_parameters_and_a_preset_all_of_its_own() {
    let study = json!({"setting": [{"ramp": 6000, "drag": 0.01}, {"preset": "draft"}, {"preset": "paper"}]});
    let found = settings(&study);
    let setting = |ramp: f64, drag: f64, step: f64, hold: f64, precision: &str| json!({"ramp": ramp, "drag": drag, "time_step": step, "hold": hold, "precision": precision});
    let expected = [
        setting(18_000.0, 0.1, 1.5, 0.2, "f32"),
        setting(6_000.0, 0.01, 1.5, 0.2, "f32"),
        setting(4_500.0, 0.1, 1.5, 0.2, "f32"),
        setting(18_000.0, 0.0, 1.0, 2.0, "f64"),
    ];
    assert_eq!(found, expected);
}

#[tokio::test]
async fn settings_share_their_packings_and_each_has_its_errors_and_its_cost() {
    let fresh = fresh().await;
    let spec = spec(&json!({"time_step": [0.5, 1.0]}));
    let submitted = fresh.submit(&spec).await;
    // Two packs; for each of them and each of three steps one training, three recalls and the zero waveform.
    assert_eq!((submitted.points, submitted.jobs.total), (18, 2 + 6 * 5));
    let studied = rows(&fresh, &spec, "where=reduce=study").await;
    assert_eq!(studied.len(), 3);
    for row in &studied {
        let results = &row["results"];
        // Every job took a second, and every recall gives back the same.
        assert_eq!(results["core_seconds"], 5.0);
        assert_eq!(results["preparation_core_seconds"], 1.0);
        assert_eq!(results["relative_cost"], 1.0);
        assert_eq!(results["fidelity_deviation"], 0.0);
        assert_eq!(results["fidelity_deviation_sem"], 0.0);
        assert_eq!((&row["n"], &row["of"]), (&json!(2), &json!(2)));
    }
    assert_eq!(studied[0]["parameters"], json!({"time_step": 1.5}));
    assert_eq!(studied[0]["verdict"], "reference");
    assert_eq!(studied[1]["verdict"], "front");
}

#[tokio::test]
async fn beam_is_judged_by_stiffness_and_strength() {
    let fresh = fresh().await;
    let spec = json!({
        "model": "beam",
        "grid": [{"packing_seed": [1, 2], "friction_coefficient": [0.2, 0.9]}],
        "study": {"rod_speed": [0.01]},
    });
    let studied = rows(&fresh, &spec, "where=reduce=study").await;
    assert_eq!(studied.len(), 4);
    let of = |friction: f64, row: usize| {
        let same = |item: &&Value| item["parameters"]["friction_coefficient"] == friction;
        studied.iter().filter(same).nth(row).expect("a row").clone()
    };
    let strong = of(0.9, 1);
    assert_eq!(strong["results"]["ultimate_strength_deviation"], 0.0);
    assert_eq!(strong["results"]["core_seconds"], 1.0);
    assert_eq!(strong["results"]["preparation_core_seconds"], 2.0);
    // Without a yield there is a stiffness to compare, and no strength.
    let weak = of(0.2, 1);
    assert_eq!(weak["results"]["beam_stiffness_deviation"], 0.0);
    assert_eq!(weak["results"]["ultimate_strength_deviation"], Value::Null);
    assert_eq!(weak["verdict"], "incomplete");
}
