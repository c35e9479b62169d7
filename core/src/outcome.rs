//! Outcomes: what a stage yields, why it may yield nothing, and what it reports while it runs.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use crate::identity::{ArtifactHash, ResultHash, canonical_json};

/// The name of the artifact that later stages start from.
pub const STATE: &str = "state";
/// The name of the artifact that holds the raw p_xy of a recall, as JSON of a [`crate::memory::score::Signal`].
pub const SIGNAL: &str = "signal";
/// The name of the artifact that holds everything recorded at the samples of a stage, as JSON.
pub const HISTORY: &str = "history";
/// The name of the artifact that holds the inside of a beam along its bending, as JSON of a [`crate::beam::structure::report::Report`].
pub const STRUCTURE: &str = "structure";
/// The name of the artifact that holds a beam's grains, snapshot by snapshot, as a LAMMPS text dump.
pub const GRAINS_DUMP: &str = "grains.dump";
/// The name of the artifact that lists the files of a beam's membrane, `membrane_0000.vtp` and so on, for ParaView.
pub const MEMBRANE_COLLECTION: &str = "membrane.pvd";

/// What a stage yields.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Scalars by name; `None` where a number has no meaning, with the reason among the reasons or the warnings.
    pub results: BTreeMap<String, Option<f64>>,
    /// Why a scalar is `None`, in one word of a fixed set, by the scalar's name; tables call it `{name}_reason`.
    pub reasons: BTreeMap<String, String>,
    /// Files by name ([`STATE`], [`SIGNAL`], [`HISTORY`], [`STRUCTURE`], [`GRAINS_DUMP`], [`MEMBRANE_COLLECTION`] and what it lists).
    pub artifacts: BTreeMap<String, Vec<u8>>,
    /// What a reader of the numbers should know, in full sentences.
    pub warnings: Vec<String>,
    /// Time steps taken.
    pub steps: u64,
}

/// The part of an outcome that its hash covers.
#[derive(Serialize)]
struct HashedOutcome<'a> {
    results: &'a BTreeMap<String, Option<f64>>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    reasons: &'a BTreeMap<String, String>,
    artifacts: BTreeMap<&'a str, ArtifactHash>,
    warnings: &'a [String],
    steps: u64,
}

impl Outcome {
    /// The hash of all that must be equal wherever the stage runs.
    #[must_use]
    pub fn hash(&self) -> ResultHash {
        let artifacts = self
            .artifacts
            .iter()
            .map(|(name, bytes)| (name.as_str(), ArtifactHash::of_bytes(bytes)));
        let hashed = HashedOutcome {
            results: &self.results,
            reasons: &self.reasons,
            artifacts: artifacts.collect(),
            warnings: &self.warnings,
            steps: self.steps,
        };
        ResultHash::of_bytes(canonical_json(&hashed).as_bytes())
    }
}

/// Why a stage has no outcome.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Serialize, Deserialize)]
#[serde(tag = "reason", rename_all = "snake_case")]
pub enum StageFailure {
    /// The physics broke down: final, and cached like an outcome.
    #[error("{kind} at step {step}: {detail}; {remedy}")]
    Stopped {
        /// One word: `unstable`, `non_finite`, `not_at_rest` and others (docs/beam.md).
        kind: String,
        /// The step at which it was noticed.
        step: u64,
        /// What was seen, with numbers, and at which grain where there is one.
        detail: String,
        /// What to change.
        remedy: String,
    },
    /// An input or a checkpoint cannot be read: a fault of the machine, worth a retry.
    #[error("{detail}")]
    Input {
        /// What is wrong with which file.
        detail: String,
    },
    /// The caller asked to stop.
    #[error("interrupted at step {step}")]
    Interrupted {
        /// The step that the run had reached.
        step: u64,
    },
}

/// What a run tells its caller now and then; the answer says whether to go on.
pub struct Report<'a> {
    /// Steps done.
    pub step: u64,
    /// Steps in all; for `pack` an upper estimate while the servo works.
    pub steps: u64,
    /// Writes the complete state of every job of the ensemble, in the order they were given.
    pub checkpoint: &'a dyn Fn() -> Vec<Vec<u8>>,
}

/// The caller's side of a run: called about every hundred steps, never between two halves of one.
pub type Watch<'a> = &'a mut (dyn FnMut(&Report<'_>) -> ControlFlow<()> + Send);

/// The caller, and how many steps it was told to expect.
pub(crate) struct Progress<'a> {
    /// The caller's side.
    pub(crate) watch: Watch<'a>,
    /// Steps in all.
    pub(crate) steps: u64,
}

impl Progress<'_> {
    /// Reports `step` and asks whether to go on.
    pub(crate) fn ask(
        &mut self,
        step: u64,
        checkpoint: &dyn Fn() -> Vec<Vec<u8>>,
    ) -> Result<(), StageFailure> {
        match (self.watch)(&Report {
            step,
            steps: self.steps.max(step),
            checkpoint,
        }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(StageFailure::Interrupted { step }),
        }
    }
}
