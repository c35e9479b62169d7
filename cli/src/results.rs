//! `granary results`: a sweep's tables.

use granary_api::id::SweepId;
use granary_api::table::{PointRow, SetRow};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::json;

use crate::api_client::{ApiClient, ServerArgs, encode};
use crate::failure::Done;
use crate::output;
use crate::table::{self, Table};

/// Print the points or the sets of a sweep.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The sweep's id.
    sweep: SweepId,
    #[command(flatten)]
    server: ServerArgs,
    /// Sets (gain, fidelity, means) instead of points.
    #[arg(long)]
    sets: bool,
    /// How to print it; CSV comes as the server writes it.
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
    /// The same as `--format json`.
    #[arg(long, conflicts_with = "format")]
    json: bool,
    /// Only rows for which this holds, such as `friction_coefficient>=0.3`; may be repeated.
    #[arg(long = "where", value_name = "CONDITION")]
    conditions: Vec<String>,
    /// Order by this column, from the largest with `-` before it: `--sort=-gain`.
    #[arg(long, value_name = "COLUMN", allow_hyphen_values = true)]
    sort: Option<String>,
}

/// The shapes that a table can be printed in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    Table,
    Json,
    Csv,
}

impl Args {
    fn query(&self) -> Vec<(String, String)> {
        let conditions = self.conditions.iter().map(|c| ("where", c));
        let all = conditions.chain(self.sort.as_ref().map(|s| ("sort", s)));
        all.map(|(name, value)| (name.to_owned(), value.clone()))
            .collect()
    }
}

/// Prints the table.
pub(crate) async fn run(args: Args) -> anyhow::Result<Done> {
    let client = args.server.client()?;
    if args.sets {
        print::<SetRow>(&client, &args, "sets", table::sets).await?;
    } else {
        print::<PointRow>(&client, &args, "points", table::points).await?;
    }
    Ok(Done::Complete)
}

async fn print<T: DeserializeOwned + Serialize>(
    client: &ApiClient,
    args: &Args,
    name: &str,
    render: impl Fn(&[T]) -> Table,
) -> anyhow::Result<()> {
    let format = if args.json { Format::Json } else { args.format };
    if format == Format::Csv {
        let mut query = args.query();
        query.push(("format".to_owned(), "csv".to_owned()));
        let path = format!("/sweeps/{}/{name}?{}", args.sweep, encode(&query));
        return output::bytes(&client.get(&path).await?);
    }
    let rows: Vec<T> = client.rows(args.sweep, name, &args.query()).await?;
    if format == Format::Json {
        output::json(&json!({"items": rows, "next": null}))
    } else {
        output::bytes(render(&rows).render().as_bytes())
    }
}
