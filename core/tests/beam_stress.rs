//! Beams at the edges of what is allowed: each ends well, with numbers or nulls that mean something, or stops with its reason.
//!
//! Source: the table of stress cases in docs/beam.md, which names these tests.

use granary_core::beam::point::BeamPoint;
use granary_core::lanes::VectorWidth;
use granary_core::stage::{HISTORY, Outcome, STATE, StageFailure, StageSpec};
use serde_json::{Value, json};

#[path = "fixture/tiny_beam.rs"]
#[allow(dead_code, reason = "every proof takes what it needs")]
mod tiny_beam;

use tiny_beam::{all, finish, stages, tiny};

/// A tiny beam that is pressed in even more haste.
fn hasty(changes: &Value) -> BeamPoint {
    let mut all = json!({"pressure_ramp": 0.01, "mold_speed": 0.4, "rest_volume_rate": 1.0});
    let table = all.as_object_mut().expect("a table");
    table.extend(changes.as_object().expect("a table").clone());
    tiny(&all)
}

/// The outcomes of the first stages of a point.
fn first<const N: usize>(point: &BeamPoint) -> [Outcome; N] {
    let specs = stages(point);
    let mut input = vec![];
    std::array::from_fn(|n| {
        let outcome = run(&specs[n], &input);
        input.clone_from(&outcome.artifacts[STATE]);
        outcome
    })
}

fn run(spec: &StageSpec, input: &[u8]) -> Outcome {
    finish(spec, (input, None), VectorWidth::widest())
        .unwrap_or_else(|failure| panic!("{}: {failure}", spec.kind().name()))
}

fn number(outcome: &Outcome, name: &str) -> f64 {
    outcome.results[name].unwrap_or_else(|| panic!("{name} is null"))
}

/// A result of exactly nothing.
fn is_zero(outcome: &Outcome, name: &str) -> bool {
    number(outcome, name).abs() < f64::MIN_POSITIVE
}

fn history(bend: &Outcome) -> Value {
    serde_json::from_slice(&bend.artifacts[HISTORY]).expect("JSON")
}

/// Whether a warning that begins with `flag` is among those of `outcome`.
fn warns(outcome: &Outcome, flag: &str) -> bool {
    outcome.warnings.iter().any(|text| text.starts_with(flag))
}

fn assert_finite(outcomes: &[Outcome]) {
    for outcome in outcomes {
        for (name, value) in &outcome.results {
            assert!(value.is_none_or(f64::is_finite), "{name} = {value:?}");
        }
    }
}

#[test]
fn smooth_beam_has_no_tangential_force_and_no_coulomb_fraction() {
    let [_, _, bend] = all(&hasty(&json!({"friction_coefficient": 0.0})));
    assert_eq!(bend.results["coulomb_fraction"], None);
    assert!(is_zero(&bend, "mean_tangential_force"));
    assert!(number(&bend, "mean_normal_force") > 0.0);
    let column = &history(&bend)["coulomb_fraction"];
    let rows = column.as_array().expect("a column");
    assert!(rows.len() > 10 && rows.iter().all(Value::is_null));
}

#[test]
fn friction_of_a_thousand_compacts_as_friction_of_ten_does() {
    let of = |friction: f64, seed: u64| {
        let point = hasty(&json!({"friction_coefficient": friction, "packing_seed": seed}));
        let [_, jam] = first(&point);
        ["volume_fraction", "coordination_number"].map(|name| number(&jam, name))
    };
    let (ten, thousand, other) = (of(10.0, 1), of(1e3, 1), of(10.0, 2));
    for k in 0..2 {
        // Less than from one packing to another.
        assert!((thousand[k] - ten[k]).abs() < (other[k] - ten[k]).abs());
    }
}

/// The same grains in other units of pressure: every time is as 1/√E_p, and nothing else changes.
#[test]
fn grains_of_a_tenth_of_a_megapascal_and_of_a_terapascal_grow_in_the_same_steps() {
    let grown = |youngs_modulus: f64| {
        let slower = (2e7 / youngs_modulus).sqrt();
        let point = tiny(&json!({
            "youngs_modulus": youngs_modulus, "membrane_youngs_modulus": 0.5 * youngs_modulus,
            "growth_time": 0.01 * slower, "growth_rest": 0.005 * slower, "background_damping": 2.0 / slower,
            "relaxation_time": 7e-6 * slower,
        }));
        let [grow] = first(&point);
        assert_finite(std::slice::from_ref(&grow));
        grow
    };
    let usual = grown(2e7);
    for youngs_modulus in [1e5, 1e12] {
        let grow = grown(youngs_modulus);
        // Rounding may cost a step, and hardly moves grains that scarcely touch.
        assert!(grow.steps.abs_diff(usual.steps) <= 1);
        let [overlap, expected] = [&grow, &usual].map(|of| number(of, "largest_overlap"));
        assert!(
            (overlap / expected - 1.0).abs() < 1e-6,
            "{overlap} {expected}"
        );
    }
}

#[test]
fn grains_of_any_poisson_ratio_and_of_one_size_grow_to_the_fraction_asked_for() {
    for changes in [
        json!({"poisson_ratio": -0.98}),
        json!({"poisson_ratio": 0.0}),
        json!({"poisson_ratio": 0.5}),
        json!({"radius_min": 1.7e-3, "radius_max": 1.7e-3}),
    ] {
        let [grow] = first(&tiny(&changes));
        assert_finite(std::slice::from_ref(&grow));
        let fraction = number(&grow, "initial_volume_fraction");
        // The last step of growth is cut short.
        assert!((fraction - 0.5).abs() < 1e-9, "{changes}: {fraction}");
        assert_eq!(grow.warnings, [""; 0], "{changes}");
    }
}

#[test]
fn soft_grains_that_overlap_by_more_than_a_quarter_of_a_radius_are_bent_with_a_warning() {
    let [_, jam, bend] = all(&hasty(&json!({"youngs_modulus": 5e6})));
    assert!(number(&jam, "largest_overlap") > 0.25);
    assert!(warns(&bend, "hertz_out_of_range"), "{:?}", bend.warnings);
    assert_finite(&[jam, bend]);
}

#[test]
fn usual_beam_begins_unbent_and_its_last_outcome_has_the_warnings_of_all_stages() {
    let [grow, jam, bend] = all(&hasty(&json!({"overlap_warning": 1e-3})));
    let deep = |outcome: &Outcome, when: &str| {
        let mut warnings = outcome.warnings.iter();
        warnings.any(|text| text.starts_with("deep_overlap") && text.ends_with(when))
    };
    assert!(deep(&grow, "in growth"));
    assert!(deep(&jam, "in growth") && deep(&jam, "in compaction"));
    assert!(deep(&bend, "in growth") && deep(&bend, "in compaction") && deep(&bend, "in the test"));
    // Grains at half of the mold's volume are loose.
    assert!(!warns(&bend, "growth_overshoot"));
    // Rods begin above the beam: the first stress is not that of a beam already bent.
    let history = history(&bend);
    let stress = history["stress"].as_array().expect("a column");
    let stress = |k: usize| stress[k].as_f64().expect("a stress");
    let last = history["stress"].as_array().map_or(0, Vec::len) - 1;
    assert!(stress(0) > 0.0 && stress(0) < 0.1 * stress(last));
}

#[test]
fn grains_grown_to_a_crystals_fraction_are_warned_about_and_not_lost_to_rounding() {
    let point = hasty(&json!({"initial_volume_fraction": 0.74, "growth_factor": 1.6}));
    let [grow, jam] = first(&point);
    assert!((number(&grow, "initial_volume_fraction") - 0.74).abs() < 1e-9);
    assert!(warns(&jam, "growth_overshoot"), "{:?}", jam.warnings);
}

#[test]
fn empty_beam_is_its_membrane() {
    let point = tiny(
        &json!({"initial_volume_fraction": 0.0, "confining_pressure": 0.0, "longest_rest": 0.3}),
    );
    let outcomes = all(&point);
    let [_, jam, bend] = &outcomes;
    assert!(is_zero(jam, "volume_fraction") && is_zero(bend, "grains"));
    for outcome in [jam, bend] {
        assert_eq!(outcome.results["coordination_number"], None);
    }
    assert!(number(bend, "beam_stiffness") > 0.0);
    assert_finite(&outcomes);
}

#[test]
fn one_grain_is_a_beam() {
    // 2e-3 of the mold is one grain's volume.
    let point = tiny(
        &json!({"initial_volume_fraction": 1.9e-3, "confining_pressure": 0.0, "longest_rest": 0.3}),
    );
    let outcomes = all(&point);
    for outcome in &outcomes {
        assert!((number(outcome, "grains") - 1.0).abs() < f64::MIN_POSITIVE);
    }
    assert!(is_zero(&outcomes[2], "coordination_number"));
    assert!(is_zero(&outcomes[2], "mean_normal_force"));
    assert_finite(&outcomes);
}

#[test]
fn beam_without_pressure_is_loose_grains_in_a_membrane() {
    let point = tiny(
        &json!({"initial_volume_fraction": 0.05, "confining_pressure": 0.0, "longest_rest": 0.3}),
    );
    let outcomes = all(&point);
    let [_, jam, bend] = &outcomes;
    assert!(number(jam, "grains") > 10.0);
    assert!((number(jam, "volume_fraction") - 0.05).abs() < 1e-3);
    assert!(number(jam, "coordination_number") < 0.5);
    assert!(number(bend, "beam_stiffness") > 0.0);
    assert_finite(&outcomes);
}

#[test]
fn membrane_with_nothing_in_it_collapses_under_pressure() {
    let specs = stages(&tiny(&json!({"initial_volume_fraction": 0.0})));
    let grow = run(&specs[0], &[]);
    let jam = finish(
        &specs[1],
        (&grow.artifacts[STATE], None),
        VectorWidth::widest(),
    );
    let Err(StageFailure::Stopped { kind, .. }) = jam else {
        panic!("it stands");
    };
    assert_eq!(kind, "membrane_collapse");
}

#[test]
fn mold_that_does_not_close_in_time_is_named() {
    let specs = stages(&tiny(&json!({"mold_speed": 1e-4, "longest_rest": 0.02})));
    let grow = run(&specs[0], &[]);
    let input = (grow.artifacts[STATE].as_slice(), None);
    let Err(StageFailure::Stopped { kind, remedy, .. }) =
        finish(&specs[1], input, VectorWidth::widest())
    else {
        panic!("it closed");
    };
    assert_eq!(kind, "not_at_rest");
    assert!(remedy.contains("mold_speed"), "{remedy}");
}
