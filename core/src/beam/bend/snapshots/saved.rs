//! Snapshots in a checkpoint: a state file of their own, after that of the beam.

use super::{Course, Last, Snapshots};
use crate::beam::bend::BendSpec;
use crate::beam::frame::Frame;
use crate::beam::interior::Interior;
use crate::beam::rig::{Beam, Friction};
use crate::beam::structure::ContactForce;
use crate::beam::structure::voronoi::local_volume_fractions;
use crate::outcome::StageFailure;
use crate::physics;
use crate::state_file::{Reader, Writer};

impl Snapshots {
    /// The bytes of the file.
    pub(in crate::beam::bend) fn to_bytes(&self) -> Vec<u8> {
        let mut writer = Writer::new(physics::BEAM, &self.course);
        writer.count(usize::from(self.last.is_some()));
        if let Some(last) = &self.last {
            write_interior(&mut writer, &last.interior);
        }
        writer.count(self.frames.len());
        for frame in &self.frames {
            frame.write(&mut writer);
        }
        writer.into_bytes()
    }

    /// Reads the file of a bending of `beam` at `step`.
    pub(in crate::beam::bend) fn from_bytes<T: Friction>(
        bytes: &[u8],
        (beam, step): (&Beam<T>, u64),
        spec: &BendSpec,
    ) -> Result<Self, StageFailure> {
        let now = Interior::of(beam, spec.friction_coefficient);
        let (course, last, frames) = read(bytes, now).map_err(|detail| StageFailure::Input {
            detail: format!("snapshots of a beam: {detail}"),
        })?;
        let last = match last {
            None => None,
            Some(interior) => {
                let fractions = local_volume_fractions(&interior.packing(step)?);
                Some(Last {
                    interior,
                    fractions,
                })
            }
        };
        Ok(Self {
            course,
            last,
            frames,
        })
    }
}

type Read = (Course, Option<Interior>, Vec<Frame>);

/// Course, last snapshot and frames; what no bending changes is as it is `now`.
fn read(bytes: &[u8], now: Interior) -> Result<Read, String> {
    let (course, mut reader) = Reader::new(physics::BEAM, bytes)?;
    let last = match reader.word()? {
        0 => None,
        _ => Some(read_interior(&mut reader, now)?),
    };
    let frames = (0..reader.word()?).map(|_| Frame::read(&mut reader));
    let frames = frames.collect::<Result<_, _>>()?;
    reader.end()?;
    Ok((course, last, frames))
}

fn write_interior(writer: &mut Writer, interior: &Interior) {
    writer.vectors(&interior.positions);
    writer.vectors(&interior.vertices);
    writer.count(interior.contacts.len());
    for contact in &interior.contacts {
        writer.count(contact.i);
        writer.count(contact.j);
        writer.numbers(&[contact.normal_force, contact.tangential_force]);
    }
    writer.count(interior.membrane_contacts.len());
    for &grain in &interior.membrane_contacts {
        writer.count(grain);
    }
}

fn read_interior(reader: &mut Reader<'_>, now: Interior) -> Result<Interior, String> {
    let (positions, vertices) = (reader.vectors()?, reader.vectors()?);
    let mut contacts = vec![];
    for _ in 0..reader.word()? {
        let (i, j) = (reader.word()? as usize, reader.word()? as usize);
        let [normal_force, tangential_force] = reader.numbers()?;
        contacts.push(ContactForce {
            i,
            j,
            normal_force,
            tangential_force,
        });
    }
    let membrane_contacts = (0..reader.word()?)
        .map(|_| reader.word().map(|grain| grain as usize))
        .collect::<Result<_, _>>()?;
    Ok(Interior {
        positions,
        contacts,
        membrane_contacts,
        vertices,
        ..now
    })
}
