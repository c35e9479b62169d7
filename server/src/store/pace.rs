//! Pace: how fast the points of each sweep were finished lately, and what its jobs took, since this server started.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How far back the pace is measured.
const WINDOW: Duration = Duration::from_mins(2);
/// Completions remembered per sweep, and sweeps remembered.
const MOST: usize = 256;
/// What an outcome's weight is multiplied by at each later one of its class: the last thirty or so count.
const FADING: f64 = 1.0 - 1.0 / 32.0;

#[derive(Default)]
pub(super) struct Pace {
    sweeps: Mutex<BTreeMap<i64, SweepPace>>,
}

#[derive(Default)]
struct SweepPace {
    finished: VecDeque<(Instant, u64)>,
    /// By class of jobs.
    taken: BTreeMap<String, Taken>,
}

/// What the latest outcomes of one class took.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Taken {
    pub(super) grain_steps: f64,
    /// Time of an engine's thread, shared among the lanes of its ensemble.
    pub(super) seconds: f64,
}

impl Pace {
    fn sweeps(&self) -> MutexGuard<'_, BTreeMap<i64, SweepPace>> {
        self.sweeps.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Notes that `points` of `sweep` were finished now.
    pub(super) fn note(&self, sweep: i64, points: u64) {
        let mut sweeps = self.sweeps();
        let times = &mut sweeps.entry(sweep).or_default().finished;
        times.push_back((Instant::now(), points));
        if times.len() > MOST {
            times.pop_front();
        }
        if sweeps.len() > MOST {
            sweeps.pop_first();
        }
    }

    /// Notes that a job of `class` that `sweep` wants has `grain_steps` and took `seconds` of a thread.
    pub(super) fn note_taken(&self, sweep: i64, class: &str, grain_steps: f64, seconds: f64) {
        let mut sweeps = self.sweeps();
        let classes = &mut sweeps.entry(sweep).or_default().taken;
        let taken = classes.entry(class.to_owned()).or_default();
        taken.grain_steps = taken.grain_steps * FADING + grain_steps;
        taken.seconds = taken.seconds * FADING + seconds;
    }

    /// What the latest jobs of `sweep` took, by class.
    pub(super) fn taken(&self, sweep: i64) -> BTreeMap<String, Taken> {
        let sweeps = self.sweeps();
        sweeps
            .get(&sweep)
            .map_or_else(BTreeMap::new, |pace| pace.taken.clone())
    }

    /// Points per second; none before two completions.
    pub(super) fn rate(&self, sweep: i64) -> Option<f64> {
        let mut sweeps = self.sweeps();
        let times = &mut sweeps.get_mut(&sweep)?.finished;
        while times.front().is_some_and(|(at, _)| at.elapsed() > WINDOW) {
            times.pop_front();
        }
        let (first, _) = times.front()?;
        let points: u64 = times.iter().skip(1).map(|(_, points)| points).sum();
        let seconds = first.elapsed().as_secs_f64();
        (points > 0 && seconds > 0.0).then(|| points as f64 / seconds)
    }
}
