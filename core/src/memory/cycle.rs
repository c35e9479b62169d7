//! Cycles: slow compressions and decompressions of the box, with or without a waveform, recorded at 256 values of u.

use serde::{Deserialize, Serialize};

use super::waveform::{Curve, SAMPLES};
use crate::crew;
use crate::guard::{Guard, Stop, alternation};
use crate::lanes::dither;
use crate::math::Vec3;
use crate::observable::critical_time_step::{Across, CriticalTimeStep, critical_time_step};
use crate::observable::{Observation, observe};
use crate::protocol::{Box2, move_box};
use crate::scene::{Physics, Replicas, Scene};

/// How often the caller is asked whether to go on \[steps\].
pub(crate) const REPORT_EVERY: u64 = 100;

/// One stretch of a cycle, in which u goes linearly from one value to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Steps.
    pub steps: u64,
    /// u at its start.
    pub from: f64,
    /// u at its end.
    pub to: f64,
    /// Whether the waveform is applied.
    pub sheared: bool,
    /// Which series its samples go to, if it is recorded.
    pub series: Option<usize>,
}

impl Segment {
    /// A ramp between u = 0 and u = 1; `steps` must be a multiple of 255.
    #[must_use]
    pub fn ramp(steps: u64, up: bool, sheared: bool, series: Option<usize>) -> Self {
        let (from, to) = if up { (0.0, 1.0) } else { (1.0, 0.0) };
        Self {
            steps,
            from,
            to,
            sheared,
            series,
        }
    }

    /// A rest at u = 1.
    #[must_use]
    pub fn hold(steps: u64) -> Self {
        Self {
            steps,
            from: 1.0,
            to: 1.0,
            sheared: false,
            series: None,
        }
    }

    /// The sample that falls on step `n` of the segment, numbered by u.
    fn sample(&self, n: u64) -> Option<(usize, usize)> {
        let series = self.series?;
        let every = self.steps / (SAMPLES as u64 - 1);
        if !n.is_multiple_of(every) {
            return None;
        }
        let index = (n / every) as usize;
        Some((
            series,
            if self.to > self.from {
                index
            } else {
                SAMPLES - 1 - index
            },
        ))
    }
}

/// What one replica is told: γ0 and the waveform.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    /// γ0.
    pub gamma0: f64,
    /// I(u).
    pub curve: Curve,
}

/// A sequence of segments in one box.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    /// One after the other.
    pub segments: Vec<Segment>,
    /// δ0.
    pub delta0: f64,
    /// The box at u = 0 \[R\].
    pub extent: Box2,
}

impl Cycle {
    /// Steps in all.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.segments.iter().map(|segment| segment.steps).sum()
    }

    /// u at step `n`, and whether the waveform is applied; the last step ends the last segment.
    fn locate(&self, n: u64) -> (f64, bool) {
        let mut start = 0;
        let mut last = (0.0, false);
        for segment in &self.segments {
            if n < start + segment.steps {
                let share = (n - start) as f64 / segment.steps as f64;
                return (
                    segment.from + (segment.to - segment.from) * share,
                    segment.sheared,
                );
            }
            start += segment.steps;
            last = (segment.to, segment.sheared);
        }
        last
    }

    /// The box of a replica at step `n`.
    fn extent_at(&self, n: u64, program: &Program) -> Box2 {
        let (u, sheared) = self.locate(n);
        let gamma = if sheared {
            program.gamma0 * program.curve.shear(u)
        } else {
            0.0
        };
        self.extent.strained(u, self.delta0, gamma)
    }

    /// The samples that fall on step `n`: two where one recorded segment ends and another begins.
    fn samples_at(&self, n: u64) -> Vec<(usize, usize)> {
        let mut samples = vec![];
        let mut start = 0;
        for segment in &self.segments {
            if n >= start && n <= start + segment.steps {
                samples.extend(segment.sample(n - start));
            }
            start += segment.steps;
        }
        samples
    }

    /// The step at which u first reaches 1.
    fn first_top(&self) -> u64 {
        self.segments.first().map_or(0, |segment| segment.steps)
    }
}

/// What is recorded at one sample, in the engine's units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Mean pressures on the walls along x, y, z \[E\].
    pub pressure: [f64; 3],
    /// Everything else.
    pub seen: Observation,
}

/// What one replica has recorded so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Track {
    /// Samples by series and u; `None` where not yet reached.
    pub series: Vec<Vec<Option<Sample>>>,
    /// The largest overlap at any sample \[R\].
    pub largest_overlap: f64,
    /// The smallest critical time step measured.
    pub critical_time_step: CriticalTimeStep,
}

impl Track {
    /// A track for `count` series.
    #[must_use]
    pub fn new(count: usize, critical_time_step: CriticalTimeStep) -> Self {
        Self {
            series: vec![vec![None; SAMPLES]; count],
            largest_overlap: 0.0,
            critical_time_step,
        }
    }

    /// The samples of one series, if it is complete.
    #[must_use]
    pub fn complete(&self, series: usize) -> Option<Vec<Sample>> {
        self.series.get(series)?.iter().copied().collect()
    }
}

/// Replicas going through a cycle.
pub struct Drive<R: Replicas, P: Physics> {
    /// The replicas.
    pub scene: Scene<R, P>,
    /// What they go through.
    pub cycle: Cycle,
    /// What each is told; replicas beyond the last job repeat the first.
    pub programs: Vec<Program>,
    /// What each has recorded.
    pub tracks: Vec<Track>,
    /// Why each was stopped, if it was.
    pub stops: Vec<Option<(u64, Stop)>>,
    /// The next step.
    pub step: u64,
    /// Stiffness of the tangential law before it slips.
    pub across: Across,
    guard: Guard,
    before: Vec<Vec3<R>>,
}

impl<R: Replicas, P: Physics> Drive<R, P> {
    /// Replicas at the first step of `cycle`; the guard's critical time step is that of the common state at its start.
    #[must_use]
    pub fn new(
        scene: Scene<R, P>,
        cycle: Cycle,
        programs: Vec<Program>,
        across: Across,
        guard: Guard,
    ) -> Self {
        let series = cycle
            .segments
            .iter()
            .filter_map(|segment| segment.series)
            .max()
            .map_or(0, |most| most + 1);
        let jobs = programs.len();
        let mut drive = Self {
            tracks: vec![Track::new(series, guard.critical_at_start); jobs],
            stops: vec![None; jobs],
            step: 0,
            across,
            guard,
            before: vec![],
            scene,
            cycle,
            programs,
        };
        for k in jobs..R::K {
            drive.scene.stop_lane(k);
        }
        drive.place_walls();
        drive
    }

    /// The critical time step in the common state at the start.
    #[must_use]
    pub fn critical_at_start(&self) -> CriticalTimeStep {
        self.guard.critical_at_start
    }

    /// The program of replica `k`; replicas without a job that runs repeat the first that does.
    fn program(&self, k: usize) -> &Program {
        let own = k < self.programs.len() && self.stops[k].is_none();
        let job = if own {
            k
        } else {
            self.stops.iter().position(Option::is_none).unwrap_or(0)
        };
        &self.programs[job]
    }

    /// Puts the walls where they were after the last step, for a start or a continuation.
    pub fn place_walls(&mut self) {
        for k in 0..R::K {
            let last = self
                .cycle
                .extent_at(self.step.saturating_sub(1), self.program(k));
            for (wall, position) in [-0.5 * last.x, 0.5 * last.x, -0.5 * last.y, 0.5 * last.y]
                .into_iter()
                .enumerate()
            {
                self.scene.walls.place(wall, k, position);
            }
        }
        self.scene.renew_contacts();
    }

    /// Whether every replica is stopped.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.stops.iter().all(Option::is_some)
    }

    /// One step: move the walls, look if a sample is due, step the scene, record the pressures.
    pub fn step_once(&mut self) {
        self.scene.laws.dither = dither(self.step);
        for k in 0..R::K {
            let to = self.cycle.extent_at(self.step, self.program(k));
            move_box(&mut self.scene, k, to);
        }
        let samples = self.cycle.samples_at(self.step);
        if samples.is_empty() && !self.step.is_multiple_of(REPORT_EVERY) {
            self.scene.step();
        } else {
            let seen = observe(&self.scene);
            self.before.clone_from(&self.scene.grains.velocity);
            if self.step == self.cycle.first_top() {
                self.measure_critical_time_step();
            }
            self.scene.step();
            self.record(&samples, &seen);
        }
        self.step += 1;
    }

    fn record(&mut self, samples: &[(usize, usize)], seen: &[Observation]) {
        let time_step = self.scene.laws.time_step;
        for (k, seen) in seen.iter().take(self.programs.len()).enumerate() {
            if self.stops[k].is_some() {
                continue;
            }
            let alternation = alternation(&self.before, &self.scene, k);
            if let Err(stop) = self.guard.judge(time_step, seen, Some(alternation)) {
                self.stop(k, stop);
                continue;
            }
            let pressure = std::array::from_fn(|axis| self.scene.walls.pressure(axis, k));
            let track = &mut self.tracks[k];
            track.largest_overlap = track.largest_overlap.max(seen.largest_overlap);
            for &(series, index) in samples {
                track.series[series][index] = Some(Sample {
                    pressure,
                    seen: *seen,
                });
            }
        }
    }

    /// In every replica, side by side on the threads of the job.
    fn measure_critical_time_step(&mut self) {
        let time_step = self.scene.laws.time_step;
        let running = (0..self.programs.len()).filter(|&k| self.stops[k].is_none());
        let mut measured: Vec<_> = running.map(|k| (k, CriticalTimeStep::NONE)).collect();
        let (scene, across) = (&self.scene, self.across);
        crew::each(&mut measured, &|(k, critical)| {
            *critical = critical_time_step(scene, *k, across);
        });
        for (k, critical) in measured {
            let track = &mut self.tracks[k];
            if critical.at_least < track.critical_time_step.at_least {
                track.critical_time_step = critical;
            }
            if let Err(stop) = self.guard.admit(time_step, critical) {
                self.stop(k, stop);
            }
        }
    }

    /// Stops replica `k` as it was stopped before a checkpoint, at step `at`.
    pub fn restore_stop(&mut self, k: usize, at: u64, kind: &str, detail: String, remedy: String) {
        let kind = ["unstable", "non_finite"]
            .into_iter()
            .find(|&known| known == kind)
            .unwrap_or("overlap");
        self.stops[k] = Some((
            at,
            Stop {
                kind,
                detail,
                remedy,
            },
        ));
        self.scene.stop_lane(k);
    }

    fn stop(&mut self, k: usize, stop: Stop) {
        self.stops[k] = Some((self.step, stop));
        self.scene.stop_lane(k);
    }
}
