//! What can go wrong in the store.

use granary_api::id::JobId;
use granary_api::problem::Mistake;

/// Why the store did not do what it was asked.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The database refused.
    #[error("the database failed")]
    Database(#[from] sqlx::Error),
    /// A file could not be read or written.
    #[error("{path}: the file system failed")]
    File {
        /// Which file.
        path: String,
        /// Why.
        source: std::io::Error,
    },
    /// A row holds text that is not what we wrote.
    #[error("the database holds a {what} that cannot be read")]
    Corrupt {
        /// What it should be.
        what: &'static str,
        /// Why.
        source: serde_json::Error,
    },
    /// The database was made by another release.
    #[error(
        "the database has schema {found}, and this release knows {known}: use the release that made it"
    )]
    Schema {
        /// The file's.
        found: i64,
        /// Ours.
        known: i64,
    },
    /// Another process holds the data directory.
    #[error("{path} is held by {holder}")]
    Locked {
        /// The directory.
        path: String,
        /// Its holder: an address, or a process.
        holder: String,
    },
    /// There is no such thing.
    #[error("there is no {0}")]
    NotFound(String),
    /// The lease is not the current one of these jobs; nothing was changed.
    #[error("the lease is not the current one of {} of these jobs", .0.len())]
    LeaseLost(Vec<JobId>),
    /// The request is wrong in these ways.
    #[error("{} mistakes", .0.len())]
    Invalid(Vec<Mistake>),
    /// An idempotency key was used for another sweep.
    #[error("the Idempotency-Key was used for another sweep")]
    KeyReused,
    /// Outcomes do not have the hashes that they were reported with; nothing was recorded.
    #[error("{} outcomes do not have their hashes", .0.len())]
    ResultMismatch(Vec<Mistake>),
    /// The bytes do not have the hash that they were sent under.
    #[error("the bytes have the hash {actual}, not {named}")]
    HashMismatch {
        /// The hash in the request.
        named: String,
        /// The hash of the bytes.
        actual: String,
    },
    /// More bytes than an artifact may have.
    #[error("an artifact may have at most {0} bytes")]
    TooLarge(u64),
}

impl StoreError {
    pub(crate) fn file(path: &std::path::Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.display().to_string();
        move |source| Self::File { path, source }
    }

    pub(crate) fn corrupt(what: &'static str) -> impl FnOnce(serde_json::Error) -> Self {
        move |source| Self::Corrupt { what, source }
    }
}
