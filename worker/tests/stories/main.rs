//! The worker against a scripted server: what it does when everything around it misbehaves.

mod engines;
mod scripted_server;

mod checkpoints;
mod faults;
mod leases;
mod spool;
mod word_to_stop;

use std::time::Duration;

use granary_api::id::{ArtifactHash, LeaseId};
use granary_api::lease::{LeaseGrant, LeasedJob};
use granary_core::memory::spec::Precision;
use granary_core::memory::spec::RecallSpec;
use granary_core::memory::waveform::Waveform;
use granary_core::stage::StageSpec;
use granary_worker::config::Config;
use granary_worker::execute::Engine;
use granary_worker::lease_client::http::HttpLeaseClient;
use granary_worker::lease_loop;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;

use crate::scripted_server::ScriptedServer;

/// The token that the scripted server wants.
const TOKEN: &str = "worker-token";

/// A worker under test.
struct Worker {
    shutdown: CancellationToken,
    task: JoinHandle<anyhow::Result<()>>,
}

impl Worker {
    fn start(server: &ScriptedServer, engine: Engine, config: Config) -> Self {
        Self::with_token(server, TOKEN, engine, config)
    }

    fn with_token(server: &ScriptedServer, token: &str, engine: Engine, config: Config) -> Self {
        let client = HttpLeaseClient::new(&server.address(), Some(token)).expect("valid address");
        let shutdown = CancellationToken::new();
        let run = lease_loop::run(client, engine, config, shutdown.clone());
        let task = tokio::spawn(run);
        Self { shutdown, task }
    }

    /// Gives the word to stop and waits for the end, 20 seconds at most.
    async fn stop(self) -> anyhow::Result<()> {
        self.shutdown.cancel();
        self.end().await
    }

    async fn end(self) -> anyhow::Result<()> {
        tokio::time::timeout(Duration::from_secs(20), self.task)
            .await
            .expect("the worker ends within 20 s")
            .expect("the worker does not panic")
    }
}

/// A worker with one slot that asks often.
fn config() -> Config {
    Config {
        poll: Duration::from_millis(200),
        ..Config::new(1)
    }
}

/// A recall of signal `number` of the six.
fn recall(number: u8) -> StageSpec {
    StageSpec::Recall(RecallSpec {
        train: granary_core::identity::StageId::of_bytes(b"trained pack"),
        encode: None,
        waveform: Waveform::Six(number),
        gamma0: 1e-3,
        time_step: 1.5,
        ramp: 18_000.0,
        drag: 0.0,
        hold: 0.2,
        precision: Precision::F32,
        second_cycle: false,
        skin: 0.1,
    })
}

/// A lease of `count` recalls in the state `input`, with a heartbeat every 50 ms.
fn grant(count: u8, input: Option<ArtifactHash>) -> LeaseGrant {
    let jobs = (1..=count).map(|number| {
        let spec = recall(number);
        LeasedJob {
            job: spec.id(),
            spec,
            input,
            checkpoint: None,
        }
    });
    LeaseGrant {
        lease: LeaseId::new(),
        heartbeat_s: 0.05,
        jobs: jobs.collect(),
    }
}
