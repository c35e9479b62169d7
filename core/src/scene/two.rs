//! Two threads within a step.
//!
//! A step is shorter than it takes to wake a thread, so the second one stays awake between steps.

use std::sync::atomic::{AtomicBool, Ordering};

/// Says, however a job ends, that it has ended.
struct Ended<'a>(&'a AtomicBool);

impl Drop for Ended<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// Whether the caller is in a pool of more than one thread.
fn has_company() -> bool {
    rayon::current_thread_index().is_some() && rayon::current_num_threads() > 1
}

/// Does `work` while another thread of the caller's pool, if there is one, watches for what [`both`] may give it.
pub(crate) fn helped<R>(work: impl FnOnce() -> R) -> R {
    if !has_company() {
        return work();
    }
    let (caller, ended) = (rayon::current_thread_index(), AtomicBool::new(false));
    rayon::in_place_scope(|scope| {
        scope.spawn(|_| {
            // The caller itself would wait for its own end.
            while rayon::current_thread_index() != caller && !ended.load(Ordering::Acquire) {
                if rayon::yield_now() != Some(rayon::Yield::Executed) {
                    std::hint::spin_loop();
                }
            }
        });
        let _ended = Ended(&ended);
        work()
    })
}

/// Does both, side by side where the caller's pool has two threads.
pub(super) fn both(first: impl FnOnce() + Send, second: impl FnOnce() + Send) {
    if has_company() {
        rayon::join(first, second);
    } else {
        first();
        second();
    }
}
