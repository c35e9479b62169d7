//! Times the stages of one beam: `beam_step PRESET KEY=VALUE…`.
//!
//! `STATES=DIR` keeps states of grown and compacted beams there, `MOST=N` ends the bending after N steps, `THREADS=2` takes
//! each step on two, and `ARTIFACTS=DIR` saves what a bending yields that was not cut short.
#![expect(
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "an example that prints what it measures"
)]

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use granary_core::beam::point::BeamPoint;
use granary_core::crew::Crew;
use granary_core::stage::{Ensemble, Outcome, STATE, StageFailure, StageSpec, run};

/// Steps of a bending before it is timed.
const WARM: u64 = 1000;

fn variable<T: std::str::FromStr>(name: &str) -> Option<T> {
    std::env::var(name).ok()?.parse().ok()
}

/// Runs a stage, `most` steps of it at most, and prints what a step took.
fn timed(spec: &StageSpec, input: &[u8], most: u64) -> Option<Outcome> {
    let name = spec.kind().name();
    let mut start = Instant::now();
    let (mut from, mut done, mut next) = (0, 0, 0);
    let ensemble = Ensemble {
        specs: std::slice::from_ref(spec),
        input,
        checkpoints: None,
    };
    let result = run(&ensemble, &mut |report| {
        if from == 0 && report.step >= WARM {
            (start, from) = (Instant::now(), report.step);
        }
        done = report.step;
        if done >= next {
            let seconds = start.elapsed().as_secs_f64();
            eprintln!("{name} {done} / {} {seconds:.1} s", report.steps);
            next += 20_000;
        }
        if done < most {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    })
    .remove(0);
    let seconds = start.elapsed().as_secs_f64();
    let each = 1e3 * seconds / (done - from).max(1) as f64;
    println!("{name}: {done} steps, {seconds:.1} s, {each:.4} ms a step");
    match result {
        Ok(outcome) => {
            println!("{:#?} {:?}", outcome.results, outcome.warnings);
            Some(outcome)
        }
        Err(StageFailure::Interrupted { .. }) => None,
        Err(failure) => panic!("{failure}"),
    }
}

/// The state of a stage before the last: kept, or found now.
fn state(spec: &StageSpec, input: &[u8]) -> Vec<u8> {
    let kept = variable::<PathBuf>("STATES").map(|dir| dir.join(spec.id().to_string()));
    if let Some(bytes) = kept.as_ref().and_then(|path| std::fs::read(path).ok()) {
        return bytes;
    }
    let outcome = timed(spec, input, u64::MAX).expect("not interrupted");
    let bytes = outcome.artifacts[STATE].clone();
    if let Some(path) = kept {
        std::fs::write(path, &bytes).expect("a folder to write to");
    }
    bytes
}

fn bend() {
    let mut arguments = std::env::args().skip(1);
    let preset = arguments.next().expect("a preset");
    let mut map = BeamPoint::defaults(&preset).expect("a preset");
    for argument in arguments {
        let (name, value) = argument.split_once('=').expect("KEY=VALUE");
        let value = serde_json::from_str(value).unwrap_or_else(|_| value.into());
        map.insert(name.to_owned(), value);
    }
    let point = BeamPoint::from_parameters(map).expect("a point");
    let grow = StageSpec::Grow(point.grow());
    let grown = state(&grow, &[]);
    let jam = StageSpec::Jam(point.jam(grow.id()));
    let jammed = state(&jam, &grown);
    let bend = StageSpec::Bend(point.bend(jam.id()));
    let most = variable("MOST").unwrap_or(u64::MAX);
    if let Some(outcome) = timed(&bend, &jammed, most)
        && let Some(dir) = variable::<PathBuf>("ARTIFACTS")
    {
        for (name, bytes) in &outcome.artifacts {
            std::fs::write(dir.join(name), bytes).expect("a folder to write to");
        }
    }
}

fn main() {
    let threads = variable("THREADS").unwrap_or(1);
    Crew::new(threads, || Duration::ZERO).work(bend);
}
