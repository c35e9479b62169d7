//! How much work a stage is, known before it runs.

use serde::{Deserialize, Serialize};

use super::{StageKind, StageSpec};
use crate::memory::spec::{
    EncodeSpec, ForceLaw, PackSpec, Precision, RecallSpec, ShapeName, TrainSpec,
};
use crate::memory::{hold_steps, ramp_steps};
use crate::scene::FARTHEST_SKIN;

/// What an ensemble holds however few its grains \[bytes\]: samples, signals and results of all replicas.
const BESIDES: u64 = 2 << 20;

/// An ensemble that would take more than this has fewer replicas.
const MOST_BYTES: u64 = 10 << 30;

/// The size of a stage's work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Work {
    /// Grains times steps; the vertices of a membrane count as grains, and so do the neurons of a classifier.
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
                let all = (1 + u64::from(spec.second_cycle)) * (2 * ramp + hold);
                all - spec.steps_before()
            }
            (Self::Encode(spec), _) => spec.steps(),
            (Self::Classifier(spec), _) => spec.steps(),
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
            Self::Pack(pack) => {
                let bytes = self.bytes(pack, self.training(before), self.lanes(before));
                (u64::from(pack.grains), bytes)
            }
            Self::Grow(grow) => (grow.predicted_bodies(), grow.predicted_bytes()),
            Self::Classifier(spec) => (spec.neurons(), spec.bytes()),
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

    /// Replicas of the ensemble that the stage runs in: as many as vectors have room for, or fewer where these would take more than
    /// 10 GiB (law M2 in large packs).
    #[must_use]
    pub fn lanes(&self, before: &[Self]) -> usize {
        let widths: &[usize] = match self.max_lanes() {
            16 => &[16, 8],
            8 => &[8, 1],
            _ => &[1],
        };
        let Some(Self::Pack(pack)) = before.first() else {
            return widths[0];
        };
        let fits = |lanes: usize| self.bytes(pack, self.training(before), lanes) <= MOST_BYTES;
        let fitting = widths.iter().copied().find(|&lanes| fits(lanes));
        fitting.unwrap_or(widths[widths.len() - 1])
    }

    /// The training that the stage is, or comes after.
    fn training<'a>(&'a self, before: &'a [Self]) -> Option<&'a TrainSpec> {
        before.iter().chain([self]).find_map(|stage| match stage {
            Self::Train(train) => Some(train),
            _ => None,
        })
    }

    /// Stages of one class run at one speed: kind, shape or experiment, precision, and the law where it is not H.
    #[must_use]
    pub fn class(&self, before: &[Self]) -> String {
        let shape = match before.first().unwrap_or(self) {
            Self::Classifier(_) => return "classifier".to_owned(),
            Self::Pack(pack) if pack.shape == ShapeName::Sphere => "sphere",
            Self::Pack(_) => "tetrahedron",
            _ => "beam",
        };
        let precision = match self {
            Self::Recall(RecallSpec { precision, .. })
            | Self::Encode(EncodeSpec { precision, .. })
                if *precision == Precision::F32 =>
            {
                "f32"
            }
            _ => "f64",
        };
        // An encoding is the beginning of a recall.
        let kind = match self.kind() {
            StageKind::Encode => StageKind::Recall,
            kind => kind,
        };
        let law = match self.training(before).map(|train| train.force_law) {
            None | Some(ForceLaw::H) => "",
            Some(ForceLaw::M1) => "/M1",
            Some(ForceLaw::M2) => "/M2",
        };
        format!("{}/{shape}/{precision}{law}", kind.name())
    }

    /// Memory of an ensemble of so many replicas in `pack` \[bytes\], not to be exceeded (`core/tests/random_specs.rs`).
    fn bytes(&self, pack: &PackSpec, train: Option<&TrainSpec>, lanes: usize) -> u64 {
        let lanes = lanes as u64;
        let (scalar, skin) = match self {
            Self::Recall(RecallSpec {
                precision, skin, ..
            })
            | Self::Encode(EncodeSpec {
                precision, skin, ..
            }) => match precision {
                Precision::F32 => (4, *skin),
                Precision::F64 => (8, *skin),
            },
            Self::Train(spec) => (8, spec.skin.max(FARTHEST_SKIN)),
            _ => (8, FARTHEST_SKIN),
        };
        let (components, slices) = match train.map(|train| (train.force_law, train.slices)) {
            None | Some((ForceLaw::H, _)) => (3, 0),
            Some((ForceLaw::M1, _)) => (4, 0),
            Some((ForceLaw::M2, slices)) => {
                // Room for a stack is asked for in eights.
                let number = slices.map_or(0, |slices| u64::from(slices.number));
                (11, number.next_multiple_of(8))
            }
        };
        // The list and the one before it: reference, grains, a flag, a spring and where slices are; and the keys that searches
        // find, in room that grows by doubling.
        let stacks = if slices > 0 { 24 } else { 0 };
        let candidate = 2 * (4 * scalar + 13 + components * scalar * lanes + stacks) + 40;
        // Slices of all that touch; of a checkpoint, its bytes, and one replica's words and bytes in room that grows by doubling.
        let touching = candidates(pack, 0.0) as u64 * slices * 2 * ((scalar + 8) * lanes + 32);
        // State and sums, what they were before; a checkpoint; what is the same for all lanes.
        let grain = lanes * (40 * scalar + 700) + 1_500;
        // A copy of a trained pack is struck and listened to.
        let scenes = if matches!(self, Self::Train(_)) { 2 } else { 1 };
        let candidates = scenes * candidates(pack, skin) as u64;
        BESIDES + u64::from(pack.grains) * (candidates * candidate + scenes * touching + grain)
    }
}

/// Candidates per grain that lists reaching by `skin` may hold.
///
/// Counted in packs of 512 at skins from 0.05 to 1: spheres 3.6 + 2.8 s; tetrahedra no more than 8 + 20 s/(1 − 𝒪), and where
/// their spheres almost coincide 50 + 46 s. Overlaps and compression bring grains nearer by s0, taken as 0.15 + δ0.
fn candidates(pack: &PackSpec, skin: f64) -> f64 {
    let s = skin + 0.15 + pack.delta0;
    let counted = match pack.shape {
        ShapeName::Sphere => 4.0 + 3.0 * s,
        ShapeName::Tetrahedron => (8.0 + 20.0 * s / (1.0 - pack.overlap)).min(50.0 + 46.0 * s),
    };
    1.3 * counted + 1.0
}
