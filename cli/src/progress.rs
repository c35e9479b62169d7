//! Progress on standard error: a bar with an ETA on a terminal, at most ten lines anywhere else.

use std::io::IsTerminal;
use std::time::Instant;

use granary_api::sweep::Sweep;
use indicatif::{ProgressBar, ProgressStyle};

/// Parts of the whole that the bar counts in.
const PARTS: u64 = 10_000;
/// The most lines about progress in a pipe or a file.
const LINES: u64 = 8;

/// Shows how far a sweep is.
pub(crate) struct Progress {
    /// Stands before every line: what it is about, if that is not the sweep itself.
    about: &'static str,
    bar: Option<ProgressBar>,
    started: Instant,
    done: f64,
    lines: u64,
}

impl Progress {
    /// A bar if standard error is a terminal, lines otherwise.
    pub(crate) fn new(about: &'static str) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(PARTS);
            let style = ProgressStyle::with_template("{bar:32} {percent:>3} %  {msg}");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar
        });
        Self {
            about,
            bar,
            started: Instant::now(),
            done: 0.0,
            lines: 0,
        }
    }

    /// Shows `sweep`; its ETA is the server's, from the steps done of all its ensembles.
    pub(crate) fn show(&mut self, sweep: &Sweep) {
        let elapsed = self.started.elapsed().as_secs_f64();
        self.done = self.done.max(part_done(sweep, elapsed));
        let done = self.done;
        let message = format!("{}{}", self.about, message(sweep, sweep.eta_s));
        if let Some(bar) = &self.bar {
            bar.set_position((done * PARTS as f64) as u64);
            bar.set_message(message);
        } else if (done * LINES as f64) as u64 >= self.lines && self.lines < LINES {
            self.lines = (done * LINES as f64) as u64 + 1;
            eprintln!("{:3.0} %  {message}", 100.0 * done);
        }
    }

    /// Takes the bar away and says how it ended.
    pub(crate) fn finish(self, sweep: &Sweep) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        let took = duration(self.started.elapsed().as_secs_f64());
        eprintln!("{}{} in {took}", self.about, message(sweep, None));
    }
}

/// The part of the work that is done: by time if the server says how long the rest takes, else by points.
fn part_done(sweep: &Sweep, elapsed: f64) -> f64 {
    let by_points = sweep.points.done as f64 / sweep.points.total.max(1) as f64;
    match sweep.eta_s {
        Some(left) if elapsed + left > 0.0 => by_points.max(elapsed / (elapsed + left)),
        _ => by_points,
    }
}

fn message(sweep: &Sweep, remaining: Option<f64>) -> String {
    let points = sweep.points;
    let mut parts = vec![format!("{}/{} points done", points.done, points.total)];
    parts.extend((points.failed > 0).then(|| format!("{} failed", points.failed)));
    parts.extend((points.cancelled > 0).then(|| format!("{} cancelled", points.cancelled)));
    parts.extend(remaining.map(|seconds| format!("{} left", duration(seconds))));
    parts.join(", ")
}

/// Seconds as people say them.
pub(crate) fn duration(seconds: f64) -> String {
    let whole = seconds.max(0.0).round() as u64;
    match whole {
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_have_two_units_at_most() {
        let shown = [0.4, 59.6, 3599.0, 7384.0].map(duration);
        assert_eq!(shown, ["0 s", "1 min 0 s", "59 min 59 s", "2 h 3 min"]);
    }

    #[test]
    fn work_that_ends_no_point_yet_is_seen_in_the_time_left() {
        let mut sweep: Sweep = serde_json::from_value(serde_json::json!({
            "sweep": "019a0000-0000-7000-8000-000000000000", "name": "", "model": "memory", "preset": "standard",
            "state": "active", "priority": 0, "created_at": "", "axes": [], "warnings": [],
            "points": {"total": 8, "done": 2, "failed": 0, "running": 0, "waiting": 6, "cancelled": 0},
            "points_per_second": null, "eta_s": null,
        }))
        .expect("a sweep");
        assert!((part_done(&sweep, 10.0) - 0.25).abs() < 1e-12);
        sweep.eta_s = Some(10.0);
        assert!((part_done(&sweep, 10.0) - 0.5).abs() < 1e-12);
    }
}
