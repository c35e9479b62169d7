//! What is looked at while the rods move: snapshots at equal ways of the rods, analyzed or stored.
//!
//! The first is taken when the rods touch the beam, the others each time that they have gone `snapshot_travel` farther, down or up.
//! Only the last snapshot is kept whole, since the next is compared with it; of the others remains what was found.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::beam::frame::dump::dump;
use crate::beam::frame::polydata::{collection, file_name, polydata};
use crate::beam::frame::{Frame, GrainValues};
use crate::beam::interior::{Interior, unfit};
use crate::beam::rig::Friction;
use crate::beam::run::Run;
use crate::beam::spec::BendSpec;
use crate::beam::structure::along::{Change, Filled, Moment};
use crate::beam::structure::report::{At, Place, Report};
use crate::beam::structure::voronoi::local_volume_fractions;
use crate::identity::canonical_json;
use crate::outcome::{GRAINS_DUMP, MEMBRANE_COLLECTION, STRUCTURE, StageFailure};

mod saved;

/// Everything looked at so far.
#[derive(Debug, Default)]
pub(super) struct Snapshots {
    course: Course,
    /// The last snapshot, where the structure is analyzed.
    last: Option<Last>,
    /// One for each snapshot, where they are stored.
    frames: Vec<Frame>,
}

/// What remains of the snapshots so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Course {
    /// Snapshots taken.
    taken: u32,
    /// Way of the rods since they touched the beam, whichever direction \[m\].
    way: f64,
    /// What each shows.
    moments: Vec<Taken>,
    /// What happened from each to the next.
    changes: Vec<Change>,
}

/// What a snapshot shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Taken {
    /// Since the rods set out \[s\].
    time: f64,
    /// Way of the rods, down \[m\].
    travel: f64,
    moment: Moment,
}

/// What the next snapshot is compared with.
#[derive(Debug)]
struct Last {
    interior: Interior,
    /// φ_i of its grains.
    fractions: Vec<Option<f64>>,
}

impl Snapshots {
    /// Takes note of one step since the rods touched the beam, of its way and of all their way down, and takes a snapshot if one is due.
    ///
    /// The beam was of this height when bending began.
    pub(super) fn follow<T: Friction>(
        &mut self,
        run: &Run<T>,
        spec: &BendSpec,
        (way, travel): (f64, f64),
        height: f64,
    ) -> Result<(), StageFailure> {
        if !(spec.structure || spec.snapshots) {
            return Ok(());
        }
        // The step that brings the rods to the beam belongs to the way before.
        if self.course.taken > 0 {
            self.course.way += way.abs();
        }
        if self.course.way < spec.snapshot_travel * f64::from(self.course.taken) {
            return Ok(());
        }
        self.course.taken += 1;
        let interior = Interior::of(&run.beam, spec.friction_coefficient);
        let frame = spec
            .snapshots
            .then(|| Frame::of(&run.beam, &interior, (run.step, run.time)));
        let values = if spec.structure {
            let taken = (run.time, travel);
            self.analyze(interior, (run.step, height), taken)?
        } else {
            vec![]
        };
        self.frames
            .extend(frame.map(|frame| Frame { values, ..frame }));
        Ok(())
    }

    /// Analyzes a snapshot of a beam of this height, and what happened since the last; returns what is known of each grain.
    fn analyze(
        &mut self,
        interior: Interior,
        (step, height): (u64, f64),
        (time, travel): (f64, f64),
    ) -> Result<Vec<GrainValues>, StageFailure> {
        let packing = interior.packing(step)?;
        let fractions = local_volume_fractions(&packing);
        self.course.moments.push(Taken {
            time,
            travel,
            moment: Moment::of(&packing, &fractions),
        });
        let mut strays = vec![None; fractions.len()];
        if let Some(last) = &self.last {
            let bins = packing.mean_diameter().map_or(0.0, |d| 0.5 * height / d);
            let (before, after) = (
                Filled {
                    packing: &last.interior.packing(step)?,
                    fractions: &last.fractions,
                },
                Filled {
                    packing: &packing,
                    fractions: &fractions,
                },
            );
            let found = Change::between(before, after, bins.ceil() as usize);
            let (change, values) = found.map_err(|error| unfit(step, error))?;
            self.course.changes.push(change);
            strays = values;
        }
        let single = |value: Option<f64>| value.map_or(f32::NAN, |value| value as f32);
        let counts = packing.contact_counts();
        let values = (0..counts.len()).map(|i| GrainValues {
            non_affine: single(strays[i]),
            local_volume_fraction: single(fractions[i]),
            contacts: counts[i] as f32,
        });
        let values = values.collect();
        self.last = Some(Last {
            interior,
            fractions,
        });
        Ok(values)
    }

    /// The artifacts: what was found, at the ε and σ that `curve` knows by the time, and what is stored.
    pub(super) fn artifacts<T: Friction>(
        &self,
        run: &Run<T>,
        spec: &BendSpec,
        curve: impl Fn(f64) -> (f64, f64),
    ) -> BTreeMap<String, Vec<u8>> {
        let mut artifacts = BTreeMap::new();
        let sizes = run.beam.grains.sizes();
        if spec.structure {
            let count = sizes.len().max(1) as f64;
            let diameter = sizes.iter().map(|size| 2.0 * size.radius).sum::<f64>() / count;
            let diameter = (!sizes.is_empty()).then_some(diameter);
            let placed = self.course.moments.iter().map(|taken| {
                let (strain, stress) = curve(taken.time);
                let place = Place {
                    time: taken.time,
                    rod_travel: taken.travel,
                    strain,
                    stress,
                };
                let found = taken.moment.clone();
                At { place, found }
            });
            let placed = placed.collect();
            let changes = self.course.changes.clone();
            let report = Report::new((diameter, spec.snapshot_travel), placed, changes);
            artifacts.insert(STRUCTURE.to_owned(), canonical_json(&report).into_bytes());
        }
        if spec.snapshots {
            let radii: Vec<f32> = sizes.iter().map(|size| size.radius as f32).collect();
            let triangles = run.beam.surroundings.membrane.mesh().triangles();
            artifacts.insert(GRAINS_DUMP.to_owned(), dump(&self.frames, &radii));
            artifacts.insert(MEMBRANE_COLLECTION.to_owned(), collection(&self.frames));
            for (k, frame) in self.frames.iter().enumerate() {
                artifacts.insert(file_name(k), polydata(frame, triangles));
            }
        }
        artifacts
    }
}
