//! What the stages of the beam share: stepping under guard, and coming to rest.

mod check;
mod energy;
mod sheet;

use super::probe::{self, GrainContact};
use super::rig::{Beam, Friction};
use super::spec::{OverlapLimits, RestCriteria};
use crate::guard::Stop;
use crate::outcome::{Progress, StageFailure};
use energy::Books;
use sheet::Sheet;

/// Steps between two reports, before each of which numbers and membrane are checked.
const REPORT_EVERY: u64 = 100;
/// Steps between two looks at contacts: overlaps, the critical step, the energy.
const LOOK_EVERY: u64 = 200;

/// A beam under way.
pub(super) struct Run<T: Friction> {
    pub(super) beam: Beam<T>,
    /// Steps done.
    pub(super) step: u64,
    /// Simulated time of the present phase \[s\].
    pub(super) time: f64,
    /// Time step over the critical one.
    pub(super) fraction: f64,
    /// No time step is longer \[s\].
    pub(super) longest_step: f64,
    pub(super) limits: OverlapLimits,
    /// The least critical time step so far \[s\].
    pub(super) critical: f64,
    /// The largest overlap so far, in smaller radii.
    pub(super) deepest: f64,
    /// The grains that overlapped so.
    deepest_pair: [usize; 2],
    /// Ṙ/R of grains that grow \[1/s\].
    pub(super) growth_rate: f64,
    /// Contacts computed so far, of grains with grains and with the membrane.
    pub(super) contact_updates: u64,
    /// Contacts of grains as of the last look.
    pub(super) contacts: Vec<GrainContact>,
    sheet: Sheet,
    books: Books,
    /// Normals of the membrane at the last report; none before the first.
    normals: Vec<[f64; 3]>,
}

/// The numbers of a run that outlast it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(super) struct Course {
    pub(super) step: u64,
    pub(super) time: f64,
    pub(super) time_step: f64,
    pub(super) critical: f64,
    pub(super) deepest: f64,
    deepest_pair: [usize; 2],
    sheet: Sheet,
    books: Books,
    pub(super) contact_updates: u64,
}

impl Course {
    /// Before the first step.
    pub(super) const BEGINNING: Self = Self {
        step: 0,
        time: 0.0,
        time_step: 0.0,
        critical: f64::MAX,
        deepest: 0.0,
        deepest_pair: [0; 2],
        sheet: Sheet::SOUND,
        books: Books::BLANK,
        contact_updates: 0,
    };
}

/// The failure of a run that was stopped.
pub(super) fn stopped(step: u64, stop: Stop) -> StageFailure {
    StageFailure::Stopped {
        kind: stop.kind.to_owned(),
        step,
        detail: stop.detail,
        remedy: stop.remedy,
    }
}

impl<T: Friction> Run<T> {
    /// A run that goes on where `course` says.
    pub(super) fn new(
        beam: Beam<T>,
        course: Course,
        (fraction, longest_step): (f64, f64),
        limits: OverlapLimits,
    ) -> Self {
        let mut run = Self {
            beam,
            step: course.step,
            time: course.time,
            fraction,
            longest_step,
            limits,
            critical: course.critical,
            deepest: course.deepest,
            deepest_pair: course.deepest_pair,
            growth_rate: 0.0,
            contact_updates: course.contact_updates,
            contacts: vec![],
            sheet: course.sheet,
            books: course.books,
            normals: vec![],
        };
        run.beam.laws.time_step = course.time_step;
        run
    }

    pub(super) fn course(&self) -> Course {
        Course {
            step: self.step,
            time: self.time,
            time_step: self.beam.laws.time_step,
            critical: self.critical,
            deepest: self.deepest,
            deepest_pair: self.deepest_pair,
            sheet: self.sheet,
            books: self.books,
            contact_updates: self.contact_updates,
        }
    }

    fn failed(&self, kind: &'static str, detail: String, remedy: &str) -> StageFailure {
        let stop = Stop {
            kind,
            detail,
            remedy: remedy.to_owned(),
        };
        stopped(self.step, stop)
    }

    /// Checks and reports now and then, looks at the contacts now and then, and takes one step.
    ///
    /// What cannot go on is found before it is saved, so that a checkpoint is of the last good state.
    pub(super) fn advance(
        &mut self,
        progress: &mut Progress<'_>,
        save: &dyn Fn(&Self) -> Vec<u8>,
    ) -> Result<(), StageFailure> {
        if self.step.is_multiple_of(REPORT_EVERY) {
            self.check_numbers()?;
            self.check_sheet()?;
            progress.ask(self.step, &|| vec![save(self)])?;
        }
        if self.step.is_multiple_of(LOOK_EVERY) {
            self.look()?;
        }
        self.beam.step();
        let touching = self.beam.touching() + self.beam.surroundings.held().count();
        self.contact_updates += touching as u64;
        self.step += 1;
        self.time += self.beam.laws.time_step;
        Ok(())
    }
}

impl<T: Friction> Run<T> {
    /// The force of a contact that is hardly one, and what as many of them as grains and a sheet as little strained would
    /// store \[N, J\].
    ///
    /// Grains that nothing presses together drift apart ever more slowly, and what little they still feel is never balanced;
    /// a sheet that nothing strains has no energy but that of rounding.
    fn touch(&self) -> [f64; 2] {
        let sizes = self.beam.grains.sizes();
        let modulus = 0.75 * self.beam.laws.material.normal_stiffness;
        let square = |radius: f64| radius * radius;
        let squares: f64 = sizes.iter().map(|size| square(size.radius)).sum();
        let cubes: f64 = sizes.iter().map(|s| s.radius * square(s.radius)).sum();
        let force = TOUCH * TOUCH.sqrt() * modulus;
        let springs = self.beam.surroundings.membrane.springs();
        let edges = springs.stiffness().iter().zip(springs.rest_lengths());
        let sheet: f64 = edges.map(|(k, length)| k * square(length * TOUCH)).sum();
        [
            force * squares / sizes.len().max(1) as f64,
            force * TOUCH * cubes + sheet,
        ]
    }
}

/// Watches a beam come to rest: all criteria at ten checks in a row, over one window.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(super) struct Rest {
    /// When to check next \[s\].
    next: f64,
    /// Of the membrane at the last check \[m³\].
    volume: f64,
    /// Checks in a row that found it at rest.
    quiet: u32,
}

/// Checks of one window.
const CHECKS: u32 = 10;

/// Overlap of a contact that is hardly one \[R\], and strain of a sheet; at the paper's pressure grains overlap by 0.03 to 0.2.
const TOUCH: f64 = 1e-6;

impl Rest {
    /// From `time` on.
    pub(super) fn from(time: f64) -> Self {
        Self {
            next: time,
            volume: 0.0,
            quiet: 0,
        }
    }

    /// Whether a check is due before the next step.
    pub(super) fn is_due(&self, time: f64) -> bool {
        time >= self.next
    }

    /// Checks; `before` are the grains' velocities before the last step. Whether the beam has been at rest for a window.
    pub(super) fn check<T: Friction>(
        &mut self,
        criteria: &RestCriteria,
        run: &mut Run<T>,
        before: &[[f64; 3]],
    ) -> bool {
        let interval = criteria.window / f64::from(CHECKS);
        self.next = run.time + interval;
        run.contacts = probe::contacts(&run.beam);
        let volume = run.beam.surroundings.membrane.mesh().volume();
        let rate = (volume - self.volume).abs() / (interval * volume);
        self.volume = volume;
        let [touching, stored] = run.touch();
        let force = probe::mean_force(&run.contacts).max(touching);
        let net = probe::mean_net_force(&run.beam, before);
        let [kinetic, elastic] = probe::energies(&run.beam, &run.contacts);
        let elastic = elastic.max(stored);
        let quiet = rate < criteria.volume_rate
            && (net < criteria.force_ratio * force || run.contacts.is_empty())
            && (kinetic < criteria.energy_ratio * elastic || elastic == 0.0);
        self.quiet = if quiet { self.quiet + 1 } else { 0 };
        self.quiet >= CHECKS
    }
}

#[cfg(test)]
mod tests;
