//! The guard: a run that has left the physics is stopped with its reason, the step, and what to change.
//!
//! No outcome is lost to it that is one: how near the critical time step it lets runs come is in `critical_time_step.rs`.

use std::ops::ControlFlow;

use granary_core::lanes::VectorWidth;
use granary_core::stage::{Ensemble, Outcome, StageFailure, StageSpec, run_with};
use serde_json::{Value, json};

#[path = "fixture/tiny_pack.rs"]
#[allow(dead_code, reason = "every proof takes what it needs")]
mod tiny_pack;

use tiny_pack::{finish, tiny};

fn prepared(changes: &Value) -> Result<Outcome, StageFailure> {
    let spec = [StageSpec::Pack(tiny(changes).pack())];
    finish(&spec, &[], VectorWidth::widest()).remove(0)
}

#[test]
fn a_sphere_pressed_half_through_a_wall_is_stopped() {
    // One sphere has no other to overlap with.
    // At rest, 0.1 E on (3.08 R)² is k_w p^(3/2) with k_w = 1.75 E R^½: p = 0.66 R.
    let changes = json!({"shape": "sphere", "grains": 1, "servo_pressure": 0.1});
    let expected = StageFailure::Stopped {
        kind: "overlap".to_owned(),
        step: 600,
        detail: "a sphere and a wall overlap by 0.60 R, more than 0.5 R".to_owned(),
        remedy: "use a smaller delta0, gamma0 or servo_pressure, or a longer ramp".to_owned(),
    };
    assert_eq!(prepared(&changes), Err(expected));
}

/// The step of a stop as unstable, and the largest time step that its remedy names.
fn unstable(result: &Result<Outcome, StageFailure>, what: &str) -> (u64, f64) {
    let Err(StageFailure::Stopped {
        kind, step, remedy, ..
    }) = result
    else {
        panic!("{what}: {result:?}")
    };
    assert_eq!(kind, "unstable", "{what}: {result:?}");
    let most = remedy
        .strip_prefix("use a preparation_time_step of at most ")
        .and_then(|most| most.parse().ok());
    (*step, most.unwrap_or_else(|| panic!("{what}: {result:?}")))
}

#[test]
fn a_far_too_large_time_step_of_preparation_is_unstable() {
    // Grains flew out of all numbers within the hundred steps between two looks, so that no contact was left to measure.
    // Once their orientations were no numbers, they touched nothing, and the pack was said not to come to rest.
    for shape in ["sphere", "tetrahedron"] {
        for (seed, time_step) in (1..=8).flat_map(|seed| [4.5, 10.0, 100.0].map(|h| (seed, h))) {
            for gas_time in [300.0, 3000.0] {
                let changes = json!({
                    "shape": shape, "packing_seed": seed, "gas_time": gas_time, "preparation_time_step": time_step,
                });
                let (step, most) = unstable(&prepared(&changes), &changes.to_string());
                // The wall of the servo needs 20,000 t_c to press.
                assert!(
                    step > 0 && step as f64 * time_step < 3e4,
                    "{changes}: {step}"
                );
                assert!(most < time_step && most > 0.5, "{changes}: {most}");
            }
        }
    }
}

#[test]
fn remedies_of_unstable_preparations_lead_to_a_pack() {
    for shape in ["sphere", "tetrahedron"] {
        for seed in 1..=8 {
            let mut time_step = 10.0;
            for attempt in 0.. {
                let changes = json!({
                    "shape": shape, "packing_seed": seed, "preparation_time_step": time_step,
                });
                let result = prepared(&changes);
                if result.is_ok() {
                    break;
                }
                // Each remedy leaves 0.85 of what was measured: from 10 to 3 t_c in at most eight.
                assert!(attempt < 8, "{changes}: {result:?}");
                (_, time_step) = unstable(&result, &changes.to_string());
            }
        }
    }
}

#[test]
fn a_pack_that_cannot_rest_for_its_time_step_is_told_so_within_ten_thousand_steps() {
    // Damping of 23 t_c, a hundred times the usual: a contact's critical step is 2 m/γ, a tenth of the preparation's.
    let changes = json!({"normal_damping": 23.0});
    let (step, most) = unstable(&prepared(&changes), "overdamped");
    assert!(step <= 300 + 10_000, "{step}");
    assert!(most < 1.0, "{most}");
}

#[test]
fn an_interrupted_preparation_fails_as_if_it_had_not_been() {
    for (shape, seed) in [
        ("sphere", 1),
        ("sphere", 5),
        ("tetrahedron", 1),
        ("tetrahedron", 6),
    ] {
        let changes = json!({"shape": shape, "packing_seed": seed, "preparation_time_step": 4.0});
        let specs = [StageSpec::Pack(tiny(&changes).pack())];
        let mut saved = vec![];
        let mut ensemble = Ensemble {
            specs: &specs,
            input: &[],
            checkpoints: None,
        };
        let whole = run_with(&ensemble, VectorWidth::widest(), &mut |report| {
            saved = (report.checkpoint)();
            ControlFlow::Continue(())
        });
        unstable(&whole[0], &changes.to_string());
        ensemble.checkpoints = Some(&saved);
        let resumed = run_with(&ensemble, VectorWidth::widest(), &mut |_| {
            ControlFlow::Continue(())
        });
        assert_eq!(resumed, whole, "{changes}");
    }
}
