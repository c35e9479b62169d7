//! Serving: a socket, the routes, the reaper, the planner, and one signal that ends them all.

use std::net::SocketAddr;
use std::time::Duration;

use axum::Router;
use tokio::net::TcpListener;
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;

use crate::routes::app;
use crate::store::{Store, StoreError};
use crate::{planner, reaper};

/// How long requests under way may take once the server is told to stop.
const GRACE: Duration = Duration::from_secs(5);

/// Why a server did not start, or stopped.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// Whoever can reach the address could steer the server.
    #[error(
        "{0} is not a loopback address and there is no token: make one first, or listen on 127.0.0.1"
    )]
    Open(SocketAddr),
    /// The address cannot be had.
    #[error("cannot listen on {address}")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// Why.
        source: std::io::Error,
    },
    /// The socket failed.
    #[error("the socket failed")]
    Socket(#[source] std::io::Error),
    /// The store failed.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// A server that listens and does not answer yet.
pub struct Server {
    store: Store,
    listener: TcpListener,
    address: SocketAddr,
}

impl Server {
    /// Listens where the store's configuration says; refuses an open address without tokens.
    pub async fn bind(store: Store) -> Result<Self, ServeError> {
        let asked = store.config().listen;
        if !asked.ip().is_loopback() && !store.token_any().await? {
            return Err(ServeError::Open(asked));
        }
        let failed = |source| ServeError::Listen {
            address: asked,
            source,
        };
        let listener = TcpListener::bind(asked).await.map_err(failed)?;
        let address = listener.local_addr().map_err(ServeError::Socket)?;
        store.lock_announce(&format!("a server at http://{address}"))?;
        Ok(Self {
            store,
            listener,
            address,
        })
    }

    /// Where it listens: the port that was given, if port 0 was asked for.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Answers until `shutdown`, then lets what is under way finish for a few seconds.
    pub async fn run(
        self,
        page: Option<Router>,
        shutdown: CancellationToken,
    ) -> Result<(), ServeError> {
        let mut background = background(&self.store, &shutdown);
        let router = app(self.store.clone(), shutdown.clone(), page);
        let stop = shutdown.clone();
        let graceful = axum::serve(self.listener, router)
            .with_graceful_shutdown(async move { stop.cancelled().await });
        let served = tokio::select! {
            served = graceful => served,
            () = grace_is_over(&shutdown) => Ok(()),
        };
        shutdown.cancel();
        while background.join_next().await.is_some() {}
        served.map_err(ServeError::Socket)
    }
}

async fn grace_is_over(shutdown: &CancellationToken) {
    shutdown.cancelled().await;
    tokio::time::sleep(GRACE).await;
}

/// Starts what the store needs done now and then, until `shutdown`; `granary run` needs it without a socket.
#[must_use]
pub fn background(store: &Store, shutdown: &CancellationToken) -> JoinSet<()> {
    let mut tasks = JoinSet::new();
    tasks.spawn(reaper::run(store.clone(), shutdown.clone()));
    tasks.spawn(planner::run(store.clone(), shutdown.clone()));
    tasks
}
