//! `granary token`: who may speak to a server.

use std::path::PathBuf;

use anyhow::Context;
use granary_api::token::Scope;
use granary_server::Tokens;

use crate::failure::Done;
use crate::output;

/// Make or revoke bearer tokens, also while the server runs; where any exists, every request needs one.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    /// Print a new token; it is stored as a hash and never shown again.
    Create {
        /// What its bearer may do; may be repeated.
        #[arg(long = "scope", value_enum, required = true)]
        scopes: Vec<ScopeName>,
        /// What it is called, to revoke it by.
        #[arg(long, default_value = "token")]
        name: String,
        #[command(flatten)]
        place: Place,
    },
    /// Forget all tokens of a name.
    Revoke {
        /// What they are called.
        name: String,
        #[command(flatten)]
        place: Place,
    },
}

#[derive(Debug, clap::Args)]
struct Place {
    /// Directory of the database, on this machine.
    #[arg(
        long,
        env = "GRANARY_DATA",
        default_value = ".granary",
        value_name = "DIR"
    )]
    data: PathBuf,
}

/// The scopes as the command line spells them.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum ScopeName {
    /// Read everything.
    Read,
    /// Submit and steer sweeps, and read.
    Submit,
    /// Lease jobs and store artifacts, and read.
    Worker,
    /// Everything.
    Admin,
}

impl From<ScopeName> for Scope {
    fn from(name: ScopeName) -> Self {
        match name {
            ScopeName::Read => Self::Read,
            ScopeName::Submit => Self::Submit,
            ScopeName::Worker => Self::Worker,
            ScopeName::Admin => Self::Admin,
        }
    }
}

/// Makes or revokes.
pub(crate) async fn run(args: Args) -> anyhow::Result<Done> {
    let (Action::Create { place, .. } | Action::Revoke { place, .. }) = &args.action;
    let tokens = Tokens::open(&place.data).await;
    let place = place.data.display();
    let tokens = tokens.with_context(|| format!("cannot use the data directory {place}"))?;
    let done = act(&tokens, &args.action).await;
    tokens.close().await;
    done
}

async fn act(tokens: &Tokens, action: &Action) -> anyhow::Result<Done> {
    match action {
        Action::Create { scopes, name, .. } => {
            let scopes: Vec<Scope> = scopes.iter().map(|scope| (*scope).into()).collect();
            output::line(&tokens.create(name, &scopes).await?)?;
        }
        Action::Revoke { name, .. } => {
            let count = tokens.revoke(name).await?;
            anyhow::ensure!(count > 0, "no token is called `{name}`");
            eprintln!("{count} revoked");
        }
    }
    Ok(Done::Complete)
}
