//! `granary serve`: the server, with workers in its own process.

use std::net::SocketAddr;
use std::time::Duration;

use granary_server::Config;
use granary_worker::archive::Archive;

use crate::failure::Done;
use crate::service::{Place, Service, all_cores};
use crate::{interrupt, log};

/// Serve the API and the page; compute in the same process.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Address and port; port 0 takes a free one. Off loopback a token is needed.
    #[arg(
        long,
        env = "GRANARY_LISTEN",
        default_value = "127.0.0.1:8000",
        value_name = "ADDR"
    )]
    listen: SocketAddr,
    #[command(flatten)]
    place: Place,
    /// Engine threads in this process; 0 leaves all work to `granary worker`.
    #[arg(long, env = "GRANARY_WORKERS", value_name = "N")]
    workers: Option<usize>,
    /// Another host name under which requests are accepted; may be repeated.
    #[arg(
        long = "host",
        env = "GRANARY_HOSTS",
        value_name = "NAME",
        value_delimiter = ','
    )]
    hosts: Vec<String>,
    /// Seconds without a heartbeat after which a worker's jobs are given to another.
    #[arg(long, env = "GRANARY_LEASE_TERM_S", value_name = "SECONDS", default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..=3600))]
    lease_term: u32,
}

/// Serves until SIGTERM or Ctrl-C.
pub(crate) async fn run(args: Args) -> anyhow::Result<Done> {
    log::to_stderr(tracing::Level::INFO);
    let config = Config {
        listen: args.listen,
        hosts: args.hosts,
        lease_term: Duration::from_secs(args.lease_term.into()),
        heartbeat: Duration::from_secs(args.lease_term.into()) / 3,
        ..Config::new(args.place.data)
    };
    let slots = args.workers.unwrap_or_else(all_cores);
    let archive = args.place.archive.open();
    let (mut service, address) = start(config, archive, slots).await?;
    eprintln!("granary serves at http://{address}");
    let ended = tokio::select! {
        interrupted = interrupt::wait() => interrupted,
        ended = service.watch() => ended,
    };
    service.stop().await?;
    ended.map(|()| Done::Complete)
}

/// Opens the data directory, listens, and sets `slots` engine threads to work.
///
/// # Errors
/// If the directory is held, the port taken, or the address open to others without a token.
pub(crate) async fn start(
    config: Config,
    archive: Option<Archive>,
    slots: usize,
) -> anyhow::Result<(Service, SocketAddr)> {
    let mut service = Service::open(config, archive, "a server that starts").await?;
    let address = service.listen().await?;
    service.work(slots);
    Ok((service, address))
}
