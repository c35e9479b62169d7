//! `granary sweeps`: what a server was asked for.

use granary_api::sweep::Sweep;
use granary_api::table::Page;
use serde_json::json;

use crate::api_client::{ServerArgs, encode};
use crate::failure::Done;
use crate::output;
use crate::table::Table;

/// List the sweeps of a server, the latest first.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    server: ServerArgs,
    /// Print them as JSON.
    #[arg(long)]
    json: bool,
}

/// Lists them, page by page.
pub(crate) async fn run(args: Args) -> anyhow::Result<Done> {
    let client = args.server.client()?;
    let mut sweeps: Vec<Sweep> = vec![];
    let mut query = vec![("limit".to_owned(), "100".to_owned())];
    loop {
        let page: Page<Sweep> = client
            .get_json(&format!("/sweeps?{}", encode(&query)))
            .await?;
        sweeps.extend(page.items);
        let Some(next) = page.next else { break };
        query.truncate(1);
        query.push(("cursor".to_owned(), next));
    }
    if args.json {
        output::json(&json!({"items": sweeps, "next": null}))?;
        return Ok(Done::Complete);
    }
    let mut table = Table::new([
        "sweep", "state", "done", "points", "failed", "created", "name",
    ]);
    for sweep in sweeps {
        let state = serde_json::to_value(sweep.state)?;
        table.push(vec![
            sweep.sweep.to_string(),
            state.as_str().unwrap_or_default().to_owned(),
            sweep.points.done.to_string(),
            sweep.points.total.to_string(),
            sweep.points.failed.to_string(),
            sweep.created_at,
            sweep.name,
        ]);
    }
    output::bytes(table.render().as_bytes())?;
    Ok(Done::Complete)
}
