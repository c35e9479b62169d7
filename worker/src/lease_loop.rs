//! The runner: take → execute → report, once per slot, until the word to stop.

use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, bail};
use granary_api::id::WorkerId;
use tokio::sync::Semaphore;
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;

use crate::config::Config;
use crate::execute::Engine;
use crate::lease_client::LeaseClient;
use crate::report::deliver;
use crate::slot::Slot;
use crate::spool::Spool;

/// Runs every slot until `shutdown`; then each hands its jobs back within the grace.
///
/// # Errors
/// If the server refuses this worker, as one with a wrong token.
pub async fn run<C: LeaseClient>(
    client: C,
    engine: Engine,
    config: Config,
    shutdown: CancellationToken,
) -> anyhow::Result<()> {
    let spool = Spool::new(config.spool.clone());
    let mut slots = JoinSet::new();
    for number in 1..=config.slots.max(1) {
        let slot = Slot {
            client: client.clone(),
            engine: Arc::clone(&engine),
            worker: WorkerId(format!("{}/{number}", config.name)),
            config: config.clone(),
            shutdown: shutdown.clone(),
            spool: spool.clone(),
            thread: Arc::new(Semaphore::new(1)),
        };
        slots.spawn(slot.run());
    }
    let redelivery = tokio::spawn(redeliver(client, spool));
    let answer = join(&mut slots, &shutdown, config.grace).await;
    redelivery.abort();
    answer
}

/// Waits for all slots; after the word to stop for `grace` at most.
async fn join(
    slots: &mut JoinSet<anyhow::Result<()>>,
    shutdown: &CancellationToken,
    grace: Duration,
) -> anyhow::Result<()> {
    let late = async {
        shutdown.cancelled().await;
        tokio::time::sleep(grace).await;
    };
    tokio::pin!(late);
    loop {
        tokio::select! {
            slot = slots.join_next() => match slot {
                Some(slot) => slot.context("a slot panicked")??,
                None => return Ok(()),
            },
            () = &mut late => {
                slots.abort_all();
                bail!("not all jobs could be handed back within {} s", grace.as_secs());
            }
        }
    }
}

/// Delivers what an earlier worker left in the spool.
async fn redeliver<C: LeaseClient>(client: C, spool: Spool) {
    for report in spool.pending().await {
        let lease = report.lease;
        match deliver(&client, &spool, report).await {
            Ok(()) => tracing::info!(lease.id = %lease, "spooled report delivered"),
            Err(error) => {
                tracing::info!(lease.id = %lease, error = %error, "spooled report is not wanted");
            }
        }
    }
}
