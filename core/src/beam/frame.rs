//! What is stored of a bent beam to be looked at: its grains and its membrane, moment by moment, in single precision.
//!
//! A place of 0.4 m is so known to 30 nm, less than a hundred-thousandth of a grain.

use super::interior::Interior;
use super::rig::{Beam, Friction};
use crate::state_file::{Reader, Writer};

pub(super) mod dump;
pub(super) mod polydata;

/// What is known of a grain besides its place and velocity where the structure is analyzed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GrainValues {
    /// D_min since the frame before \[m\]; NaN where it has none.
    pub(super) non_affine: f32,
    /// φ_i; NaN where it has none.
    pub(super) local_volume_fraction: f32,
    /// z_i: grains that press on it.
    pub(super) contacts: f32,
}

/// One moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Frame {
    /// Steps done.
    pub(super) step: u64,
    /// Since the rods set out \[s\].
    pub(super) time: f64,
    /// Centers of the grains \[m\].
    pub(super) positions: Vec<[f32; 3]>,
    /// \[m/s\].
    pub(super) velocities: Vec<[f32; 3]>,
    /// Of every grain, or of none.
    pub(super) values: Vec<GrainValues>,
    /// The membrane's vertices \[m\].
    pub(super) vertices: Vec<[f32; 3]>,
}

fn single(vector: [f64; 3]) -> [f32; 3] {
    vector.map(|x| x as f32)
}

impl Frame {
    /// The beam as it is now, whose inside is `interior`.
    pub(super) fn of<T: Friction>(
        beam: &Beam<T>,
        interior: &Interior,
        (step, time): (u64, f64),
    ) -> Self {
        let grains = 0..beam.grains.len();
        Self {
            step,
            time,
            positions: interior.positions.iter().copied().map(single).collect(),
            velocities: grains
                .map(|i| single(beam.grains.motion(i, 0).velocity))
                .collect(),
            values: vec![],
            vertices: interior.vertices.iter().copied().map(single).collect(),
        }
    }

    /// Low and high corner of the box around the membrane \[m\].
    fn bounds(&self) -> [[f32; 3]; 2] {
        let around = |pick: fn(f32, f32) -> f32| {
            let both = |a: [f32; 3], b: &[f32; 3]| std::array::from_fn(|k| pick(a[k], b[k]));
            let first = self.vertices.first().copied().unwrap_or_default();
            self.vertices.iter().fold(first, both)
        };
        [around(f32::min), around(f32::max)]
    }

    /// Writes it into a state file.
    pub(super) fn write(&self, writer: &mut Writer) {
        writer.word((self.step >> 32) as u32);
        writer.word(self.step as u32);
        writer.numbers(&[self.time]);
        for vectors in [&self.positions, &self.velocities, &self.vertices] {
            writer.count(vectors.len());
            writer.singles(vectors.as_flattened());
        }
        writer.count(self.values.len());
        for of in &self.values {
            writer.singles(&[of.non_affine, of.local_volume_fraction, of.contacts]);
        }
    }

    /// Reads it from a state file.
    pub(super) fn read(reader: &mut Reader<'_>) -> Result<Self, String> {
        let step = u64::from(reader.word()?) << 32 | u64::from(reader.word()?);
        let [time] = reader.numbers()?;
        let mut vectors = || -> Result<Vec<[f32; 3]>, String> {
            let count = reader.word()?;
            (0..count).map(|_| reader.singles()).collect()
        };
        let (positions, velocities, vertices) = (vectors()?, vectors()?, vectors()?);
        let mut values = vec![];
        for _ in 0..reader.word()? {
            let [non_affine, local_volume_fraction, contacts] = reader.singles()?;
            values.push(GrainValues {
                non_affine,
                local_volume_fraction,
                contacts,
            });
        }
        Ok(Self {
            step,
            time,
            positions,
            velocities,
            values,
            vertices,
        })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::physics;
    use crate::state_file::{Reader, Writer};

    /// Two grains, the second with a number of nine digits, in a membrane of one tetrahedron.
    pub(in crate::beam) fn frame(step: u64, values: Vec<GrainValues>) -> Frame {
        Frame {
            step,
            time: 0.125,
            positions: vec![[0.0, -1e-3, 2.5e-3], [0.123_456_79, 1e-12, 3.0]],
            velocities: vec![[0.0; 3], [-1e-7, 2.0, 0.1]],
            values,
            vertices: vec![
                [-1.0, -1.0, -1.0],
                [1.0, -1.0, -1.0],
                [0.0, 1.0, -1.0],
                [0.0, 0.0, 4.0],
            ],
        }
    }

    /// Values of the two grains.
    pub(in crate::beam) fn values() -> Vec<GrainValues> {
        let one = |non_affine, contacts| GrainValues {
            non_affine,
            local_volume_fraction: 0.5,
            contacts,
        };
        vec![one(1e-5, 4.0), one(f32::NAN, 0.0)]
    }

    #[test]
    fn a_frame_is_read_as_it_was_written() {
        let finite = vec![values()[0]; 2];
        for one in [
            frame(7 << 33 | 5, vec![]),
            frame(3, finite),
            Frame::default(),
        ] {
            let mut writer = Writer::new(physics::BEAM, &());
            one.write(&mut writer);
            let bytes = writer.into_bytes();
            let ((), mut reader) = Reader::new(physics::BEAM, &bytes).expect("a header");
            assert_eq!(Frame::read(&mut reader), Ok(one));
            assert_eq!(reader.end(), Ok(()));
        }
    }
}
