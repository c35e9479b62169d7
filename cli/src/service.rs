//! A store, its reaper and its workers, in this process: what `serve`, `run` and `demo` share.

use std::num::NonZero;
use std::time::Duration;

use anyhow::Context;
use granary_server::{Config, Store};
use granary_worker::{config as worker, execute::core_engine, lease_loop};
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;

use crate::api_client::ApiClient;
use crate::direct::DirectLeaseClient;

/// How long workers in this process wait for work before they ask again.
const POLL: Duration = Duration::from_secs(20);

/// The threads that the machine can run at once.
pub(crate) fn all_cores() -> usize {
    std::thread::available_parallelism().map_or(1, NonZero::get)
}

/// An open data directory and what runs around it.
pub(crate) struct Service {
    /// The store.
    pub(crate) store: Store,
    /// The word to stop.
    pub(crate) shutdown: CancellationToken,
    tasks: JoinSet<anyhow::Result<()>>,
}

impl Service {
    /// Opens the data directory of `config` and looks after its leases; `holder` is told to whoever comes second.
    ///
    /// # Errors
    /// If another process holds the directory, or it cannot be opened.
    pub(crate) async fn open(config: Config, holder: &str) -> anyhow::Result<Self> {
        let place = config.data.display().to_string();
        let store = Store::open(config, holder).await;
        let store = store.with_context(|| format!("cannot use the data directory {place}"))?;
        let mut service = Self {
            store,
            shutdown: CancellationToken::new(),
            tasks: JoinSet::new(),
        };
        let reaper = granary_server::reaper::run(service.store.clone(), service.shutdown.clone());
        service.tasks.spawn(async {
            reaper.await;
            Ok(())
        });
        Ok(service)
    }

    /// Adds `slots` engine threads, each with its own lease.
    pub(crate) fn work(&mut self, slots: usize) {
        if slots == 0 {
            return;
        }
        let config = worker::Config {
            poll: POLL,
            ..worker::Config::new(slots)
        };
        let client = DirectLeaseClient::new(self.store.clone());
        let run = lease_loop::run(client, core_engine(), config, self.shutdown.clone());
        self.tasks.spawn(run);
    }

    /// Adds a task that ends after the word to stop.
    pub(crate) fn spawn(
        &mut self,
        task: impl Future<Output = anyhow::Result<()>> + Send + 'static,
    ) {
        self.tasks.spawn(task);
    }

    /// The public API of this store, without a socket.
    pub(crate) fn client(&self) -> ApiClient {
        ApiClient::Local(granary_server::app(self.store.clone()))
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
        self.store.close().await;
        first
    }
}
