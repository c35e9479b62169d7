//! What the stages of the beam share: stepping under guard, and coming to rest.

use super::probe::{self, GrainContact};
use super::rig::{Beam, Friction};
use super::spec::{OverlapLimits, RestCriteria};
use crate::guard::Stop;
use crate::outcome::{Progress, StageFailure};

/// Steps between two reports, and between two looks for what is not a number.
const REPORT_EVERY: u64 = 100;
/// Steps between two looks at contacts: overlaps, the critical step, grains outside.
pub(super) const LOOK_EVERY: u64 = 200;

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
    /// Contacts computed so far, of grains with grains and with the membrane.
    pub(super) contact_updates: u64,
    /// Contacts of grains as of the last look.
    pub(super) contacts: Vec<GrainContact>,
}

/// The numbers of a run that outlast it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(super) struct Course {
    pub(super) step: u64,
    pub(super) time: f64,
    pub(super) time_step: f64,
    pub(super) critical: f64,
    pub(super) deepest: f64,
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
            contact_updates: course.contact_updates,
            contacts: vec![],
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

    /// Reports now and then, looks at the beam now and then, and takes one step.
    pub(super) fn advance(
        &mut self,
        progress: &mut Progress<'_>,
        save: &dyn Fn(&Self) -> Vec<u8>,
    ) -> Result<(), StageFailure> {
        if self.step.is_multiple_of(REPORT_EVERY) {
            progress.ask(self.step, &|| vec![save(self)])?;
            self.check_numbers()?;
        }
        if self.step.is_multiple_of(LOOK_EVERY) {
            self.look()?;
        }
        self.beam.step();
        let touching = self.beam.touching() + self.beam.surroundings.held().len();
        self.contact_updates += touching as u64;
        self.step += 1;
        self.time += self.beam.laws.time_step;
        Ok(())
    }

    fn check_numbers(&self) -> Result<(), StageFailure> {
        let grains = &self.beam.grains;
        let grain = (0..grains.len()).find(|&i| {
            let (place, motion) = (grains.pose(i, 0).position, grains.motion(i, 0));
            let numbers = place.iter().chain(&motion.velocity).chain(&motion.spin);
            !numbers.copied().all(f64::is_finite)
        });
        let places = self.beam.surroundings.membrane.mesh().positions();
        let vertex = places
            .iter()
            .position(|x| !x.iter().copied().all(f64::is_finite));
        let what = match (grain, vertex) {
            (None, None) => return Ok(()),
            (Some(i), _) => format!("grain {i}"),
            (None, Some(v)) => format!("vertex {v} of the membrane"),
        };
        let detail = format!("place or velocity of {what} is not a number");
        Err(self.failed("non_finite", detail, "use a smaller time_step_fraction"))
    }

    /// Looks at all contacts: renews the time step, and stops what has left the physics.
    fn look(&mut self) -> Result<(), StageFailure> {
        self.contacts = probe::contacts(&self.beam);
        let critical = probe::critical_time_step(&self.beam, &self.contacts);
        self.critical = self.critical.min(critical);
        if self.fraction >= 1.0 {
            let detail = format!(
                "a time step of {} of the critical one, {critical:.2e} s, is not stable",
                self.fraction
            );
            let remedy =
                "use a time_step_fraction and preparation_time_step_fraction of at most 0.4";
            return Err(self.failed("unstable", detail, remedy));
        }
        self.beam.laws.time_step = (self.fraction * critical).min(self.longest_step);
        let grains = &self.beam.grains;
        let (mut most, mut pair) = (0.0f64, (0, 0));
        for c in &self.contacts {
            let depth = c.overlap / grains.radius(c.i).min(grains.radius(c.j));
            if depth > most {
                (most, pair) = (depth, (c.i, c.j));
            }
        }
        self.deepest = self.deepest.max(most);
        if most > self.limits.stop {
            let detail = format!(
                "grains {} and {} overlap by {most:.2} of the smaller radius, more than {}",
                pair.0, pair.1, self.limits.stop
            );
            let remedy = "use stiffer grains or less pressure, or raise overlap_limit";
            return Err(self.failed("overlap_limit", detail, remedy));
        }
        self.look_for_escaped()
    }

    fn look_for_escaped(&self) -> Result<(), StageFailure> {
        let [low, high] = self.beam.surroundings.membrane.mesh().bounds();
        let grains = &self.beam.grains;
        let outside = |&i: &usize| {
            let place = grains.pose(i, 0).position;
            (0..3).any(|k| place[k] < low[k] || place[k] > high[k])
        };
        match (0..grains.len()).find(outside) {
            None => Ok(()),
            Some(i) => Err(self.failed(
                "escaped_particle",
                format!("grain {i} is outside the membrane"),
                "use a finer membrane_edge or a smaller time_step_fraction",
            )),
        }
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
        let force = probe::mean_force(&run.contacts);
        let net = probe::mean_net_force(&run.beam, before);
        let [kinetic, elastic] = probe::energies(&run.beam, &run.contacts);
        let quiet = rate < criteria.volume_rate
            && (net < criteria.force_ratio * force || run.contacts.is_empty())
            && (kinetic < criteria.energy_ratio * elastic || elastic == 0.0);
        self.quiet = if quiet { self.quiet + 1 } else { 0 };
        self.quiet >= CHECKS
    }
}
