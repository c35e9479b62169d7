//! Words that begin alike share the beginning of their encoding: each recall has the bits that it would have alone.

use std::ops::ControlFlow;

use granary_core::lanes::VectorWidth;
use granary_core::memory::spec::{MemoryPoint, Precision};
use granary_core::memory::waveform::Waveform;
use granary_core::model::ModelPoint;
use granary_core::stage::{
    Ensemble, Outcome, STATE, StageFailure, StageKind, StageSpec, checkpoint_step, run_with,
};
use serde_json::json;

#[path = "fixture/tiny_pack.rs"]
#[allow(dead_code, reason = "every proof takes what it needs")]
mod tiny_pack;

use tiny_pack::{Results, Trained, finish, outcome, tiny};

const BITS: u8 = 5;

/// The encoding and the recall of a word, as a sweep plans them.
fn planned(pack: &Trained, word: u32, precision: Precision) -> (StageSpec, StageSpec) {
    let point = ModelPoint::Memory(MemoryPoint {
        waveform: Waveform::BinaryWord { bits: BITS, word },
        precision,
        ..pack.point.clone()
    });
    let (encode, recall) = point.ends(pack.train_spec.id());
    (encode.expect("a long word"), recall)
}

fn go_on(specs: &[StageSpec], input: &[u8], states: &[Vec<u8>]) -> Results {
    let ensemble = Ensemble {
        specs,
        input,
        checkpoints: Some(states),
    };
    run_with(&ensemble, VectorWidth::widest(), &mut |_| {
        ControlFlow::Continue(())
    })
}

/// Everything but the steps, which another stage has done in part.
fn assert_same(whole: &Outcome, parted: &Outcome, before: u64) {
    assert_eq!(whole.results, parted.results);
    assert_eq!(whole.artifacts, parted.artifacts);
    assert_eq!(whole.warnings, parted.warnings);
    assert_eq!(whole.steps, before + parted.steps);
}

fn done(results: Results) -> Vec<Outcome> {
    let done: Result<Vec<Outcome>, StageFailure> = results.into_iter().collect();
    done.expect("outcomes")
}

#[test]
fn words_that_share_an_encoding_recall_as_if_each_had_its_own() {
    let pack = Trained::new(tiny(&json!({"drag": 0.001})));
    for precision in [Precision::F64, Precision::F32] {
        let beginnings: Vec<StageSpec> = (0..4)
            .map(|n| planned(&pack, 8 * n + 5, precision).0)
            .collect();
        let encoded = done(finish(&beginnings, pack.state(), VectorWidth::widest()));
        let states: Vec<Vec<u8>> = encoded.iter().map(|e| e.artifacts[STATE].clone()).collect();
        // Words of all four beginnings, in no order, and one alone with nothing but its input.
        for words in [vec![31, 0, 7, 8, 22, 16, 15, 3], vec![12]] {
            let (mut parted, mut begun, mut whole) = (vec![], vec![], vec![]);
            for &word in &words {
                let (encode, recall) = planned(&pack, word, precision);
                let n = beginnings.iter().position(|one| *one == encode);
                let n = n.expect("one of the four");
                assert_eq!(recall.needs(), Some(encode.id()));
                parted.push(recall);
                begun.push(states[n].clone());
                let waveform = Waveform::BinaryWord { bits: BITS, word };
                whole.push(pack.recall(waveform, pack.point.gamma0, precision));
            }
            let whole = done(finish(&whole, pack.state(), VectorWidth::widest()));
            let found = if words.len() == 1 {
                vec![outcome(&parted[0], &begun[0])]
            } else {
                done(go_on(&parted, &begun[0], &begun))
            };
            for (whole, found) in whole.iter().zip(&found) {
                assert_same(whole, found, encoded[0].steps);
            }
        }
        assert_eq!(encoded[0].steps, beginnings[0].steps(&[]));
    }
}

#[test]
fn an_interrupted_recall_goes_on_from_its_own_checkpoint() {
    let pack = Trained::new(tiny(&json!({})));
    let (encode, recall) = planned(&pack, 9, Precision::F64);
    let state = outcome(&encode, pack.state()).artifacts[STATE].clone();
    let whole = outcome(&recall, &state);
    let mut saved = vec![];
    let ensemble = Ensemble {
        specs: std::slice::from_ref(&recall),
        input: &state,
        checkpoints: None,
    };
    let _ = run_with(&ensemble, VectorWidth::widest(), &mut |report| {
        if report.step < 300 {
            return ControlFlow::Continue(());
        }
        assert!(
            report.step <= report.steps,
            "{} {}",
            report.step,
            report.steps
        );
        saved = (report.checkpoint)();
        ControlFlow::Break(())
    });
    // A checkpoint counts the steps of the whole cycle, a report those of the stage.
    let step = checkpoint_step(&saved[0]).expect("a checkpoint");
    assert!(step >= 300 + encode.steps(&[]));
    let found = done(go_on(std::slice::from_ref(&recall), &state, &saved)).remove(0);
    assert_eq!(found, whole);
}

#[test]
fn what_begins_at_another_step_or_in_another_encoding_is_no_lane_of_the_ensemble() {
    let pack = Trained::new(tiny(&json!({})));
    let (encode, recall) = planned(&pack, 9, Precision::F64);
    let (_, stranger) = planned(&pack, 30, Precision::F64);
    let zero = pack.recall(Waveform::Zero, 0.0, Precision::F64);
    assert_eq!(zero.ensemble_key(), recall.ensemble_key());
    let state = outcome(&encode, pack.state()).artifacts[STATE].clone();
    let states = [state.clone(), state.clone()];
    for specs in [[recall.clone(), zero], [recall, stranger]] {
        for result in go_on(&specs, &state, &states) {
            assert!(
                matches!(result, Err(StageFailure::Input { .. })),
                "{result:?}"
            );
        }
    }
}

#[test]
fn a_point_has_its_encoding_between_training_and_recall() {
    let pack = tiny(&json!({}));
    let kinds = |waveform: Waveform| -> Vec<StageKind> {
        let point = MemoryPoint {
            waveform,
            ..pack.clone()
        };
        let stages = ModelPoint::Memory(point).stages();
        for pair in stages.windows(2) {
            assert_eq!(pair[1].needs(), Some(pair[0].id()));
        }
        stages.iter().map(StageSpec::kind).collect()
    };
    let [begins, trains, encodes, recalls] = [
        StageKind::Pack,
        StageKind::Train,
        StageKind::Encode,
        StageKind::Recall,
    ];
    let word = Waveform::BinaryWord { bits: 7, word: 77 };
    assert_eq!(kinds(word), [begins, trains, encodes, recalls]);
    assert_eq!(kinds(Waveform::Six(2)), [begins, trains, recalls]);
}
