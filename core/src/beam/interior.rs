//! The inside of a beam at one moment, as the structural analyses look at it.

use super::probe;
use super::rig::{Beam, Friction};
use super::run::stopped;
use super::structure::{ContactForce, Packing, Snapshot, SnapshotError};
use crate::guard::Stop;
use crate::outcome::StageFailure;

/// What a [`Packing`] borrows.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Interior {
    pub(super) positions: Vec<[f64; 3]>,
    pub(super) radii: Vec<f64>,
    pub(super) friction_coefficient: f64,
    pub(super) contacts: Vec<ContactForce>,
    /// The grain of each contact with the membrane that presses.
    pub(super) membrane_contacts: Vec<usize>,
    pub(super) vertices: Vec<[f64; 3]>,
    pub(super) triangles: Vec<[usize; 3]>,
}

impl Interior {
    /// The inside of `beam` as it is now.
    pub(super) fn of<T: Friction>(beam: &Beam<T>, friction_coefficient: f64) -> Self {
        let grains = &beam.grains;
        let force = |contact: probe::GrainContact| ContactForce {
            i: contact.i,
            j: contact.j,
            normal_force: contact.normal_force,
            tangential_force: contact.tangential_force,
        };
        let casing = &beam.surroundings;
        let pressing = casing.held().filter(|held| held.normal_force > 0.0);
        let mesh = casing.membrane.mesh();
        Self {
            positions: (0..grains.len())
                .map(|i| grains.pose(i, 0).position)
                .collect(),
            radii: grains.sizes().iter().map(|size| size.radius).collect(),
            friction_coefficient,
            contacts: probe::contacts(beam).into_iter().map(force).collect(),
            membrane_contacts: pressing.map(|held| held.grain as usize).collect(),
            vertices: mesh.positions().to_vec(),
            triangles: mesh
                .triangles()
                .iter()
                .map(|corners| corners.map(|vertex| vertex as usize))
                .collect(),
        }
    }

    /// The same, checked; a beam that cannot be analyzed at `step` has left the physics.
    pub(super) fn packing(&self, step: u64) -> Result<Packing<'_>, StageFailure> {
        let snapshot = Snapshot {
            positions: &self.positions,
            radii: &self.radii,
            friction_coefficient: self.friction_coefficient,
            contacts: &self.contacts,
            membrane_contacts: &self.membrane_contacts,
            vertices: &self.vertices,
            triangles: &self.triangles,
        };
        Packing::new(snapshot).map_err(|error| unfit(step, error))
    }
}

/// A place that is not a number, or a membrane around nothing: what is always so was checked when the beam was made.
pub(super) fn unfit(step: u64, error: SnapshotError) -> StageFailure {
    let stop = Stop {
        kind: "non_finite",
        detail: error.to_string(),
        remedy: "use a smaller time_step_fraction".to_owned(),
    };
    stopped(step, stop)
}
