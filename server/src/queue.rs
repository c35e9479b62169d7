//! The queue's rules, pure: in which state a job may be, and what moves it.
//!
//! ```text
//! blocked ──> ready ──> leased ──> done
//!    │          ^ │        ├─────> failed      (physics; or the machine, three times)
//!    │          │ │        └─────> poisoned    (outlived five workers)
//!    ├─> failed │ └─> cancelled   (what it needs failed; nobody wants it)
//!    └──────────┴──── retry, wanted again
//! ```
//! A job whose outcome is archived is done without a lease; preparation that only such jobs needed is cancelled.

use granary_api::job::{Failure, JobState};
use granary_core::stage::StageFailure;

use JobState::{Blocked, Cancelled, Done, Failed, Leased, Poisoned, Ready};

/// How often a job may fail for reasons that are not its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Workers lost before the job is set aside as poisoned.
    pub losses: u64,
    /// Faults of machines before the job fails.
    pub faults: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            losses: 5,
            faults: 3,
        }
    }
}

/// Every move that a job may make; the schema's trigger holds the same list.
pub const MOVES: [(JobState, JobState); 18] = [
    (Blocked, Ready),
    (Blocked, Done),
    (Blocked, Failed),
    (Blocked, Cancelled),
    (Ready, Leased),
    (Ready, Done),
    (Ready, Cancelled),
    (Leased, Done),
    (Leased, Failed),
    (Leased, Poisoned),
    (Leased, Ready),
    (Leased, Cancelled),
    (Failed, Ready),
    (Failed, Blocked),
    (Poisoned, Ready),
    (Cancelled, Ready),
    (Cancelled, Blocked),
    (Cancelled, Failed),
];

/// Where a new job begins, by the state of the job that it needs, if it needs one.
#[must_use]
pub fn first_state(needs: Option<JobState>) -> JobState {
    match needs {
        None | Some(Done) => Ready,
        Some(Failed | Poisoned) => Failed,
        Some(_) => Blocked,
    }
}

/// What ends a lease on a job without an outcome.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    /// The worker fell silent.
    Lost,
    /// The worker handed it back.
    Released,
    /// The worker reports a failure.
    Failed(StageFailure),
}

/// Where a leased job goes, and what is counted.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The next state.
    pub state: JobState,
    /// Added to the job's losses.
    pub losses: u64,
    /// Added to the job's faults.
    pub faults: u64,
    /// Why it failed or was set aside.
    pub failure: Option<Failure>,
    /// How the attempt is remembered: `lost`, `released`, `failed` or `cancelled`.
    pub ending: &'static str,
}

/// Decides about a leased job with `losses` and `faults` so far; `wanted` by some sweep or by none.
#[must_use]
pub fn verdict(
    ending: &Ending,
    (losses, faults): (u64, u64),
    wanted: bool,
    limits: Limits,
) -> Verdict {
    let back = if wanted { Ready } else { Cancelled };
    let verdict = |state, name| Verdict {
        state,
        losses: 0,
        faults: 0,
        failure: None,
        ending: name,
    };
    match ending {
        Ending::Released | Ending::Failed(StageFailure::Interrupted { .. }) => {
            verdict(back, "released")
        }
        Ending::Lost if losses + 1 >= limits.losses => Verdict {
            losses: 1,
            failure: Some(poisoned(losses + 1)),
            ..verdict(Poisoned, "lost")
        },
        Ending::Lost => Verdict {
            losses: 1,
            ..verdict(back, "lost")
        },
        Ending::Failed(failure @ StageFailure::Input { .. }) if faults + 1 < limits.faults => {
            Verdict {
                faults: 1,
                failure: Some(described(failure)),
                ..verdict(back, "failed")
            }
        }
        Ending::Failed(failure) => Verdict {
            faults: u64::from(matches!(failure, StageFailure::Input { .. })),
            failure: Some(described(failure)),
            ..verdict(Failed, "failed")
        },
    }
}

fn poisoned(losses: u64) -> Failure {
    plain(
        "poisoned",
        format!("{losses} workers were lost while running it; `retry` tries again"),
    )
}

fn plain(reason: &str, message: String) -> Failure {
    Failure {
        reason: reason.to_owned(),
        message,
        kind: None,
        step: None,
        remedy: None,
        job: None,
    }
}

/// A stage's failure in the words of the API.
#[must_use]
pub fn described(failure: &StageFailure) -> Failure {
    let message = failure.to_string();
    match failure {
        StageFailure::Stopped {
            kind, step, remedy, ..
        } => Failure {
            kind: Some(kind.clone()),
            step: Some(*step),
            remedy: Some(remedy.clone()),
            ..plain("stopped", message)
        },
        StageFailure::Input { .. } => plain("input", message),
        StageFailure::Interrupted { .. } => plain("interrupted", message),
    }
}

/// The failure of a job that needs `job`, which has failed.
#[must_use]
pub fn needs_failed(kind: &str, job: granary_api::id::JobId, cause: &str) -> Failure {
    Failure {
        job: Some(job),
        ..plain(
            "needs",
            format!("the {kind} {job} that it starts from has failed: {cause}"),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits {
        losses: 5,
        faults: 3,
    };

    fn input() -> Ending {
        Ending::Failed(StageFailure::Input {
            detail: "pack.bin ends early".to_owned(),
        })
    }

    fn stopped() -> Ending {
        Ending::Failed(StageFailure::Stopped {
            kind: "unstable".to_owned(),
            step: 7,
            detail: "grain 3 is too fast".to_owned(),
            remedy: "shorten time_step".to_owned(),
        })
    }

    #[test]
    fn nothing_leaves_done() {
        assert!(MOVES.iter().all(|(from, _)| *from != Done));
    }

    #[test]
    fn every_verdict_is_a_legal_move() {
        for ending in [Ending::Lost, Ending::Released, input(), stopped()] {
            for counts in [(0, 0), (4, 0), (0, 2), (9, 9)] {
                for wanted in [true, false] {
                    let state = verdict(&ending, counts, wanted, LIMITS).state;
                    assert!(MOVES.contains(&(Leased, state)), "{ending:?} {counts:?}");
                }
            }
        }
    }

    #[test]
    fn fifth_loss_poisons_and_release_never_does() {
        assert_eq!(verdict(&Ending::Lost, (3, 0), true, LIMITS).state, Ready);
        assert_eq!(verdict(&Ending::Lost, (4, 0), true, LIMITS).state, Poisoned);
        let released = verdict(&Ending::Released, (100, 100), true, LIMITS);
        assert_eq!((released.state, released.losses), (Ready, 0));
    }

    #[test]
    fn machine_is_tried_three_times_and_physics_once() {
        assert_eq!(verdict(&input(), (0, 1), true, LIMITS).state, Ready);
        assert_eq!(verdict(&input(), (0, 2), true, LIMITS).state, Failed);
        let physics = verdict(&stopped(), (0, 0), true, LIMITS);
        assert_eq!((physics.state, physics.faults), (Failed, 0));
    }

    #[test]
    fn unwanted_jobs_go_to_cancelled() {
        assert_eq!(
            verdict(&Ending::Lost, (0, 0), false, LIMITS).state,
            Cancelled
        );
    }
}
