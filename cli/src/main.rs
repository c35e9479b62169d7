//! `granary`: sweeps of jammed granular packs, from the command line.

mod api_client;
mod direct;
mod failure;
mod interrupt;
#[cfg(test)]
mod lease_conformance;
mod log;
mod output;
mod progress;
mod published;
mod service;
mod spec_file;
mod table;

mod demo;
mod models;
mod replay;
mod results;
mod run;
mod serve;
mod submit;
mod watch;
mod worker;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use failure::Done;

/// Sweeps of jammed granular packs: submit a spec, read a table.
#[derive(Debug, Parser)]
#[command(name = "granary", version, about, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Demo(demo::Args),
    Run(run::Args),
    Serve(serve::Args),
    Worker(worker::Args),
    Submit(submit::Args),
    Watch(watch::Args),
    Results(results::Args),
    Replay(replay::Args),
    Models(models::Args),
}

impl Command {
    async fn run(self) -> anyhow::Result<Done> {
        match self {
            Self::Demo(args) => demo::run(args).await,
            Self::Run(args) => run::run(args).await,
            Self::Serve(args) => serve::run(args).await,
            Self::Worker(args) => worker::run(args).await,
            Self::Submit(args) => submit::run(args).await,
            Self::Watch(args) => watch::run(args).await,
            Self::Results(args) => results::run(args).await,
            Self::Replay(args) => replay::run(args).await,
            Self::Models(args) => models::run(&args),
        }
    }
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let runtime = tokio::runtime::Runtime::new();
    let done = runtime
        .map_err(anyhow::Error::from)
        .and_then(|runtime| runtime.block_on(cli.command.run()));
    match done {
        Ok(done) => done.into(),
        Err(error) => {
            eprintln!("error: {error:#}");
            failure::exit_code(&error)
        }
    }
}
