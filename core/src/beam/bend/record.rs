//! What is recorded while the rods move: means over equal ways of the rods, and the contacts at the end of each.

use serde::{Deserialize, Serialize};

use crate::beam::curve::Sample;
use crate::beam::probe;
use crate::beam::rig::Friction;
use crate::beam::run::Run;
use crate::beam::spec::BendSpec;

/// Share of the Coulomb limit from which on a contact counts as being at it.
const AT_LIMIT: f64 = 0.95;

/// Sums of the way that is being recorded, and all rows so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Record {
    sums: [f64; 3],
    steps: u64,
    /// Way of the rods since the last row, whichever direction.
    way: f64,
    /// Way of the rods, down.
    travel: f64,
    rows: Vec<Row>,
}

/// Means over one way of the rods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Means {
    time: f64,
    travel: f64,
    force: f64,
    reaction: f64,
    height: f64,
}

/// One row of the record.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Row {
    /// Since the rods set out \[s\].
    pub(super) time: f64,
    /// Way of the rods, down \[m\].
    pub(super) travel: f64,
    /// Of both rods on the beam, down \[N\].
    pub(super) force: f64,
    /// Of both supports on the beam, up \[N\].
    pub(super) reaction: f64,
    /// Of the middle of the bottom \[m\].
    pub(super) height: f64,
    pub(super) kinetic_energy: f64,
    pub(super) elastic_energy: f64,
    pub(super) volume_fraction: f64,
    pub(super) coordination_number: Option<f64>,
    pub(super) mean_force: f64,
    pub(super) mean_normal_force: f64,
    pub(super) mean_tangential_force: f64,
    /// None without friction.
    pub(super) coulomb_fraction: Option<f64>,
    pub(super) mean_overlap: f64,
}

impl Record {
    /// Adds one step: force on the rods, reaction of the supports, height of the middle.
    pub(super) fn add(&mut self, values: [f64; 3], way: f64) {
        for (sum, value) in self.sums.iter_mut().zip(values) {
            *sum += value;
        }
        self.steps += 1;
        self.way += way.abs();
        self.travel += way;
    }

    /// Way of the rods so far, down \[m\].
    pub(super) fn travel(&self) -> f64 {
        self.travel
    }

    pub(super) fn is_due(&self, sample_way: f64) -> bool {
        self.way >= sample_way
    }

    pub(super) fn mean(&self, time: f64) -> Means {
        let [force, reaction, height] = self.sums.map(|sum| sum / self.steps as f64);
        Means {
            time,
            travel: self.travel,
            force,
            reaction,
            height,
        }
    }

    /// The rows since the first touch, when the middle was at the height `zero`: everything before is the rods' way through the air.
    pub(super) fn since_touch(&self, zero: f64) -> &[Row] {
        let touch = |row: &Row| row.height.to_bits() == zero.to_bits();
        let first = self.rows.iter().position(touch);
        &self.rows[first.unwrap_or(self.rows.len())..]
    }

    /// Keeps a row and begins the next.
    pub(super) fn close(&mut self, row: Row) -> Row {
        self.rows.push(row);
        (self.sums, self.steps, self.way) = ([0.0; 3], 0, 0.0);
        row
    }
}

impl Row {
    /// As a sample of the curve of a beam whose middle was at the height `zero` when the rods first touched.
    pub(super) fn sample(&self, zero: f64) -> Sample {
        Sample {
            time: self.time,
            rod_travel: self.travel,
            force: self.force,
            deflection: zero - self.height,
        }
    }

    /// The row of these means, with the contacts as they are now.
    pub(super) fn of<T: Friction>(run: &Run<T>, spec: &BendSpec, means: Means) -> Self {
        let contacts = probe::contacts(&run.beam);
        let [kinetic_energy, elastic_energy] = probe::energies(&run.beam, &contacts);
        let grains = &run.beam.grains;
        let count = contacts.len();
        let mean = |value: &dyn Fn(&probe::GrainContact) -> f64| {
            contacts.iter().map(value).fold(0.0, |sum, x| sum + x) / count.max(1) as f64
        };
        let mu = spec.friction_coefficient;
        let limited = |c: &probe::GrainContact| {
            f64::from(u8::from(
                c.tangential_force >= AT_LIMIT * mu * c.normal_force,
            ))
        };
        Self {
            time: means.time,
            travel: means.travel,
            force: means.force,
            reaction: means.reaction,
            height: means.height,
            kinetic_energy,
            elastic_energy,
            volume_fraction: probe::grain_volume(&run.beam)
                / run.beam.surroundings.membrane.mesh().volume(),
            coordination_number: (!grains.is_empty())
                .then(|| 2.0 * count as f64 / grains.len() as f64),
            mean_force: probe::mean_force(&contacts),
            mean_normal_force: mean(&|c| c.normal_force),
            mean_tangential_force: mean(&|c| c.tangential_force),
            coulomb_fraction: (mu > 0.0 && count > 0).then(|| mean(&limited)),
            mean_overlap: mean(&|c| c.overlap / grains.radius(c.i).min(grains.radius(c.j))),
        }
    }
}
