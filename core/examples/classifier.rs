//! How fast classifiers are trained, beside plain products of matrices by the same library, and how well they learn.
//!
//! `cargo run --release -p granary-core --example classifier -- BITS SHIFTS AMPLITUDES NOISES EPOCHS RATE`

#![expect(
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "an example that prints what it measures"
)]

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use granary_core::crew::Crew;
use granary_core::memory::classifier::{BATCH, ClassifierSpec, HIDDEN};
use granary_core::memory::waveform::SAMPLES;
use granary_core::stage::{Ensemble, StageSpec, run};

/// Products of square matrices: the best of some, on one core [1/s].
fn products_per_second() -> f64 {
    const N: usize = 1024;
    let a = nalgebra::DMatrix::<f32>::from_fn(N, N, |i, j| ((i + 2 * j) % 7) as f32);
    let mut c = a.clone();
    let time = |c: &mut nalgebra::DMatrix<f32>| {
        let start = Instant::now();
        c.gemm(1e-3, &a, &a, 0.0);
        start.elapsed().as_secs_f64()
    };
    let fastest = (0..20).map(|_| time(&mut c)).fold(f64::INFINITY, f64::min);
    2.0 * (N * N * N) as f64 / fastest
}

fn main() {
    let arguments: Vec<f64> = std::env::args()
        .skip(1)
        .map(|text| text.parse().expect("a number"))
        .collect();
    let of = |k: usize, usual: f64| arguments.get(k).copied().unwrap_or(usual);
    let spec = ClassifierSpec {
        bits: of(0, 7.0) as u32,
        classifier_seed: 1,
        shifts: of(1, 9.0) as u32,
        amplitudes: of(2, 5.0) as u32,
        noises: of(3, 5.0) as u32,
        largest_shift: 0.02,
        largest_amplitude_change: 0.2,
        noise: 0.2,
        learning_rate: of(5, 0.02),
        epochs: of(4, 5.0) as u32,
    };
    let threads = of(6, 1.0) as usize;
    let crew: Arc<Crew> = Crew::new(threads, || Duration::ZERO);
    let specs = [StageSpec::Classifier(spec.clone())];
    let ensemble = Ensemble {
        specs: &specs,
        input: &[],
        checkpoints: None,
    };
    let start = Instant::now();
    let ((outcome, learned), _) = crew.work(|| {
        let mut learned = None;
        let outcome = run(&ensemble, &mut |_| {
            if learned.is_none() {
                eprintln!("signals made in {:.2} s", start.elapsed().as_secs_f64());
                learned = Some(Instant::now());
            }
            ControlFlow::Continue(())
        });
        (outcome, learned)
    });
    let seconds = learned.expect("a report").elapsed().as_secs_f64();
    let outcome = outcome.into_iter().next().expect("one").expect("trained");
    let weights = SAMPLES * HIDDEN + HIDDEN * HIDDEN + HIDDEN * spec.words() as usize;
    // Forward, slopes of inputs (but of the first layer's), slopes of weights.
    let flops = |signals: u64| signals as f64 * (6 * weights - 2 * SAMPLES * HIDDEN) as f64;
    let training = (spec.signals() - spec.validation_signals()) * u64::from(spec.epochs);
    let rate =
        (flops(training) + 2.0 * (spec.validation_signals() * weights as u64) as f64) / seconds;
    let plain = products_per_second();
    println!(
        "{} words, {} signals in batches of {BATCH}, {threads} threads: {seconds:.1} s, {:.1} Gflop/s; plain products {:.1} on one core: {:.2} of that a thread",
        spec.words(),
        training,
        rate / 1e9,
        plain / 1e9,
        rate / plain / threads as f64,
    );
    for (name, value) in &outcome.results {
        println!("{name} = {value:?}");
    }
}
