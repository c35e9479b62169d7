//! The same sweep gives the same bits, however it is run.

use std::collections::BTreeMap;

use granary_tests::{Process, Sandbox, tiny};
use serde_json::Value;

const SEEDS: &str = "[1, 2]";
const SIX: &str = "{ suite = \"six\" }";

/// Result hash by parameters; every point must have one.
fn hashes(points: &Value) -> BTreeMap<String, String> {
    let rows = points["items"].as_array().expect("a list");
    let hash = |row: &Value| row["result_hash"].as_str().expect("a result").to_owned();
    rows.iter()
        .map(|row| (row["parameters"].to_string(), hash(row)))
        .collect()
}

/// A sandbox with the sweep, and what `granary run` makes of it.
fn computed_alone() -> (Sandbox, Value) {
    let sandbox = Sandbox::new();
    sandbox.write("tiny.toml", &tiny(12, SEEDS, SIX));
    let run = sandbox.run(&["run", "tiny.toml", "--json", "--data", "alone"]);
    let tables = run.expect(0).json();
    assert_eq!(hashes(&tables["points"]).len(), 12);
    (sandbox, tables)
}

/// Submits the sweep to the server that `server` names, waits, and returns its points and sets.
fn served(sandbox: &Sandbox, server: &[&str]) -> (Value, Value) {
    let run = |arguments: &[&str]| sandbox.run(&[arguments, server].concat()).expect(0);
    let submitted = run(&["submit", "tiny.toml", "--wait"]);
    let sweep = submitted.stdout.trim();
    let points = run(&["results", sweep, "--format", "json"]).json();
    let sets = run(&["results", sweep, "--format", "json", "--sets"]).json();
    (points, sets)
}

#[test]
fn a_served_sweep_equals_a_lone_run_bit_for_bit() {
    let (sandbox, alone) = computed_alone();
    let (_server, address) = sandbox.serve(&["--data", "served", "--workers", "2"]);
    let (points, sets) = served(&sandbox, &["--server", &address]);
    assert_eq!(hashes(&points), hashes(&alone["points"]));
    assert_eq!(sets["items"], alone["sets"]["items"]);
}

#[test]
fn workers_in_other_processes_with_a_token_give_the_same_bits() {
    let (sandbox, alone) = computed_alone();
    for scope in ["worker", "submit"] {
        let create = ["token", "create", "--scope", scope, "--data", "served"];
        sandbox.write(scope, &sandbox.run(&create).expect(0).stdout);
    }
    let (_server, address) = sandbox.serve(&["--data", "served", "--workers", "0"]);
    let worker = |threads| {
        let arguments = ["worker", "--server", &address, "--token-file", "worker"];
        sandbox.start(&[&arguments[..], &["--threads", threads, "--spool", "spool"]].concat())
    };
    let mut workers: Vec<Process> = vec![worker("1"), worker("2")];
    let refused = sandbox.run(&["submit", "tiny.toml", "--server", &address]);
    assert!(refused.expect(1).stderr.contains("--token-file"));
    let server = ["--server", &address, "--token-file", "submit"];
    let (points, sets) = served(&sandbox, &server);
    assert_eq!(hashes(&points), hashes(&alone["points"]));
    assert_eq!(sets["items"], alone["sets"]["items"]);
    for worker in &mut workers {
        assert!(worker.terminate().success());
    }
}

#[test]
fn a_run_that_was_interrupted_goes_on_to_the_same_bits() {
    let sandbox = Sandbox::new();
    sandbox.write("tiny.toml", &tiny(64, "[1, 2]", SIX));
    let mut first = sandbox.start(&["run", "tiny.toml", "--data", "broken"]);
    first.line_with("points done");
    first.signal(rustix::process::Signal::INT);
    let code = first.end().code();
    assert!(code == Some(130) || code == Some(0), "{code:?}");
    let again = sandbox.run(&["run", "tiny.toml", "--json", "--data", "broken"]);
    let whole = sandbox.run(&["run", "tiny.toml", "--json", "--data", "whole"]);
    let (again, whole) = (again.expect(0).json(), whole.expect(0).json());
    assert_eq!(hashes(&again["points"]), hashes(&whole["points"]));
    assert_eq!(again["sets"], whole["sets"]);
}

#[test]
fn a_replayed_job_has_the_stored_hash() {
    let (sandbox, alone) = computed_alone();
    let job = alone["points"]["items"][7]["job"].as_str().expect("a job");
    let replay = sandbox.run(&["replay", job, "--data", "alone", "--json"]);
    let replay = replay.expect(0).json();
    assert_eq!(replay["equal"], true);
    assert_eq!(replay["stored"], alone["points"]["items"][7]["result_hash"]);
}

#[test]
fn the_same_sweep_again_computes_nothing_and_a_larger_one_only_the_rest() {
    let (sandbox, _) = computed_alone();
    let (_server, address) = sandbox.serve(&["--data", "alone", "--workers", "0"]);
    let submit = ["submit", "tiny.toml", "--server", &address, "--json"];
    let again = sandbox.run(&submit).expect(0);
    assert_eq!(again.json()["jobs"]["new"], 0);
    assert!(again.stderr.contains("12 of 12"), "{}", again.stderr);
    sandbox.write("tiny.toml", &tiny(12, "[1, 2, 3]", SIX));
    let more = sandbox.run(&submit).expect(0).json();
    // A pack, a trained pack, six recalls and the zero signal.
    assert_eq!(more["jobs"]["new"], 9);
    assert_eq!(more["points_done"], 12);
}
