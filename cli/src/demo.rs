//! `granary demo`: a server, its workers and a whole sweep, with the published results beside ours.

use std::net::SocketAddr;
use std::path::PathBuf;

use granary_api::sweep::Sweep;
use granary_api::table::SetRow;
use granary_server::Config;
use serde_json::Value;

use crate::api_client::ApiClient;
use crate::failure::Done;
use crate::published::{Mean, published};
use crate::service::{Service, all_cores};
use crate::spec_file::SpecFile;
use crate::table::{Table, number};
use crate::{interrupt, log, output, serve, submit, watch};

const SPEC: &str = include_str!("../../examples/demo.toml");

/// Start a server, run the demo sweep, and leave the page up.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// End after the table instead of leaving the page up.
    #[arg(long)]
    exit: bool,
    /// Directory of the database and the artifacts.
    #[arg(
        long,
        env = "GRANARY_DATA",
        default_value = ".granary",
        value_name = "DIR"
    )]
    data: PathBuf,
    /// Address and port; by default port 8000, or a free one if that is taken.
    #[arg(long, env = "GRANARY_LISTEN", value_name = "ADDR")]
    listen: Option<SocketAddr>,
    /// Engine threads; all cores by default.
    #[arg(long, env = "GRANARY_WORKERS", value_name = "N")]
    workers: Option<usize>,
}

/// Runs the demo; a second time everything is there already.
pub(crate) async fn run(args: Args) -> anyhow::Result<Done> {
    log::to_stderr(tracing::Level::WARN);
    let spec = SpecFile::parse("examples/demo.toml".to_owned(), SPEC, false)?;
    let listen = args.listen.unwrap_or_else(usual_or_free_port);
    let config = Config {
        listen,
        ..Config::new(args.data)
    };
    let (mut service, address) =
        serve::start(config, None, args.workers.unwrap_or_else(all_cores)).await?;
    eprintln!("the page is at http://{address}");
    let shown = show(&mut service, &spec, args.exit, address).await;
    let stopped = service.stop().await;
    let done = shown?;
    stopped?;
    Ok(done)
}

/// Port 8000 if nobody has it.
fn usual_or_free_port() -> SocketAddr {
    let usual = SocketAddr::from(([127, 0, 0, 1], 8000));
    match std::net::TcpListener::bind(usual) {
        Ok(_) => usual,
        Err(_) => SocketAddr::from(([127, 0, 0, 1], 0)),
    }
}

/// Runs the sweep, and waits for the user's word unless told to `exit`.
async fn show(
    service: &mut Service,
    spec: &SpecFile,
    exit: bool,
    address: SocketAddr,
) -> anyhow::Result<Done> {
    let client = service.client().await?;
    let finished = tokio::select! {
        finished = compare(&client, spec) => finished?,
        ended = service.watch() => {
            ended?;
            anyhow::bail!("the server ended before the demo");
        }
        interrupted = interrupt::wait() => return interrupted.map(|()| Done::Interrupted),
    };
    if !exit {
        let sweep = finished.sweep;
        eprintln!("the same numbers: curl http://{address}/api/v1/sweeps/{sweep}/sets");
        eprintln!("the page stays at http://{address}; Ctrl-C ends it");
        tokio::select! {
            ended = service.watch() => ended?,
            interrupted = interrupt::wait() => interrupted?,
        }
    }
    Ok(watch::verdict(&finished))
}

/// Submits, follows and prints.
async fn compare(client: &ApiClient, spec: &SpecFile) -> anyhow::Result<Sweep> {
    let submitted = client.submit(spec, false).await?;
    submit::announce(&submitted);
    let Some(sweep) = submitted.sweep else {
        anyhow::bail!("the planner gave the sweep no id");
    };
    let finished = watch::follow(client, sweep).await?;
    let sets: Vec<SetRow> = client.rows(sweep, "sets", &[]).await?;
    output::bytes(comparison(&sets, grains(spec)).render().as_bytes())?;
    Ok(finished)
}

fn grains(spec: &SpecFile) -> u64 {
    spec.value
        .pointer("/fixed/grains")
        .and_then(Value::as_u64)
        .unwrap_or_default()
}

/// Our packings and their means, with the published means beside the latter.
fn comparison(sets: &[SetRow], grains: u64) -> Table {
    let mut table = Table::new([
        "μ",
        "packing",
        "𝒢·E·δ0 [kPa]",
        "𝓕",
        "published 𝒢·E·δ0 [kPa]",
        "published 𝓕",
        "published packs",
    ]);
    let friction = |set: &SetRow| {
        set.parameters
            .get("friction_coefficient")
            .and_then(Value::as_f64)
    };
    let mut frictions: Vec<f64> = sets.iter().filter_map(friction).collect();
    frictions.sort_by(f64::total_cmp);
    frictions.dedup();
    for value in frictions {
        let rows = sets.iter().filter(|set| friction(set) == Some(value));
        let (means, packings): (Vec<_>, Vec<_>) = rows.partition(|set| set.reduce == "mean_sem");
        for set in packings {
            table.push(ours(set, value));
        }
        for set in means {
            let mut row = ours(set, value);
            if let Some(theirs) = published(value, grains) {
                row.push(kilopascals(theirs.gain_e_delta0));
                row.push(with_error(theirs.fidelity));
                row.push(format!("{} of N = {}", theirs.packs, theirs.grains));
            }
            table.push(row);
        }
    }
    table
}

/// The columns of our own result.
fn ours(set: &SetRow, friction: f64) -> Vec<String> {
    let mean = |name: &str| {
        let value = |name: &str| set.results.get(name).copied().flatten();
        let sem = value(&format!("{name}_sem"));
        value(name).map(|mean| Mean { mean, sem })
    };
    let seed = set.parameters.get("packing_seed");
    vec![
        number(friction),
        seed.map_or_else(|| "mean".to_owned(), Value::to_string),
        mean("gain_e_delta0").map_or_else(|| "–".to_owned(), kilopascals),
        mean("fidelity").map_or_else(|| "–".to_owned(), with_error),
    ]
}

fn kilopascals(value: Mean) -> String {
    let kilo = format!("{:.1}", value.mean / 1e3);
    match value.sem {
        Some(sem) => format!("{kilo} ± {:.1}", sem / 1e3),
        None => kilo,
    }
}

fn with_error(value: Mean) -> String {
    match value.sem {
        Some(sem) => format!("{:.3} ± {sem:.3}", value.mean),
        None => format!("{:.3}", value.mean),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn means_stand_beside_the_published_ones() {
        let sets: Vec<SetRow> = serde_json::from_value(json!([
            {"set": 0, "reduce": "gain_fidelity", "processing": "SUB0", "n": 6, "of": 6, "provisional": false,
             "parameters": {"friction_coefficient": 1.0, "packing_seed": 2},
             "results": {"gain_e_delta0": 140_000.0, "fidelity": 0.85}},
            {"set": 1, "reduce": "mean_sem", "processing": "SUB0", "n": 3, "of": 3, "provisional": false,
             "parameters": {"friction_coefficient": 1.0},
             "results": {"gain_e_delta0": 141_000.0, "gain_e_delta0_sem": 2000.0, "fidelity": 0.84, "fidelity_sem": null}},
        ]))
        .expect("rows");
        let text = comparison(&sets, 1024).render();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[1], "1  2        140.0         0.850");
        assert!(
            lines[2].starts_with("1  mean     141.0 ± 2.0   0.840  141.5 ± "),
            "{}",
            lines[2]
        );
        assert!(lines[2].ends_with("5 of N = 1024"));
    }
}
