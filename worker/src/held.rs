//! A lease in hand: its jobs, how far they are, and the word to stop.

use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use granary_api::id::{ArtifactHash, JobId, LeaseId};
use granary_api::lease::{Heartbeat, JobProgress, LeaseGrant, LeasedJob};

/// What the engine is told at its next look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Word {
    /// Keep computing.
    GoOn,
    /// Write a checkpoint, then stop: the jobs go back to the queue.
    HandBack,
    /// Stop: nobody wants the outcome.
    Drop,
}

/// What the engine thread and its lease tell each other, without a lock.
#[derive(Debug, Default)]
pub(crate) struct Signals {
    step: AtomicU64,
    steps: AtomicU64,
    word: AtomicU8,
}

impl Signals {
    /// The engine says how far it is, and hears what to do.
    pub(crate) fn report(&self, step: u64, steps: u64) -> Word {
        self.step.store(step, Ordering::Relaxed);
        self.steps.store(steps, Ordering::Relaxed);
        match self.word.load(Ordering::Relaxed) {
            0 => Word::GoOn,
            1 => Word::HandBack,
            _ => Word::Drop,
        }
    }

    /// Tells the engine what to do; a stronger word is never taken back.
    pub(crate) fn say(&self, word: Word) {
        self.word.fetch_max(word as u8, Ordering::Relaxed);
    }

    fn progress(&self) -> (u64, u64) {
        let step = self.step.load(Ordering::Relaxed);
        (step, self.steps.load(Ordering::Relaxed))
    }
}

/// What happened to one job while it was held.
#[derive(Clone, Copy, Debug)]
struct JobState {
    wanted: bool,
    checkpoint: Option<ArtifactHash>,
}

/// One lease, shared by its heartbeat and its work.
#[derive(Debug)]
pub(crate) struct Held {
    pub(crate) lease: LeaseId,
    pub(crate) heartbeat: Duration,
    pub(crate) jobs: Vec<LeasedJob>,
    pub(crate) signals: Arc<Signals>,
    states: Mutex<Vec<JobState>>,
}

impl Held {
    pub(crate) fn new(grant: LeaseGrant) -> Self {
        let states = grant.jobs.iter().map(|job| JobState {
            wanted: true,
            checkpoint: job.checkpoint,
        });
        Self {
            lease: grant.lease,
            heartbeat: Duration::from_secs_f64(grant.heartbeat_s.clamp(0.01, 60.0)),
            states: Mutex::new(states.collect()),
            jobs: grant.jobs,
            signals: Arc::default(),
        }
    }

    fn states(&self) -> MutexGuard<'_, Vec<JobState>> {
        // The states stay whole even if a holder of the lock panicked: each is written by one assignment.
        self.states.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether the server still wants the job at `index`.
    pub(crate) fn wants(&self, index: usize) -> bool {
        self.states()[index].wanted
    }

    /// Notes that the server no longer wants `jobs`; whether it still wants any.
    pub(crate) fn drop_jobs(&self, jobs: &[JobId]) -> bool {
        let mut states = self.states();
        for (held, state) in self.jobs.iter().zip(states.iter_mut()) {
            state.wanted &= !jobs.contains(&held.job);
        }
        states.iter().any(|state| state.wanted)
    }

    /// Notes the latest stored checkpoint of every job, in the jobs' order.
    pub(crate) fn note_checkpoints(&self, hashes: &[ArtifactHash]) {
        for (state, hash) in self.states().iter_mut().zip(hashes) {
            state.checkpoint = Some(*hash);
        }
    }

    /// Progress of every job that is still wanted.
    pub(crate) fn progress(&self) -> Vec<JobProgress> {
        let (step, steps) = self.signals.progress();
        let states = self.states();
        let wanted = self
            .jobs
            .iter()
            .zip(states.iter())
            .filter(|(_, s)| s.wanted);
        wanted
            .map(|(held, state)| JobProgress {
                job: held.job,
                step,
                steps,
                checkpoint: state.checkpoint,
            })
            .collect()
    }

    /// The next heartbeat.
    pub(crate) fn beat(&self) -> Heartbeat {
        Heartbeat {
            jobs: self.progress(),
        }
    }
}
