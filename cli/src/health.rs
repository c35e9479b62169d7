//! `granary health`: whether a server answers, for health checks of containers.

use serde_json::Value;

use crate::api_client::ServerArgs;
use crate::failure::Done;
use crate::output;

/// Say whether a server and its database answer; needs no token.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    server: ServerArgs,
}

/// Prints the server's answer as JSON.
pub(crate) async fn run(args: Args) -> anyhow::Result<Done> {
    let answer: Value = args.server.client()?.get_json("/healthz").await?;
    output::json(&answer)?;
    Ok(Done::Complete)
}
