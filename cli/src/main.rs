//! `granary`: sweeps of jammed granular packs, from the command line.

mod api_client;
mod failure;
mod interrupt;
mod log;
mod output;
mod page;
mod progress;
mod published;
mod spec_file;
mod table;

mod direct;
#[cfg(test)]
mod lease_conformance;
mod service;

mod bench;
mod demo;
mod figures;
mod health;
mod models;
mod openapi;
mod replay;
mod results;
mod run;
mod serve;
mod steer;
mod study;
mod submit;
mod sweeps;
mod token;
mod watch;
mod worker;
mod workers;

mod command;

use std::process::ExitCode;

use clap::Parser;

/// Sweeps of jammed granular packs: submit a spec, read a table.
#[derive(Debug, Parser)]
#[command(name = "granary", version, about, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: command::Command,
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
