//! The planner: lets sweeps go on whose pilots have decided.

use tokio_util::sync::CancellationToken;

use crate::store::{Store, StoreError};

/// Looks once; how many sweeps went on.
async fn look(store: &Store) -> Result<usize, StoreError> {
    let waiting = store.pilot_ended().await?;
    for sweep in &waiting {
        store.pilot_settle(sweep).await?;
    }
    Ok(waiting.len())
}

/// Looks whenever something has changed, until `shutdown`.
pub(crate) async fn run(store: Store, shutdown: CancellationToken) {
    let mut changes = store.subscribe();
    loop {
        if let Err(error) = look(&store).await {
            tracing::error!(%error, cause = ?std::error::Error::source(&error), "a pilot's choice was not made");
        }
        tokio::select! {
            () = shutdown.cancelled() => return,
            changed = changes.changed() => if changed.is_err() { return },
        }
    }
}
