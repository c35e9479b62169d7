//! Log lines on standard error.

use std::io::IsTerminal;

use tracing::Level;
use tracing_subscriber::fmt;

/// Shows what is at least as grave as `level`; colors only on a terminal.
pub(crate) fn to_stderr(level: Level) {
    let logs = fmt()
        .with_max_level(level)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .with_target(false);
    // An error means that somebody listens already.
    let _ = logs.try_init();
}
