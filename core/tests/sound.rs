//! The sound of a trained pack: heard in it, quieter with a drag by just that drag, and warned about where a ramp is too hasty.

#[path = "fixture/tiny_pack.rs"]
#[expect(dead_code, reason = "other tests need more of it")]
mod tiny_pack;

use std::ops::ControlFlow;

use granary_core::lanes::VectorWidth;
use granary_core::memory::score::Signal;
use granary_core::memory::spec::Precision;
use granary_core::memory::waveform::Waveform;
use granary_core::stage::{Ensemble, Outcome, SIGNAL, STATE, StageFailure, StageSpec, run_with};
use serde_json::json;
use tiny_pack::{Trained, outcome, tiny};

fn number(outcome: &Outcome, name: &str) -> f64 {
    let value = outcome.results[name];
    value.unwrap_or_else(|| panic!("{name} is missing"))
}

#[test]
fn trained_pack_is_heard_and_a_drag_adds_its_rate() {
    let quiet = Trained::new(tiny(&json!({"grains": 75})));
    // Waves of 10 R at 0.2 to 0.4 R/t_c.
    let period = number(&quiet.train, "sound_period");
    assert!((15.0..60.0).contains(&period), "{period}");
    let decay = number(&quiet.train, "sound_decay_time");
    let drag = 0.04;
    let mut point = quiet.point.clone();
    point.drag = drag;
    let StageSpec::Train(first) = &quiet.train_spec else {
        unreachable!("a training");
    };
    let dragged = StageSpec::Train(point.train(first.pack));
    let dragged = outcome(&dragged, &quiet.pack.artifacts[STATE]);
    let added = 1.0 / number(&dragged, "sound_decay_time") - 1.0 / decay;
    // The drag is added to what is heard without it, in a pack of 75 grains that was trained with it and is not the same: its own
    // rate is less than twice the other's.
    assert!((added - drag).abs() < 1.0 / decay, "{added}, {decay}");
    assert!((number(&dragged, "sound_period") / period - 1.0).abs() < 0.2);
}

#[test]
fn ramps_that_are_short_beside_the_sound_are_warned_about_and_others_are_not() {
    let pack = Trained::new(tiny(&json!({"grains": 75, "ramp": 400.0})));
    let least = 7.0 * number(&pack.train, "sound_decay_time");
    let warned = |ramp: f64| {
        let mut point = pack.point.clone();
        (point.ramp, point.waveform) = (ramp, Waveform::Six(1));
        point.precision = Precision::F64;
        let StageSpec::Train(_) = &pack.train_spec else {
            unreachable!("a training");
        };
        let recall = StageSpec::Recall(point.recall(pack.train_spec.id()));
        let recalled = outcome(&recall, pack.state());
        let both = [&recalled, &pack.train].map(|outcome| outcome.results["sound_decay_time"]);
        assert_eq!(both[0], both[1]);
        recalled.warnings
    };
    let hasty = warned(0.5 * least);
    assert!(hasty[0].starts_with("fast_ramp: "), "{hasty:?}");
    assert_eq!(warned(1.01 * least), Vec::<String>::new());
}

/// What scatters from sample to sample, by fourth differences.
fn scatter(series: impl Iterator<Item = f64>) -> f64 {
    let all: Vec<f64> = series.collect();
    let differences = all
        .windows(5)
        .map(|w| w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4]);
    let squares: f64 = differences.map(|d| d * d).sum();
    (squares / (70.0 * (all.len() - 4) as f64)).sqrt()
}

/// A decompression begins with a jolt, and the hold before it with another. Both are the same in both cycles, and holds outlast
/// sound fifteen times, so SUB2 is rid of all but what the pack itself has become in between.
#[test]
fn both_decompressions_stir_up_the_same_sound() {
    let pack = Trained::new(tiny(&json!({"grains": 75, "ramp": 600.0, "hold": 3.0})));
    let recall = StageSpec::Recall(pack.point.recall(pack.train_spec.id()));
    let recalled = outcome(&recall, pack.state());
    let signal: Signal = serde_json::from_slice(&recalled.artifacts[SIGNAL]).expect("a signal");
    let first = scatter(signal.decode.iter().copied());
    let pairs = signal.decode.iter().zip(&signal.second_decode);
    let left = scatter(pairs.map(|(first, second)| first - second));
    assert!(left < 0.3 * first, "{left} of {first}");
}

#[test]
fn few_grains_have_no_sound_and_no_warning() {
    let pack = Trained::new(tiny(&json!({"grains": 30})));
    assert_eq!(pack.train.results["sound_decay_time"], None);
}

#[test]
fn training_that_is_interrupted_while_it_listens_gives_the_same_outcome() {
    let pack = Trained::new(tiny(&json!({"grains": 75})));
    let mut saved = vec![];
    let mut asked_at_the_end = 0;
    let ensemble = Ensemble {
        specs: std::slice::from_ref(&pack.train_spec),
        input: &pack.pack.artifacts[STATE],
        checkpoints: None,
    };
    let width = VectorWidth::widest();
    let stopped = run_with(&ensemble, width, &mut |report| {
        asked_at_the_end += u32::from(report.step == report.steps);
        if asked_at_the_end < 2 {
            return ControlFlow::Continue(());
        }
        saved = (report.checkpoint)();
        ControlFlow::Break(())
    });
    assert!(matches!(stopped[0], Err(StageFailure::Interrupted { .. })));
    let again = run_with(
        &Ensemble {
            checkpoints: Some(&saved),
            ..ensemble
        },
        width,
        &mut |_| ControlFlow::Continue(()),
    );
    let again = again[0].as_ref().expect("a trained pack");
    assert_eq!(again.hash(), pack.train.hash());
}
