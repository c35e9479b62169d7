//! Tokens: 256 random bits each, known to the database by their hash alone.

use std::path::Path;

use granary_api::token::Scope;
use serde_json::json;
use sqlx::SqlitePool;
use sqlx::sqlite::SqlitePoolOptions;

use super::lock::DataLock;
use super::{Store, StoreError, connecting, now_ms, schema};

/// The tokens of a data directory, whether a server holds it or not.
pub struct Tokens {
    database: SqlitePool,
}

impl Tokens {
    /// Opens the database of `data` beside its holder; where there is none, makes or migrates it first.
    ///
    /// The lock is let go of before this returns, so that a server may start at once.
    pub async fn open(data: &Path) -> Result<Self, StoreError> {
        let lock = match DataLock::take(data, "granary token") {
            Ok(lock) => Some(lock),
            Err(StoreError::Locked { .. }) => None,
            Err(error) => return Err(error),
        };
        let options = connecting(data).create_if_missing(lock.is_some());
        let one = SqlitePoolOptions::new().max_connections(1);
        let database = one.connect_with(options).await?;
        match lock {
            Some(_) => schema::migrate(&database).await?,
            None => schema::check(&database).await?,
        }
        Ok(Self { database })
    }

    /// Makes a token; its text is never seen again. From the first one on, the server asks everybody for one.
    pub async fn create(&self, name: &str, scopes: &[Scope]) -> Result<String, StoreError> {
        create(&self.database, name, scopes).await
    }

    /// Forgets the tokens called `name`; how many there were.
    pub async fn revoke(&self, name: &str) -> Result<u64, StoreError> {
        revoke(&self.database, name).await
    }

    /// Closes the database.
    pub async fn close(self) {
        self.database.close().await;
    }
}

async fn create(database: &SqlitePool, name: &str, scopes: &[Scope]) -> Result<String, StoreError> {
    const CREATE: &str =
        "insert into token (hash, name, scopes, created_at) values ($1, $2, $3, $4)";
    let mut random = [0; 32];
    getrandom::fill(&mut random).map_err(|error| StoreError::File {
        path: "random numbers".to_owned(),
        source: std::io::Error::other(error.to_string()),
    })?;
    let text = format!("granary_{}", blake3::Hash::from_bytes(random).to_hex());
    let create = sqlx::query(CREATE)
        .bind(blake3::hash(text.as_bytes()).as_bytes().to_vec())
        .bind(name)
        .bind(json!(scopes).to_string())
        .bind(now_ms());
    create.execute(database).await?;
    Ok(text)
}

async fn revoke(database: &SqlitePool, name: &str) -> Result<u64, StoreError> {
    const REVOKE: &str = "delete from token where name = $1";
    let revoked = sqlx::query(REVOKE).bind(name).execute(database).await?;
    Ok(revoked.rows_affected())
}

impl Store {
    /// Makes a token; its text is never seen again.
    pub async fn token_create(&self, name: &str, scopes: &[Scope]) -> Result<String, StoreError> {
        create(&self.inner.writer, name, scopes).await
    }

    /// Forgets the tokens called `name`; how many there were.
    pub async fn token_revoke(&self, name: &str) -> Result<u64, StoreError> {
        revoke(&self.inner.writer, name).await
    }

    /// Whether any token exists: then every request needs one.
    pub async fn token_any(&self) -> Result<bool, StoreError> {
        const ANY: &str = "select exists (select 1 from token)";
        if !self.config().tokens.is_empty() {
            return Ok(true);
        }
        Ok(sqlx::query_scalar(ANY).fetch_one(self.readers()).await?)
    }

    /// What the bearer of `text` may do; none if there is no such token.
    ///
    /// Only hashes are compared, so the time that it takes says nothing about the text.
    pub async fn token_scopes(&self, text: &str) -> Result<Option<Vec<Scope>>, StoreError> {
        const SCOPES: &str = "select scopes from token where hash = $1";
        let hash = blake3::hash(text.as_bytes());
        let configured = self.config().tokens.iter();
        let mut configured = configured.filter(|(token, _)| blake3::hash(token.as_bytes()) == hash);
        if let Some((_, scopes)) = configured.next() {
            return Ok(Some(scopes.clone()));
        }
        let scopes: Option<String> = sqlx::query_scalar(SCOPES)
            .bind(hash.as_bytes().to_vec())
            .fetch_optional(self.readers())
            .await?;
        scopes
            .map(|scopes| {
                serde_json::from_str(&scopes).map_err(StoreError::corrupt("list of scopes"))
            })
            .transpose()
    }
}
