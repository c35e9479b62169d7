//! `granary serve`: the server, with workers in its own process.

use std::net::SocketAddr;
use std::path::PathBuf;

use anyhow::Context;
use granary_server::Config;
use tokio::net::TcpListener;

use crate::failure::Done;
use crate::service::{Service, all_cores};
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
    /// Directory of the database and the artifacts.
    #[arg(
        long,
        env = "GRANARY_DATA",
        default_value = ".granary",
        value_name = "DIR"
    )]
    data: PathBuf,
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
}

/// Serves until SIGTERM or Ctrl-C.
pub(crate) async fn run(args: Args) -> anyhow::Result<Done> {
    log::to_stderr(tracing::Level::INFO);
    let config = Config {
        listen: args.listen,
        hosts: args.hosts,
        ..Config::new(args.data)
    };
    let (mut service, address) = start(config, args.workers.unwrap_or_else(all_cores)).await?;
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
pub(crate) async fn start(config: Config, slots: usize) -> anyhow::Result<(Service, SocketAddr)> {
    let listen = config.listen;
    let holder = format!("a server that starts, process {}", std::process::id());
    let mut service = Service::open(config, &holder).await?;
    let listener = TcpListener::bind(listen)
        .await
        .with_context(|| format!("cannot listen at {listen}"))?;
    let address = listener.local_addr()?;
    service.store.lock_announce(&format!("http://{address}"))?;
    let app = granary_server::app(service.store.clone());
    let shutdown = service.shutdown.clone();
    service.spawn(async move {
        let serve = axum::serve(listener, app).with_graceful_shutdown(shutdown.cancelled_owned());
        serve.await.context("the server stopped")
    });
    service.work(slots);
    Ok((service, address))
}
