//! An archive: finished stages in a directory, by identity, from which any worker takes what was computed before.
//!
//! A stage is `{identity}.json` with what it cost, and a file for each of its artifacts.
//! It is found only if all is there and has the hash that it had: states, which are large and soon made again, may be left out
//! of what is passed on.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use granary_core::identity::ResultHash;
use granary_core::stage::{Outcome, StageFailure, StageSpec};
use serde::{Deserialize, Serialize};

use crate::execute::{Finished, StageResult};

/// A directory of finished stages.
#[derive(Clone, Debug)]
pub struct Archive {
    directory: PathBuf,
}

/// An outcome that was kept, and how it was computed.
#[derive(Clone, Debug)]
pub struct Kept {
    /// What the stage yielded.
    pub outcome: Outcome,
    /// The release that computed it.
    pub engine_version: String,
    /// Its share of its ensemble's wall time \[s\].
    pub wall_s: f64,
    /// And of its CPU time \[s\].
    pub cpu_s: f64,
}

/// What is kept of one stage besides its artifacts.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    stage: StageSpec,
    physics: u32,
    engine: String,
    /// This stage's share of its ensemble's time \[s\].
    wall_s: f64,
    cpu_s: f64,
    /// Whether it was resumed from a checkpoint, so that it cost more.
    resumed: bool,
    end: End,
}

/// How a stage ended: what comes out the same wherever it is computed.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum End {
    Stopped(StageFailure),
    Done {
        steps: u64,
        results: BTreeMap<String, Option<f64>>,
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        reasons: BTreeMap<String, String>,
        warnings: Vec<String>,
        artifacts: Vec<String>,
        hash: ResultHash,
    },
}

impl Archive {
    /// The archive in `directory`, which need not exist yet.
    #[must_use]
    pub fn new(directory: PathBuf) -> Self {
        Self { directory }
    }

    /// An ensemble that was computed before, with what it cost then; none if any of it is missing.
    pub(crate) fn find(&self, specs: &[StageSpec]) -> Option<Finished> {
        let found: Option<Vec<(StageResult, Entry)>> =
            specs.iter().map(|spec| self.read(spec)).collect();
        let found = found.filter(|found| !found.is_empty())?;
        let sum = |part: fn(&Entry) -> f64| {
            let seconds: f64 = found.iter().map(|(_, entry)| part(entry)).sum();
            Duration::try_from_secs_f64(seconds).unwrap_or_default()
        };
        Some(Finished {
            wall: sum(|entry| entry.wall_s),
            cpu: sum(|entry| entry.cpu_s),
            results: found.into_iter().map(|(result, _)| result).collect(),
        })
    }

    /// What one stage yielded; none if anything of it is missing, or it failed.
    #[must_use]
    pub fn outcome(&self, spec: &StageSpec) -> Option<Kept> {
        let (result, entry) = self.read(spec)?;
        Some(Kept {
            outcome: result.ok()?,
            engine_version: entry.engine,
            wall_s: entry.wall_s,
            cpu_s: entry.cpu_s,
        })
    }

    /// Keeps what ended of an ensemble; that it cannot is no failure of the work.
    pub(crate) fn keep(&self, specs: &[StageSpec], finished: &Finished, resumed: bool) {
        let share = |time: Duration| time.as_secs_f64() / specs.len().max(1) as f64;
        for (spec, result) in specs.iter().zip(&finished.results) {
            let (end, artifacts) = match result {
                Ok(outcome) => (End::of(outcome), Some(&outcome.artifacts)),
                Err(stopped @ StageFailure::Stopped { .. }) => {
                    (End::Stopped(stopped.clone()), None)
                }
                Err(_) => continue,
            };
            let entry = Entry {
                stage: spec.clone(),
                physics: spec.kind().physics(),
                engine: env!("CARGO_PKG_VERSION").to_owned(),
                wall_s: share(finished.wall),
                cpu_s: share(finished.cpu),
                resumed,
                end,
            };
            let artifacts = artifacts.into_iter().flatten();
            if let Err(error) = self.write(spec, &entry, artifacts) {
                tracing::warn!(error = %error, directory = %self.directory.display(), "outcome not archived");
            }
        }
    }

    fn place(&self, spec: &StageSpec, ending: &str) -> PathBuf {
        self.directory
            .join(format!("{}.{ending}", spec.id().to_hex()))
    }

    fn read(&self, spec: &StageSpec) -> Option<(StageResult, Entry)> {
        let entry = std::fs::read(self.place(spec, "json")).ok()?;
        let entry: Entry = serde_json::from_slice(&entry).ok()?;
        if entry.stage != *spec || entry.physics != spec.kind().physics() {
            return None;
        }
        let result = match &entry.end {
            End::Stopped(failure) => Err(failure.clone()),
            End::Done {
                steps,
                results,
                reasons,
                warnings,
                artifacts,
                hash,
            } => {
                let artifact = |name: &String| {
                    let bytes = std::fs::read(self.place(spec, name)).ok()?;
                    Some((name.clone(), bytes))
                };
                let outcome = Outcome {
                    results: results.clone(),
                    reasons: reasons.clone(),
                    artifacts: artifacts.iter().map(artifact).collect::<Option<_>>()?,
                    warnings: warnings.clone(),
                    steps: *steps,
                };
                if outcome.hash() != *hash {
                    tracing::warn!(stage = %spec.id(), "archived outcome is damaged: computed again");
                    return None;
                }
                Ok(outcome)
            }
        };
        Some((result, entry))
    }

    /// Writes the entry last: it is there only if all is.
    fn write<'a>(
        &self,
        spec: &StageSpec,
        entry: &Entry,
        artifacts: impl Iterator<Item = (&'a String, &'a Vec<u8>)>,
    ) -> io::Result<()> {
        std::fs::create_dir_all(&self.directory)?;
        for (name, bytes) in artifacts {
            replace(&self.place(spec, name), bytes)?;
        }
        replace(
            &self.place(spec, "json"),
            &serde_json::to_vec_pretty(entry)?,
        )
    }
}

impl End {
    fn of(outcome: &Outcome) -> Self {
        Self::Done {
            steps: outcome.steps,
            results: outcome.results.clone(),
            reasons: outcome.reasons.clone(),
            warnings: outcome.warnings.clone(),
            artifacts: outcome.artifacts.keys().cloned().collect(),
            hash: outcome.hash(),
        }
    }
}

/// Writes a file beside its place, then puts it there: nobody reads half of it.
fn replace(place: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut unfinished = place.to_owned();
    unfinished
        .as_mut_os_string()
        .push(format!(".{}", std::process::id()));
    std::fs::write(&unfinished, bytes)?;
    std::fs::rename(unfinished, place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use granary_core::beam::point::BeamPoint;

    fn specs() -> Vec<StageSpec> {
        let defaults = BeamPoint::defaults("smoke").expect("a preset");
        let point = BeamPoint::from_parameters(defaults).expect("a point");
        vec![StageSpec::Grow(point.grow())]
    }

    fn finished(result: StageResult) -> Finished {
        Finished {
            results: vec![result],
            wall: Duration::from_secs(3),
            cpu: Duration::from_secs(2),
        }
    }

    fn outcome() -> Outcome {
        Outcome {
            results: BTreeMap::from([
                ("third".to_owned(), Some(1.0 / 3.0)),
                ("none".to_owned(), None),
            ]),
            reasons: BTreeMap::from([("none".to_owned(), "run_too_short".to_owned())]),
            artifacts: BTreeMap::from([("state".to_owned(), vec![1, 2, 3])]),
            warnings: vec!["short_edges: look".to_owned()],
            steps: 7,
        }
    }

    #[test]
    fn what_was_computed_is_found_with_what_it_cost() {
        let directory = tempfile::tempdir().expect("a directory");
        let archive = Archive::new(directory.path().join("new"));
        let specs = specs();
        assert!(archive.find(&specs).is_none());
        let stopped = StageFailure::Stopped {
            kind: "unstable".to_owned(),
            step: 4,
            detail: "d".to_owned(),
            remedy: "r".to_owned(),
        };
        for result in [Err(stopped), Ok(outcome())] {
            archive.keep(&specs, &finished(result.clone()), false);
            let found = archive.find(&specs).expect("it was kept");
            assert_eq!(found.results, [result]);
            assert_eq!((found.wall.as_secs(), found.cpu.as_secs()), (3, 2));
        }
    }

    #[test]
    fn what_may_end_otherwise_next_time_is_not_kept() {
        let directory = tempfile::tempdir().expect("a directory");
        let archive = Archive::new(directory.path().to_owned());
        archive.keep(
            &specs(),
            &finished(Err(StageFailure::Interrupted { step: 4 })),
            false,
        );
        assert!(archive.find(&specs()).is_none());
    }

    #[test]
    fn what_is_missing_or_damaged_is_computed_again() {
        let directory = tempfile::tempdir().expect("a directory");
        let archive = Archive::new(directory.path().to_owned());
        let specs = specs();
        let state = archive.place(&specs[0], "state");
        for damage in [
            |state: &Path| std::fs::remove_file(state),
            |state: &Path| std::fs::write(state, [1, 2, 4]),
        ] {
            archive.keep(&specs, &finished(Ok(outcome())), false);
            assert!(archive.find(&specs).is_some());
            damage(&state).expect("a file");
            assert!(archive.find(&specs).is_none());
        }
    }
}
