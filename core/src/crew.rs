//! A crew: threads that several jobs share. Those without a job of their own help the others with their steps.
//!
//! Who helps whom changes with every job that starts or ends, and no bit of any result.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;

/// Rows that are worth a thread.
pub(crate) const LEAST_ROWS: usize = 256;

/// How long a thread that may not help waits until it looks again.
const NAP: Duration = Duration::from_millis(1);

/// Threads, and how many jobs they have.
#[derive(Debug)]
pub struct Crew {
    threads: usize,
    jobs: AtomicUsize,
    /// The CPU time of the calling thread.
    clock: fn() -> Duration,
}

/// What a thread knows that works for a job.
#[derive(Clone, Debug)]
struct Member {
    crew: Arc<Crew>,
    /// Threads that its job can have, itself included: none but it where nobody watches for what is shared out.
    most: usize,
    /// The CPU time of all threads but the one that has the job \[ns\].
    help: Arc<AtomicU64>,
}

thread_local! {
    static MEMBER: RefCell<Option<Member>> = const { RefCell::new(None) };
}

/// Runs what it holds when it goes, however that comes about.
struct Finally<F: FnMut()>(F);

impl<F: FnMut()> Drop for Finally<F> {
    fn drop(&mut self) {
        (self.0)();
    }
}

impl Crew {
    /// A crew of so many threads, those that call [`Crew::work`] among them; `clock` tells the CPU time of the calling thread.
    #[must_use]
    pub fn new(threads: usize, clock: fn() -> Duration) -> Arc<Self> {
        Arc::new(Self {
            threads: threads.max(1),
            jobs: AtomicUsize::new(0),
            clock,
        })
    }

    /// Does a job; returns also the CPU time of all other threads that had a part in it.
    pub fn work<R>(self: &Arc<Self>, job: impl FnOnce() -> R) -> (R, Duration) {
        self.jobs.fetch_add(1, Ordering::AcqRel);
        let _leave = Finally(|| {
            self.jobs.fetch_sub(1, Ordering::AcqRel);
            MEMBER.set(None);
        });
        let help = Arc::new(AtomicU64::new(0));
        MEMBER.set(Some(Member {
            crew: Arc::clone(self),
            most: 1,
            help: Arc::clone(&help),
        }));
        let done = job();
        (done, Duration::from_nanos(help.load(Ordering::Acquire)))
    }

    /// How many threads each job has now.
    fn share(&self) -> usize {
        (self.threads / self.jobs.load(Ordering::Acquire).max(1)).max(1)
    }
}

/// How many threads the calling thread's job has now.
pub(crate) fn size() -> usize {
    MEMBER.with_borrow(|member| {
        let size = |member: &Member| member.crew.share().min(member.most);
        member.as_ref().map_or(1, size)
    })
}

/// Does `work`, the steps of a job of so many rows, while the other threads of its crew, as far as they have no job, do what steps share out.
///
/// A step is shorter than it takes to wake a thread, so they stay awake between steps.
pub(crate) fn helped<R: Send>(rows: usize, work: impl FnOnce() -> R + Send) -> R {
    // Without others everything is done here, to the same bits.
    let Some(mut member) = MEMBER.with_borrow(Clone::clone) else {
        return work();
    };
    member.most = member.crew.threads.min(rows / LEAST_ROWS);
    if member.most < 2 {
        return work();
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(member.most);
    let Ok(pool) = pool.build() else {
        return work();
    };
    pool.install(|| {
        let (own, ended) = (rayon::current_thread_index(), AtomicBool::new(false));
        rayon::in_place_scope(|scope| {
            scope.spawn_broadcast(|_, thread| {
                // This thread itself would wait for its own end.
                if Some(thread.index()) != own {
                    let place = thread.index() + usize::from(Some(thread.index()) < own);
                    member.charged(|| member.help(place, &ended));
                }
            });
            let _ended = Finally(|| ended.store(true, Ordering::Release));
            member.charged(work)
        })
    })
}

impl Member {
    /// Does what the job's steps share out until it has ended, whenever its threads are more than `place`.
    fn help(&self, place: usize, ended: &AtomicBool) {
        while !ended.load(Ordering::Acquire) {
            if place < self.crew.share() {
                look_for_work();
            } else {
                std::thread::sleep(NAP);
            }
        }
    }

    /// Does `work` for the job, and charges it with the time.
    fn charged<R>(&self, work: impl FnOnce() -> R) -> R {
        MEMBER.set(Some(self.clone()));
        let before = (self.crew.clock)();
        let done = work();
        let used = (self.crew.clock)().saturating_sub(before);
        let nanoseconds = u64::try_from(used.as_nanos()).unwrap_or(u64::MAX);
        self.help.fetch_add(nanoseconds, Ordering::AcqRel);
        done
    }
}

/// Does what some other thread of the pool shares out, if there is any.
fn look_for_work() {
    if rayon::yield_now() != Some(rayon::Yield::Executed) {
        std::hint::spin_loop();
    }
}

/// Does both, side by side where the job has more threads.
pub(crate) fn both(first: impl FnOnce() + Send, second: impl FnOnce() + Send) {
    if size() == 1 {
        first();
        second();
        return;
    }
    let (taken, done) = (AtomicBool::new(false), AtomicBool::new(false));
    rayon::join(
        || {
            first();
            // Who is done first stays awake, as waking takes longer than most of what is shared out.
            while taken.load(Ordering::Acquire) && !done.load(Ordering::Acquire) {
                look_for_work();
            }
        },
        || {
            taken.store(true, Ordering::Release);
            let _done = Finally(|| done.store(true, Ordering::Release));
            second();
        },
    );
}

/// Does `work` on every part, side by side where the job has more threads.
pub(crate) fn each<T: Send>(parts: &mut [T], work: &(impl Fn(&mut T) + Sync)) {
    match parts {
        [] => {}
        [part] => work(part),
        _ if size() == 1 => parts.iter_mut().for_each(work),
        _ => {
            let (first, second) = parts.split_at_mut(parts.len() / 2);
            both(|| each(first, work), || each(second, work));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Barrier;

    use super::*;

    #[test]
    fn who_has_no_job_helps() {
        let crew = Crew::new(4, || Duration::ZERO);
        assert_eq!(size(), 1, "no job");
        crew.work(|| {
            helped(usize::MAX, || {
                assert_eq!(size(), 4);
                std::thread::scope(|scope| {
                    let other = scope.spawn(|| crew.work(|| helped(usize::MAX, size)).0);
                    assert_eq!(other.join().expect("a job"), 2);
                });
                assert_eq!(size(), 4);
            });
        });
        assert_eq!(size(), 1, "the job has ended");
    }

    #[test]
    fn who_watches_for_nothing_is_not_shared_out_to() {
        let crew = Crew::new(4, || Duration::ZERO);
        crew.work(|| {
            assert_eq!(size(), 1, "no steps yet");
            let caller = std::thread::current().id();
            helped(2 * LEAST_ROWS - 1, || {
                assert_eq!(size(), 1, "too few rows");
                let mut by = [None; 8];
                each(&mut by, &|by| *by = Some(std::thread::current().id()));
                assert_eq!(by, [Some(caller); 8]);
            });
            assert_eq!(helped(3 * LEAST_ROWS, size), 3, "rows for three");
        });
    }

    #[test]
    fn jobs_beyond_the_threads_are_alone() {
        let crew = Crew::new(2, || Duration::ZERO);
        let all = Barrier::new(3);
        let size_of_one = || {
            let at_work = crew.work(|| {
                all.wait();
                let at_work = helped(usize::MAX, size);
                all.wait();
                at_work
            });
            at_work.0
        };
        std::thread::scope(|scope| {
            let jobs: Vec<_> = (0..3).map(|_| scope.spawn(size_of_one)).collect();
            for job in jobs {
                assert_eq!(job.join().expect("a job"), 1);
            }
        });
    }

    #[test]
    fn what_the_others_use_is_told() {
        // Every thread's clock goes on by a second with each look at it.
        thread_local! {
            static LOOKS: RefCell<u64> = const { RefCell::new(0) };
        }
        let crew = Crew::new(3, || {
            LOOKS.with_borrow_mut(|looks| {
                *looks += 1;
                Duration::from_secs(*looks)
            })
        });
        let (parts, help) = crew.work(|| {
            helped(3 * LEAST_ROWS, || {
                let mut parts = [0; 100];
                each(&mut parts, &|part| *part += 1);
                parts
            })
        });
        assert_eq!(parts, [1; 100]);
        assert_eq!(help, Duration::from_secs(3), "three threads");
    }
}
