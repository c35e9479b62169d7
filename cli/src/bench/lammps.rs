//! LAMMPS, run as a program of its own on the pack of a bench.

mod input;

use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};
use std::time::Duration;

use anyhow::{Context, bail, ensure};
use granary_core::bench::{PackFile, Settings};
use tempfile::TempDir;
use tokio::process::Command;

use input::{Input, SCRIPT};

/// Steps before LAMMPS' clock starts.
const WARM_UP: u64 = 200;
/// The fewest steps that are timed.
const LEAST_STEPS: u64 = 100;
/// About what LAMMPS does on one core \[sphere-steps/s\]: it turns the time of a run into a number of steps.
const PACE: f64 = 5e6;
/// How long LAMMPS may run; ten times the time that it is meant to comes on top.
const PATIENCE: Duration = Duration::from_mins(10);
/// How long a program may take to say that it is LAMMPS.
const GREETING: Duration = Duration::from_secs(30);
/// Lines of a failed run's log that its error quotes.
const QUOTED: usize = 8;
const LOG: &str = "log.lammps";

/// A program that said it is LAMMPS.
pub(super) struct Lammps {
    program: PathBuf,
    version: String,
}

impl Lammps {
    /// Asks `program` for its version.
    ///
    /// # Errors
    /// If it cannot be run, or is something else.
    pub(super) async fn find(program: &Path) -> anyhow::Result<Self> {
        // A path is taken from here, since LAMMPS runs in a directory of its own; a mere name is looked up.
        let program = if program.components().count() > 1 {
            std::path::absolute(program)?
        } else {
            program.to_owned()
        };
        let output = finish(Command::new(&program).arg("-help"), GREETING)
            .await
            .with_context(|| format!("cannot run LAMMPS as `{}`", program.display()))?;
        let greeting = String::from_utf8_lossy(&output.stdout);
        let version = greeting
            .lines()
            .find_map(|line| line.split_once("Massively Parallel Simulator - "))
            .map(|(_, version)| version.trim().to_owned());
        let version = version
            .with_context(|| format!("`{} -help` does not say LAMMPS", program.display()))?;
        Ok(Self { program, version })
    }

    /// What it calls its version.
    pub(super) fn version(&self) -> &str {
        &self.version
    }

    /// Writes the input that times it on `pack` for about as long as `limit`.
    ///
    /// # Errors
    /// If the pack has no known shape, or the files cannot be written.
    pub(super) fn prepare(
        &self,
        pack: &PackFile,
        settings: &Settings,
        limit: Duration,
    ) -> anyhow::Result<Prepared<'_>> {
        let body = pack.body();
        let body = body.with_context(|| format!("a pack of `{}` is not known", pack.kind))?;
        let poses = pack.poses();
        let spheres = poses.len() * body.arms.len();
        ensure!(spheres > 0, "the pack has no grains");
        let steps = (limit.as_secs_f64() * PACE / spheres as f64) as u64;
        let steps = steps.max(LEAST_STEPS);
        let directory = tempfile::tempdir().context("there is no place for LAMMPS' input")?;
        Input::new(pack, settings, &body, &poses, [WARM_UP, steps]).write(directory.path())?;
        Ok(Prepared {
            lammps: self,
            directory,
            grains: poses.len(),
            steps,
            deadline: PATIENCE.saturating_add(limit.saturating_mul(10)),
        })
    }
}

/// LAMMPS with the input of one pack, in a directory that goes with this value.
pub(super) struct Prepared<'a> {
    lammps: &'a Lammps,
    directory: TempDir,
    grains: usize,
    steps: u64,
    deadline: Duration,
}

impl Prepared<'_> {
    /// The steps that are timed.
    pub(super) fn steps(&self) -> u64 {
        self.steps
    }

    /// Runs it once on the processors that this thread may use; returns grain-steps per CPU second.
    ///
    /// # Errors
    /// If it fails, takes too long or does not tell its time.
    pub(super) async fn run(&self) -> anyhow::Result<f64> {
        let program = self.lammps.program.display();
        let log = self.directory.path().join(LOG);
        if log.exists() {
            std::fs::remove_file(&log).context("cannot remove the log of the last run")?;
        }
        let mut command = Command::new(&self.lammps.program);
        command
            .args(["-in", SCRIPT, "-log", LOG, "-screen", "none"])
            .current_dir(self.directory.path())
            .env("OMP_NUM_THREADS", "1");
        let output = finish(&mut command, self.deadline)
            .await
            .with_context(|| format!("cannot run LAMMPS as `{program}`"))?;
        let log = std::fs::read(&log).unwrap_or_default();
        let log = String::from_utf8_lossy(&log);
        if !output.status.success() {
            let errors = String::from_utf8_lossy(&output.stderr);
            let words = if log.is_empty() { errors } else { log };
            let end = last_lines(&words);
            bail!("LAMMPS `{program}` failed ({}):{end}", output.status);
        }
        let seconds = cpu_seconds(&log, self.steps).with_context(|| {
            let (steps, end) = (self.steps, last_lines(&log));
            format!("the log of `{program}` does not time {steps} steps on one processor:{end}")
        })?;
        Ok(self.grains as f64 * self.steps as f64 / seconds)
    }
}

/// Waits for the end of `command`, or kills it at the deadline.
async fn finish(command: &mut Command, deadline: Duration) -> anyhow::Result<Output> {
    let child = command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .kill_on_drop(true)
        .spawn()?;
    let ended = tokio::time::timeout(deadline, child.wait_with_output()).await;
    let ended = ended.with_context(|| {
        let limit = deadline.as_secs();
        format!("it did not end within {limit} s and was killed")
    })?;
    Ok(ended?)
}

/// The end of `text`, each line on a line of its own.
fn last_lines(text: &str) -> String {
    let lines: Vec<&str> = text.lines().filter(|line| !line.is_empty()).collect();
    let last = &lines[lines.len().saturating_sub(QUOTED)..];
    last.iter().flat_map(|line| ["\n  ", line]).collect()
}

/// The CPU time of the last run that `log` tells of: its loop time, without what other work took of the processor \[s\].
///
/// `None` if that was no run of `steps` steps on one processor, or too short to be timed.
fn cpu_seconds(log: &str, steps: u64) -> Option<f64> {
    let (_, run) = log.rsplit_once("Loop time of ")?;
    let (seconds, run) = run.split_once(' ')?;
    let run = run.strip_prefix(&format!("on 1 procs for {steps} steps "))?;
    let (share, _) = run.split_once("% CPU use")?;
    let percent: f64 = share.split_whitespace().last()?.parse().ok()?;
    let seconds = seconds.parse::<f64>().ok()? * (percent / 100.0).min(1.0);
    (seconds > 0.0 && seconds.is_finite()).then_some(seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOG: &str = "\
Loop time of 0.160700 on 1 procs for 200 steps with 1300 atoms

31.4% CPU use with 1 MPI tasks x 1 OpenMP threads
run 300
Loop time of 0.241049 on 1 procs for 300 steps with 1300 atoms

31.6% CPU use with 1 MPI tasks x 1 OpenMP threads

Pair    | 0.14359    | 0.14359    | 0.14359    |   0.0 | 59.57
";

    #[test]
    fn time_of_the_last_run_is_its_loop_time_without_other_work() {
        let seconds = cpu_seconds(LOG, 300).expect("is there");
        assert!((seconds - 0.241_049 * 0.316).abs() < 1e-12);
        // Above one processor's worth is rounding.
        let busy = LOG.replace("31.6%", "100.2%");
        let seconds = cpu_seconds(&busy, 300).expect("is there");
        assert!((seconds - 0.241_049).abs() < 1e-12);
    }

    #[test]
    fn log_without_the_figures_has_no_time() {
        for log in [
            String::new(),
            "LAMMPS (29 Sep 2021 - Update 2)\nERROR: Unknown pair style granular".to_owned(),
            LOG.replace("% CPU use", ""),
            LOG.replace("300 steps", "299 steps"),
            LOG.replace("1 procs", "2 procs"),
            LOG.replace("0.241049", "nan"),
            LOG.replace("31.6%", "0.0%"),
        ] {
            assert!(cpu_seconds(&log, 300).is_none(), "{log}");
        }
    }

    #[tokio::test]
    async fn program_that_does_not_end_is_killed() {
        let mut endless = Command::new("sleep");
        let ended = finish(endless.arg("1000"), Duration::from_millis(20)).await;
        let error = ended.expect_err("does not end").to_string();
        assert!(error.ends_with("was killed"), "{error}");
    }

    #[test]
    fn error_quotes_the_end_of_the_log() {
        let log: Vec<String> = (0..20).map(|line| format!("line {line}\n\n")).collect();
        let quoted = last_lines(&log.concat());
        assert!(quoted.starts_with("\n  line 12\n"), "{quoted}");
        assert!(quoted.ends_with("\n  line 19"), "{quoted}");
    }
}
