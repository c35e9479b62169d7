//! `granary worker`: computes for a server on another machine, or in another process.

use std::path::PathBuf;
use std::time::Duration;

use anyhow::Context;
use granary_worker::config::Config;
use granary_worker::execute::core_engine;
use granary_worker::lease_client::http::HttpLeaseClient;
use granary_worker::lease_loop;
use tokio_util::sync::CancellationToken;

use crate::api_client::ServerArgs;
use crate::failure::Done;
use crate::service::{ArchiveArgs, all_cores};
use crate::{interrupt, log};

/// Compute jobs of a server until stopped; needs no port of its own.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    server: ServerArgs,
    /// Engine threads, each with its own lease; those without work help the others. All cores by default.
    #[arg(long, env = "GRANARY_THREADS", value_name = "N")]
    threads: Option<usize>,
    /// What this worker calls itself; host and process by default.
    #[arg(long, env = "GRANARY_WORKER_NAME")]
    name: Option<String>,
    /// Memory for all its ensembles together \[GiB\]; four fifths of the machine's by default.
    #[arg(long, env = "GRANARY_MEMORY_GIB", value_name = "GIB")]
    memory_gib: Option<u64>,
    /// Directory for finished outcomes that could not be delivered.
    #[arg(long, env = "GRANARY_SPOOL", value_name = "DIR", default_value_os_t = spool())]
    spool: PathBuf,
    #[command(flatten)]
    archive: ArchiveArgs,
    /// Seconds between stored checkpoints of a running job.
    #[arg(
        long,
        env = "GRANARY_CHECKPOINT_S",
        value_name = "SECONDS",
        default_value_t = 300
    )]
    checkpoint_s: u64,
}

/// Beside other temporary files: it holds nothing that cannot be computed again.
fn spool() -> PathBuf {
    std::env::temp_dir().join("granary-spool")
}

impl Args {
    fn config(&self) -> Config {
        let usual = Config::new(self.threads.unwrap_or_else(all_cores));
        let memory = |gib: u64| (gib << 30) / usual.slots as u64;
        Config {
            name: self.name.clone().unwrap_or_else(|| usual.name.clone()),
            memory_bytes: self.memory_gib.map_or(usual.memory_bytes, memory),
            checkpoint_every: Duration::from_secs(self.checkpoint_s),
            spool: Some(self.spool.clone()),
            archive: self.archive.open(),
            ..usual
        }
    }
}

/// Works until SIGTERM or Ctrl-C; then checkpoints, hands back and ends within 20 seconds.
pub(crate) async fn run(args: Args) -> anyhow::Result<Done> {
    log::to_stderr(tracing::Level::INFO);
    let token = args.server.token()?;
    let client = HttpLeaseClient::new(&args.server.server, token.as_deref())?;
    let config = args.config();
    tracing::info!(
        worker.name = config.name,
        worker.slots = config.slots,
        server.address = args.server.server,
        "worker started"
    );
    let shutdown = CancellationToken::new();
    let engine = core_engine(config.slots);
    let work = lease_loop::run(client, engine, config, shutdown.clone());
    tokio::pin!(work);
    let ended = tokio::select! {
        ended = &mut work => ended,
        interrupted = interrupt::wait() => {
            interrupted?;
            shutdown.cancel();
            work.await
        }
    };
    ended.context("the worker stopped")?;
    Ok(Done::Complete)
}
