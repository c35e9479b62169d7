//! The lock on a data directory: one process at a time, and its address for whoever comes second.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::Path;

use super::StoreError;

/// Held until it is dropped, or its process ends in whatever way.
pub(super) struct DataLock {
    file: File,
    path: std::path::PathBuf,
}

impl DataLock {
    /// Takes the lock of `data`, making the directory if it is missing.
    pub(super) fn take(data: &Path, holder: &str) -> Result<Self, StoreError> {
        std::fs::create_dir_all(data).map_err(StoreError::file(data))?;
        let path = data.join("granary.lock");
        let mut options = OpenOptions::new();
        let options = options.read(true).write(true).create(true).truncate(false);
        let mut file = options.open(&path).map_err(StoreError::file(&path))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut holder = String::new();
                let mut start = Read::by_ref(&mut file).take(1000);
                start
                    .read_to_string(&mut holder)
                    .map_err(StoreError::file(&path))?;
                return Err(StoreError::Locked {
                    path: data.display().to_string(),
                    holder: holder.trim().to_owned(),
                });
            }
            Err(TryLockError::Error(source)) => return Err(StoreError::file(&path)(source)),
        }
        let lock = Self { file, path };
        lock.announce(holder)?;
        Ok(lock)
    }

    /// Writes who holds it.
    pub(super) fn announce(&self, holder: &str) -> Result<(), StoreError> {
        let mut file = &self.file;
        let mut write = || {
            file.set_len(0)?;
            file.rewind()?;
            writeln!(file, "{holder}")
        };
        write().map_err(StoreError::file(&self.path))
    }
}
