//! State files: blocks of exact numbers under a header, for packs between two stages and runs between two steps.
//!
//! Little-endian: a magic word, the physics version, a JSON header, then blocks of `f64` and `u32`.
//! Every number is written exactly, so a run continued from a file yields the same bits.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::grains::{Motion, Pose};
use crate::identity::canonical_json;
use crate::neighbor::Key;

const MAGIC: &[u8; 8] = b"granary\x01";

/// Instead of the number of components that all histories have: each begins with its own.
const EACH_ITS_OWN: u32 = u32::MAX;

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

/// Reads only the header of a file of this physics version.
pub(crate) fn read_header<H: DeserializeOwned>(physics: u32, bytes: &[u8]) -> Result<H, String> {
    Reader::new(physics, bytes).map(|(header, _)| header)
}

/// Writes a state file.
pub(crate) struct Writer(Vec<u8>);

impl Writer {
    /// The bytes of the file.
    pub(crate) fn into_bytes(self) -> Vec<u8> {
        self.0
    }

    /// Begins a file of this physics version with its header.
    pub(crate) fn new<H: Serialize>(physics: u32, header: &H) -> Self {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(physics.to_le_bytes());
        let header = canonical_json(header);
        bytes.extend((header.len() as u32).to_le_bytes());
        bytes.extend(header.as_bytes());
        Self(bytes)
    }

    /// A length.
    pub(crate) fn count(&mut self, n: usize) {
        self.0.extend((n as u32).to_le_bytes());
    }

    /// A number of something.
    pub(crate) fn word(&mut self, n: u32) {
        self.0.extend(n.to_le_bytes());
    }

    /// Vectors and their count.
    pub(crate) fn vectors(&mut self, vectors: &[[f64; 3]]) {
        self.count(vectors.len());
        self.numbers(vectors.as_flattened());
    }

    /// Numbers, without their count.
    pub(crate) fn numbers(&mut self, numbers: &[f64]) {
        for number in numbers {
            self.0.extend(number.to_le_bytes());
        }
    }

    /// Numbers in single precision, without their count.
    pub(crate) fn singles(&mut self, numbers: &[f32]) {
        for number in numbers {
            self.0.extend(number.to_le_bytes());
        }
    }

    /// Poses and their count.
    pub(crate) fn poses(&mut self, poses: &[Pose]) {
        self.count(poses.len());
        for pose in poses {
            self.numbers(&pose.position);
            self.numbers(&pose.orientation);
        }
    }

    /// As many poses as motions.
    pub(crate) fn grains(&mut self, poses: &[Pose], motions: &[Motion]) {
        self.poses(poses);
        for motion in motions {
            self.numbers(&motion.velocity);
            self.numbers(&motion.spin);
        }
    }

    /// What contacts remember.
    pub(crate) fn contacts(&mut self, contacts: &[Remembered]) {
        self.count(contacts.len());
        let of_first = contacts.first().map_or(0, |contact| contact.history.len());
        let alike = contacts
            .iter()
            .all(|contact| contact.history.len() == of_first);
        self.word(if alike { of_first as u32 } else { EACH_ITS_OWN });
        for Remembered { i, key, history } in contacts {
            if !alike {
                self.count(history.len());
            }
            self.0.extend(i.to_le_bytes());
            self.0.extend(key.j.to_le_bytes());
            self.0.extend([key.a, key.b]);
            self.numbers(history);
        }
    }
}

/// Reads a state file.
pub(crate) struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    /// The header of a file of this physics version, and the rest of it.
    pub(crate) fn new<H: DeserializeOwned>(
        physics: u32,
        bytes: &'a [u8],
    ) -> Result<(H, Self), String> {
        let mut reader = Self(bytes);
        if reader.take(MAGIC.len())? != MAGIC {
            return Err("not a state file".to_owned());
        }
        let version = reader.word()?;
        if version != physics {
            return Err(format!(
                "state of physics version {version}; this is {physics}"
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

    /// A length or a number of something.
    pub(crate) fn word(&mut self) -> Result<u32, String> {
        let mut word = [0; 4];
        word.copy_from_slice(self.take(4)?);
        Ok(u32::from_le_bytes(word))
    }

    /// Vectors and their count.
    pub(crate) fn vectors(&mut self) -> Result<Vec<[f64; 3]>, String> {
        let n = self.word()?;
        (0..n).map(|_| self.numbers()).collect()
    }

    /// N numbers.
    pub(crate) fn numbers<const N: usize>(&mut self) -> Result<[f64; N], String> {
        let bytes = self.take(8 * N)?;
        Ok(std::array::from_fn(|n| {
            let mut word = [0; 8];
            word.copy_from_slice(&bytes[8 * n..8 * n + 8]);
            f64::from_le_bytes(word)
        }))
    }

    /// N numbers in single precision.
    pub(crate) fn singles<const N: usize>(&mut self) -> Result<[f32; N], String> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            let mut word = [0; 4];
            word.copy_from_slice(self.take(4)?);
            *number = f32::from_le_bytes(word);
        }
        Ok(numbers)
    }

    /// As many numbers in single precision.
    pub(crate) fn many_singles(&mut self, count: usize) -> Result<Vec<f32>, String> {
        let words = self.take(4 * count)?.chunks_exact(4);
        let number = |word: &[u8]| f32::from_le_bytes([word[0], word[1], word[2], word[3]]);
        Ok(words.map(number).collect())
    }

    /// Poses and their count.
    pub(crate) fn poses(&mut self) -> Result<Vec<Pose>, String> {
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

    /// As many poses as motions.
    pub(crate) fn grains(&mut self) -> Result<(Vec<Pose>, Vec<Motion>), String> {
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

    /// What contacts of so many grains remember.
    pub(crate) fn contacts(&mut self, grains: usize) -> Result<Vec<Remembered>, String> {
        let (n, of_all) = (self.word()?, self.word()?);
        let mut contacts = vec![];
        for _ in 0..n {
            let components = match of_all {
                EACH_ITS_OWN => self.word()?,
                all => all,
            };
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

    /// What is left.
    pub(crate) fn rest(&self) -> &'a [u8] {
        self.0
    }

    /// That nothing is left.
    pub(crate) fn end(&self) -> Result<(), String> {
        if self.0.is_empty() {
            Ok(())
        } else {
            Err(format!("{} bytes too many", self.0.len()))
        }
    }
}
