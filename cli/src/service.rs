//! A store, its reaper and its workers, in this process: what `serve`, `run` and `demo` share.

use std::net::SocketAddr;
use std::num::NonZero;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use anyhow::Context;
use granary_api::token::Scope;
use granary_core::stage::StageSpec;
use granary_server::{Archived, Config, ServeError, Server, Store};
use granary_worker::archive::Archive;
use granary_worker::{config as worker, execute::core_engine, lease_loop};
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;

use crate::api_client::ApiClient;
use crate::direct::DirectLeaseClient;
use crate::page;

/// How long workers in this process wait for work before they ask again.
const POLL: Duration = Duration::from_secs(20);

/// How the names of workers begin that live in the process of their store.
const IN_PROCESS: &str = "in-process/";

/// The threads that the machine can run at once.
pub(crate) fn all_cores() -> usize {
    std::thread::available_parallelism().map_or(1, NonZero::get)
}

/// Where a process that computes by itself keeps what it knows.
#[derive(Debug, clap::Args)]
pub(crate) struct Place {
    /// Directory of the database and the artifacts.
    #[arg(
        long,
        env = "GRANARY_DATA",
        default_value = ".granary",
        value_name = "DIR"
    )]
    pub(crate) data: PathBuf,
    #[command(flatten)]
    pub(crate) archive: ArchiveArgs,
}

/// What was computed before, on whatever server.
#[derive(Debug, clap::Args)]
pub(crate) struct ArchiveArgs {
    /// Directory where finished stages are kept, and looked for before they are computed.
    #[arg(long, env = "GRANARY_ARCHIVE", value_name = "DIR")]
    archive: Option<PathBuf>,
}

impl ArchiveArgs {
    pub(crate) fn open(&self) -> Option<Archive> {
        self.archive.clone().map(Archive::new)
    }
}

/// The same archive, for sweeps as they are submitted.
#[derive(Debug)]
struct Known(Archive);

impl granary_server::Archive for Known {
    fn find(&self, spec: &StageSpec) -> Option<Archived> {
        let kept = self.0.outcome(spec)?;
        Some(Archived {
            outcome: kept.outcome,
            engine_version: kept.engine_version,
            wall_s: kept.wall_s,
            cpu_s: kept.cpu_s,
        })
    }
}

/// An open data directory and what runs around it.
pub(crate) struct Service {
    /// The store.
    pub(crate) store: Store,
    /// What its workers need not compute.
    archive: Option<Archive>,
    shutdown: CancellationToken,
    tasks: JoinSet<anyhow::Result<()>>,
    /// The name of the token of this process, if the store asks for tokens.
    token: Option<String>,
}

/// Opens the data directory at `place`, lets `work` use it, and stops whatever runs around it, however that ended.
///
/// # Errors
/// Those of `work` first, then those of opening and stopping.
pub(crate) async fn with<T>(
    place: &Place,
    purpose: &str,
    work: impl AsyncFnOnce(&mut Service) -> anyhow::Result<T>,
) -> anyhow::Result<T> {
    let config = Config::new(&place.data);
    let mut service = Service::open(config, place.archive.open(), purpose).await?;
    let done = work(&mut service).await;
    let stopped = service.stop().await;
    let done = done?;
    stopped?;
    Ok(done)
}

impl Service {
    /// Opens the data directory of `config`, to compute nothing that `archive` holds; `purpose` is told to whoever comes second.
    ///
    /// # Errors
    /// If another process holds the directory, or it cannot be opened.
    pub(crate) async fn open(
        config: Config,
        archive: Option<Archive>,
        purpose: &str,
    ) -> anyhow::Result<Self> {
        let known = archive.clone().map(Known);
        let config = Config {
            archive: known.map(|known| Arc::new(known) as Arc<dyn granary_server::Archive>),
            ..config
        };
        let place = config.data.display().to_string();
        let holder = format!("{purpose}, process {}", std::process::id());
        let store = Store::open(config, &holder).await;
        let store = store.with_context(|| format!("cannot use the data directory {place}"))?;
        Ok(Self {
            store,
            archive,
            shutdown: CancellationToken::new(),
            tasks: JoinSet::new(),
            token: None,
        })
    }

    /// Serves at the configured address, and looks after leases; where that is in the end.
    ///
    /// # Errors
    /// If the address cannot be had, or is open to others and there is no token.
    pub(crate) async fn listen(&mut self) -> anyhow::Result<SocketAddr> {
        let server = Server::bind(self.store.clone()).await.map_err(explain)?;
        self.reap_own().await?;
        let address = server.address();
        let shutdown = self.shutdown.clone();
        self.tasks
            .spawn(async move { Ok(server.run(Some(page::router()), shutdown).await?) });
        Ok(address)
    }

    /// Looks after leases without a socket.
    ///
    /// # Errors
    /// If the store fails.
    pub(crate) async fn stay_alone(&mut self) -> anyhow::Result<()> {
        self.reap_own().await?;
        let background = granary_server::background(&self.store, &self.shutdown);
        self.tasks.spawn(async {
            background.join_all().await;
            Ok(())
        });
        Ok(())
    }

    /// Takes back the leases of earlier processes that held this directory: their workers died with them.
    async fn reap_own(&self) -> anyhow::Result<()> {
        for (lease, beat) in self.store.lease_beats_of(IN_PROCESS).await? {
            self.store.lease_reap(lease, beat).await?;
        }
        Ok(())
    }

    /// Adds `slots` engine threads, each with its own lease; those without work help the others.
    pub(crate) fn work(&mut self, slots: usize) {
        if slots == 0 {
            return;
        }
        let usual = worker::Config::new(slots);
        let config = worker::Config {
            name: format!("{IN_PROCESS}{}", usual.name),
            poll: POLL,
            archive: self.archive.clone(),
            ..usual
        };
        let client = DirectLeaseClient::new(self.store.clone());
        let engine = core_engine(slots);
        let run = lease_loop::run(client, engine, config, self.shutdown.clone());
        self.tasks.spawn(run);
    }

    /// The public API of this store, without a socket.
    ///
    /// # Errors
    /// If the store fails.
    pub(crate) async fn client(&mut self) -> anyhow::Result<ApiClient> {
        let router = granary_server::app(self.store.clone(), self.shutdown.clone(), None);
        let mut token = None;
        if self.store.token_any().await? {
            let name = format!("process {}", std::process::id());
            token = Some(self.store.token_create(&name, &[Scope::Admin]).await?);
            self.token = Some(name);
        }
        Ok(ApiClient::Local { router, token })
    }

    /// Returns when a part of the service has ended, which none should before the word to stop.
    ///
    /// # Errors
    /// That part's.
    pub(crate) async fn watch(&mut self) -> anyhow::Result<()> {
        match self.tasks.join_next().await {
            Some(part) => part.context("a part of the service panicked")?,
            None => Ok(()),
        }
    }

    /// Gives the word to stop; jobs are handed back with checkpoints, then the database is closed.
    ///
    /// # Errors
    /// The first of any part.
    pub(crate) async fn stop(mut self) -> anyhow::Result<()> {
        self.shutdown.cancel();
        let mut first = Ok(());
        while let Some(part) = self.tasks.join_next().await {
            let part = part.context("a part of the service panicked").flatten();
            first = first.and(part);
        }
        if let Some(name) = &self.token {
            self.store.token_revoke(name).await?;
        }
        self.store.close().await;
        first
    }
}

/// What went wrong, with the next command where there is one.
fn explain(error: ServeError) -> anyhow::Error {
    let open = matches!(error, ServeError::Open(_));
    let error = anyhow::Error::from(error);
    if open {
        error.context("make a token: granary token create --scope worker --scope submit")
    } else {
        error
    }
}
