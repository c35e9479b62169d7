//! How a command ends: its exit code, and the words for what went wrong.

use std::fmt;
use std::process::ExitCode;

use granary_api::problem::Problem;

use crate::spec_file::BadSpec;

/// How a command that did its work ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Done {
    /// Everything that was asked for is there.
    Complete,
    /// Some points failed, or results differ.
    Incomplete,
    /// The user interrupted it.
    Interrupted,
}

impl From<Done> for ExitCode {
    fn from(done: Done) -> Self {
        Self::from(match done {
            Done::Complete => 0,
            Done::Incomplete => 3,
            Done::Interrupted => 130,
        })
    }
}

/// Why a command could not do its work, where that has an exit code of its own.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// The spec has mistakes.
    #[error("{0}")]
    BadSpec(BadSpec),
    /// Nothing answers at the server's address.
    #[error("no server answers at {server}: {detail}\n  start one: granary serve")]
    Unreachable {
        /// The address.
        server: String,
        /// What went wrong on the way.
        detail: String,
    },
    /// The server said no.
    #[error("{}", Refusal(.0))]
    Refused(Problem),
}

impl Failure {
    fn code(&self) -> u8 {
        match self {
            Self::BadSpec(_) => 2,
            Self::Unreachable { .. } => 4,
            Self::Refused(_) => 1,
        }
    }
}

/// A problem document as a sentence for people, with the next command where there is one.
struct Refusal<'a>(&'a Problem);

impl fmt::Display for Refusal<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let problem = self.0;
        write!(f, "{} ({})", problem.title, problem.status)?;
        if let Some(detail) = &problem.detail {
            write!(f, ": {detail}")?;
        }
        for mistake in &problem.errors {
            write!(f, "\n  {}: {}", mistake.pointer, mistake.detail)?;
        }
        if matches!(problem.status, 401 | 403) {
            write!(
                f,
                "\n  give a token: --token-file FILE (made by `granary token create`)"
            )?;
        }
        Ok(())
    }
}

/// The exit code of an error, wherever in its chain the reason stands.
pub(crate) fn exit_code(error: &anyhow::Error) -> ExitCode {
    let failure = error.downcast_ref::<Failure>();
    ExitCode::from(failure.map_or(1, Failure::code))
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::Context;

    #[test]
    fn the_exit_code_survives_added_context() {
        let unreachable = Failure::Unreachable {
            server: "http://127.0.0.1:1".to_owned(),
            detail: "refused".to_owned(),
        };
        let error = Err::<(), _>(unreachable)
            .context("while submitting")
            .expect_err("is one");
        assert_eq!(
            format!("{:?}", exit_code(&error)),
            format!("{:?}", ExitCode::from(4))
        );
    }
}
