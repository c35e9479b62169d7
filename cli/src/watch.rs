//! `granary watch`: follows a sweep to its end.

use std::time::Duration;

use anyhow::bail;
use granary_api::id::SweepId;
use granary_api::sweep::{Sweep, SweepState};
use tokio::time::Instant;

use crate::api_client::{ApiClient, ServerArgs};
use crate::failure::{Done, Failure};
use crate::progress::Progress;
use crate::{interrupt, output};

/// The shortest and the longest time between two questions to the server; a long sweep is asked after less often.
const PAUSE: (Duration, Duration) = (Duration::from_millis(100), Duration::from_secs(2));
/// How long a server that restarts may be away.
const PATIENCE: Duration = Duration::from_secs(30);

/// Follow a sweep until every point has come to its end.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The sweep's id.
    sweep: SweepId,
    #[command(flatten)]
    server: ServerArgs,
    /// Print the sweep as JSON at the end.
    #[arg(long)]
    json: bool,
}

/// Follows; the exit code tells whether all points have results.
pub(crate) async fn run(args: Args) -> anyhow::Result<Done> {
    let client = args.server.client()?;
    let done = until_interrupted(&client, args.sweep).await?;
    if args.json && done != Done::Interrupted {
        output::json(&client.sweep(args.sweep).await?)?;
    }
    Ok(done)
}

/// Follows `sweep` to its end, or until the user has seen enough; the sweep goes on without a watcher.
pub(crate) async fn until_interrupted(client: &ApiClient, sweep: SweepId) -> anyhow::Result<Done> {
    tokio::select! {
        interrupted = interrupt::wait() => {
            interrupted?;
            eprintln!("the sweep goes on; look again with: granary watch {sweep}");
            Ok(Done::Interrupted)
        }
        sweep = follow(client, sweep) => Ok(verdict(&sweep?)),
    }
}

/// Follows `sweep` to its end, after the pilot that it may wait for, through restarts of its server.
pub(crate) async fn follow(client: &ApiClient, sweep: SweepId) -> anyhow::Result<Sweep> {
    let pilot = client.sweep(sweep).await?.accuracy;
    if let Some(accuracy) = pilot.filter(|accuracy| accuracy.choice.is_none()) {
        let pilot = follow_to_end(client, accuracy.pilot, "pilot: ").await?;
        if pilot.state == SweepState::Cancelled {
            bail!(
                "its pilot was cancelled\n  go on with it: granary resume {}",
                pilot.sweep
            );
        }
        choice(client, sweep).await?;
    }
    follow_to_end(client, sweep, "").await
}

/// Tells what the pilot of `sweep` has chosen, once the server has looked.
async fn choice(client: &ApiClient, sweep: SweepId) -> anyhow::Result<()> {
    let asked = Instant::now();
    while asked.elapsed() < PATIENCE {
        let accuracy = client.sweep(sweep).await?.accuracy;
        let Some(choice) = accuracy.and_then(|accuracy| accuracy.choice) else {
            tokio::time::sleep(PAUSE.0).await;
            continue;
        };
        eprint!("chosen: {}", choice.setting);
        if let Some(cost) = choice.relative_cost {
            eprint!("; {:.0} % of the time of the reference", 100.0 * cost);
        }
        match &choice.reason {
            Some(reason) => eprintln!(": {reason}"),
            None => eprintln!(),
        }
        return Ok(());
    }
    bail!("the pilot has ended, and the server has chosen no settings by it")
}

async fn follow_to_end(
    client: &ApiClient,
    sweep: SweepId,
    about: &'static str,
) -> anyhow::Result<Sweep> {
    let mut progress = Progress::new(about);
    let start = Instant::now();
    let mut heard = start;
    loop {
        let sweep = match client.sweep(sweep).await {
            Ok(sweep) => sweep,
            Err(error) if is_away(&error) && heard.elapsed() < PATIENCE => {
                tokio::time::sleep(PAUSE.0).await;
                continue;
            }
            Err(error) => return Err(error),
        };
        heard = Instant::now();
        progress.show(&sweep);
        if matches!(sweep.state, SweepState::Finished | SweepState::Cancelled) {
            progress.finish(&sweep);
            return Ok(sweep);
        }
        tokio::time::sleep((start.elapsed() / 20).clamp(PAUSE.0, PAUSE.1)).await;
    }
}

fn is_away(error: &anyhow::Error) -> bool {
    matches!(error.downcast_ref(), Some(Failure::Unreachable { .. }))
}

/// Whether every point of a finished sweep has results.
pub(crate) fn verdict(sweep: &Sweep) -> Done {
    if sweep.points.done == sweep.points.total {
        Done::Complete
    } else {
        Done::Incomplete
    }
}
