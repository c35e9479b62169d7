//! State files of the memory experiment: a pack between two stages, and a run between two steps.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::sound::Sound;
use super::spec::{PackSpec, TrainSpec};
use crate::grains::{Motion, Pose};
use crate::physics;
use crate::state_file::{Reader, Remembered, Writer};

/// The specs that led to a state: all that a later stage needs to know of its past.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Past {
    /// How the pack was made.
    pub pack: PackSpec,
    /// How it was trained, if it was.
    pub train: Option<TrainSpec>,
    /// The walls \[R\].
    pub walls: [f64; 6],
    /// p_xy \[E\] of the training compression, which carries no waveform, at the 256 values of u; empty before training.
    pub unsheared: Vec<f64>,
    /// What the trained pack sounds like, if it was heard.
    pub sound: Option<Sound>,
}

/// A pack between two stages.
#[derive(Clone, Debug, PartialEq)]
pub struct PackState {
    /// What led to it.
    pub past: Past,
    /// Where the grains are.
    pub poses: Vec<Pose>,
    /// How they move.
    pub motions: Vec<Motion>,
    /// What the contacts remember.
    pub contacts: Vec<Remembered>,
}

impl PackState {
    /// The bytes of the file.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut writer = Writer::new(physics::MEMORY, &self.past);
        writer.grains(&self.poses, &self.motions);
        writer.contacts(&self.contacts);
        writer.into_bytes()
    }

    /// Reads a file; the error says what is wrong with it.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let (past, mut reader) = Reader::new(physics::MEMORY, bytes)?;
        let (poses, motions) = reader.grains()?;
        let contacts = reader.contacts(poses.len())?;
        reader.end()?;
        Ok(Self {
            past,
            poses,
            motions,
            contacts,
        })
    }
}

/// One replica of a run between two steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint<H> {
    /// What the driver needs to go on.
    pub header: H,
    /// The shared reference.
    pub reference: Vec<Pose>,
    /// Displacement and turn of every grain from the reference, as a pose.
    pub offsets: Vec<Pose>,
    /// How the grains move.
    pub motions: Vec<Motion>,
    /// What the contacts remember.
    pub contacts: Vec<Remembered>,
}

impl<H: Serialize + DeserializeOwned> Checkpoint<H> {
    /// The bytes of the file.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut writer = Writer::new(physics::MEMORY, &self.header);
        writer.poses(&self.reference);
        writer.grains(&self.offsets, &self.motions);
        writer.contacts(&self.contacts);
        writer.into_bytes()
    }

    /// Reads a file; the error says what is wrong with it.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let (header, mut reader) = Reader::new(physics::MEMORY, bytes)?;
        let reference = reader.poses()?;
        let (offsets, motions) = reader.grains()?;
        let contacts = reader.contacts(offsets.len())?;
        reader.end()?;
        if reference.len() != offsets.len() {
            return Err("reference and offsets differ in length".to_owned());
        }
        Ok(Self {
            header,
            reference,
            offsets,
            motions,
            contacts,
        })
    }
}
