//! Finished work that waits on disk for its server.
//!
//! One directory per lease: the files that its outcomes name, then `report.json`, whose presence says that all is there.

use std::io;
use std::path::{Path, PathBuf};

use bytes::Bytes;
use granary_api::id::{ArtifactHash, LeaseId};

use crate::report::Report;

const REPORT: &str = "report.json";

/// The most reports that are kept; a slot never adds one before its last is delivered, so this bounds only what old runs left.
const MOST: usize = 256;

/// Where reports wait; without a directory they wait in memory alone.
#[derive(Clone, Debug)]
pub(crate) struct Spool {
    directory: Option<PathBuf>,
}

impl Spool {
    pub(crate) fn new(directory: Option<PathBuf>) -> Self {
        Self { directory }
    }

    fn place(&self, lease: LeaseId) -> Option<PathBuf> {
        Some(self.directory.as_ref()?.join(lease.to_string()))
    }

    /// Writes `report` down, unless it is there already or there is no room.
    pub(crate) async fn keep(&self, report: &Report) {
        let Some(place) = self
            .place(report.lease)
            .filter(|place| !place.join(REPORT).exists())
        else {
            return;
        };
        let report = report.clone();
        let written = tokio::task::spawn_blocking(move || write(&place, &report)).await;
        match written.map_err(io::Error::other).flatten() {
            Ok(()) => tracing::info!("report spooled"),
            Err(error) => tracing::warn!(error = %error, "report not spooled, it waits in memory"),
        }
    }

    /// Removes the report of `lease`, if it is there.
    pub(crate) async fn forget(&self, lease: LeaseId) {
        if let Some(place) = self.place(lease).filter(|place| place.exists()) {
            // What cannot be removed is offered again at the next start, and refused by its lease.
            let _ = tokio::fs::remove_dir_all(place).await;
        }
    }

    /// The reports that an earlier worker could not deliver.
    pub(crate) async fn pending(&self) -> Vec<Report> {
        let Some(directory) = self.directory.clone() else {
            return vec![];
        };
        let read = tokio::task::spawn_blocking(move || read_all(&directory)).await;
        read.map_err(io::Error::other).flatten().unwrap_or_default()
    }
}

fn write(place: &Path, report: &Report) -> io::Result<()> {
    if let Some(parent) = place.parent()
        && parent.is_dir()
        && std::fs::read_dir(parent)?.count() >= MOST
    {
        return Err(io::Error::other(format!("{MOST} reports wait already")));
    }
    std::fs::create_dir_all(place)?;
    for (hash, bytes) in &report.artifacts {
        std::fs::write(place.join(hash.to_hex()), bytes)?;
    }
    let unfinished = place.join("report.new");
    std::fs::write(&unfinished, serde_json::to_vec(report)?)?;
    std::fs::File::open(&unfinished)?.sync_all()?;
    std::fs::rename(unfinished, place.join(REPORT))
}

fn read_all(directory: &Path) -> io::Result<Vec<Report>> {
    let mut reports = vec![];
    for entry in std::fs::read_dir(directory)? {
        let place = entry?.path();
        match read(&place) {
            Ok(report) => reports.push(report),
            Err(error) => {
                tracing::warn!(path = %place.display(), error = %error, "spooled report not readable");
            }
        }
    }
    Ok(reports)
}

fn read(place: &Path) -> io::Result<Report> {
    let mut report: Report = serde_json::from_slice(&std::fs::read(place.join(REPORT))?)?;
    let hashes: Vec<ArtifactHash> = report
        .completion
        .outcomes
        .iter()
        .flat_map(|outcome| outcome.artifacts.values().copied())
        .collect();
    for hash in hashes {
        // A file that is not here was stored before the report was spooled.
        let path = place.join(hash.to_hex());
        if path.exists() {
            report
                .artifacts
                .insert(hash, Bytes::from(std::fs::read(path)?));
        }
    }
    Ok(report)
}

#[cfg(test)]
mod tests {
    use super::*;
    use granary_api::lease::{Completion, FailureReport};
    use std::collections::BTreeMap;

    #[tokio::test]
    async fn a_spooled_report_is_read_back_until_it_is_forgotten() {
        let directory = tempfile::tempdir().expect("temporary directory");
        let spool = Spool::new(Some(directory.path().join("spool")));
        assert!(spool.pending().await.is_empty());
        let report = Report {
            lease: LeaseId::new(),
            completion: Completion { outcomes: vec![] },
            failures: FailureReport { failures: vec![] },
            artifacts: BTreeMap::new(),
        };
        spool.keep(&report).await;
        spool.keep(&report).await;
        let pending = spool.pending().await;
        assert_eq!(pending.len(), 1);
        assert_eq!(pending[0].lease, report.lease);
        spool.forget(report.lease).await;
        assert!(spool.pending().await.is_empty());
    }
}
