//! Log lines on standard error.

use tracing::Level;
use tracing_subscriber::fmt;

/// The setting that overrules a command's own level: `error`, `warn`, `info`, `debug` or `trace`.
const SETTING: &str = "GRANARY_LOG";

/// Shows what is at least as grave as `level`, or as the setting says.
pub(crate) fn to_stderr(level: Level) {
    let asked = std::env::var(SETTING).ok();
    let level = asked.and_then(|text| text.parse().ok()).unwrap_or(level);
    let logs = fmt()
        .with_max_level(level)
        .with_writer(std::io::stderr)
        .with_ansi(false)
        .with_target(false);
    // An error means that somebody listens already.
    let _ = logs.try_init();
}
