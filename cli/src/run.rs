//! `granary run`: computes one sweep with no server: the same store, planner, runner and cache, without the socket.

use std::path::PathBuf;

use granary_api::id::SweepId;
use granary_api::sweep::{Sweep, SweepState};
use granary_api::table::{PointRow, SetRow};
use serde_json::json;

use crate::api_client::ApiClient;
use crate::failure::Done;
use crate::figures::FigureArgs;
use crate::service::{self, Place, Service, all_cores};
use crate::spec_file::SpecFile;
use crate::{interrupt, log, output, submit, table, watch};

/// Compute a sweep on this machine and print its table.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The spec, TOML or JSON; `-` is standard input.
    #[arg(required_unless_present = "figure", conflicts_with = "figure")]
    spec: Option<PathBuf>,
    #[command(flatten)]
    figure: FigureArgs,
    /// Print points and sets as JSON; of a figure, `granary figures NAME --spec | granary run - --json` does.
    #[arg(long, conflicts_with = "figure")]
    json: bool,
    /// Engine threads; all cores by default.
    #[arg(long, env = "GRANARY_THREADS", value_name = "N")]
    threads: Option<usize>,
    #[command(flatten)]
    place: Place,
}

/// Computes, or goes on where an interrupted run stopped.
pub(crate) async fn run(args: Args) -> anyhow::Result<Done> {
    log::to_stderr(tracing::Level::WARN);
    let spec = match (&args.spec, args.figure.spec()?) {
        (_, Some(spec)) => spec,
        (Some(path), None) => SpecFile::read(path)?,
        (None, None) => anyhow::bail!("there is neither a spec nor a figure"),
    };
    let work = async |service: &mut Service| whole(service, &args, &spec).await;
    service::with(&args.place, "granary run", work).await
}

async fn whole(service: &mut Service, args: &Args, spec: &SpecFile) -> anyhow::Result<Done> {
    let client = service.client().await?;
    let Some(finished) = compute(service, &client, spec, args.threads).await? else {
        return Ok(Done::Interrupted);
    };
    print(&client, finished.sweep, args.json).await?;
    args.figure.draw(&client, finished.sweep).await?;
    Ok(watch::verdict(&finished))
}

/// Computes a sweep in this process; none if the user interrupted it.
pub(crate) async fn compute(
    service: &mut Service,
    client: &ApiClient,
    spec: &SpecFile,
    threads: Option<usize>,
) -> anyhow::Result<Option<Sweep>> {
    let submitted = client.submit(spec, false).await?;
    submit::announce(&submitted);
    let Some(sweep) = submitted.sweep else {
        anyhow::bail!("the planner gave the sweep no id");
    };
    if client.sweep(sweep).await?.state == SweepState::Paused {
        client.steer(sweep, "resume").await?;
    }
    service.stay_alone().await?;
    service.work(threads.unwrap_or_else(all_cores));
    tokio::select! {
        finished = watch::follow(client, sweep) => finished.map(Some),
        ended = service.watch() => {
            ended?;
            anyhow::bail!("the engine threads ended before the sweep");
        }
        interrupted = interrupt::wait() => {
            interrupted?;
            // Another sweep run in this directory should not share the machine with this one.
            client.steer(sweep, "pause").await?;
            eprintln!("interrupted; the same command goes on from here");
            Ok(None)
        }
    }
}

/// Prints both tables as JSON, or the one that says most to people.
async fn print(client: &ApiClient, sweep: SweepId, as_json: bool) -> anyhow::Result<()> {
    let points: Vec<PointRow> = client.rows(sweep, "points", &[]).await?;
    let sets: Vec<SetRow> = client.rows(sweep, "sets", &[]).await?;
    if as_json {
        return output::json(&json!({
            "points": {"items": points, "next": null},
            "sets": {"items": sets, "next": null},
        }));
    }
    let failed: Vec<PointRow> = points
        .iter()
        .filter(|row| row.failure.is_some())
        .cloned()
        .collect();
    if !failed.is_empty() {
        output::bytes(table::points(&failed).render().as_bytes())?;
    }
    let whole = if sets.is_empty() {
        table::points(&points)
    } else {
        table::sets(&sets)
    };
    output::bytes(whole.render().as_bytes())
}
