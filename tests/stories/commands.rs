//! The smaller commands, as a user meets them.

use granary_tests::{Finished, Sandbox, tiny};
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
fn an_archive_without_its_states_answers_at_once() {
    let sandbox = Sandbox::new();
    sandbox.write("tiny.toml", &tiny(12, "[1]", SIX));
    let run = |data: &str| {
        let place = ["--data", data, "--archive", "archive", "--json"];
        sandbox
            .run(&[&["run", "tiny.toml"], &place[..]].concat())
            .expect(0)
    };
    let computed = run("first");
    // States are large and soon made again: who passes an archive on leaves them out.
    let files = || {
        let files = std::fs::read_dir(sandbox.path("archive")).expect("a directory");
        files.map(|file| file.expect("a file").path())
    };
    let states: Vec<_> = { files() }
        .filter(|file| file.extension().is_some_and(|end| end == "state"))
        .collect();
    assert_eq!(states.len(), 2);
    for state in states {
        std::fs::remove_file(state).expect("removed");
    }
    let left = files().count();
    let again = run("second");
    assert!(
        again.stderr.contains("6 of 6 already done"),
        "{}",
        again.stderr
    );
    assert_eq!(files().count(), left);
    let results = |of: &Finished| {
        let rows = of.json()["points"]["items"].clone();
        let rows = rows.as_array().expect("a list").iter();
        rows.map(|row| row["results"].clone()).collect::<Vec<_>>()
    };
    assert_eq!(results(&again), results(&computed));
}

#[test]
fn a_study_says_what_each_setting_costs() {
    let sandbox = Sandbox::new();
    sandbox.write("tiny.toml", &tiny(12, "[1]", SIX));
    let knobs = ["--knob", "time_step=0.3", "--setting", "preset=paper"];
    let place = ["--data", "data", "--plot", "study.svg", "--json"];
    let line = [&["study", "tiny.toml"], &knobs[..], &place[..]].concat();
    let study = sandbox.run(&line).expect(0).json();
    let rows = study["items"].as_array().expect("a list");
    let told: Vec<_> = rows.iter().map(|row| &row["setting"]).collect();
    assert_eq!(told, ["reference", "time_step 0.3", "preset paper"]);
    for row in rows {
        assert!(row["results"]["fidelity_deviation"].is_f64(), "{row}");
        assert!(row["results"]["core_seconds"].is_f64(), "{row}");
    }
    let picture = std::fs::read_to_string(sandbox.path("study.svg")).expect("a picture");
    assert!(picture.contains(">time_step<") && picture.contains(">preset paper<"));
    // The planner reads what the options say as it reads a spec.
    let wrong = [
        "study",
        "tiny.toml",
        "--knob",
        "tme_step=1",
        "--data",
        "data",
    ];
    let refused = sandbox.run(&wrong);
    assert_eq!(refused.code, Some(2));
    assert!(
        refused.stderr.contains("did you mean time_step?"),
        "{}",
        refused.stderr
    );
}

#[test]
fn settings_are_chosen_for_the_accuracy_that_is_asked_for() {
    let sandbox = Sandbox::new();
    let drag = "second_cycle = false\ndrag = 0.01";
    let spec = tiny(12, "[1, 2, 3]", SIX).replace("second_cycle = false", drag);
    let accuracy = "[accuracy]\nfidelity = 1.0\npackings = 2\n";
    sandbox.write("accurate.toml", &format!("{spec}{accuracy}"));
    let run = || {
        sandbox
            .run(&["run", "accurate.toml", "--data", "data", "--json"])
            .expect(0)
    };
    let first = run();
    // What the spec leaves open is chosen; whatever is as good as that is good enough here, so the cheapest.
    let chosen = "chosen: time_step 1.5, hold 0.2, precision f32";
    assert!(first.stderr.contains(chosen), "{}", first.stderr);
    let sets = first.json()["sets"]["items"].clone();
    let mean = sets.as_array().expect("a list").last().expect("a mean");
    assert_eq!(mean["of"], 3);
    assert_eq!(mean["parameters"]["time_step"], 1.5);
    assert!(
        mean["results"]["fidelity_deviation_bound"].is_f64(),
        "{mean}"
    );
    // A choice once made is kept, and with it the results.
    let second = run();
    assert!(
        second.stderr.contains("18 of 18 already done"),
        "{}",
        second.stderr
    );
    assert_eq!(second.json(), first.json());
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

/// Two spheres that touch, between walls far off.
const TWO_SPHERES: &str = r#"{"kind": "spheres", "radius": 5e-4, "density": 1200,
    "box": [[0, 2e-3], [0, 2e-3], [0, 3e-3]], "positions": [[1e-3, 1e-3, 1e-3], [1e-3, 1e-3, 1.95e-3]]}"#;

/// A program that says it is LAMMPS, and then does as `body` says.
fn straw_lammps(sandbox: &Sandbox, body: &str) {
    use std::os::unix::fs::PermissionsExt;
    let greeting = "Large-scale Atomic/Molecular Massively Parallel Simulator - of straw";
    let text = format!("#!/bin/sh\n[ $1 = -help ] && echo '{greeting}' && exit\n{body}\n");
    sandbox.write("lmp", &text);
    let executable = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(sandbox.path("lmp"), executable).expect("is ours");
}

#[test]
fn bench_beside_lammps_pairs_its_runs_and_says_what_went_wrong() {
    let sandbox = Sandbox::new();
    sandbox.write("pack.json", TWO_SPHERES);
    std::fs::create_dir(sandbox.path("tmp")).expect("is new");
    let bench = |more: &[&str]| {
        let pack = ["bench", "--pack", "pack.json", "--seconds", "0.05"];
        let mut command = sandbox.command(&[&pack[..], more].concat());
        command.env("TMPDIR", sandbox.path("tmp"));
        let output = command.output().expect("granary starts");
        let words =
            [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
        (output.status.code(), words)
    };
    let beside = ["--beside", "./lmp", "--repeats", "3", "--json"];
    let refused = |words: &str| {
        let (code, [_, stderr]) = bench(&beside);
        assert_eq!(code, Some(1), "{stderr}");
        assert!(
            stderr.contains("lmp`") && stderr.contains(words),
            "{stderr}"
        );
    };
    refused("No such file");
    straw_lammps(
        &sandbox,
        "echo 'ERROR: Unknown pair style' > log.lammps; exit 7",
    );
    refused("(exit status: 7):\n  ERROR: Unknown pair style");
    straw_lammps(&sandbox, "cp in.bench log.lammps");
    refused("does not time 125000 steps");
    let steps = "$(sed -n '$ s/run //p' in.bench)";
    let timed = format!("Loop time of 0.5 on 1 procs for {steps} steps with 2 atoms");
    let shared = "80.0% CPU use with 1 MPI tasks";
    let figures = format!("echo \"{timed}\n{shared}\" > log.lammps");
    straw_lammps(&sandbox, &figures);
    let (code, [stdout, stderr]) = bench(&beside);
    assert_eq!(code, Some(0), "{stderr}");
    let figures: serde_json::Value = serde_json::from_str(&stdout).expect("is JSON");
    // Two grains, 125,000 steps, 0.5 s of which 80 % were LAMMPS' own.
    let rate = figures["lammps_median_grain_steps_per_cpu_second"].as_f64();
    assert_eq!(rate, Some(625_000.0));
    let ratios = figures["ratios"].as_array().expect("a list");
    assert!(
        ratios.len() == 3 && ratios.contains(&figures["median_ratio"]),
        "{figures}"
    );
    assert_eq!(figures["lammps_version"], "of straw");
    let left = std::fs::read_dir(sandbox.path("tmp")).expect("is there");
    assert_eq!(left.count(), 0, "LAMMPS' directories are removed");
    // Rates are of one thread, and without LAMMPS there are no pairs.
    assert_eq!(bench(&["--beside", "./lmp", "--threads", "2"]).0, Some(2));
    assert_eq!(bench(&["--repeats", "3"]).0, Some(2));
}

#[test]
fn models_openapi_and_health_speak_json() {
    let sandbox = Sandbox::new();
    let models = sandbox.run(&["models", "--json"]).expect(0).json();
    assert_eq!(models["properties"]["delta0"]["x-symbol"], "δ0");
    let beam = sandbox.run(&["models", "beam", "--json"]).expect(0).json();
    assert_eq!(beam["properties"]["confining_pressure"]["x-symbol"], "Δp");
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
        ("words-7", 136, 0),
        ("big-standard", 6, 0),
        ("big-paper", 6, 0),
        ("spheres", 72, 0),
    ] {
        let spec = format!("{examples}/{name}.toml");
        let submit = ["submit", &spec, "--dry-run", "--json", "--server", &address];
        let planned = sandbox.run(&submit).expect(0).json();
        assert_eq!(planned["points"], points, "{name}");
        assert_eq!(planned["warnings"].as_array().map(Vec::len), Some(warnings));
    }
}

#[test]
fn figures_are_listed_printed_submitted_and_drawn_as_far_as_they_are() {
    let sandbox = Sandbox::new();
    let list = sandbox.run(&["figures"]).expect(0).stdout;
    let names = |name: &&str| list.lines().any(|line| line.starts_with(name));
    assert!(["fig3 ", "fig16 ", "table1 "].iter().all(names), "{list}");
    let spec = ["figures", "fig5", "--preset", "smoke", "--spec"];
    let spec = sandbox.run(&spec).expect(0).stdout;
    sandbox.write("fig5.toml", &spec);
    let (_server, address) = sandbox.serve(&["--data", "data", "--workers", "0"]);
    let draw =
        |name: &str| sandbox.run(&["figures", name, "--preset", "smoke", "--server", &address]);
    let unknown = draw("fig5").expect(1);
    assert!(
        unknown
            .stderr
            .contains("granary figures fig5 --preset smoke")
    );
    let submit = ["submit", "fig5.toml", "--server", &address];
    assert_eq!(sandbox.run(&submit).code, Some(0));
    // Nothing is computed yet, and the picture says no more than that.
    let drawn = draw("fig5").expect(3);
    assert!(
        drawn.stderr.contains("of 2 points 0 are done"),
        "{drawn:#?}"
    );
    let picture = std::fs::read_to_string(sandbox.path("figures/fig5.svg")).expect("a picture");
    assert!(picture.contains("σ (kPa)") && picture.contains("no number yet"));
}
