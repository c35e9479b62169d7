//! A classifier from its spec to its words: what it learns, that interruptions change no bit, and what is refused.

use std::ops::ControlFlow;

use granary_core::lanes::VectorWidth;
use granary_core::memory::classifier::{BATCH, ClassifierSpec, network_of, recognize};
use granary_core::memory::waveform::{SAMPLES, Waveform, sample_u};
use granary_core::stage::{
    Ensemble, Outcome, Report, STATE, StageFailure, StageSpec, checkpoint_step, run, run_with,
};

/// A small classifier.
fn small(bits: u32) -> ClassifierSpec {
    ClassifierSpec {
        bits,
        classifier_seed: 1,
        shifts: 3,
        amplitudes: 3,
        noises: 10,
        largest_shift: 5.0 / 255.0,
        largest_amplitude_change: 0.2,
        noise: 0.2,
        learning_rate: 0.02,
        epochs: 4,
    }
}

fn trained(spec: &ClassifierSpec, stop_at: Option<u64>) -> Result<Outcome, Vec<u8>> {
    trained_from(spec, stop_at, None)
}

fn trained_from(
    spec: &ClassifierSpec,
    stop_at: Option<u64>,
    checkpoint: Option<Vec<u8>>,
) -> Result<Outcome, Vec<u8>> {
    let specs = [StageSpec::Classifier(spec.clone())];
    let checkpoints = checkpoint.map(|bytes| vec![bytes]);
    let ensemble = Ensemble {
        specs: &specs,
        input: &[],
        checkpoints: checkpoints.as_deref(),
    };
    let mut saved = vec![];
    let mut watch = |report: &Report<'_>| {
        assert!(report.step <= report.steps && report.steps == spec.steps());
        if Some(report.step) == stop_at {
            saved = (report.checkpoint)().remove(0);
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    };
    let done = run_with(&ensemble, VectorWidth::widest(), &mut watch).remove(0);
    match done {
        Ok(outcome) => Ok(outcome),
        Err(StageFailure::Interrupted { .. }) => Err(saved),
        Err(other) => panic!("{other}"),
    }
}

fn interrupted(spec: &ClassifierSpec, step: u64) -> Vec<u8> {
    match trained(spec, Some(step)) {
        Err(saved) => saved,
        Ok(_) => panic!("not interrupted at {step}"),
    }
}

/// J of a word, as a pack might return it.
fn recalled(bits: u8, word: u32, size: f64) -> Vec<f64> {
    let curve = Waveform::BinaryWord { bits, word }.curve();
    (0..SAMPLES)
        .map(|k| size * curve.integral(sample_u(k)))
        .collect()
}

#[test]
fn it_tells_words_that_it_never_saw_in_this_size() {
    let outcome = trained(&small(3), None).expect("not interrupted");
    let accuracy = outcome.results["validation_accuracy"].expect("a number");
    assert!(accuracy > 0.999, "{accuracy}");
    assert_eq!(outcome.steps, small(3).steps());
    let network = network_of(&outcome.artifacts[STATE]).expect("a network");
    let mut signals: Vec<Vec<f64>> = (0..8).map(|word| recalled(3, word, 4e3)).collect();
    assert_eq!(recognize(&network, &signals), Some((0..8).collect()));
    // Recalled upside down, each bit is its opposite.
    signals.iter_mut().flatten().for_each(|p| *p = -*p);
    assert_eq!(recognize(&network, &signals), Some((0..8).rev().collect()));
    assert_eq!(recognize(&network, &vec![vec![0.0; SAMPLES]; 8]), None);
}

#[test]
fn an_interruption_changes_no_bit() {
    let spec = ClassifierSpec {
        noises: 40,
        epochs: 2,
        ..small(3)
    };
    let whole = trained(&spec, None).expect("not interrupted");
    // In the first epoch, in the second, and where the validation begins.
    let learned = 2 * ((spec.signals() - spec.validation_signals()) / BATCH as u64);
    for stop in [0, 50, learned / 50 * 50] {
        let saved = interrupted(&spec, stop);
        assert_eq!(checkpoint_step(&saved), Some(stop));
        let resumed = trained_from(&spec, None, Some(saved)).expect("not interrupted");
        assert!(resumed.hash() == whole.hash(), "stopped at {stop}");
    }
    let other = ClassifierSpec {
        classifier_seed: 2,
        ..spec
    };
    let saved = interrupted(&other, 50);
    let specs = [StageSpec::Classifier(other)];
    assert_ne!(specs[0].id(), StageSpec::Classifier(small(3)).id());
    let wrong = Ensemble {
        specs: &[StageSpec::Classifier(small(3))],
        input: &[],
        checkpoints: Some(&[saved]),
    };
    let failed = run(&wrong, &mut |_| ControlFlow::Continue(())).remove(0);
    assert!(matches!(failed, Err(StageFailure::Input { .. })));
}

#[test]
fn a_classifier_that_cannot_be_is_refused() {
    let ensembles = [
        ClassifierSpec {
            bits: 11,
            ..small(3)
        },
        ClassifierSpec {
            bits: 2,
            ..small(3)
        },
        ClassifierSpec {
            shifts: 0,
            ..small(3)
        },
        ClassifierSpec {
            noises: u32::MAX,
            ..small(3)
        },
    ];
    for spec in ensembles {
        assert!(spec.check().is_err(), "{spec:?}");
    }
    assert_eq!(small(3).check(), Ok(()));
    let paper = ClassifierSpec {
        shifts: 33,
        amplitudes: 21,
        noises: 25,
        ..small(10)
    };
    assert_eq!((paper.transformations(), paper.check()), (17_325, Ok(())));
}
