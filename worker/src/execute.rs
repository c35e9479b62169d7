//! One ensemble on its own thread: never on the async runtime's.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::{Duration, Instant};

use granary_core::crew::Crew;
use granary_core::stage::{Ensemble, Outcome, Report, StageFailure, StageSpec, Watch};
use tokio::sync::{OwnedSemaphorePermit, oneshot, watch};

use crate::archive::Archive;
use crate::held::{Signals, Word};
use crate::machine::{charge, thread_cpu_time};

/// What becomes of one job.
pub type StageResult = Result<Outcome, StageFailure>;

/// Runs ensembles; tests put their own in the place of [`granary_core::stage::run`].
pub type Engine = Arc<dyn Fn(&Ensemble<'_>, Watch<'_>) -> Vec<StageResult> + Send + Sync>;

/// The engine of `core` on so many threads: those that have no ensemble of their own help the others with their steps.
#[must_use]
pub fn core_engine(threads: usize) -> Engine {
    let crew = Crew::new(threads, thread_cpu_time);
    Arc::new(move |ensemble, watch| {
        let (results, help) = crew.work(|| granary_core::stage::run(ensemble, watch));
        charge(help);
        results
    })
}

/// Everything an ensemble needs, in memory.
#[derive(Debug)]
pub(crate) struct Inputs {
    pub(crate) specs: Vec<StageSpec>,
    pub(crate) state: Vec<u8>,
    pub(crate) checkpoints: Option<Vec<Vec<u8>>>,
}

/// What the engine thread leaves behind.
#[derive(Debug)]
pub(crate) struct Finished {
    pub(crate) results: Vec<StageResult>,
    pub(crate) wall: Duration,
    pub(crate) cpu: Duration,
}

/// A checkpoint of every job of an ensemble, in the jobs' order.
pub(crate) type Checkpoints = Arc<Vec<Vec<u8>>>;

/// An ensemble under way.
#[derive(Debug)]
pub(crate) struct Running {
    pub(crate) finished: oneshot::Receiver<Finished>,
    pub(crate) checkpoints: watch::Receiver<Checkpoints>,
}

/// Starts `inputs` on a thread of its own; `slot` is given back when that thread ends.
///
/// What the archive holds is not computed again, and what is computed is kept there.
///
/// # Errors
/// If the system gives no thread.
pub(crate) fn start(
    engine: Engine,
    inputs: Inputs,
    signals: Arc<Signals>,
    (checkpoint_every, archive): (Duration, Option<Archive>),
    slot: OwnedSemaphorePermit,
) -> std::io::Result<Running> {
    let (finished_in, finished) = oneshot::channel();
    let (checkpoints_in, checkpoints) = watch::channel(Checkpoints::default());
    let observer = Observer {
        signals,
        checkpoints: checkpoints_in,
        every: checkpoint_every,
        latest: Instant::now(),
    };
    std::thread::Builder::new()
        .name("engine".to_owned())
        .spawn(move || {
            let before = archive.as_ref().and_then(|a| a.find(&inputs.specs));
            let outcome = before.unwrap_or_else(|| {
                let finished = compute(&engine, &inputs, observer);
                if let Some(archive) = &archive {
                    archive.keep(&inputs.specs, &finished, inputs.checkpoints.is_some());
                }
                finished
            });
            drop(inputs);
            drop(slot);
            // An error means that the lease is gone and nobody waits.
            let _ = finished_in.send(outcome);
        })?;
    Ok(Running {
        finished,
        checkpoints,
    })
}

/// Runs the ensemble; a panic becomes a machine fault of every job.
fn compute(engine: &Engine, inputs: &Inputs, mut observer: Observer) -> Finished {
    let (wall, cpu) = (Instant::now(), thread_cpu_time());
    let ensemble = Ensemble {
        specs: &inputs.specs,
        input: &inputs.state,
        checkpoints: inputs.checkpoints.as_deref(),
    };
    let run = AssertUnwindSafe(|| engine(&ensemble, &mut |report| observer.observe(report)));
    let results = catch_unwind(run).unwrap_or_else(|panic| {
        let detail = format!("the engine panicked: {}", panic_message(panic.as_ref()));
        all_failed(inputs.specs.len(), &detail)
    });
    Finished {
        results,
        wall: wall.elapsed(),
        cpu: thread_cpu_time().saturating_sub(cpu),
    }
}

/// A machine fault for each of `count` jobs.
pub(crate) fn all_failed(count: usize, detail: &str) -> Vec<StageResult> {
    let failure = StageFailure::Input {
        detail: detail.to_owned(),
    };
    vec![Err(failure); count]
}

fn panic_message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    text.unwrap_or("no message")
}

/// The worker's side of the engine's callback.
struct Observer {
    signals: Arc<Signals>,
    checkpoints: watch::Sender<Checkpoints>,
    every: Duration,
    latest: Instant,
}

impl Observer {
    fn observe(&mut self, report: &Report<'_>) -> std::ops::ControlFlow<()> {
        let word = self.signals.report(report.step, report.steps);
        let due = word == Word::GoOn && self.latest.elapsed() >= self.every;
        if due || word == Word::HandBack {
            self.checkpoints
                .send_replace(Arc::new((report.checkpoint)()));
            self.latest = Instant::now();
        }
        if word == Word::GoOn {
            std::ops::ControlFlow::Continue(())
        } else {
            std::ops::ControlFlow::Break(())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;

    fn inputs() -> Inputs {
        Inputs {
            specs: vec![],
            state: vec![],
            checkpoints: None,
        }
    }

    fn observer(
        signals: &Arc<Signals>,
        every: Duration,
    ) -> (Observer, watch::Receiver<Checkpoints>) {
        let (sender, receiver) = watch::channel(Checkpoints::default());
        let observer = Observer {
            signals: Arc::clone(signals),
            checkpoints: sender,
            every,
            latest: Instant::now(),
        };
        (observer, receiver)
    }

    fn look(observer: &mut Observer) -> ControlFlow<()> {
        observer.observe(&Report {
            step: 100,
            steps: 1000,
            checkpoint: &|| vec![b"state".to_vec()],
        })
    }

    #[test]
    fn a_checkpoint_is_written_when_due_and_the_run_goes_on() {
        let signals = Arc::default();
        let (mut observer, checkpoints) = observer(&signals, Duration::ZERO);
        assert!(look(&mut observer).is_continue());
        assert_eq!(**checkpoints.borrow(), [b"state".to_vec()]);
    }

    #[test]
    fn handing_back_writes_a_checkpoint_and_stops() {
        let signals: Arc<Signals> = Arc::default();
        let (mut observer, checkpoints) = observer(&signals, Duration::from_hours(1));
        assert!(look(&mut observer).is_continue());
        assert!(checkpoints.borrow().is_empty());
        signals.say(Word::HandBack);
        assert!(look(&mut observer).is_break());
        assert_eq!(checkpoints.borrow().len(), 1);
    }

    #[test]
    fn dropping_stops_without_a_checkpoint() {
        let signals: Arc<Signals> = Arc::default();
        let (mut observer, checkpoints) = observer(&signals, Duration::ZERO);
        signals.say(Word::Drop);
        signals.say(Word::HandBack);
        assert!(look(&mut observer).is_break());
        assert!(checkpoints.borrow().is_empty());
    }

    #[test]
    fn a_panic_is_a_fault_of_the_machine() {
        let engine: Engine = Arc::new(|_, _| panic!("grain 7 is missing"));
        let signals = Arc::default();
        let (observer, _checkpoints) = observer(&signals, Duration::from_hours(1));
        let specs = inputs();
        assert!(compute(&engine, &specs, observer).results.is_empty());
        let detail = all_failed(2, "x");
        assert!(matches!(&detail[..], [Err(StageFailure::Input { .. }), _]));
    }
}
