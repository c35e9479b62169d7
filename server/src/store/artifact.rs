//! Artifacts: immutable files under their hash, `artifacts/ab/cdef…`.
//!
//! A file is written under a temporary name, synced, renamed, and its directory synced, before anything names it.

use std::path::{Path, PathBuf};

use futures_util::{Stream, StreamExt};
use granary_core::identity::ArtifactHash;
use tokio::fs::{self, File};
use tokio::io::AsyncWriteExt;
use uuid::Uuid;

use super::{Store, StoreError};

/// An artifact, open for reading.
pub struct ArtifactFile {
    /// The file.
    pub file: File,
    /// Its size \[bytes\].
    pub bytes: u64,
}

/// Makes the directories and removes what an earlier process left half written.
pub(super) fn prepare(data: &Path) -> Result<(), StoreError> {
    let half_written = temporary(data);
    if half_written.exists() {
        std::fs::remove_dir_all(&half_written).map_err(StoreError::file(&half_written))?;
    }
    std::fs::create_dir_all(&half_written).map_err(StoreError::file(&half_written))
}

fn temporary(data: &Path) -> PathBuf {
    data.join("artifacts").join("tmp")
}

impl Store {
    pub(super) fn artifact_path(&self, hash: &ArtifactHash) -> PathBuf {
        let hex = hash.to_hex();
        let shard = self.config().data.join("artifacts").join(&hex[..2]);
        shard.join(&hex[2..])
    }

    /// Whether there is such a file.
    pub async fn artifact_exists(&self, hash: &ArtifactHash) -> bool {
        fs::try_exists(self.artifact_path(hash))
            .await
            .unwrap_or(false)
    }

    /// Opens an artifact.
    pub async fn artifact_open(&self, hash: &ArtifactHash) -> Result<ArtifactFile, StoreError> {
        let path = self.artifact_path(hash);
        let file = match File::open(&path).await {
            Ok(file) => file,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                return Err(StoreError::NotFound(format!("artifact {hash}")));
            }
            Err(error) => return Err(StoreError::file(&path)(error)),
        };
        let metadata = file.metadata().await.map_err(StoreError::file(&path))?;
        Ok(ArtifactFile {
            file,
            bytes: metadata.len(),
        })
    }

    /// All bytes of an artifact.
    pub async fn artifact_get(&self, hash: &ArtifactHash) -> Result<Vec<u8>, StoreError> {
        let path = self.artifact_path(hash);
        match fs::read(&path).await {
            Ok(bytes) => Ok(bytes),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                Err(StoreError::NotFound(format!("artifact {hash}")))
            }
            Err(error) => Err(StoreError::file(&path)(error)),
        }
    }

    /// Stores `bytes` under their hash.
    pub async fn artifact_put(&self, bytes: Vec<u8>) -> Result<ArtifactHash, StoreError> {
        let hash = ArtifactHash::of_bytes(&bytes);
        let one = futures_util::stream::once(async { Ok::<_, std::io::Error>(bytes) });
        self.artifact_receive(&hash, Box::pin(one)).await?;
        Ok(hash)
    }

    /// Stores a stream of bytes that must have the hash `named`; whether it was new.
    pub async fn artifact_receive<B, E, S>(
        &self,
        named: &ArtifactHash,
        stream: S,
    ) -> Result<bool, StoreError>
    where
        B: AsRef<[u8]>,
        E: Into<Box<dyn std::error::Error + Send + Sync>>,
        S: Stream<Item = Result<B, E>> + Unpin,
    {
        let target = self.artifact_path(named);
        if fs::try_exists(&target).await.unwrap_or(false) {
            return Ok(false);
        }
        let partial = temporary(&self.config().data).join(Uuid::now_v7().to_string());
        let received = self.receive(named, stream, &partial, &target).await;
        if received.is_err() {
            // The error is what matters; a file left behind is removed at the next start.
            let _ = fs::remove_file(&partial).await;
        }
        received.map(|()| true)
    }

    async fn receive<B, E, S>(
        &self,
        named: &ArtifactHash,
        mut stream: S,
        partial: &Path,
        target: &Path,
    ) -> Result<(), StoreError>
    where
        B: AsRef<[u8]>,
        E: Into<Box<dyn std::error::Error + Send + Sync>>,
        S: Stream<Item = Result<B, E>> + Unpin,
    {
        let most = self.config().artifact_bytes;
        let mut file = File::create(partial)
            .await
            .map_err(StoreError::file(partial))?;
        let mut hasher = blake3::Hasher::new();
        while let Some(piece) = stream.next().await {
            let piece =
                piece.map_err(|error| StoreError::file(partial)(std::io::Error::other(error)))?;
            hasher.update(piece.as_ref());
            if hasher.count() > most {
                return Err(StoreError::TooLarge(most));
            }
            file.write_all(piece.as_ref())
                .await
                .map_err(StoreError::file(partial))?;
        }
        let actual = format!("b3:{}", hasher.finalize().to_hex());
        if actual != named.to_string() {
            return Err(StoreError::HashMismatch {
                named: named.to_string(),
                actual,
            });
        }
        file.sync_all().await.map_err(StoreError::file(partial))?;
        let shard = target.parent().expect("an artifact lies in its shard");
        fs::create_dir_all(shard)
            .await
            .map_err(StoreError::file(shard))?;
        fs::rename(partial, target)
            .await
            .map_err(StoreError::file(target))?;
        for directory in [
            shard,
            shard.parent().expect("a shard lies in the artifacts"),
        ] {
            let opened = File::open(directory)
                .await
                .map_err(StoreError::file(directory))?;
            opened
                .sync_all()
                .await
                .map_err(StoreError::file(directory))?;
        }
        Ok(())
    }

    /// Removes a checkpoint that no job names any more; at worst it stays.
    pub(super) async fn artifact_discard(&self, hash: &ArtifactHash) {
        let path = self.artifact_path(hash);
        if let Err(error) = fs::remove_file(&path).await {
            tracing::debug!(artifact.hash = %hash, %error, "checkpoint not removed");
        }
    }
}
