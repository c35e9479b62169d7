//! Killed servers and workers: nothing acknowledged is lost, nothing is counted twice.

use granary_tests::{Process, Sandbox, tiny};
use serde_json::Value;

/// A sweep that takes seconds, so that it can be disturbed.
fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    let spec = tiny(200, "[1, 2, 3]", "{ suite = \"six\" }");
    sandbox.write("slow.toml", &spec.replace("ramp = 150.0", "ramp = 1500.0"));
    sandbox
}

fn worker(sandbox: &Sandbox, address: &str) -> Process {
    let mut worker = sandbox.start(&[
        "worker",
        "--server",
        address,
        "--threads",
        "1",
        "--spool",
        "spool",
    ]);
    worker.line_with("worker started");
    worker
}

/// Submits without waiting; the sweep's id.
fn submit(sandbox: &Sandbox, address: &str) -> String {
    let submitted = sandbox.run(&["submit", "slow.toml", "--server", address]);
    submitted.expect(0).stdout.trim().to_owned()
}

/// Waits for the sweep and counts its results, each at most once.
fn all_done_once(sandbox: &Sandbox, address: &str, sweep: &str) {
    let watched = sandbox.run(&["watch", sweep, "--server", address]);
    assert_eq!(watched.code, Some(0), "{watched:#?}");
    let results = ["results", sweep, "--server", address, "--format", "json"];
    let points = sandbox.run(&results).expect(0).json();
    let items = points["items"].as_array().expect("a list");
    let done = |row: &&Value| row["state"] == "done";
    assert_eq!(items.iter().filter(done).count(), 18);
}

/// Waits until some job of the sweep is at a worker.
fn until_leased(sandbox: &Sandbox, address: &str) {
    let deadline = std::time::Instant::now() + std::time::Duration::from_mins(1);
    loop {
        let workers = sandbox.run(&["workers", "--server", address, "--json"]);
        let workers = workers.expect(0).json();
        let items = workers["items"].as_array().expect("a list");
        if items.iter().any(|worker| worker["leased"] != 0) {
            return;
        }
        assert!(std::time::Instant::now() < deadline, "no job was leased");
    }
}

#[test]
fn a_killed_workers_jobs_are_done_by_another() {
    let sandbox = sandbox();
    let serve = ["--data", "data", "--workers", "0", "--lease-term", "2"];
    let (_server, address) = sandbox.serve(&serve);
    let sweep = submit(&sandbox, &address);
    let mut victim = worker(&sandbox, &address);
    until_leased(&sandbox, &address);
    victim.kill();
    let _heir = worker(&sandbox, &address);
    all_done_once(&sandbox, &address, &sweep);
}

#[test]
fn a_killed_server_comes_back_to_workers_that_went_on() {
    let sandbox = sandbox();
    // A lease whose grant dies with the server is nobody's until its term is over.
    let serve = ["--data", "data", "--workers", "0", "--lease-term", "2"];
    let (mut server, address) = sandbox.serve(&serve);
    let _worker = worker(&sandbox, &address);
    let sweep = submit(&sandbox, &address);
    until_leased(&sandbox, &address);
    server.kill();
    let port = address.trim_start_matches("http://");
    let (_server, address) = sandbox.serve(&[&serve[..], &["--listen", port]].concat());
    all_done_once(&sandbox, &address, &sweep);
}

#[test]
fn a_worker_told_to_stop_hands_back_at_once() {
    let sandbox = sandbox();
    let (_server, address) = sandbox.serve(&["--data", "data", "--workers", "0"]);
    let sweep = submit(&sandbox, &address);
    let mut first = worker(&sandbox, &address);
    until_leased(&sandbox, &address);
    let before = std::time::Instant::now();
    assert!(first.terminate().success());
    assert!(before.elapsed().as_secs() < 20);
    // A lease that had not been handed back would cost the heir a term of 30 s, then a watch of the whole.
    let _heir = worker(&sandbox, &address);
    all_done_once(&sandbox, &address, &sweep);
}

#[test]
fn workers_that_died_with_their_server_cost_no_lease_term() {
    let sandbox = sandbox();
    // With a term of an hour, a lease that is not taken back at the start is never seen again by this test.
    let serve = ["--data", "data", "--workers", "2", "--lease-term", "3600"];
    let (mut server, address) = sandbox.serve(&serve);
    let sweep = submit(&sandbox, &address);
    until_leased(&sandbox, &address);
    server.kill();
    let (_server, address) = sandbox.serve(&serve);
    all_done_once(&sandbox, &address, &sweep);
}

#[test]
fn nothing_acknowledged_is_lost_and_nothing_is_counted_twice() {
    granary_tests::crash(6);
}

#[test]
fn sixteen_workers_started_before_their_server_compute_each_point_once() {
    let sandbox = Sandbox::new();
    let words = "{ suite = \"binary_words\", bits = 6 }";
    sandbox.write("words.toml", &tiny(5, "[1]", words));
    // A port that was free a moment ago.
    let port = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
    let listen = port.local_addr().expect("bound").to_string();
    drop(port);
    let address = format!("http://{listen}");
    let four = [
        "worker",
        "--server",
        &address,
        "--threads",
        "4",
        "--spool",
        "spool",
    ];
    let _workers: Vec<Process> = (0..4).map(|_| sandbox.start(&four)).collect();
    let serve = ["--data", "data", "--workers", "0", "--listen", &listen];
    let (_server, _) = sandbox.serve(&serve);
    let submit = [
        "submit",
        "words.toml",
        "--server",
        &address,
        "--json",
        "--wait",
    ];
    let submitted = sandbox.run(&submit).expect(0).json();
    assert_eq!(submitted["points"], 64);
    let workers = sandbox.run(&["workers", "--server", &address, "--json"]);
    let workers = workers.expect(0).json();
    let items = workers["items"].as_array().expect("a list");
    let done: u64 = items
        .iter()
        .filter_map(|worker| worker["done"].as_u64())
        .sum();
    // A pack, a trained pack, 64 words, an encoding for every eight of them, and the zero signal.
    assert_eq!(
        (Some(done), done),
        (submitted["jobs"]["total"].as_u64(), 75)
    );
}
