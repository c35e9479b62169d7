//! Runs the six signals on one pack and prints 𝒢, 𝓕 and the time each stage took: `six KEY=VALUE …`.
#![expect(
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "an example that prints what it measures"
)]

use std::ops::ControlFlow;
use std::time::Instant;

use granary_core::memory::score::{Dots, Processing, Score, Signal};
use granary_core::memory::spec::MemoryPoint;
use granary_core::memory::waveform::Waveform;
use granary_core::stage::{Ensemble, Outcome, SIGNAL, STATE, StageSpec, run};

fn outcomes(specs: &[StageSpec], input: &[u8]) -> Vec<Outcome> {
    let start = Instant::now();
    let mut next = 0;
    let results = run(
        &Ensemble {
            specs,
            input,
            checkpoints: None,
        },
        &mut |report| {
            if report.step >= next {
                eprintln!(
                    "{} {} / {} {:.1} s",
                    specs[0].kind().name(),
                    report.step,
                    report.steps,
                    start.elapsed().as_secs_f64()
                );
                next += 20_000;
            }
            ControlFlow::Continue(())
        },
    );
    let results: Vec<Outcome> = results
        .into_iter()
        .map(|result| result.unwrap_or_else(|stop| panic!("{stop}")))
        .collect();
    println!(
        "{} x{}: {:.1} s, {} steps, {:?}",
        specs[0].kind().name(),
        specs.len(),
        start.elapsed().as_secs_f64(),
        results[0].steps,
        results[0].results
    );
    results
}

fn main() {
    let mut map = MemoryPoint::defaults("standard").expect("preset");
    for argument in std::env::args().skip(1) {
        let (name, value) = argument.split_once('=').expect("KEY=VALUE");
        let value = serde_json::from_str(value).unwrap_or_else(|_| value.into());
        map.insert(name.to_owned(), value);
    }
    let point = MemoryPoint::from_parameters(map).expect("a point");
    let pack = StageSpec::Pack(point.pack());
    let packed = outcomes(std::slice::from_ref(&pack), &[]);
    let train = StageSpec::Train(point.train(pack.id()));
    let trained = outcomes(std::slice::from_ref(&train), &packed[0].artifacts[STATE]);
    let waveforms: Vec<Waveform> = std::iter::once(Waveform::Zero)
        .chain((1..=6).map(Waveform::Six))
        .collect();
    let recalls: Vec<StageSpec> = waveforms
        .iter()
        .map(|waveform| {
            StageSpec::Recall(
                MemoryPoint {
                    waveform: waveform.clone(),
                    ..point.clone()
                }
                .recall(train.id()),
            )
        })
        .collect();
    let recalled = outcomes(&recalls, &trained[0].artifacts[STATE]);
    let signals: Vec<Signal> = recalled
        .iter()
        .map(|outcome| serde_json::from_slice(&outcome.artifacts[SIGNAL]).expect("a signal"))
        .collect();
    for (name, processing) in Processing::ALL {
        let mut dots = Dots::default();
        for (signal, waveform) in signals.iter().zip(&waveforms).skip(1) {
            if let Some(p) = processing.apply(signal, Some(&signals[0])) {
                dots += Dots::of(&p, &waveform.curve(), signal.resolution);
            }
        }
        println!(
            "{name} {:?}",
            Score::of(&dots, point.youngs_modulus, point.delta0, point.gamma0)
        );
    }
    for outcome in &recalled {
        println!("{} {:?}", outcome.hash(), outcome.results);
    }
}
