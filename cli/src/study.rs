//! `granary study`: what each numerical setting of one's own scene costs in accuracy, and what it saves.

mod asked;
mod picture;
mod shown;

use std::path::PathBuf;

use anyhow::Context;
use granary_api::sweep::Sweep;
use granary_api::table::SetRow;
use granary_core::model::Model;
use serde_json::json;

use crate::api_client::ApiClient;
use crate::failure::Done;
use crate::service::{self, Place, Service};
use crate::spec_file::SpecFile;
use crate::{log, output, run, watch};

/// Compare settings of a sweep with a reference, on the same packings: errors, core-seconds, and which are worth it.
///
/// A spec with `[study]` says so itself; the options add to it.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The spec, TOML or JSON; `-` is standard input.
    spec: PathBuf,
    /// Vary one parameter, all others as the spec says: `time_step=0.5,1,1.5`; may be repeated.
    #[arg(long = "knob", value_name = "NAME=VALUES")]
    knobs: Vec<String>,
    /// One more setting, of several parameters or a preset: `ramp=4500,drag=0.01` or `preset=draft`; may be repeated.
    #[arg(long = "setting", value_name = "NAME=VALUE,…")]
    settings: Vec<String>,
    /// What all are compared with, as changes to the spec: `time_step=0.5,precision=f64`; the spec itself without.
    #[arg(long, value_name = "NAME=VALUE,…")]
    reference: Option<String>,
    /// Print the settings as JSON.
    #[arg(long)]
    json: bool,
    /// Write a picture of error over cost.
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// Engine threads; all cores by default.
    #[arg(long, env = "GRANARY_THREADS", value_name = "N")]
    threads: Option<usize>,
    #[command(flatten)]
    place: Place,
}

/// Computes, or goes on where an interrupted study stopped.
pub(crate) async fn run(args: Args) -> anyhow::Result<Done> {
    log::to_stderr(tracing::Level::WARN);
    let mut spec = SpecFile::read(&args.spec)?;
    asked::add(&mut spec.value, &args)?;
    let work = async |service: &mut Service| whole(service, &args, &spec).await;
    service::with(&args.place, "granary study", work).await
}

async fn whole(service: &mut Service, args: &Args, spec: &SpecFile) -> anyhow::Result<Done> {
    let client = service.client().await?;
    let Some(finished) = run::compute(service, &client, spec, args.threads).await? else {
        return Ok(Done::Interrupted);
    };
    print(&client, &finished, args).await?;
    Ok(watch::verdict(&finished))
}

async fn print(client: &ApiClient, sweep: &Sweep, args: &Args) -> anyhow::Result<()> {
    let only = [("where".to_owned(), "reduce=study".to_owned())];
    let rows: Vec<SetRow> = client.rows(sweep.sweep, "sets", &only).await?;
    let model = Model::named(&sweep.model).context("the server named no model")?;
    if let Some(path) = &args.plot {
        let text = picture::picture(&rows, model, &sweep.name);
        std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))?;
    }
    if args.json {
        return output::json(&json!({"name": sweep.name, "items": rows, "next": null}));
    }
    output::bytes(shown::table(&rows, model).render().as_bytes())?;
    output::line(shown::LEGEND)
}
