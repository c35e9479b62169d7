//! Settings, packings and costs that are known, and what a study says of them.

use super::*;
use serde_json::json;

fn map(value: &Value) -> Map<String, Value> {
    value.as_object().expect("an object").clone()
}

/// A score of one packing at one time step, with all its members or with one less.
fn score(time_step: f64, seed: u64, gain: f64, fidelity: f64, n: u64) -> SetRow {
    let results = [("gain", gain), ("fidelity", fidelity)];
    SetRow {
        set: 0,
        reduce: "gain_fidelity".to_owned(),
        processing: Some("SUB0".to_owned()),
        shape: None,
        setting: None,
        verdict: None,
        parameters: map(&json!({"packing_seed": seed, "time_step": time_step})),
        results: results
            .map(|(name, value)| (name.to_owned(), Some(value)))
            .into(),
        n,
        of: 6,
        provisional: false,
        missing_reason: (n < 6).then(|| "1 of 6 members are missing: unstable".to_owned()),
        warning: None,
        confused: vec![],
    }
}

/// A study of three time steps; `cost` falls with the step.
fn studied(rows: &[SetRow]) -> Vec<SetRow> {
    let settings = [0.5, 1.5, 2.0].map(|step| Studied {
        label: format!("time_step {step}"),
        values: map(&json!({"time_step": step})),
    });
    let over = ["packing_seed".to_owned()];
    let cost = |row: &SetRow| Cost {
        preparation: Some(100.0),
        run: row.parameters["time_step"].as_f64().map(|step| 30.0 / step),
    };
    study(rows, &over, &settings, Model::Memory, cost)
}

fn close(value: Option<f64>, expected: f64) -> bool {
    value.is_some_and(|value| (value - expected).abs() < 1e-12)
}

#[test]
fn errors_are_of_pairs_on_one_packing() {
    // The packings differ by 0.2 in fidelity, the settings by 0.01 and 0.03 on the same packing.
    let rows = studied(&[
        score(0.5, 1, 0.4, 0.7, 6),
        score(0.5, 2, 0.2, 0.9, 6),
        score(1.5, 1, 0.44, 0.71, 6),
        score(1.5, 2, 0.22, 0.93, 6),
    ]);
    let row = &rows[1];
    assert!(close(row.results["fidelity"], 0.82));
    assert!(close(row.results["fidelity_deviation"], 0.02));
    assert!(close(row.results["fidelity_deviation_sem"], 0.01));
    assert!(close(row.results["gain_deviation"], 0.1));
    assert!(row.results["gain_deviation_sem"].is_some_and(|sem| sem < 1e-12));
    assert!(close(row.results["core_seconds"], 20.0));
    assert!(close(row.results["relative_cost"], 1.0 / 3.0));
    assert!(close(row.results["preparation_core_seconds"], 100.0));
    assert_eq!(row.verdict.as_deref(), Some("front"));
    let reference = &rows[0];
    assert_eq!(reference.verdict.as_deref(), Some("reference"));
    assert!(close(reference.results["fidelity_deviation_bound"], 0.0));
}

#[test]
fn stopped_setting_has_no_error_and_says_why() {
    let rows = studied(&[score(0.5, 1, 0.4, 0.7, 6), score(2.0, 1, 0.1, 0.2, 5)]);
    let stopped = &rows[2];
    assert_eq!(stopped.results["fidelity"], None);
    assert_eq!(stopped.results["fidelity_deviation"], None);
    assert_eq!((stopped.n, stopped.of), (0, 1));
    assert_eq!(stopped.verdict.as_deref(), Some("incomplete"));
    let reason = stopped.missing_reason.as_deref().expect("a reason");
    assert_eq!(
        reason,
        "1 of 1 packings: 1 of 6 members are missing: unstable"
    );
}

#[test]
fn setting_that_another_beats_is_not_on_the_front() {
    // A step of 1.5 is dearer than one of 2, and worse in both results.
    let rows = studied(&[
        score(0.5, 1, 0.4, 0.7, 6),
        score(1.5, 1, 0.5, 0.8, 6),
        score(2.0, 1, 0.41, 0.71, 6),
    ]);
    let verdicts: Vec<_> = rows.iter().map(|row| row.verdict.as_deref()).collect();
    assert_eq!(verdicts, [Some("reference"), Some("beaten"), Some("front")]);
}

#[test]
fn what_is_to_come_has_no_verdict() {
    let mut open = score(1.5, 1, 0.5, 0.8, 4);
    open.provisional = true;
    let rows = studied(&[score(0.5, 1, 0.4, 0.7, 6), open]);
    assert_eq!(rows[1].verdict, None);
    assert!(rows[1].provisional);
    assert_eq!(rows[1].results["fidelity_deviation"], None);
    assert_eq!(rows[1].missing_reason, None);
}
