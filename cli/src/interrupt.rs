//! The user's word to stop: Ctrl-C, or the system's SIGTERM.

use tokio::signal::unix::{SignalKind, signal};

/// Returns at the first of the two.
///
/// # Errors
/// If the system lets no handler be set.
pub(crate) async fn wait() -> anyhow::Result<()> {
    let mut terminate = signal(SignalKind::terminate())?;
    let mut interrupt = signal(SignalKind::interrupt())?;
    tokio::select! {
        _ = terminate.recv() => {}
        _ = interrupt.recv() => {}
    }
    Ok(())
}
