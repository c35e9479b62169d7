//! A hundred thousand points through the command line, against the clock: only a release build is in time.
//!
//! The limits are for one core of an idle machine: a sweep is taken in within 2.5 s and found again within 0.1 s
//! when its packs are few, within 5 s and 0.2 s when there are thousands of them, and the server stays small.

use std::time::{Duration, Instant};

use granary_tests::{Finished, Sandbox};

/// 25 frictions of one pack, 4,096 words each.
const FEW_PACKS: &str = "\
friction_coefficient = { linspace = [0, 1, 25] }
waveform = { suite = \"binary_words\", bits = 12 }
";
/// Two frictions of 8,333 packs, six signals each.
const MANY_PACKS: &str = "\
friction_coefficient = [0.4, 1.0]
packing_seed = { range = [1, 8333] }
waveform = { suite = \"six\" }
";
/// The most memory that the server may have used by the end \[kB\].
const MEMORY: u64 = 100_000;

fn timed(what: &str, most: f64, run: impl Fn() -> Finished) -> Finished {
    let start = Instant::now();
    let finished = run().expect(0);
    let took = start.elapsed();
    eprintln!("{what}: {took:.2?}");
    assert!(
        took < Duration::from_secs_f64(most),
        "{what} took {took:.2?}"
    );
    finished
}

fn intake(grid: &str, points: u64, (new, known): (f64, f64)) {
    let sandbox = Sandbox::new();
    let spec =
        format!("name = \"large\"\nmodel = \"memory\"\n[fixed]\ngrains = 10\n[[grid]]\n{grid}");
    sandbox.write("large.toml", &spec);
    let (server, address) = sandbox.serve(&["--data", "data", "--workers", "0"]);
    let run = |arguments: &[&str]| sandbox.run(&[arguments, &["--server", &address]].concat());
    let submit = || run(&["submit", "large.toml", "--json"]);
    let first = timed("submit", new, submit).json();
    assert_eq!(first["points"], points);
    let sweep = first["sweep"].as_str().expect("an id").to_owned();
    assert!(server.most_memory() < MEMORY, "{} kB", server.most_memory());
    let again = timed("submit again", known, submit).json();
    assert_eq!(
        (&again["sweep"], &again["jobs"]["new"]),
        (&first["sweep"], &0.into())
    );
    timed("cancel", new, || run(&["cancel", &sweep]));
    timed("submit the cancelled", new, submit);
}

#[test]
fn intake_of_100_000_points_in_one_pack() {
    intake(FEW_PACKS, 102_400, (2.5, 0.1));
}

#[test]
fn intake_of_100_000_points_in_thousands_of_packs() {
    intake(MANY_PACKS, 99_996, (5.0, 0.2));
}
