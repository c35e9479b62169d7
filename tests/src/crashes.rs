//! Short sweeps under `kill -9` of server and worker at random moments, judged by the client's own ledger.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::process::Process;
use crate::sandbox::{Finished, Sandbox, tiny};

/// The victims.
struct Service<'a> {
    sandbox: &'a Sandbox,
    port: String,
    server: Process,
    worker: Process,
}

/// A short lease term, so that the jobs of a killed worker are soon another's.
const SERVE: [&str; 6] = ["--data", "data", "--workers", "1", "--lease-term", "1"];

fn worker(sandbox: &Sandbox, address: &str) -> Process {
    let arguments = [
        "worker",
        "--server",
        address,
        "--threads",
        "1",
        "--spool",
        "spool",
    ];
    sandbox.start(&arguments)
}

impl<'a> Service<'a> {
    fn start(sandbox: &'a Sandbox) -> Self {
        let (server, address) = sandbox.serve(&SERVE);
        Self {
            sandbox,
            port: address.trim_start_matches("http://").to_owned(),
            worker: worker(sandbox, &address),
            server,
        }
    }

    fn address(&self) -> String {
        format!("http://{}", self.port)
    }

    /// Kills one of the two, or none, and starts it again.
    fn disturb(&mut self) {
        match fastrand::u8(0..3) {
            0 => {
                self.server.kill();
                let arguments = [&SERVE[..], &["--listen", &self.port]].concat();
                (self.server, _) = self.sandbox.serve(&arguments);
            }
            1 => {
                self.worker.kill();
                self.worker = worker(self.sandbox, &self.address());
            }
            _ => {}
        }
    }

    fn command(&self, arguments: &[&str]) -> Finished {
        let address = self.address();
        self.sandbox
            .run(&[arguments, &["--server", &address]].concat())
    }

    /// Submits until the server acknowledges; the sweep's id.
    fn submit(&mut self, spec: &str) -> String {
        let deadline = Instant::now() + Duration::from_mins(1);
        loop {
            let submitted = self.command(&["submit", spec]);
            if submitted.code == Some(0) {
                return submitted.stdout.trim().to_owned();
            }
            assert!(Instant::now() < deadline, "{submitted:#?}");
        }
    }

    /// Waits for the sweep; jobs that outlived too many workers are tried again, as a user would.
    fn finish(&self, sweep: &str) {
        for _ in 0..5 {
            if self.command(&["watch", sweep]).code == Some(0) {
                return;
            }
            let retried = self.command(&["retry", sweep]);
            assert_eq!(retried.code, Some(0), "{retried:#?}");
        }
        panic!(
            "{sweep} does not finish: {:#?}",
            self.command(&["results", sweep])
        );
    }
}

/// Result hash by seed and waveform.
fn hashes(tables: &Value) -> BTreeMap<String, String> {
    let rows = tables["items"].as_array().expect("a list");
    let hash = |row: &Value| row["result_hash"].as_str().expect("a result").to_owned();
    let name = |row: &Value| row["parameters"].to_string();
    let hashes: BTreeMap<String, String> = rows.iter().map(|row| (name(row), hash(row))).collect();
    assert_eq!(hashes.len(), rows.len(), "each point once");
    hashes
}

/// Submits `sweeps` short sweeps while server and worker are killed, then holds the service to the client's ledger:
/// every acknowledged sweep is there once, complete, and with the bits of an undisturbed run.
///
/// # Panics
/// If it is not so.
pub fn crash(sweeps: u32) {
    let seed = fastrand::u64(..);
    fastrand::seed(seed);
    eprintln!("random seed {seed}");
    let sandbox = Sandbox::new();
    let mut service = Service::start(&sandbox);
    let mut ledger = vec![];
    for number in 1..=sweeps {
        // One packing of its own, and one that it shares with the next sweep.
        let seeds = format!("[{number}, {}]", number + 1);
        let spec = format!("{number}.toml");
        sandbox.write(&spec, &tiny(5, &seeds, "{ suite = \"six\" }"));
        let sweep = service.submit(&spec);
        service.disturb();
        ledger.push((spec, sweep));
    }
    for (_, sweep) in &ledger {
        service.finish(sweep);
    }
    let listed = service.command(&["sweeps", "--json"]).expect(0).json();
    assert_eq!(listed["items"].as_array().map(Vec::len), Some(ledger.len()));
    for (spec, sweep) in &ledger {
        assert_eq!(
            &service.submit(spec),
            sweep,
            "an acknowledged sweep is found again"
        );
        let results = service.command(&["results", sweep, "--json"]).expect(0);
        let alone = sandbox.run(&["run", spec, "--json", "--data", "alone"]);
        let alone = alone.expect(0).json();
        assert_eq!(hashes(&results.json()), hashes(&alone["points"]));
    }
}
