//! The commands, in the order in which the help lists them.

use crate::failure::Done;
use crate::{
    bench, demo, figures, health, models, openapi, replay, results, run, serve, steer, study,
    submit, sweeps, token, watch, worker, workers,
};

/// What `granary` can be told to do.
#[derive(Debug, clap::Subcommand)]
pub(crate) enum Command {
    Demo(demo::Args),
    Run(run::Args),
    Study(study::Args),
    Serve(serve::Args),
    Worker(worker::Args),
    Submit(submit::Args),
    Watch(watch::Args),
    Sweeps(sweeps::Args),
    Results(results::Args),
    /// Give up a sweep; jobs that no other sweep wants are cancelled.
    Cancel(steer::Args),
    /// Give no more jobs of a sweep to workers; what runs goes on.
    Pause(steer::Args),
    /// Go on with a paused or cancelled sweep.
    Resume(steer::Args),
    /// Try poisoned jobs and faults of machines again; broken physics stays as it is.
    Retry(steer::Args),
    Replay(replay::Args),
    Workers(workers::Args),
    Health(health::Args),
    Figures(figures::Args),
    Bench(bench::Args),
    Models(models::Args),
    Openapi(openapi::Args),
    Token(token::Args),
}

impl Command {
    /// Does it.
    pub(crate) async fn run(self) -> anyhow::Result<Done> {
        match self {
            Self::Demo(args) => demo::run(args).await,
            Self::Run(args) => run::run(args).await,
            Self::Study(args) => study::run(args).await,
            Self::Serve(args) => serve::run(args).await,
            Self::Worker(args) => worker::run(args).await,
            Self::Submit(args) => submit::run(args).await,
            Self::Watch(args) => watch::run(args).await,
            Self::Sweeps(args) => sweeps::run(args).await,
            Self::Results(args) => results::run(args).await,
            Self::Cancel(args) => steer::run(args, "cancel").await,
            Self::Pause(args) => steer::run(args, "pause").await,
            Self::Resume(args) => steer::run(args, "resume").await,
            Self::Retry(args) => steer::run(args, "retry").await,
            Self::Replay(args) => replay::run(args).await,
            Self::Health(args) => health::run(args).await,
            Self::Workers(args) => workers::run(args).await,
            Self::Figures(args) => figures::run(args).await,
            Self::Bench(args) => bench::run(&args).await,
            Self::Models(args) => models::run(&args),
            Self::Openapi(args) => openapi::run(&args),
            Self::Token(args) => token::run(args).await,
        }
    }
}
