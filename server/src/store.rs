//! The store: all SQL, and the files beside it.
//!
//! One SQLite file, held by one process: write-ahead log, every commit synced, one connection that writes.
//! Only [`Tokens`] are made and revoked beside it, by `granary token` while a server runs.
//! Transactions that write begin `immediate`, so none fails half way because another came first.

mod archived;
mod artifact;
mod bulk;
mod chunk;
mod completion;
mod cost;
mod detail;
mod ending;
mod error;
mod event;
mod intake;
mod job;
mod lease;
mod lock;
mod measured;
mod pace;
mod pilot;
mod point;
mod recognition;
mod schema;
mod set;
mod speed;
mod sweep;
mod token;
mod worker;

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous};
use sqlx::{Sqlite, SqlitePool, Transaction};
use tokio::sync::watch;

use crate::config::Config;
pub use artifact::ArtifactFile;
pub use error::StoreError;
pub use intake::Submission;
pub use token::Tokens;

/// A transaction that may write.
type Writing = Transaction<'static, Sqlite>;

/// The database and the artifacts of one data directory; cheap to clone.
#[derive(Clone)]
pub struct Store {
    inner: Arc<Inner>,
}

struct Inner {
    config: Config,
    writer: SqlitePool,
    readers: SqlitePool,
    changed: watch::Sender<u64>,
    lock: lock::DataLock,
    pace: pace::Pace,
    dots: set::DotsCache,
    answers: recognition::Answers,
    /// Tells this process's count of changes from an earlier one's.
    opened: i64,
}

impl Store {
    /// Opens the data directory of `config`, making or migrating what is there; `holder` is told to whoever comes next.
    pub async fn open(config: Config, holder: &str) -> Result<Self, StoreError> {
        let lock = lock::DataLock::take(&config.data, holder)?;
        artifact::prepare(&config.data)?;
        let options = connecting(&config.data);
        let pool = |most| {
            SqlitePoolOptions::new()
                .max_connections(most)
                .acquire_timeout(Duration::from_secs(30))
        };
        // A large intake touches its indexes all over; what it does not use costs nothing.
        // What undoes a failing statement stays in memory too: a chunk of rows changes a few megabytes at most.
        let writing = options
            .clone()
            .create_if_missing(true)
            .pragma("cache_size", "-32000")
            .pragma("temp_store", "memory");
        let writer = pool(1).connect_with(writing).await?;
        schema::migrate(&writer).await?;
        let readers = pool(4).connect_lazy_with(options.read_only(true));
        let (changed, _) = watch::channel(0);
        let inner = Inner {
            config,
            writer,
            readers,
            changed,
            lock,
            pace: pace::Pace::default(),
            dots: set::DotsCache::default(),
            answers: recognition::Answers::default(),
            opened: now_ms(),
        };
        Ok(Self {
            inner: Arc::new(inner),
        })
    }

    /// The configuration that it was opened with.
    #[must_use]
    pub fn config(&self) -> &Config {
        &self.inner.config
    }

    /// Tells whoever finds the data directory locked that `holder` has it.
    pub fn lock_announce(&self, holder: &str) -> Result<(), StoreError> {
        self.inner.lock.announce(holder)
    }

    /// A signal whenever something in the store has changed.
    #[must_use]
    pub fn subscribe(&self) -> watch::Receiver<u64> {
        self.inner.changed.subscribe()
    }

    /// Closes the database after what is under way.
    pub async fn close(&self) {
        self.inner.readers.close().await;
        self.inner.writer.close().await;
    }

    async fn begin(&self) -> Result<Writing, StoreError> {
        Ok(self.inner.writer.begin_with("begin immediate").await?)
    }

    async fn commit(&self, transaction: Writing) -> Result<(), StoreError> {
        transaction.commit().await?;
        self.inner.changed.send_modify(|count| *count += 1);
        Ok(())
    }

    fn readers(&self) -> &SqlitePool {
        &self.inner.readers
    }
}

/// How every connection to the database of `data` is made.
fn connecting(data: &Path) -> SqliteConnectOptions {
    SqliteConnectOptions::new()
        .filename(data.join("granary.sqlite"))
        .journal_mode(SqliteJournalMode::Wal)
        .synchronous(SqliteSynchronous::Full)
        .foreign_keys(true)
        .busy_timeout(Duration::from_secs(5))
        .statement_cache_capacity(200)
}

/// Milliseconds since 1970, UTC; for people, never for rules.
fn now_ms() -> i64 {
    jiff::Timestamp::now().as_millisecond()
}

/// A stored time as RFC 3339.
fn rfc3339(ms: i64) -> String {
    jiff::Timestamp::from_millisecond(ms).map_or_else(|_| String::new(), |time| time.to_string())
}

/// A count as SQLite holds it; counts never come near the end of either type.
fn signed(count: u64) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}
