//! How much work a stage is, known before it runs.

use serde::{Deserialize, Serialize};

use super::StageSpec;
use crate::memory::spec::{PackSpec, Precision, ShapeName};
use crate::memory::{hold_steps, ramp_steps};

/// The size of a stage's work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Work {
    /// Grains times steps; the vertices of a membrane count as grains.
    pub grain_steps: u64,
    /// Time steps.
    pub steps: u64,
    /// Memory of the ensemble that the stage would run in \[bytes\].
    pub bytes: u64,
}

impl StageSpec {
    /// Time steps; an estimate where a stage ends when the grains rest, and 0 of `jam` and `bend` without the stages before them.
    #[must_use]
    pub fn steps(&self, before: &[Self]) -> u64 {
        match (self, before) {
            (Self::Pack(spec), _) => spec.predicted_steps(),
            (Self::Train(spec), _) => 2 * ramp_steps(spec.ramp, spec.time_step),
            (Self::Recall(spec), _) => {
                let ramp = ramp_steps(spec.ramp, spec.time_step);
                let hold = hold_steps(spec.hold, ramp);
                2 * ramp + hold + if spec.second_cycle { 2 * ramp } else { 0 }
            }
            (Self::Grow(spec), _) => spec.predicted_steps(),
            (Self::Jam(spec), [Self::Grow(grow), ..]) => spec.predicted_steps(grow),
            (Self::Bend(spec), [Self::Grow(grow), Self::Jam(jam), ..]) => {
                spec.predicted_steps(jam, grow)
            }
            (Self::Jam(_) | Self::Bend(_), _) => 0,
        }
    }

    /// How much work the stage is after those in `before`, the first of them first.
    #[must_use]
    pub fn work(&self, before: &[Self]) -> Work {
        let steps = self.steps(before);
        let (grains, bytes) = match before.first().unwrap_or(self) {
            Self::Pack(pack) => (u64::from(pack.grains), self.bytes(pack)),
            Self::Grow(grow) => (grow.predicted_bodies(), grow.predicted_bytes()),
            _ => (0, 0),
        };
        let kept = match (self, before) {
            (Self::Bend(spec), [Self::Grow(grow), ..]) => spec.predicted_snapshot_bytes(grow),
            _ => 0,
        };
        Work {
            grain_steps: grains.saturating_mul(steps),
            steps,
            bytes: bytes.saturating_add(kept),
        }
    }

    /// Stages of one class run at one speed: kind, shape or experiment, and precision.
    #[must_use]
    pub fn class(&self, before: &[Self]) -> String {
        let shape = match before.first().unwrap_or(self) {
            Self::Pack(pack) if pack.shape == ShapeName::Sphere => "sphere",
            Self::Pack(_) => "tetrahedron",
            _ => "beam",
        };
        let precision = match self {
            Self::Recall(recall) if recall.precision == Precision::F32 => "f32",
            _ => "f64",
        };
        format!("{}/{shape}/{precision}", self.kind().name())
    }

    /// Memory of an ensemble of the memory experiment in `pack` \[bytes\].
    fn bytes(&self, pack: &PackSpec) -> u64 {
        // Generous per-grain sizes of one lane: state, list and springs (`granary bench` prints the measured ones).
        let (scalar, lanes) = match self {
            Self::Recall(spec) if spec.precision == Precision::F32 => (4, 16),
            Self::Recall(_) => (8, 8),
            _ => (8, 1),
        };
        let contacts = match pack.shape {
            ShapeName::Sphere => 6,
            ShapeName::Tetrahedron => 12,
        };
        u64::from(pack.grains) * ((19 + 3 * contacts) * scalar * lanes + contacts * 64 + 256)
    }
}
