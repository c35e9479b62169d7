//! The smaller commands, as a user meets them.

use granary_tests::{Sandbox, tiny};
use rustix::process::Signal;

const SIX: &str = "{ suite = \"six\" }";

#[test]
fn a_cancelled_sweep_submitted_again_computes_the_rest_alone() {
    let sandbox = Sandbox::new();
    sandbox.write("three.toml", &tiny(12, "[1, 2, 3]", SIX));
    sandbox.write("one.toml", &tiny(12, "[1]", SIX));
    let (_server, address) = sandbox.serve(&["--data", "data", "--workers", "0"]);
    let run = |arguments: &[&str]| sandbox.run(&[arguments, &["--server", &address]].concat());
    let sweep = run(&["submit", "three.toml"]).expect(0).stdout;
    let sweep = sweep.trim();
    let cancelled = run(&["cancel", sweep, "--json"]).expect(0).json();
    assert_eq!(cancelled["state"], "cancelled");
    // What a cancelled sweep shares with a living one is computed all the same.
    let _worker = sandbox.start(&["worker", "--server", &address, "--spool", "spool"]);
    assert_eq!(run(&["submit", "one.toml", "--wait"]).code, Some(0));
    let results = run(&["results", sweep, "--json"]).expect(0).json();
    let items = results["items"].as_array().expect("a list");
    let done = |state: &str| items.iter().filter(|row| row["state"] == state).count();
    assert_eq!((done("done"), done("cancelled")), (6, 12));
    let again = run(&["submit", "three.toml", "--json"]).expect(0).json();
    assert_eq!(
        (&again["sweep"], &again["points_done"]),
        (&sweep.into(), &6.into())
    );
    assert_eq!(again["jobs"]["new"], 0);
    assert_eq!(run(&["watch", sweep]).code, Some(0));
}

#[test]
fn a_watcher_may_leave_and_the_sweep_goes_on() {
    let sandbox = Sandbox::new();
    sandbox.write("tiny.toml", &tiny(12, "[1]", SIX));
    let (_server, address) = sandbox.serve(&["--data", "data", "--workers", "0"]);
    let submitted = sandbox.run(&["submit", "tiny.toml", "--server", &address]);
    let sweep = submitted.expect(0).stdout;
    let mut watcher = sandbox.start(&["watch", sweep.trim(), "--server", &address]);
    watcher.line_with("0/6 points done");
    watcher.signal(Signal::INT);
    watcher.line_with("the sweep goes on");
    assert_eq!(watcher.end().code(), Some(130));
}

#[test]
fn tokens_are_made_and_revoked_while_the_server_runs() {
    let sandbox = Sandbox::new();
    let (_server, address) = sandbox.serve(&["--data", "data", "--workers", "0"]);
    let sweeps = |more: &[&str]| {
        let list = ["sweeps", "--json", "--server", &address];
        sandbox.run(&[&list[..], more].concat())
    };
    assert_eq!(sweeps(&[]).code, Some(0));
    let place = ["--data", "data"];
    let create = ["token", "create", "--scope", "read", "--name", "reader"];
    let made = sandbox.run(&[&create[..], &place].concat()).expect(0);
    sandbox.write("reader.token", &made.stdout);
    // The server notices at once.
    let refused = sweeps(&[]);
    assert_ne!(refused.code, Some(0));
    assert!(refused.stderr.contains("token"), "{}", refused.stderr);
    assert_eq!(sweeps(&["--token-file", "reader.token"]).code, Some(0));
    let second = ["serve", "--listen", "127.0.0.1:0", "--data", "data"];
    let second = sandbox.run(&second).expect(1);
    assert!(second.stderr.contains(&address), "{}", second.stderr);
    let revoke = ["token", "revoke", "reader"];
    let revoked = sandbox.run(&[&revoke[..], &place].concat()).expect(0);
    assert!(revoked.stderr.contains("1 revoked"), "{}", revoked.stderr);
    assert_eq!(sweeps(&[]).code, Some(0));
}

#[test]
fn bench_reports_the_figures_that_scripts_read() {
    let sandbox = Sandbox::new();
    let arguments = [
        "bench",
        "--grains",
        "20",
        "--lanes",
        "8",
        "--precision",
        "f64",
    ];
    let quick = ["--seconds", "0.05", "--json"];
    let figures = sandbox
        .run(&[&arguments[..], &quick].concat())
        .expect(0)
        .json();
    for name in [
        "grain_steps_per_second",
        "contact_updates_per_second",
        "nanoseconds_per_contact",
        "bytes_per_grain",
    ] {
        assert!(figures[name].as_f64() > Some(0.0), "{name}: {figures}");
    }
}

#[test]
fn models_openapi_and_health_speak_json() {
    let sandbox = Sandbox::new();
    let models = sandbox.run(&["models", "--json"]).expect(0).json();
    assert_eq!(models["properties"]["delta0"]["x-symbol"], "δ0");
    let document = sandbox.run(&["openapi"]).expect(0).json();
    assert!(document["paths"]["/api/v1/sweeps"].is_object());
    let (_server, address) = sandbox.serve(&["--data", "data", "--workers", "0"]);
    let health = sandbox.run(&["health", "--server", &address]).expect(0);
    assert_eq!(health.json()["status"], "ok");
    let nobody = sandbox.run(&["health", "--server", "http://127.0.0.1:9"]);
    assert_eq!(nobody.code, Some(4));
}

#[test]
fn examples_are_valid_and_count_what_they_say() {
    let sandbox = Sandbox::new();
    let (_server, address) = sandbox.serve(&["--data", "data", "--workers", "0"]);
    let examples = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples");
    for (name, points, warnings) in [
        ("demo", 54, 0),
        ("six-325", 6, 0),
        ("words-3", 24, 0),
        ("big-standard", 6, 0),
        ("big-paper", 6, 0),
        ("spheres", 72, 1),
    ] {
        let spec = format!("{examples}/{name}.toml");
        let submit = ["submit", &spec, "--dry-run", "--json", "--server", &address];
        let planned = sandbox.run(&submit).expect(0).json();
        assert_eq!(planned["points"], points, "{name}");
        assert_eq!(planned["warnings"].as_array().map(Vec::len), Some(warnings));
    }
}
