//! `granary cancel`, `pause`, `resume` and `retry`: steer a sweep.

use granary_api::id::SweepId;

use crate::api_client::ServerArgs;
use crate::failure::Done;
use crate::output;

/// Which sweep.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The sweep's id.
    sweep: SweepId,
    #[command(flatten)]
    server: ServerArgs,
    /// Print the server's answer as JSON.
    #[arg(long)]
    json: bool,
}

/// Does to the sweep what the route called `way` does.
pub(crate) async fn run(args: Args, way: &str) -> anyhow::Result<Done> {
    let steered = args.server.client()?.steer(args.sweep, way).await?;
    if args.json {
        output::json(&steered)?;
    } else {
        let state = serde_json::to_value(steered.state)?;
        let state = state.as_str().unwrap_or_default();
        output::line(&format!("{state}, {} jobs moved", steered.jobs))?;
    }
    Ok(Done::Complete)
}
