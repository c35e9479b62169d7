//! The threads that share a step.
//!
//! A step is shorter than it takes to wake a thread, so the others stay awake between steps.
//! What is shared out is cut into parts that none but one thread writes; which thread takes which part changes no bit.

use std::sync::atomic::{AtomicBool, Ordering};

/// Rows that are worth a thread.
pub(super) const LEAST_ROWS: usize = 256;

/// Says, however something ends, that it has ended.
struct Ended<'a>(&'a AtomicBool);

impl Drop for Ended<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// How many threads share the caller's steps: those of the pool that it runs in.
pub(crate) fn size() -> usize {
    if rayon::current_thread_index().is_some() {
        rayon::current_num_threads()
    } else {
        1
    }
}

/// Does `work`, a lone run of so many grains or of a beam, while the other threads of the caller's pool watch for what its
/// steps share out.
pub(crate) fn helped<R>(grains: usize, work: impl FnOnce() -> R) -> R {
    if size() == 1 || grains < 2 * LEAST_ROWS {
        return work();
    }
    let (caller, ended) = (rayon::current_thread_index(), AtomicBool::new(false));
    rayon::in_place_scope(|scope| {
        scope.spawn_broadcast(|_, thread| {
            // The caller itself would wait for its own end.
            while Some(thread.index()) != caller && !ended.load(Ordering::Acquire) {
                look_for_work();
            }
        });
        let _ended = Ended(&ended);
        work()
    })
}

/// Does what some other thread of the team shares out, if there is any.
fn look_for_work() {
    if rayon::yield_now() != Some(rayon::Yield::Executed) {
        std::hint::spin_loop();
    }
}

/// Does both, side by side where the caller's pool has more threads.
pub(super) fn both(first: impl FnOnce() + Send, second: impl FnOnce() + Send) {
    if size() > 1 {
        join(first, second);
    } else {
        first();
        second();
    }
}

/// The same by another thread of the pool, if one takes it: who is done first then stays awake, as waking takes longer than
/// most of what is shared out.
fn join(first: impl FnOnce() + Send, second: impl FnOnce() + Send) {
    let (taken, done) = (AtomicBool::new(false), AtomicBool::new(false));
    rayon::join(
        || {
            first();
            while taken.load(Ordering::Acquire) && !done.load(Ordering::Acquire) {
                look_for_work();
            }
        },
        || {
            taken.store(true, Ordering::Release);
            // Set even if `second` panics, so that nobody waits for ever.
            let _done = Ended(&done);
            second();
        },
    );
}

/// Does `work` on every part, side by side where the caller's pool has more threads.
pub(super) fn each<T: Send>(parts: &mut [T], work: &(impl Fn(&mut T) + Sync)) {
    if size() == 1 {
        parts.iter_mut().for_each(work);
        return;
    }
    match parts {
        [] => {}
        [part] => work(part),
        _ => {
            let (first, second) = parts.split_at_mut(parts.len() / 2);
            join(|| each(first, work), || each(second, work));
        }
    }
}
