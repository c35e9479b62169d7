//! `granary replay`: computes a stored result again and compares its bits.

use std::ops::ControlFlow;
use std::path::PathBuf;

use anyhow::{Context, bail};
use granary_api::id::{JobId, ResultHash};
use granary_api::job::JobDetail;
use granary_core::stage::{Ensemble, Report, STATE, StageSpec, run as run_stage};
use granary_server::Config;
use granary_worker::machine;
use serde_json::json;

use crate::api_client::{ApiClient, ServerArgs};
use crate::failure::Done;
use crate::output;
use crate::service::Service;

/// Compute a job's result again on this machine; exit code 3 if a bit differs.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The job, `b3:` and 64 digits, as the tables show it.
    job: JobId,
    #[command(flatten)]
    server: ServerArgs,
    /// Read from this data directory instead of a server.
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Print both hashes as JSON.
    #[arg(long)]
    json: bool,
}

/// Compares; the stored result is left as it is either way.
pub(crate) async fn run(args: Args) -> anyhow::Result<Done> {
    let Some(data) = &args.data else {
        let client = args.server.client()?;
        return replay(&client, &args).await;
    };
    let mut service = Service::open(Config::new(data), None, "granary replay").await?;
    let client = service.client().await?;
    let done = replay(&client, &args).await;
    service.stop().await?;
    done
}

async fn replay(client: &ApiClient, args: &Args) -> anyhow::Result<Done> {
    let detail = client.job(args.job).await?;
    let Some(stored) = detail.result_hash else {
        bail!("job {} is {} and has no result", args.job, detail.state);
    };
    let input = input(client, &detail).await?;
    let spec = detail.spec.clone();
    eprintln!("computing {} {} again", spec.kind().name(), args.job);
    let computed = tokio::task::spawn_blocking(move || recompute(spec, &input)).await??;
    let equal = computed == stored;
    if args.json {
        let target = machine::target();
        output::json(
            &json!({"job": args.job, "stored": stored, "computed": computed, "equal": equal, "target": target}),
        )?;
    } else if equal {
        output::line(&format!("equal: {stored}"))?;
    } else {
        output::line(&format!("different: stored {stored}, computed {computed}"))?;
    }
    Ok(if equal {
        Done::Complete
    } else {
        Done::Incomplete
    })
}

/// The state that the job starts from; empty for a pack.
async fn input(client: &ApiClient, detail: &JobDetail) -> anyhow::Result<Vec<u8>> {
    let Some(needs) = detail.needs else {
        return Ok(vec![]);
    };
    let source = client.job(needs).await?;
    let hash = source.artifacts.get(STATE);
    let hash = hash.with_context(|| format!("job {needs} has no state to start from"))?;
    Ok(client.artifact(*hash).await?.into())
}

fn recompute(spec: StageSpec, input: &[u8]) -> anyhow::Result<ResultHash> {
    let ensemble = Ensemble {
        specs: &[spec],
        input,
        checkpoints: None,
    };
    let mut watch = |_: &Report<'_>| ControlFlow::Continue(());
    let result = run_stage(&ensemble, &mut watch).pop();
    let outcome = result.context("the engine gave no answer")?;
    Ok(outcome.context("the run failed")?.hash())
}
