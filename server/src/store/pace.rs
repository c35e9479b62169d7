//! Pace: how fast the points of each sweep were finished lately, since this server started.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How far back the pace is measured.
const WINDOW: Duration = Duration::from_mins(2);
/// Completions remembered per sweep, and sweeps remembered.
const MOST: usize = 256;

#[derive(Default)]
pub(super) struct Pace {
    finished: Mutex<BTreeMap<i64, VecDeque<(Instant, u64)>>>,
}

impl Pace {
    /// Notes that `points` of `sweep` were finished now.
    pub(super) fn note(&self, sweep: i64, points: u64) {
        let mut finished = self.finished.lock().unwrap_or_else(PoisonError::into_inner);
        let times = finished.entry(sweep).or_default();
        times.push_back((Instant::now(), points));
        if times.len() > MOST {
            times.pop_front();
        }
        if finished.len() > MOST {
            finished.pop_first();
        }
    }

    /// Points per second; none before two completions.
    pub(super) fn rate(&self, sweep: i64) -> Option<f64> {
        let mut finished = self.finished.lock().unwrap_or_else(PoisonError::into_inner);
        let times = finished.get_mut(&sweep)?;
        while times.front().is_some_and(|(at, _)| at.elapsed() > WINDOW) {
            times.pop_front();
        }
        let (first, _) = times.front()?;
        let points: u64 = times.iter().skip(1).map(|(_, points)| points).sum();
        let seconds = first.elapsed().as_secs_f64();
        (points > 0 && seconds > 0.0).then(|| points as f64 / seconds)
    }
}
