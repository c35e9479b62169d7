//! Specs: what the accepted forms mean.

use granary_core::stage::StageKind;
use granary_server::sweep::expansion::Expansion;
use granary_server::sweep::{Limits, Plan};
use serde_json::{Value, json};

/// A sweep that is right but for what `wrong` puts over it.
fn with(wrong: &Value) -> Value {
    let mut spec = json!({"model": "memory"});
    let table = spec.as_object_mut().expect("a table");
    table.extend(wrong.as_object().expect("a table").clone());
    spec
}

fn plan(spec: &Value) -> Plan {
    Plan::read(spec, Limits::default()).expect("a valid spec")
}

/// The parameters of every point, by number.
fn points(spec: &Value) -> Vec<(u64, Value)> {
    let plan = plan(spec);
    let mut expansion = Expansion::new(&plan);
    let mut points = vec![];
    while let Some(chunk) = expansion.next_chunk(7) {
        points.extend(chunk.points);
    }
    points.sort_by_key(|point| point.point);
    let read = |text: &str| serde_json::from_str(text).expect("JSON");
    points
        .iter()
        .map(|point| (point.point, read(&point.parameters)))
        .collect()
}

fn axis_of(name: &str, value: &Value) -> Vec<Value> {
    plan(&with(&json!({"grid": [{name: value}]}))).grids[0][0]
        .values
        .clone()
}

#[test]
fn axes_mean_what_the_manual_says() {
    assert_eq!(
        axis_of("friction_coefficient", &json!({"linspace": [0, 1.2, 7]})).len(),
        7
    );
    assert_eq!(
        axis_of("friction_coefficient", &json!({"linspace": [0, 1, 3]})),
        [json!(0.0), json!(0.5), json!(1.0)]
    );
    assert_eq!(
        axis_of("friction_coefficient", &json!({"linspace": [0.1, 0.3, 3]}))[2],
        json!(0.3)
    );
    assert_eq!(
        axis_of("packing_seed", &json!({"range": [1, 4]})),
        [1, 2, 3, 4]
    );
    assert_eq!(
        axis_of("packing_seed", &json!({"range": [1, 6, 2]})),
        [1, 3, 5]
    );
    assert_eq!(
        axis_of("packing_seed", &json!({"range": [3, 1, -1]})),
        [3, 2, 1]
    );
    assert_eq!(axis_of("packing_seed", &json!(7)), [7]);
    assert_eq!(
        axis_of("second_cycle", &json!([true, false])),
        [true, false]
    );
    assert_eq!(axis_of("waveform", &json!({"suite": "six"})).len(), 6);
    assert_eq!(
        axis_of("waveform", &json!({"suite": "binary_words", "bits": 3})).len(),
        8
    );
    assert_eq!(axis_of("waveform", &json!("zero")), ["zero"]);
    let bumps = json!({"width": 0.2, "centers": [0.5], "amplitudes": [1.0]});
    assert_eq!(
        axis_of("waveform", &json!({"suite": "bumps", "bumps": [bumps]})),
        std::slice::from_ref(&bumps)
    );
    assert_eq!(
        axis_of("waveform", &json!(["zero", {"suite": "six"}, bumps])).len(),
        8
    );
}

#[test]
fn points_are_numbered_in_the_declared_order_the_last_axis_fastest() {
    let spec = with(&json!({"grid": [{"waveform": ["six/1", "zero"], "packing_seed": [1, 2]}]}));
    let expected = [("six/1", 1), ("six/1", 2), ("zero", 1), ("zero", 2)];
    let expected = expected.iter().enumerate().map(|(k, (waveform, seed))| {
        (
            k as u64,
            json!({"waveform": waveform, "packing_seed": seed}),
        )
    });
    assert_eq!(points(&spec), expected.collect::<Vec<_>>());
}

#[test]
fn grids_are_joined_and_a_point_that_two_of_them_name_is_one() {
    let spec = with(&json!({"grid": [
        {"friction_coefficient": [0.2, 0.4], "packing_seed": 1},
        {"friction_coefficient": [0.4, 0.6], "packing_seed": [1, 2]},
    ]}));
    let points = points(&spec);
    assert_eq!(points.len(), 5);
    assert_eq!(
        points[4],
        (5, json!({"friction_coefficient": 0.6, "packing_seed": 2}))
    );
}

#[test]
fn axis_of_one_grid_takes_the_fixed_value_in_another() {
    let spec = with(&json!({"grid": [{"friction_coefficient": [0.2]}, {"hold": [1.0]}]}));
    assert_eq!(
        points(&spec),
        [
            (0, json!({"friction_coefficient": 0.2, "hold": 0.2})),
            (1, json!({"friction_coefficient": 1.0, "hold": 1.0})),
        ]
    );
}

#[test]
fn what_the_spec_writes_wins_over_its_preset() {
    let draft = plan(&with(
        &json!({"preset": "draft", "numerics": {"drag": 0.02}}),
    ));
    assert_eq!(
        (&draft.fixed["drag"], &draft.fixed["ramp"]),
        (&json!(0.02), &json!(4500.0))
    );
}

#[test]
fn second_cycle_is_run_where_a_reduction_needs_it_or_the_spec_says_so() {
    let reduced = |processing: &str| json!([{"kind": "gain_fidelity", "processing": [processing]}]);
    let second_cycle = |changes: Value| plan(&with(&changes)).fixed["second_cycle"].clone();
    assert_eq!(second_cycle(json!({})), false);
    assert_eq!(second_cycle(json!({"reduce": reduced("SUB0")})), false);
    assert_eq!(second_cycle(json!({"reduce": reduced("SUB2-BL")})), true);
    let said = json!({"numerics": {"second_cycle": true}});
    assert_eq!(second_cycle(said), true);
    // An axis is not told otherwise.
    let axis = json!({"grid": [{"second_cycle": [true, false]}]});
    assert_eq!(points(&with(&axis)).len(), 2);
}

#[test]
fn whole_reals_and_key_order_of_sections_do_not_make_another_sweep() {
    let one = plan(&json!({"model": "memory", "fixed": {"grains": 10, "delta0": 0.1}}));
    let two =
        plan(&json!({"fixed": {"delta0": 0.10, "grains": 10.0}, "model": "memory", "priority": 3}));
    assert_eq!(one.identity(), two.identity());
    let three = plan(&json!({"model": "memory", "fixed": {"grains": 11, "delta0": 0.1}}));
    assert_ne!(one.identity(), three.identity());
}

#[test]
fn another_physics_makes_another_sweep() {
    // Else a data directory would answer with what an older engine computed.
    let sweep = plan(&json!({"model": "memory", "fixed": {"grains": 10}}));
    let kinds = [
        StageKind::Pack,
        StageKind::Train,
        StageKind::Encode,
        StageKind::Recall,
    ];
    let now = kinds.map(StageKind::physics);
    assert_eq!(sweep.identity(), sweep.identity_with(&now));
    let later = [now[0], now[1], now[2], now[3] + 1];
    assert_ne!(sweep.identity(), sweep.identity_with(&later));
}

#[test]
fn large_shear_is_allowed_with_a_warning() {
    let plan = plan(&with(&json!({"fixed": {"gamma0": 0.1}})));
    let mut expansion = Expansion::new(&plan);
    while expansion.next_chunk(100).is_some() {}
    let warnings = expansion.into_warnings();
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].contains("gamma0"), "{warnings:?}");
}
