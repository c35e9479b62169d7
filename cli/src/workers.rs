//! `granary workers`: who computes for a server.

use granary_api::job::WorkerRow;
use granary_api::table::Page;

use crate::api_client::ServerArgs;
use crate::failure::Done;
use crate::output;
use crate::table::Table;

/// List the workers that a server has heard of.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    server: ServerArgs,
    /// Print the server's answer as JSON.
    #[arg(long)]
    json: bool,
}

/// Lists them.
pub(crate) async fn run(args: Args) -> anyhow::Result<Done> {
    let client = args.server.client()?;
    let page: Page<WorkerRow> = client.get_json("/workers").await?;
    if args.json {
        output::json(&page)?;
        return Ok(Done::Complete);
    }
    let mut table = Table::new(["worker", "state", "leased", "done", "release", "last seen"]);
    for row in page.items {
        table.push(vec![
            row.worker.to_string(),
            row.state,
            row.leased.to_string(),
            row.done.to_string(),
            row.engine_version,
            row.last_seen,
        ]);
    }
    output::bytes(table.render().as_bytes())?;
    Ok(Done::Complete)
}
