//! What a user may count on when machines fail: every limit is asserted, every figure printed.
//!
//! The limits are for a release build on two cores that have nothing else to do.

use std::net::TcpListener;
use std::time::{Duration, Instant};

use granary_tests::{Process, Sandbox, binary, tiny};
use serde_json::Value;

/// The longest that any of these waits lasts.
const PATIENCE: Duration = Duration::from_mins(3);

/// A worker of one thread, which may start before its server.
fn worker(sandbox: &Sandbox, address: &str, name: &str) -> Process {
    sandbox.start(&[
        "worker",
        "--server",
        address,
        "--threads",
        "1",
        "--name",
        name,
        "--spool",
        name,
    ])
}

fn workers(sandbox: &Sandbox, address: &str) -> Vec<Value> {
    let listed = sandbox.run(&["workers", "--server", address, "--json"]);
    let listed = listed.expect(0).json();
    listed["items"].as_array().expect("a list").clone()
}

/// The sum of a column over all workers.
fn sum(sandbox: &Sandbox, address: &str, column: &str) -> u64 {
    let number = |row: &Value| row[column].as_u64().expect("a number");
    workers(sandbox, address).iter().map(number).sum()
}

/// Waits until `met` and says how long that took.
fn until(what: &str, mut met: impl FnMut() -> bool) -> Duration {
    let start = Instant::now();
    while !met() {
        assert!(start.elapsed() < PATIENCE, "waited in vain: {what}");
        std::thread::yield_now();
    }
    let took = start.elapsed();
    eprintln!("{what}: {took:.2?}");
    took
}

fn submit(sandbox: &Sandbox, spec: &str, address: &str) -> String {
    let submitted = sandbox.run(&["submit", spec, "--server", address]);
    submitted.expect(0).stdout.trim().to_owned()
}

/// Waits for the sweep; the number of its points that are done.
fn finish(sandbox: &Sandbox, address: &str, sweep: &str) -> usize {
    let watched = sandbox.run(&["watch", sweep, "--server", address]);
    assert_eq!(watched.code, Some(0), "{watched:#?}");
    let results = ["results", sweep, "--server", address, "--format", "json"];
    let points = sandbox.run(&results).expect(0).json();
    let items = points["items"].as_array().expect("a list");
    items.iter().filter(|row| row["state"] == "done").count()
}

/// An address that nothing listens at.
fn free_address() -> String {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    listener.local_addr().expect("an address").to_string()
}

#[test]
fn service_gives_the_jobs_of_twenty_killed_workers_back_within_a_lease_and_five_seconds() {
    let sandbox = Sandbox::new();
    let spec = tiny(100, "{ range = [1, 20] }", "\"zero\"");
    let slow = spec.replace("gas_time = 50.0", "gas_time = 20000.0");
    sandbox.write("slow.toml", &slow);
    let (_server, address) = sandbox.serve(&["--data", "data", "--workers", "0"]);
    let sweep = submit(&sandbox, "slow.toml", &address);
    let names: Vec<String> = (0..20).map(|n| format!("victim-{n}")).collect();
    let start = |name: &String| worker(&sandbox, &address, name);
    let mut victims: Vec<Process> = names.iter().map(start).collect();
    until("twenty workers hold a job each", || {
        sum(&sandbox, &address, "leased") == 20
    });
    victims.iter_mut().for_each(Process::kill);
    let held = || sum(&sandbox, &address, "leased") == 0;
    let back = until("their jobs are back in the queue", held);
    assert!(back < Duration::from_secs(35), "{back:?}");
    let _heirs = ["one", "two"].map(|name| worker(&sandbox, &address, name));
    assert_eq!(finish(&sandbox, &address, &sweep), 20);
    assert_eq!(sum(&sandbox, &address, "done"), 60, "every job once");
}

#[test]
fn service_finds_its_workers_busy_within_five_seconds_of_its_return() {
    let sandbox = Sandbox::new();
    sandbox.write(
        "many.toml",
        &tiny(20, "{ range = [1, 100000] }", "\"zero\""),
    );
    let serve = ["--data", "data", "--workers", "0"];
    let (mut server, address) = sandbox.serve(&serve);
    let names = ["one", "two", "three", "four"];
    let _workers = names.map(|name| worker(&sandbox, &address, name));
    submit(&sandbox, "many.toml", &address);
    for round in 1..=5 {
        until("all four workers are busy", || {
            let rows = workers(&sandbox, &address);
            rows.len() == 4 && rows.iter().all(|row| row["done"] != 0)
        });
        server.kill();
        // How long a server is away is what its workers' waits grow with.
        std::thread::sleep(Duration::from_secs(3 * round));
        let port = address.trim_start_matches("http://");
        (server, _) = sandbox.serve(&[&serve[..], &["--listen", port]].concat());
        let before = sum(&sandbox, &address, "done");
        let back = until("all four workers have finished new jobs", || {
            let rows = workers(&sandbox, &address);
            sum(&sandbox, &address, "done") > before + 4
                && rows.iter().all(|row| row["leased"] != 0)
        });
        assert!(back < Duration::from_secs(5), "{back:?}");
    }
}

#[test]
fn service_computes_64_points_64_times_with_workers_that_were_there_before_it() {
    for count in [4, 16] {
        let sandbox = Sandbox::new();
        sandbox.write("64.toml", &tiny(5, "{ range = [1, 64] }", "\"zero\""));
        let place = free_address();
        let address = format!("http://{place}");
        let names: Vec<String> = (0..count).map(|n| format!("early-{n}")).collect();
        let start = |name: &String| worker(&sandbox, &address, name);
        let mut early: Vec<Process> = names.iter().map(start).collect();
        for worker in &mut early {
            worker.line_with("worker started");
        }
        let (_server, _) = sandbox.serve(&["--data", "data", "--workers", "0", "--listen", &place]);
        let sweep = submit(&sandbox, "64.toml", &address);
        assert_eq!(finish(&sandbox, &address, &sweep), 64);
        let done = sum(&sandbox, &address, "done");
        eprintln!("{count} workers finished {done} jobs of 64 points");
        assert_eq!(done, 3 * 64, "pack, training and recall of each point once");
    }
}

#[test]
fn service_keeps_up_with_jobs_that_take_no_time() {
    let rate = |count: usize| {
        let sandbox = Sandbox::new();
        let words = "{ suite = \"binary_words\", bits = 11 }";
        let spec = tiny(1, "[1]", words).replace("ramp = 150.0", "ramp = 100.0");
        sandbox.write("words.toml", &spec);
        let (_server, address) = sandbox.serve(&["--data", "data", "--workers", "0"]);
        let names: Vec<String> = (0..count).map(|n| format!("worker-{n}")).collect();
        let start = |name: &String| worker(&sandbox, &address, name);
        let _workers: Vec<Process> = names.iter().map(start).collect();
        let start = Instant::now();
        let sweep = submit(&sandbox, "words.toml", &address);
        assert_eq!(finish(&sandbox, &address, &sweep), 2048);
        let rate = 2048.0 / start.elapsed().as_secs_f64();
        eprintln!("{count} workers: {rate:.0} jobs/s");
        rate
    };
    let (two, four) = (rate(2), rate(4));
    assert!(four > 150.0, "{four}");
    assert!(four > 0.8 * two, "{four} of {two}");
}

#[test]
fn service_starts_at_once_and_is_small() {
    let binary = std::fs::metadata(binary()).expect("it is built").len();
    eprintln!("binary: {:.1} MB", binary as f64 / 1e6);
    assert!(binary <= 25_000_000);
    let mut starts: Vec<Duration> = (0..9)
        .map(|_| {
            let sandbox = Sandbox::new();
            let before = Instant::now();
            let (server, _) = sandbox.serve(&["--data", "data", "--workers", "2"]);
            let took = before.elapsed();
            assert!(server.most_memory() < 20_000, "{} kB", server.most_memory());
            took
        })
        .collect();
    starts.sort();
    eprintln!("start: {starts:.0?}");
    assert!(starts[4] < Duration::from_millis(200));
}
