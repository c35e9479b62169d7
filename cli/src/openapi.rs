//! `granary openapi`: the API's document, from the same table as the routes.

use crate::failure::Done;
use crate::output;

/// Print the OpenAPI document of the server's API.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {}

/// Prints it; needs no server.
pub(crate) fn run(_args: &Args) -> anyhow::Result<Done> {
    let document = serde_json::to_string_pretty(&granary_server::openapi())?;
    output::line(&document)?;
    Ok(Done::Complete)
}
