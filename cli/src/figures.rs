//! `granary figures`: the figures and tables of both papers, computed here.

mod catalog;
mod contact;
mod data;
pub(crate) mod drawing;
pub(crate) mod svg;
mod tables;

mod beams;
mod curves;
mod grains;
mod inside;
mod memory;

use std::path::{Path, PathBuf};

use anyhow::Context;
use granary_api::id::SweepId;
use granary_api::sweep::Sweep;
use granary_core::model::Model;
use granary_server::Config;

use catalog::{ALL, Figure, Shown};
use contact::CONTACTS;
use data::Data;
use drawing::Drawing;

use crate::api_client::{ApiClient, ServerArgs};
use crate::failure::Done;
use crate::progress::duration;
use crate::service::{self, Place, Service};
use crate::spec_file::SpecFile;
use crate::table::Table;
use crate::{log, output, run};

/// List the figures that are there, print the sweep of one, or compute and draw it.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Which one; all are listed without.
    name: Option<String>,
    /// Print its spec instead, ready to be submitted.
    #[arg(long, requires = "name")]
    spec: bool,
    /// Size and numerics; packs of grains are as large as the paper's but for `draft`.
    #[arg(long, default_value = "draft", value_parser = preset_names())]
    preset: String,
    /// Packings of each combination.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1000))]
    packings: u64,
    /// Where pictures and numbers are written.
    #[arg(long, default_value = "figures", value_name = "DIR")]
    out: PathBuf,
    /// Draw what a server has of it; without, it is computed here.
    #[arg(long, value_name = "URL")]
    server: Option<String>,
    /// File that holds the bearer token; not needed on loopback.
    #[arg(long, env = "GRANARY_TOKEN_FILE", value_name = "FILE")]
    token_file: Option<PathBuf>,
    /// Draw this sweep instead, a variation of one's own.
    #[arg(long, value_name = "ID", requires = "name", conflicts_with = "spec")]
    sweep: Option<SweepId>,
    /// Draw what is there, and compute nothing.
    #[arg(long)]
    as_is: bool,
    /// Engine threads; all cores by default.
    #[arg(long, env = "GRANARY_THREADS", value_name = "N")]
    threads: Option<usize>,
    #[command(flatten)]
    place: Place,
}

/// A figure in place of a spec, as `granary run` takes it.
#[derive(Debug, clap::Args)]
pub(crate) struct FigureArgs {
    /// The sweep behind this figure of the papers, drawn when it is done; `granary figures` lists them.
    #[arg(long, value_name = "NAME")]
    figure: Option<String>,
    /// Size and numerics of the figure.
    #[arg(long, default_value = "draft", value_parser = preset_names(), requires = "figure")]
    preset: String,
    /// Packings of each combination of the figure.
    #[arg(long, default_value_t = 1, value_name = "N", requires = "figure", value_parser = clap::value_parser!(u64).range(1..=1000))]
    packings: u64,
    /// Where the figure's pictures and numbers are written.
    #[arg(
        long,
        default_value = "figures",
        value_name = "DIR",
        requires = "figure"
    )]
    out: PathBuf,
}

impl FigureArgs {
    fn figure(&self) -> anyhow::Result<Option<&'static Figure>> {
        self.figure
            .as_deref()
            .map(|name| sweep_named(name, &self.preset))
            .transpose()
    }

    /// The spec of the figure, if there is one.
    pub(crate) fn spec(&self) -> anyhow::Result<Option<SpecFile>> {
        let Some(figure) = self.figure()? else {
            return Ok(None);
        };
        let text = figure.sweep().spec(&self.preset, self.packings);
        Ok(Some(SpecFile::parse(figure.name.to_owned(), &text, false)?))
    }

    /// Draws the figure from its sweep.
    pub(crate) async fn draw(&self, client: &ApiClient, sweep: SweepId) -> anyhow::Result<()> {
        if let Some(figure) = self.figure()? {
            write(client, sweep, figure, &self.out).await?;
        }
        Ok(())
    }
}

/// The figure called `name`, whose model has such a preset.
fn sweep_named(name: &str, preset: &str) -> anyhow::Result<&'static Figure> {
    let names = || {
        let contacts = CONTACTS.iter().map(|figure| figure.name);
        let all = ALL.iter().map(|figure| figure.name).chain(contacts);
        all.collect::<Vec<_>>()
    };
    let figure = Figure::named(name)
        .with_context(|| format!("`{name}` is not one of {}", names().join(", ")))?;
    let model = figure.sweep().model;
    anyhow::ensure!(
        figure.sweep().has_preset(preset),
        "`{name}` has no preset {preset}: its model, {}, has none",
        model.name()
    );
    Ok(figure)
}

/// The presets of both models.
fn preset_names() -> Vec<&'static str> {
    let all = Model::ALL.into_iter().flat_map(Model::presets);
    let mut names: Vec<&str> = all.map(|preset| preset.name).collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// Lists, prints or draws.
pub(crate) async fn run(args: Args) -> anyhow::Result<Done> {
    let Some(name) = &args.name else {
        return list(&args).await;
    };
    if let Some(figure) = CONTACTS.iter().find(|figure| figure.name == name) {
        anyhow::ensure!(
            !args.spec && args.sweep.is_none(),
            "`{name}` is drawn without a sweep"
        );
        let files = pictures(
            figure.name,
            &format!("{}: {}", figure.name, figure.shows),
            &(figure.draw)(),
        );
        save(&args.out, files)?;
        return Ok(Done::Complete);
    }
    let figure = sweep_named(name, &args.preset)?;
    if args.spec {
        output::bytes(figure.sweep().spec(&args.preset, args.packings).as_bytes())?;
        return Ok(Done::Complete);
    }
    draw(&args, figure).await
}

/// The spec of a figure, as the command was told.
fn spec_of(args: &Args, figure: &Figure) -> anyhow::Result<SpecFile> {
    let text = figure.sweep().spec(&args.preset, args.packings);
    Ok(SpecFile::parse(figure.name.to_owned(), &text, false)?)
}

async fn list(args: &Args) -> anyhow::Result<Done> {
    log::to_stderr(tracing::Level::WARN);
    // Estimates come from the planner; nothing is queued, so a store that nobody keeps will do.
    let place = tempfile::tempdir()?;
    let mut service = Service::open(Config::new(place.path()), None, "granary figures").await?;
    let client = service.client().await?;
    let mut table = Table::new(["figure", "points", "one core", "drawn", "what it shows"]);
    for figure in ALL
        .iter()
        .filter(|figure| figure.sweep().has_preset(&args.preset))
    {
        let planned = client.submit(&spec_of(args, figure)?, true).await?;
        table.push(vec![
            figure.name.to_owned(),
            planned.points.to_string(),
            format!("~ {}", duration(planned.predicted.core_seconds)),
            match figure.shown {
                Shown::Picture(_) => "SVG, CSV",
                Shown::Table => "CSV",
            }
            .to_owned(),
            figure.sweep().shows.to_owned(),
        ]);
    }
    for figure in CONTACTS {
        table.push(vec![
            figure.name.to_owned(),
            "–".to_owned(),
            "–".to_owned(),
            "SVG, CSV".to_owned(),
            figure.shows.to_owned(),
        ]);
    }
    service.stop().await?;
    output::bytes(table.render().as_bytes())?;
    let (preset, packings) = (&args.preset, args.packings);
    let packings = match packings {
        1 => "one packing".to_owned(),
        more => format!("{more} packings"),
    };
    output::line(&format!(
        "preset {preset}, {packings}; what figures have in common is computed once"
    ))?;
    Ok(Done::Complete)
}

async fn draw(args: &Args, figure: &Figure) -> anyhow::Result<Done> {
    let spec = spec_of(args, figure)?;
    if let Some(server) = &args.server {
        let server = ServerArgs {
            server: server.clone(),
            token_file: args.token_file.clone(),
        };
        let client = server.client()?;
        let sweep = known(&client, args, &spec).await?;
        return write(&client, sweep, figure, &args.out).await;
    }
    log::to_stderr(tracing::Level::WARN);
    let work = async |service: &mut Service| draw_here(service, args, figure, &spec).await;
    service::with(&args.place, "granary figures", work).await
}

async fn draw_here(
    service: &mut Service,
    args: &Args,
    figure: &Figure,
    spec: &SpecFile,
) -> anyhow::Result<Done> {
    let client = service.client().await?;
    if args.as_is || args.sweep.is_some() {
        let sweep = known(&client, args, spec).await?;
        return write(&client, sweep, figure, &args.out).await;
    }
    match run::compute(service, &client, spec, args.threads).await? {
        None => Ok(Done::Interrupted),
        Some(finished) => write(&client, finished.sweep, figure, &args.out).await,
    }
}

/// The sweep that was named, or the one of this spec if it was ever submitted.
async fn known(client: &ApiClient, args: &Args, spec: &SpecFile) -> anyhow::Result<SweepId> {
    if let Some(sweep) = args.sweep {
        return Ok(sweep);
    }
    let found = client.submit(spec, true).await?.sweep;
    found.with_context(|| {
        let (name, preset, packings) = (&spec.name, &args.preset, args.packings);
        let spec = format!("granary figures {name} --preset {preset} --packings {packings} --spec");
        match &args.server {
            Some(server) => format!(
                "the server has no such sweep\n  submit it: {spec} | granary submit - --server {server}"
            ),
            None => "nothing of it is here; without --as-is it is computed".to_owned(),
        }
    })
}

/// Writes what there is of a figure; some of it may be missing.
async fn write(
    client: &ApiClient,
    sweep: SweepId,
    figure: &Figure,
    out: &Path,
) -> anyhow::Result<Done> {
    let sweep: Sweep = client.sweep(sweep).await?;
    let data = Data::read(client, sweep.sweep, figure).await?;
    let files = match figure.shown {
        Shown::Picture(draw) => {
            let title = format!(
                "{}: {}; preset {}",
                figure.name,
                figure.sweep().shows,
                sweep.preset
            );
            pictures(figure.name, &title, &draw(&data))
        }
        Shown::Table => {
            output::bytes(tables::fits(&data).render().as_bytes())?;
            vec![(format!("{}.csv", figure.name), tables::fits_csv(&data))]
        }
    };
    save(out, files)?;
    let points = sweep.points;
    if points.done == points.total {
        return Ok(Done::Complete);
    }
    eprintln!(
        "of {} points {} are done and {} have failed: what is missing is not drawn",
        points.total, points.done, points.failed
    );
    Ok(Done::Incomplete)
}

/// Writes files and says where.
fn save(out: &Path, files: Vec<(String, String)>) -> anyhow::Result<()> {
    std::fs::create_dir_all(out)
        .with_context(|| format!("cannot make the directory {}", out.display()))?;
    for (name, text) in files {
        let path = out.join(name);
        std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
        output::line(&path.display().to_string())?;
    }
    Ok(())
}

/// The picture, and a file of numbers for each panel that has any.
fn pictures(figure: &str, title: &str, drawing: &Drawing) -> Vec<(String, String)> {
    let mut files = vec![(format!("{figure}.svg"), svg::picture(drawing, title))];
    for (k, panel) in drawing.panels.iter().enumerate() {
        if panel.is_empty() {
            eprintln!("panel {} has no number yet", k + 1);
            continue;
        }
        for (what, text) in panel.csv() {
            let letter = char::from(b'a' + k as u8);
            files.push((format!("{figure}-{letter}{what}.csv"), text));
        }
    }
    files
}

#[cfg(test)]
mod tests;
