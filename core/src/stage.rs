//! Stages: pure units of work, named by their content.
//!
//! A stage's outcome is a function of its spec alone (and of its kind's version in [`crate::physics`], which its identity holds).
//! Stages that ask the same packing the same kind of question run side by side, as the lanes of one ensemble.

use serde::{Deserialize, Serialize};

use crate::beam::spec::{BendSpec, GrowSpec, JamSpec};
use crate::identity::{StageId, canonical_json};
use crate::lanes::VectorWidth;
use crate::memory::classifier::ClassifierSpec;
use crate::memory::spec::{EncodeSpec, PackSpec, Precision, RecallSpec, TrainSpec};
use crate::memory::waveform::Waveform;
use crate::physics;

mod choose;
mod work;

pub use work::Work;

pub use crate::outcome::{
    GRAINS_DUMP, HISTORY, MEMBRANE_COLLECTION, Outcome, Report, SIGNAL, STATE, STRUCTURE,
    StageFailure, Watch,
};

/// The kinds of stages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StageKind {
    /// A prepared pack of frictionless grains.
    Pack,
    /// The pack after one compression cycle with friction.
    Train,
    /// The beginning of an encoding that several words share.
    Encode,
    /// One waveform stored in it and recalled.
    Recall,
    /// A network that tells binary words apart.
    Classifier,
    /// Grains grown in a mold without friction.
    Grow,
    /// The grains compacted in their membrane.
    Jam,
    /// The beam bent.
    Bend,
}

impl StageKind {
    /// Every kind, each after the one that it needs.
    pub const ALL: [Self; 8] = [
        Self::Pack,
        Self::Train,
        Self::Encode,
        Self::Recall,
        Self::Classifier,
        Self::Grow,
        Self::Jam,
        Self::Bend,
    ];

    /// The physics version of its outcomes, which enters its identity.
    #[must_use]
    pub fn physics(self) -> u32 {
        match self {
            Self::Pack | Self::Train => physics::MEMORY,
            Self::Encode | Self::Recall => physics::RECALL,
            Self::Classifier => physics::CLASSIFIER,
            Self::Grow | Self::Jam | Self::Bend => physics::BEAM,
        }
    }

    /// The name in the database and on the wire.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pack => "pack",
            Self::Train => "train",
            Self::Encode => "encode",
            Self::Recall => "recall",
            Self::Classifier => "classifier",
            Self::Grow => "grow",
            Self::Jam => "jam",
            Self::Bend => "bend",
        }
    }
}

/// One unit of work.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", content = "spec", rename_all = "snake_case")]
pub enum StageSpec {
    /// See [`PackSpec`].
    Pack(PackSpec),
    /// See [`TrainSpec`].
    Train(TrainSpec),
    /// See [`EncodeSpec`].
    Encode(EncodeSpec),
    /// See [`RecallSpec`].
    Recall(RecallSpec),
    /// See [`ClassifierSpec`].
    Classifier(ClassifierSpec),
    /// See [`GrowSpec`].
    Grow(GrowSpec),
    /// See [`JamSpec`].
    Jam(JamSpec),
    /// See [`BendSpec`].
    Bend(BendSpec),
}

/// What an identity is the hash of.
#[derive(Serialize)]
struct Identity<'a> {
    physics: u32,
    #[serde(flatten)]
    stage: &'a StageSpec,
}

impl StageSpec {
    /// The kind of work.
    #[must_use]
    pub fn kind(&self) -> StageKind {
        match self {
            Self::Pack(_) => StageKind::Pack,
            Self::Train(_) => StageKind::Train,
            Self::Encode(_) => StageKind::Encode,
            Self::Recall(_) => StageKind::Recall,
            Self::Classifier(_) => StageKind::Classifier,
            Self::Grow(_) => StageKind::Grow,
            Self::Jam(_) => StageKind::Jam,
            Self::Bend(_) => StageKind::Bend,
        }
    }

    /// The identity: BLAKE3 of the canonical spec, its kind and the physics version.
    #[must_use]
    pub fn id(&self) -> StageId {
        StageId::of_bytes(
            canonical_json(&Identity {
                physics: self.kind().physics(),
                stage: self,
            })
            .as_bytes(),
        )
    }

    /// The stage whose state this one starts from, if any.
    #[must_use]
    pub fn needs(&self) -> Option<StageId> {
        match self {
            Self::Pack(_) | Self::Classifier(_) | Self::Grow(_) => None,
            Self::Train(spec) => Some(spec.pack),
            Self::Encode(spec) => Some(spec.train),
            Self::Recall(spec) => Some(spec.encode.unwrap_or(spec.train)),
            Self::Jam(spec) => Some(spec.grow),
            Self::Bend(spec) => Some(spec.jam),
        }
    }

    /// Whether it is a recall that goes on from an encoding, so that each of an ensemble has a state of its own to begin with.
    #[must_use]
    pub fn goes_on(&self) -> bool {
        matches!(self, Self::Recall(spec) if spec.encode.is_some())
    }

    /// Stages with equal keys that begin at one step can run as lanes of one ensemble: recalls in one trained pack with the same
    /// numerics, and encodings of words of one length.
    #[must_use]
    pub fn ensemble_key(&self) -> StageId {
        match self {
            Self::Recall(spec) => {
                let spec = RecallSpec {
                    encode: None,
                    waveform: Waveform::Zero,
                    gamma0: 0.0,
                    ..spec.clone()
                };
                Self::Recall(spec).id()
            }
            Self::Encode(spec) => {
                let waveform = match spec.waveform {
                    Waveform::BinaryWord { bits, .. } => Waveform::BinaryWord { bits, word: 0 },
                    ref other => other.clone(),
                };
                let spec = EncodeSpec {
                    waveform,
                    gamma0: 0.0,
                    ..spec.clone()
                };
                Self::Encode(spec).id()
            }
            alone => alone.id(),
        }
    }

    /// The largest number of stages with this key that one ensemble holds.
    #[must_use]
    pub fn max_lanes(&self) -> usize {
        let precision = match self {
            Self::Encode(spec) => spec.precision,
            Self::Recall(spec) => spec.precision,
            _ => return 1,
        };
        match precision {
            Precision::F64 => 8,
            Precision::F32 => 16,
        }
    }
}

/// The jobs of one ensemble.
pub struct Ensemble<'a> {
    /// Specs with equal [`StageSpec::ensemble_key`], at most [`StageSpec::max_lanes`] of them.
    pub specs: &'a [StageSpec],
    /// The [`STATE`] artifact of the stage that the first needs; empty if it needs none.
    ///
    /// All need the same, but for recalls that go on from encodings: their states are checkpoints where they have no other.
    pub input: &'a [u8],
    /// A checkpoint for each job, all taken at the same step, or none at all.
    pub checkpoints: Option<&'a [Vec<u8>]>,
}

/// Runs the jobs of one ensemble side by side, with the widest vectors of this machine; one result per job, in order.
///
/// The result of a job does not depend on the others, on their order, or on where it was interrupted and continued.
#[must_use]
pub fn run(ensemble: &Ensemble<'_>, watch: Watch<'_>) -> Vec<Result<Outcome, StageFailure>> {
    run_with(ensemble, VectorWidth::widest(), watch)
}

/// [`run`] with the vectors of `width`; the results are the same.
#[must_use]
pub fn run_with(
    ensemble: &Ensemble<'_>,
    width: VectorWidth,
    watch: Watch<'_>,
) -> Vec<Result<Outcome, StageFailure>> {
    choose::run(ensemble, width, watch)
        .unwrap_or_else(|failure| vec![Err(failure); ensemble.specs.len()])
}

/// The step at which a checkpoint was taken; `None` if `bytes` are not one of this physics version.
///
/// Jobs can be continued in one ensemble if their checkpoints were taken at the same step.
#[must_use]
pub fn checkpoint_step(bytes: &[u8]) -> Option<u64> {
    #[derive(Deserialize)]
    struct Step {
        step: u64,
    }
    let of = |version| crate::state_file::read_header::<Step>(version, bytes).ok();
    let header = of(physics::MEMORY)
        .or_else(|| of(physics::BEAM))
        .or_else(|| of(physics::CLASSIFIER));
    header.map(|header| header.step)
}
