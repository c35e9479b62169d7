//! Engines that do as they are told instead of computing.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex};
use std::time::Duration;

use granary_core::stage::{Ensemble, Outcome, Report, SIGNAL, StageFailure};
use granary_worker::execute::{Engine, StageResult};

/// The outcome of job `lane`.
pub(crate) fn outcome(lane: usize) -> Outcome {
    Outcome {
        results: BTreeMap::from([("encode_correlation".to_owned(), Some(lane as f64))]),
        reasons: BTreeMap::new(),
        artifacts: BTreeMap::from([(SIGNAL.to_owned(), format!("signal {lane}").into_bytes())]),
        warnings: vec![],
        steps: 1000,
    }
}

fn outcomes(ensemble: &Ensemble<'_>) -> Vec<StageResult> {
    (0..ensemble.specs.len())
        .map(|lane| Ok(outcome(lane)))
        .collect()
}

/// Finishes at once.
pub(crate) fn instant() -> Engine {
    Arc::new(|ensemble, _| outcomes(ensemble))
}

/// Finishes at once, with `results`.
pub(crate) fn scripted(results: Vec<StageResult>) -> Engine {
    Arc::new(move |_, _| results.clone())
}

/// An engine that computes until the test lets it finish, and what it has seen.
#[derive(Default)]
pub(crate) struct Gated {
    open: Mutex<bool>,
    opened: Condvar,
    begun: AtomicU64,
    /// Runs that were told to stop.
    pub(crate) interrupted: AtomicU64,
    /// Runs that were given checkpoints.
    pub(crate) resumed: AtomicU64,
}

impl Gated {
    pub(crate) fn new() -> Arc<Self> {
        Arc::default()
    }

    pub(crate) fn engine(self: &Arc<Self>) -> Engine {
        let gate = Arc::clone(self);
        Arc::new(move |ensemble, watch| gate.run(ensemble, watch))
    }

    /// Lets every run finish.
    pub(crate) fn open(&self) {
        *self.open.lock().expect("gate") = true;
        self.opened.notify_all();
    }

    /// Waits until `count` runs have begun, 20 seconds at most.
    pub(crate) async fn until_begun(&self, count: u64) {
        let begun = async {
            while self.begun.load(Ordering::SeqCst) < count {
                tokio::task::yield_now().await;
            }
        };
        let deadline = Duration::from_secs(20);
        tokio::time::timeout(deadline, begun)
            .await
            .expect("runs begin within 20 s");
    }

    fn run(
        &self,
        ensemble: &Ensemble<'_>,
        watch: granary_core::stage::Watch<'_>,
    ) -> Vec<StageResult> {
        self.begun.fetch_add(1, Ordering::SeqCst);
        if ensemble.checkpoints.is_some() {
            self.resumed.fetch_add(1, Ordering::SeqCst);
        }
        let lanes = ensemble.specs.len();
        let mut step = 0;
        loop {
            step += 100;
            let checkpoint = || {
                (0..lanes)
                    .map(|lane| format!("state of {lane} at {step}").into_bytes())
                    .collect()
            };
            let report = Report {
                step,
                steps: 1_000_000,
                checkpoint: &checkpoint,
            };
            if watch(&report) == ControlFlow::Break(()) {
                self.interrupted.fetch_add(1, Ordering::SeqCst);
                return vec![Err(StageFailure::Interrupted { step }); lanes];
            }
            let open = self.open.lock().expect("gate");
            let tick = Duration::from_millis(2);
            let (open, _) = self
                .opened
                .wait_timeout_while(open, tick, |open| !*open)
                .expect("gate");
            if *open {
                return outcomes(ensemble);
            }
        }
    }
}
