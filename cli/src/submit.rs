//! `granary submit`: queues a sweep at a server.

use std::path::PathBuf;

use granary_api::sweep::Submitted;

use crate::api_client::ServerArgs;
use crate::failure::Done;
use crate::output;
use crate::progress::duration;
use crate::spec_file::SpecFile;
use crate::watch;

/// Submit a sweep; prints its id.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The spec, TOML or JSON; `-` is standard input.
    spec: PathBuf,
    #[command(flatten)]
    server: ServerArgs,
    /// Wait for the results, with progress on standard error.
    #[arg(long, conflicts_with = "dry_run")]
    wait: bool,
    /// Only say what it would cost; nothing is queued.
    #[arg(long)]
    dry_run: bool,
    /// Print the server's answer as JSON.
    #[arg(long)]
    json: bool,
}

/// Submits, and waits if asked to.
pub(crate) async fn run(args: Args) -> anyhow::Result<Done> {
    let spec = SpecFile::read(&args.spec)?;
    let client = args.server.client()?;
    let submitted = client.submit(&spec, args.dry_run).await?;
    announce(&submitted);
    if args.json {
        output::json(&submitted)?;
    } else if let Some(sweep) = submitted.sweep {
        output::line(&sweep.to_string())?;
    }
    match submitted.sweep {
        Some(sweep) if args.wait => watch::until_interrupted(&client, sweep).await,
        _ => Ok(Done::Complete),
    }
}

/// Says what was queued, what is there already and what it will cost.
pub(crate) fn announce(submitted: &Submitted) {
    for warning in &submitted.warnings {
        eprintln!("warning: {warning}");
    }
    let cost = &submitted.predicted;
    eprint!("{}", submitted.message);
    if cost.core_seconds > 0.0 {
        let estimate = if cost.basis == "measured" {
            "measured speed"
        } else {
            "rough estimate"
        };
        eprint!("; {} on one core ({estimate})", duration(cost.core_seconds));
    }
    eprintln!();
}
