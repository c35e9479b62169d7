//! State files: a pack between two stages, and a run between two steps.
//!
//! Little-endian: a magic word, the physics version, a JSON header, then blocks of `f64` and `u32`.
//! Every number is written exactly, so a run continued from a file yields the same bits.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::spec::{PackSpec, TrainSpec};
use crate::PHYSICS_VERSION;
use crate::grains::{Motion, Pose};
use crate::identity::canonical_json;
use crate::neighbor::Key;

const MAGIC: &[u8; 8] = b"granary\x01";

/// What one contact remembers.
#[derive(Clone, Debug, PartialEq)]
pub struct Remembered {
    /// The first grain.
    pub i: u32,
    /// The pair.
    pub key: Key,
    /// The law's history.
    pub history: Vec<f64>,
}

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
        let mut writer = Writer::new(&self.past);
        writer.grains(&self.poses, &self.motions);
        writer.contacts(&self.contacts);
        writer.0
    }

    /// Reads a file; the error says what is wrong with it.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let (past, mut reader) = Reader::new(bytes)?;
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
        let mut writer = Writer::new(&self.header);
        writer.poses(&self.reference);
        writer.grains(&self.offsets, &self.motions);
        writer.contacts(&self.contacts);
        writer.0
    }

    /// Reads a file; the error says what is wrong with it.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let (header, mut reader) = Reader::new(bytes)?;
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

/// Reads only the header of a file.
pub fn read_header<H: DeserializeOwned>(bytes: &[u8]) -> Result<H, String> {
    Reader::new(bytes).map(|(header, _)| header)
}

struct Writer(Vec<u8>);

impl Writer {
    fn new<H: Serialize>(header: &H) -> Self {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(PHYSICS_VERSION.to_le_bytes());
        let header = canonical_json(header);
        bytes.extend((header.len() as u32).to_le_bytes());
        bytes.extend(header.as_bytes());
        Self(bytes)
    }

    fn count(&mut self, n: usize) {
        self.0.extend((n as u32).to_le_bytes());
    }

    fn numbers(&mut self, numbers: &[f64]) {
        for number in numbers {
            self.0.extend(number.to_le_bytes());
        }
    }

    fn poses(&mut self, poses: &[Pose]) {
        self.count(poses.len());
        for pose in poses {
            self.numbers(&pose.position);
            self.numbers(&pose.orientation);
        }
    }

    fn grains(&mut self, poses: &[Pose], motions: &[Motion]) {
        self.poses(poses);
        for motion in motions {
            self.numbers(&motion.velocity);
            self.numbers(&motion.spin);
        }
    }

    fn contacts(&mut self, contacts: &[Remembered]) {
        self.count(contacts.len());
        self.count(contacts.first().map_or(0, |contact| contact.history.len()));
        for Remembered { i, key, history } in contacts {
            self.0.extend(i.to_le_bytes());
            self.0.extend(key.j.to_le_bytes());
            self.0.extend([key.a, key.b]);
            self.numbers(history);
        }
    }
}

struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn new<H: DeserializeOwned>(bytes: &'a [u8]) -> Result<(H, Self), String> {
        let mut reader = Self(bytes);
        if reader.take(MAGIC.len())? != MAGIC {
            return Err("not a state file".to_owned());
        }
        let version = reader.word()?;
        if version != PHYSICS_VERSION {
            return Err(format!(
                "state of physics version {version}; this is {PHYSICS_VERSION}"
            ));
        }
        let length = reader.word()? as usize;
        let header = serde_json::from_slice(reader.take(length)?)
            .map_err(|error| format!("header: {error}"))?;
        Ok((header, reader))
    }

    fn take(&mut self, n: usize) -> Result<&'a [u8], String> {
        if n > self.0.len() {
            return Err("the file ends early".to_owned());
        }
        let (head, tail) = self.0.split_at(n);
        self.0 = tail;
        Ok(head)
    }

    fn word(&mut self) -> Result<u32, String> {
        let mut word = [0; 4];
        word.copy_from_slice(self.take(4)?);
        Ok(u32::from_le_bytes(word))
    }

    fn numbers<const N: usize>(&mut self) -> Result<[f64; N], String> {
        let bytes = self.take(8 * N)?;
        Ok(std::array::from_fn(|n| {
            let mut word = [0; 8];
            word.copy_from_slice(&bytes[8 * n..8 * n + 8]);
            f64::from_le_bytes(word)
        }))
    }

    fn poses(&mut self) -> Result<Vec<Pose>, String> {
        let n = self.word()?;
        (0..n)
            .map(|_| {
                Ok(Pose {
                    position: self.numbers()?,
                    orientation: self.numbers()?,
                })
            })
            .collect()
    }

    fn grains(&mut self) -> Result<(Vec<Pose>, Vec<Motion>), String> {
        let poses = self.poses()?;
        let motions: Result<Vec<Motion>, String> = poses
            .iter()
            .map(|_| {
                Ok(Motion {
                    velocity: self.numbers()?,
                    spin: self.numbers()?,
                })
            })
            .collect();
        Ok((poses, motions?))
    }

    fn contacts(&mut self, grains: usize) -> Result<Vec<Remembered>, String> {
        let (n, components) = (self.word()?, self.word()?);
        let mut contacts = vec![];
        for _ in 0..n {
            let (i, j) = (self.word()?, self.word()?);
            let spheres = self.take(2)?;
            let key = Key {
                j,
                a: spheres[0],
                b: spheres[1],
            };
            if i >= j || j as usize >= grains || key.a > 3 || key.b > 3 {
                return Err(format!(
                    "contact of grains {i} and {j} is not one of {grains} grains"
                ));
            }
            let mut history = vec![];
            for _ in 0..components {
                let [number] = self.numbers()?;
                history.push(number);
            }
            contacts.push(Remembered { i, key, history });
        }
        Ok(contacts)
    }

    fn end(&self) -> Result<(), String> {
        if self.0.is_empty() {
            Ok(())
        } else {
            Err(format!("{} bytes too many", self.0.len()))
        }
    }
}
