//! The beam's stages: the same bits whatever interrupts them and whatever vectors they run on, and what they may not do.
//!
//! Source: the invariants of ARCHITECTURE.md, and what stops a run (docs/refusals.md).

use std::time::Duration;

use granary_core::beam::results::{FITS, RESULTS};
use granary_core::crew::Crew;
use granary_core::lanes::VectorWidth;
use granary_core::stage::{
    GRAINS_DUMP, HISTORY, MEMBRANE_COLLECTION, Outcome, STATE, STRUCTURE, StageFailure, StageSpec,
    checkpoint_step,
};
use serde_json::{Value, json};

#[path = "fixture/tiny_beam.rs"]
mod tiny_beam;

use tiny_beam::{all, finish, interrupt, stages, tiny};

fn assert_same(expected: &Outcome, found: &Result<Outcome, StageFailure>, what: &str) {
    let found = found
        .as_ref()
        .unwrap_or_else(|failure| panic!("{what}: {failure}"));
    assert_eq!(expected.results, found.results, "{what}");
    assert_eq!(expected.hash(), found.hash(), "{what}");
}

#[test]
fn an_interrupted_stage_ends_as_if_it_had_not_been() {
    // Down, up and down again, with one end on a roller.
    let point = tiny(&json!({"cycles": 1, "cycle_strain": 0.0005, "support": "pinned_roller"}));
    let (specs, outcomes) = (stages(&point), all(&point));
    let loss = outcomes[2].results["unloading_loss"].expect("a cycle");
    assert!((0.0..1.0).contains(&loss), "{loss}");
    let mut input: &[u8] = &[];
    for (spec, outcome) in specs.iter().zip(&outcomes) {
        for share in [0.2, 0.75] {
            let step = (share * outcome.steps as f64) as u64;
            let saved = interrupt(spec, input, step);
            let at = checkpoint_step(&saved).expect("a checkpoint");
            assert!(at >= step && at < step + 100);
            let found = finish(spec, (input, Some(&saved)), VectorWidth::widest());
            assert_same(outcome, &found, &format!("{} at {at}", spec.kind().name()));
        }
        input = outcome.artifacts.get(STATE).map_or(&[], Vec::as_slice);
    }
}

#[test]
fn every_vector_width_gives_the_same_bits() {
    // Without fused instructions a product-sum takes a hundred times as long: the narrowest path only grows and jams grains.
    let point = tiny(&json!({"strain_end": 0.0005}));
    let (specs, outcomes) = (stages(&point), all(&point));
    let mut input: &[u8] = &[];
    for (spec, outcome) in specs.iter().zip(&outcomes) {
        for width in VectorWidth::available() {
            if width == VectorWidth::PORTABLE && !matches!(spec, StageSpec::Grow(_)) {
                continue;
            }
            let found = finish(spec, (input, None), width);
            assert_same(
                outcome,
                &found,
                &format!("{} {}", spec.kind().name(), width.name()),
            );
        }
        input = outcome.artifacts.get(STATE).map_or(&[], Vec::as_slice);
    }
}

#[test]
fn two_threads_give_the_same_bits() {
    let point = tiny(&json!({"strain_end": 0.0005}));
    let (specs, outcomes) = (stages(&point), all(&point));
    let crew = Crew::new(2, || Duration::ZERO);
    let mut input: &[u8] = &[];
    for (spec, outcome) in specs.iter().zip(&outcomes) {
        let found = crew
            .work(|| finish(spec, (input, None), VectorWidth::widest()))
            .0;
        assert_same(outcome, &found, spec.kind().name());
        input = outcome.artifacts.get(STATE).map_or(&[], Vec::as_slice);
    }
}

#[test]
fn a_bent_beam_says_how_it_was_bent() {
    let [_, jam, bend] = all(&tiny(&json!({})));
    let number = |outcome: &Outcome, name: &str| {
        outcome.results[name].unwrap_or_else(|| panic!("{name} is null"))
    };
    // Denser than as grown, looser than a crystal.
    let jammed = number(&jam, "volume_fraction");
    assert!((0.55..0.9).contains(&jammed), "{jammed}");
    assert!(number(&bend, "beam_stiffness") > 0.0);
    assert!(number(&bend, "strain_reached") >= 0.0015);
    for control in [
        "imbalance_max",
        "kinetic_energy_ratio_max",
        "inertial_number_max",
    ] {
        assert!(number(&bend, control) > 0.0, "{control}");
    }
    for quantity in &RESULTS[FITS.len()..] {
        assert!(
            bend.results.contains_key(quantity.name),
            "{}",
            quantity.name
        );
    }
    let z = number(&bend, "coordination_number");
    assert!(number(&bend, "coordination_number_without_rattlers") >= z);
    assert!(number(&bend, "coordination_number_with_membrane") > z);
    // The beam is under pressure all the time: each step computes about z N/2 contacts of grains, and those with the membrane.
    let pairs = 0.5 * z * number(&bend, "grains") * bend.steps as f64;
    assert!(number(&bend, "contact_updates") > 0.5 * pairs);
    assert!(bend.results["ultimate_strength"].is_none());
    assert_eq!(bend.reasons["ultimate_strength"], "run_too_short");
    let history: Value = serde_json::from_slice(&bend.artifacts[HISTORY]).expect("JSON");
    let length = |name: &str| history[name].as_array().expect("a column").len();
    assert!(length("strain") > 20);
    for name in [
        "time",
        "stress",
        "force",
        "support_reaction",
        "coulomb_fraction",
    ] {
        assert_eq!(length(name), length("strain"), "{name}");
    }
}

#[test]
fn both_protocols_and_every_friction_of_b_share_one_compacted_beam() {
    let of = |changes: Value| stages(&tiny(&changes))[1].id();
    let a = of(json!({"protocol": "A", "friction_coefficient": 0.3}));
    for friction in [0.3, 0.6, 1.2] {
        assert_eq!(
            a,
            of(json!({"protocol": "B", "friction_coefficient": friction}))
        );
    }
    assert_ne!(a, of(json!({"protocol": "A", "friction_coefficient": 0.6})));
}

#[test]
fn a_stage_refuses_the_state_of_another_beam() {
    let point = tiny(&json!({}));
    let grow = finish(&stages(&point)[0], (&[], None), VectorWidth::widest()).expect("grains");
    let other = &stages(&tiny(&json!({"packing_seed": 2})))[1];
    let found = finish(other, (&grow.artifacts[STATE], None), VectorWidth::widest());
    assert!(
        matches!(found, Err(StageFailure::Input { .. })),
        "{found:?}"
    );
    // Nor does it go on from the checkpoint of another.
    let [first, second] =
        [1, 2].map(|seed| stages(&tiny(&json!({"packing_seed": seed})))[0].clone());
    let saved = interrupt(&first, &[], 100);
    let found = finish(&second, (&[], Some(&saved)), VectorWidth::widest());
    assert!(
        matches!(found, Err(StageFailure::Input { .. })),
        "{found:?}"
    );
}

fn stop(changes: &Value) -> (String, String) {
    let specs = stages(&tiny(changes));
    let mut input = vec![];
    for spec in &specs {
        match finish(spec, (&input, None), VectorWidth::widest()) {
            Ok(outcome) => input = outcome.artifacts.get(STATE).cloned().unwrap_or_default(),
            Err(StageFailure::Stopped { kind, remedy, .. }) => return (kind, remedy),
            Err(other) => panic!("{other}"),
        }
    }
    panic!("{changes} ends well");
}

#[test]
fn a_run_that_leaves_the_physics_stops_with_its_reason() {
    let (kind, remedy) = stop(&json!({"overlap_limit": 0.01, "overlap_warning": 0.005}));
    assert_eq!(kind, "overlap_limit");
    assert!(remedy.contains("overlap_limit"));
    let (kind, _) = stop(&json!({"preparation_time_step_fraction": 1.1}));
    assert_eq!(kind, "unstable");
    let (kind, _) = stop(&json!({"longest_rest": 1e-3}));
    assert_eq!(kind, "not_at_rest");
}

/// The numbers after each `ITEM: TIMESTEP` of a dump.
fn dumped_steps(dump: &[u8]) -> Vec<u64> {
    let text = std::str::from_utf8(dump).expect("text");
    let after = text.split("ITEM: TIMESTEP\n").skip(1);
    after
        .map(|block| block.lines().next().and_then(|line| line.parse().ok()))
        .collect::<Option<_>>()
        .expect("a step in each block")
}

#[test]
fn a_bending_that_is_looked_at_is_the_same_and_goes_on_with_all_that_was_seen() {
    let point = tiny(&json!({
        "strain_end": 0.004, "structure": true, "snapshots": true, "snapshot_travel": 5e-5,
    }));
    let [.., unseen] = all(&tiny(&json!({"strain_end": 0.004})));
    let [_, jam, seen] = all(&point);
    assert_eq!(seen.results, unseen.results);
    assert_eq!(seen.artifacts[HISTORY], unseen.artifacts[HISTORY]);

    // One block, one membrane and one entry for each snapshot, 0.05 mm of the rods' way apart.
    let steps = dumped_steps(&seen.artifacts[GRAINS_DUMP]);
    assert!(steps.len() >= 4, "{steps:?}");
    let report: Value = serde_json::from_slice(&seen.artifacts[STRUCTURE]).expect("JSON");
    let list = |name: &str| report[name].as_array().expect("a list").clone();
    let (snapshots, changes) = (list("snapshots"), list("changes"));
    assert_eq!(snapshots.len(), steps.len());
    assert_eq!(changes.len() + 1, steps.len());
    let names = seen.artifacts.keys();
    let files: Vec<&String> = names.filter(|name| name.starts_with("membrane_")).collect();
    assert_eq!(files.len(), steps.len());
    let collection = std::str::from_utf8(&seen.artifacts[MEMBRANE_COLLECTION]).expect("text");
    for file in files {
        assert!(collection.contains(&format!("file=\"{file}\"")), "{file}");
    }
    for pair in snapshots.windows(2) {
        let travel = |snapshot: &Value| snapshot["rod_travel"].as_f64().expect("a number");
        let way = travel(&pair[1]) - travel(&pair[0]);
        // Each may be late by one step, in which the rods go at most 0.05 m/s times some 10 µs.
        assert!((way - 5e-5).abs() < 1e-6, "{way}");
    }
    assert_eq!(
        snapshots[0]["coordination"]["all"].as_f64(),
        seen.results["coordination_number"]
    );
    for change in &changes {
        let stray = change["non_affine"]["all"].as_f64().expect("grains");
        assert!(stray > 0.0 && stray < 5e-5, "{stray}");
        assert!(change["autocorrelation"]["printed"].is_array());
        assert!(change["displacement"]["values"].is_array());
    }

    // Between the second snapshot and the third one, the second is still to be compared with.
    let bend = &stages(&point)[2];
    let input = &jam.artifacts[STATE];
    let saved = interrupt(bend, input, steps[1] + (steps[2] - steps[1]) / 2);
    let found = finish(bend, (input, Some(&saved)), VectorWidth::widest());
    assert_same(&seen, &found, "after the second snapshot");
    let first = interrupt(bend, input, steps[0] / 2);
    let found = finish(bend, (input, Some(&first)), VectorWidth::widest());
    assert_same(&seen, &found, "before the first snapshot");
    // What follows a checkpoint is part of it.
    let cut = &saved[..saved.len() - 1];
    let found = finish(bend, (input, Some(cut)), VectorWidth::widest());
    assert!(
        matches!(found, Err(StageFailure::Input { .. })),
        "{found:?}"
    );
}
