//! Exit codes that scripts can use, and the words that come with them.

use granary_tests::{Sandbox, tiny};

const ONE: &str = "[\"six/5\"]";

#[test]
fn a_bad_spec_ends_with_2_and_shows_every_mistake_with_its_line() {
    let sandbox = Sandbox::new();
    let spec = tiny(0, "[1]", ONE) + "[[reduce]]\nkind = \"gain_fidelty\"\n";
    sandbox.write("bad.toml", &spec);
    let refused = sandbox.run(&["run", "bad.toml"]).expect(2);
    assert!(refused.stdout.is_empty());
    assert!(
        refused
            .stderr
            .contains("bad.toml:4 /fixed/grains: 0 is not in 1"),
        "{}",
        refused.stderr
    );
    assert!(
        refused.stderr.contains("gain_fidelity"),
        "{}",
        refused.stderr
    );
    sandbox.write("broken.toml", "name = \n");
    let broken = sandbox.run(&["run", "broken.toml"]).expect(2);
    assert!(broken.stderr.contains("broken.toml:1"), "{}", broken.stderr);
}

#[test]
fn a_format_that_no_server_writes_is_refused_with_those_that_are() {
    let sandbox = Sandbox::new();
    let sweep = "019a0000-0000-7000-8000-000000000000";
    let refused = sandbox.run(&["results", sweep, "--format", "parquet"]);
    let refused = refused.expect(2);
    for words in ["'parquet'", "--format", "table, json, csv"] {
        assert!(refused.stderr.contains(words), "{}", refused.stderr);
    }
}

#[test]
fn a_server_that_is_not_there_ends_with_4_and_names_the_next_command() {
    let sandbox = Sandbox::new();
    sandbox.write("tiny.toml", &tiny(5, "[1]", ONE));
    let submit = ["submit", "tiny.toml", "--server", "http://127.0.0.1:9"];
    let lost = sandbox.run(&submit).expect(4);
    assert!(lost.stderr.contains("granary serve"), "{}", lost.stderr);
}

#[test]
fn a_plain_address_needs_no_certificates() {
    let sandbox = Sandbox::new();
    let mut health = sandbox.command(&["health", "--server", "http://127.0.0.1:9"]);
    // As in a container without the authorities' certificates.
    health
        .env("SSL_CERT_FILE", "/nowhere")
        .env("SSL_CERT_DIR", "/nowhere");
    let status = health.status().expect("granary starts");
    assert_eq!(status.code(), Some(4));
}

#[test]
fn failed_points_end_with_3_and_are_shown_with_the_reason() {
    let sandbox = Sandbox::new();
    let spec = tiny(12, "[1]", ONE).replace("ramp = 150.0", "ramp = 3000.0\ntime_step = 5.0");
    sandbox.write("unstable.toml", &spec);
    let run = sandbox.run(&["run", "unstable.toml", "--json"]).expect(3);
    let row = &run.json()["points"]["items"][0];
    assert_eq!(row["state"], "failed");
    assert!(row["failure"]["message"].is_string(), "{row}");
}

#[test]
fn a_pipe_sees_json_alone_and_no_more_than_ten_lines_of_progress() {
    let sandbox = Sandbox::new();
    sandbox.write("tiny.toml", &tiny(12, "[1, 2]", ONE));
    let run = sandbox.run(&["run", "tiny.toml", "--json"]).expect(0);
    assert_eq!(run.stdout.lines().count(), 1);
    assert!(run.json()["sets"]["items"].is_array());
    assert!(run.stderr.lines().count() <= 10, "{}", run.stderr);
    assert!(!run.stderr.contains('\u{1b}'), "{:?}", run.stderr);
}

#[test]
fn a_data_directory_has_one_holder_and_the_second_is_told_its_address() {
    let sandbox = Sandbox::new();
    sandbox.write("tiny.toml", &tiny(5, "[1]", ONE));
    let (_server, address) = sandbox.serve(&["--data", "held", "--workers", "0"]);
    let second = ["serve", "--data", "held", "--listen", "127.0.0.1:0"];
    for arguments in [&second[..], &["run", "tiny.toml", "--data", "held"]] {
        let refused = sandbox.run(arguments).expect(1);
        assert!(refused.stderr.contains(&address), "{}", refused.stderr);
    }
}

#[test]
fn a_server_off_loopback_without_a_token_does_not_start() {
    let sandbox = Sandbox::new();
    let refused = sandbox.run(&["serve", "--listen", "0.0.0.0:0", "--data", "open"]);
    let refused = refused.expect(1);
    assert!(
        refused.stderr.contains("granary token create"),
        "{}",
        refused.stderr
    );
}

#[test]
fn a_terminal_sees_a_bar_with_the_time_left() {
    let sandbox = Sandbox::new();
    sandbox.write("tiny.toml", &tiny(64, "[1, 2]", ONE));
    // Every command that logs once panicked on a terminal, and only there: tests had always been pipes.
    let run = format!("{} run tiny.toml", granary_tests::binary().display());
    let mut script = std::process::Command::new("script");
    let script = script.args(["--quiet", "--return", "--command", &run, "/dev/null"]);
    let script = script
        .current_dir(sandbox.path("."))
        .stdin(std::process::Stdio::null());
    let output = script.output().expect("`script` of bsdutils starts");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}");
    assert!(
        text.contains("2/2 points done") && text.contains('█'),
        "{text}"
    );
}
