//! An outcome is a function of its spec alone: not of lanes, groups, vector widths, threads, skins, or interruptions.
//!
//! Every comparison is of bits: the hash of the outcome and the bytes of all its artifacts.
//! Source: ARCHITECTURE.md, invariant 1.

use std::ops::ControlFlow;
use std::sync::OnceLock;

use granary_core::lanes::VectorWidth;
use granary_core::memory::spec::{Precision, RecallSpec, TrainSpec};
use granary_core::memory::state::PackState;
use granary_core::memory::waveform::{Bumps, Waveform};
use granary_core::stage::{Ensemble, STATE, StageFailure, StageSpec, checkpoint_step, run_with};
use serde_json::json;

#[path = "fixture/tiny_pack.rs"]
mod tiny_pack;

use tiny_pack::{Results, Trained, finish, outcome, tiny};

/// Trained packs of tetrahedra without drag, tetrahedra with drag, spheres, tetrahedra without friction, and of laws M1 and M2.
fn packs() -> &'static [Trained; 6] {
    static PACKS: OnceLock<[Trained; 6]> = OnceLock::new();
    PACKS.get_or_init(|| {
        [
            Trained::new(tiny(&json!({}))),
            Trained::new(tiny(&json!({"drag": 0.01, "packing_seed": 2}))),
            Trained::new(tiny(&json!({"shape": "sphere", "packing_seed": 3}))),
            Trained::new(tiny(
                &json!({"friction_coefficient": 0.0, "packing_seed": 4}),
            )),
            Trained::new(tiny(&json!({"force_law": "M1", "packing_seed": 5}))),
            Trained::new(tiny(&json!({"force_law": "M2", "packing_seed": 6}))),
        ]
    })
}

/// Asserts that `found` are the results of `expected`, in the order of `jobs`, to the last bit.
fn assert_same(expected: &Results, jobs: &[usize], found: &Results, how: &str) {
    assert_eq!(found.len(), jobs.len(), "{how}");
    for (result, &job) in found.iter().zip(jobs) {
        match (result, &expected[job]) {
            (Ok(found), Ok(expected)) => {
                assert_eq!(found.hash(), expected.hash(), "{how}: job {job}");
                assert_eq!(found.artifacts, expected.artifacts, "{how}: job {job}");
            }
            (found, expected) => assert_eq!(found, expected, "{how}: job {job}"),
        }
    }
}

/// The widest vectors but one: what is interrupted with the widest goes on with these.
fn narrower() -> VectorWidth {
    let widths = VectorWidth::available();
    widths[widths.len().saturating_sub(2)]
}

fn select(specs: &[StageSpec], jobs: &[usize]) -> Vec<StageSpec> {
    jobs.iter().map(|&job| specs[job].clone()).collect()
}

/// Each recall alone.
fn one_by_one(specs: &[StageSpec], input: &[u8]) -> Results {
    specs
        .iter()
        .flat_map(|spec| finish(std::slice::from_ref(spec), input, VectorWidth::widest()))
        .collect()
}

/// Runs until `step`, and returns the checkpoints taken there.
fn interrupt(ensemble: &Ensemble<'_>, width: VectorWidth, step: u64) -> Vec<Vec<u8>> {
    let mut saved = vec![];
    let results = run_with(ensemble, width, &mut |report| {
        if report.step < step {
            return ControlFlow::Continue(());
        }
        saved = (report.checkpoint)();
        ControlFlow::Break(())
    });
    for result in results {
        assert!(
            matches!(result, Err(StageFailure::Interrupted { .. })),
            "{result:?}"
        );
    }
    saved
}

fn resume(
    specs: &[StageSpec],
    input: &[u8],
    checkpoints: &[Vec<u8>],
    width: VectorWidth,
) -> Results {
    let ensemble = Ensemble {
        specs,
        input,
        checkpoints: Some(checkpoints),
    };
    run_with(&ensemble, width, &mut |_| ControlFlow::Continue(()))
}

#[test]
fn every_lane_of_eight_gives_the_bits_of_a_lone_run() {
    for pack in packs() {
        let specs = pack.recalls(8, Precision::F64);
        let alone = one_by_one(&specs, pack.state());
        assert!(alone.iter().all(Result::is_ok), "{alone:?}");
        let groupings: [&[usize]; 6] = [
            &[0, 1, 2, 3, 4, 5, 6, 7],
            &[7, 6, 5, 4, 3, 2, 1, 0],
            &[3, 7, 0, 5, 2, 6, 1, 4],
            &[5, 2],
            &[1, 4, 6],
            &[2, 0, 7, 3, 1],
        ];
        for jobs in groupings {
            let found = finish(&select(&specs, jobs), pack.state(), VectorWidth::widest());
            assert_same(&alone, jobs, &found, "f64 lanes");
        }
    }
}

#[test]
fn sixteen_single_precision_lanes_give_the_bits_of_eight_in_any_grouping() {
    for pack in packs() {
        let specs = pack.recalls(16, Precision::F32);
        // A lone single precision run is the first of eight lanes, the others being its copies.
        let alone = one_by_one(&specs, pack.state());
        assert!(alone.iter().all(Result::is_ok), "{alone:?}");
        let groupings: [&[usize]; 5] = [
            &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15],
            &[15, 3, 9, 1, 12, 0, 7, 14, 2, 5, 11],
            &[8, 6, 4, 2, 0, 1, 3, 5, 7],
            &[15, 8, 1, 13, 6, 10, 4, 9],
            &[11, 12, 13],
        ];
        for jobs in groupings {
            let found = finish(&select(&specs, jobs), pack.state(), VectorWidth::widest());
            assert_same(&alone, jobs, &found, "f32 lanes");
        }
    }
}

#[test]
fn every_vector_width_gives_the_same_bits() {
    for pack in packs() {
        let pack_spec = StageSpec::Pack(pack.point.pack());
        for width in VectorWidth::available() {
            let packed = finish(std::slice::from_ref(&pack_spec), &[], width);
            assert_same(&vec![Ok(pack.pack.clone())], &[0], &packed, width.name());
            let input = &pack.pack.artifacts[STATE];
            let trained = finish(std::slice::from_ref(&pack.train_spec), input, width);
            assert_same(&vec![Ok(pack.train.clone())], &[0], &trained, width.name());
        }
        for (lanes, precision) in [
            (1, Precision::F64),
            (8, Precision::F64),
            (8, Precision::F32),
            (16, Precision::F32),
        ] {
            // Without fused instructions a product-sum takes a hundred times as long: one short ramp up and down.
            let short = |spec| match spec {
                StageSpec::Recall(recall) => StageSpec::Recall(RecallSpec {
                    ramp: 255.0 * recall.time_step,
                    second_cycle: false,
                    ..recall
                }),
                _ => unreachable!("recalls"),
            };
            let specs: Vec<StageSpec> = pack
                .recalls(lanes, precision)
                .into_iter()
                .map(short)
                .collect();
            let jobs: Vec<usize> = (0..specs.len()).collect();
            let portable = finish(&specs, pack.state(), VectorWidth::PORTABLE);
            for width in VectorWidth::available() {
                let found = finish(&specs, pack.state(), width);
                assert_same(&portable, &jobs, &found, width.name());
            }
        }
    }
}

#[test]
fn an_interrupted_pack_or_training_ends_as_if_it_had_not_been() {
    for pack in packs() {
        let pack_spec = StageSpec::Pack(pack.point.pack());
        // At the end of the gas, under the servo, and late in the cycles.
        let last = pack.pack.steps / 100 * 100;
        for step in [300, 2500, last - 700] {
            let specs = std::slice::from_ref(&pack_spec);
            let ensemble = Ensemble {
                specs,
                input: &[],
                checkpoints: None,
            };
            let saved = interrupt(&ensemble, VectorWidth::widest(), step);
            assert!(checkpoint_step(&saved[0]).is_some());
            let found = resume(specs, &[], &saved, narrower());
            assert_same(&vec![Ok(pack.pack.clone())], &[0], &found, "pack");
        }
        let input = &pack.pack.artifacts[STATE];
        for step in [0, 700, 1400] {
            let specs = std::slice::from_ref(&pack.train_spec);
            let ensemble = Ensemble {
                specs,
                input,
                checkpoints: None,
            };
            let saved = interrupt(&ensemble, VectorWidth::widest(), step);
            let found = resume(specs, input, &saved, narrower());
            assert_same(&vec![Ok(pack.train.clone())], &[0], &found, "train");
        }
    }
}

#[test]
fn an_interrupted_recall_goes_on_in_any_grouping() {
    for pack in packs() {
        for precision in [Precision::F64, Precision::F32] {
            let specs = pack.recalls(8, precision);
            let whole = one_by_one(&specs, pack.state());
            for step in [0, 900, 2300] {
                // Interrupted in two groups, and once more as other two.
                let groups: [&[usize]; 2] = [&[6, 0, 3, 4], &[1, 7, 5, 2]];
                let mut saved = vec![vec![]; 8];
                for jobs in groups {
                    let specs = select(&specs, jobs);
                    let ensemble = Ensemble {
                        specs: &specs,
                        input: pack.state(),
                        checkpoints: None,
                    };
                    let checkpoints = interrupt(&ensemble, VectorWidth::widest(), step);
                    for (&job, checkpoint) in jobs.iter().zip(checkpoints) {
                        assert_eq!(checkpoint_step(&checkpoint), Some(step));
                        saved[job] = checkpoint;
                    }
                }
                let regroupings: [&[usize]; 3] = [&[0, 1, 2, 3, 4, 5, 6, 7], &[5, 3, 1], &[2]];
                for jobs in regroupings {
                    let checkpoints: Vec<Vec<u8>> =
                        jobs.iter().map(|&job| saved[job].clone()).collect();
                    let specs = select(&specs, jobs);
                    let ensemble = Ensemble {
                        specs: &specs,
                        input: pack.state(),
                        checkpoints: Some(&checkpoints),
                    };
                    let again = interrupt(&ensemble, VectorWidth::widest(), step + 200);
                    let found = resume(&specs, pack.state(), &again, narrower());
                    assert_same(&whole, jobs, &found, "resumed");
                }
            }
        }
    }
}

#[test]
fn two_threads_at_once_give_the_bits_of_one() {
    let pack = &packs()[0];
    let (f64s, f32s) = (
        pack.recalls(8, Precision::F64),
        pack.recalls(16, Precision::F32),
    );
    let run = |specs: &[StageSpec]| finish(specs, pack.state(), VectorWidth::widest());
    let expected = [run(&f64s), run(&f32s)];
    let (one, other) = std::thread::scope(|scope| {
        let other = scope.spawn(|| [run(&f32s), run(&f64s)]);
        ([run(&f64s), run(&f32s)], other.join().expect("no panic"))
    });
    for n in 0..2 {
        let jobs: Vec<usize> = (0..expected[n].len()).collect();
        assert_same(&expected[n], &jobs, &one[n], "this thread");
        assert_same(&expected[n], &jobs, &other[1 - n], "the other thread");
    }
}

#[test]
fn a_lane_that_the_guard_stops_leaves_the_others_alone() {
    for pack in packs() {
        for precision in [Precision::F64, Precision::F32] {
            let specs = pack.recalls(4, precision);
            let whole = one_by_one(&specs, pack.state());
            // A wall runs a quarter of the compressed box's width into the pack in 12 t_c.
            let sudden = Waveform::Bumps(Bumps {
                width: 0.02,
                centers: vec![0.9],
                amplitudes: vec![-1.0],
            });
            let broken = pack.recall(sudden, 0.5, precision);
            for place in [0, 2, 4] {
                let mut together = specs.clone();
                together.insert(place, broken.clone());
                let mut found = finish(&together, pack.state(), VectorWidth::widest());
                let stopped = found.remove(place);
                assert!(
                    matches!(stopped, Err(StageFailure::Stopped { .. })),
                    "{stopped:?}"
                );
                assert_same(&whole, &[0, 1, 2, 3], &found, "beside a stopped lane");

                // Interrupted after the stop and resumed, the stopped lane stays stopped for the same reason.
                let ensemble = Ensemble {
                    specs: &together,
                    input: pack.state(),
                    checkpoints: None,
                };
                let saved = interrupt(&ensemble, VectorWidth::widest(), 1500);
                let mut found = resume(&together, pack.state(), &saved, VectorWidth::widest());
                assert_eq!(found.remove(place), stopped);
                assert_same(
                    &whole,
                    &[0, 1, 2, 3],
                    &found,
                    "resumed beside a stopped lane",
                );
            }
        }
    }
}

#[test]
fn the_skin_changes_no_bit() {
    for pack in packs() {
        let StageSpec::Train(train) = &pack.train_spec else {
            unreachable!("a training")
        };
        let reference = PackState::from_bytes(pack.state()).expect("a state");
        for skin in [0.02, 0.05, 0.4] {
            let spec = StageSpec::Train(TrainSpec {
                skin,
                ..train.clone()
            });
            let found = outcome(&spec, &pack.pack.artifacts[STATE]);
            // The state carries its spec, and that the skin: all numbers beside it are the same.
            let state = PackState::from_bytes(&found.artifacts[STATE]).expect("a state");
            assert_eq!(found.results, pack.train.results);
            assert_eq!(state.past.unsheared, reference.past.unsheared);
            assert_eq!(
                (state.poses, state.motions),
                (reference.poses.clone(), reference.motions.clone())
            );
            assert_eq!(state.contacts, reference.contacts);
        }
        for precision in [Precision::F64, Precision::F32] {
            let specs = pack.recalls(3, precision);
            let expected = finish(&specs, pack.state(), VectorWidth::widest());
            for skin in [0.02, 0.05, 0.4] {
                let other: Vec<StageSpec> = specs
                    .iter()
                    .map(|spec| match spec {
                        StageSpec::Recall(recall) => StageSpec::Recall(RecallSpec {
                            skin,
                            ..recall.clone()
                        }),
                        _ => unreachable!("recalls"),
                    })
                    .collect();
                let found = finish(&other, pack.state(), VectorWidth::widest());
                assert_same(&expected, &[0, 1, 2], &found, "another skin");
            }
        }
    }
}

/// The outcomes of one fixed pack, training and recall, as this physics version has them.
///
/// If this test fails, the bits of outcomes have changed.
/// If that was meant: raise the kind's version in `granary_core::physics`, with the engine's own, and copy the found hashes here.
/// If it was not: a change of compiler, machine or code has broken invariant 1.
const STORED: [&str; 4] = [
    "b3:23e0d2eb0da89fcde63623cd87ef429423e4381fce3917dd3cbee8125a2c12b5",
    "b3:2417520128c2a96b6cf7944014c13873c0fff9621491ffe53d57a50025361bf7",
    "b3:f4420f7614059728dfce0e1a2bc8bbc799ea29ee9e70e4fae34ae3cb15d8880b",
    "b3:e76fe0ca2e584edb4c95869303e8c1cd7c3a365a97f1efca5e6eed07a538b81b",
];

#[test]
fn outcomes_have_the_stored_hashes_at_every_width() {
    let pack = &packs()[0];
    let pack_spec = [StageSpec::Pack(pack.point.pack())];
    for width in VectorWidth::available() {
        let packed = finish(&pack_spec, &[], width);
        let packed = packed[0].as_ref().expect("a pack");
        let train_spec = std::slice::from_ref(&pack.train_spec);
        let trained = finish(train_spec, &packed.artifacts[STATE], width);
        let trained = trained[0].as_ref().expect("a trained pack");
        let mut found = vec![packed.hash().to_string(), trained.hash().to_string()];
        for precision in [Precision::F64, Precision::F32] {
            let recall = pack.recall(Waveform::Six(5), 0.004, precision);
            let recalled = finish(&[recall], &trained.artifacts[STATE], width);
            found.push(recalled[0].as_ref().expect("a signal").hash().to_string());
        }
        assert_eq!(found, STORED, "{}", width.name());
    }
}
