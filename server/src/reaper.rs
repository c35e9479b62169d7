//! The reaper: takes back the leases of workers that have fallen silent.
//!
//! It reads no wall clock: a lease is stale when this process has itself seen its count of heartbeats unchanged
//! for a full term of a monotonic clock, so a restart gives every lease a full term by itself.

use std::collections::BTreeMap;
use std::time::Duration;

use granary_api::id::LeaseId;
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;

use crate::store::{Store, StoreError};

/// What the reaper has seen of each lease.
#[derive(Debug, Default)]
pub struct Reaper {
    seen: BTreeMap<LeaseId, (u64, Duration)>,
}

impl Reaper {
    /// Looks at the leases at time `now`; those whose count has not moved for `term`, with that count.
    pub fn stale(
        &mut self,
        leases: &[(LeaseId, u64)],
        now: Duration,
        term: Duration,
    ) -> Vec<(LeaseId, u64)> {
        let mut next = BTreeMap::new();
        let mut stale = vec![];
        for &(lease, beat) in leases {
            let since = match self.seen.get(&lease) {
                Some(&(seen, since)) if seen == beat => since,
                _ => now,
            };
            if now.saturating_sub(since) >= term {
                stale.push((lease, beat));
            }
            next.insert(lease, (beat, since));
        }
        self.seen = next;
        stale
    }

    /// Looks once, and takes back what is stale; how many jobs came back.
    pub async fn sweep(&mut self, store: &Store, now: Duration) -> Result<usize, StoreError> {
        let leases = store.lease_beats().await?;
        let mut jobs = 0;
        for (lease, beat) in self.stale(&leases, now, store.config().lease_term) {
            jobs += store.lease_reap(lease, beat).await?;
            tracing::warn!(lease.id = %lease, "no heartbeat for a full term: lease taken back");
        }
        Ok(jobs)
    }
}

/// Looks again and again until `shutdown`.
pub async fn run(store: Store, shutdown: CancellationToken) {
    let mut reaper = Reaper::default();
    let start = Instant::now();
    let pause =
        (store.config().lease_term / 10).clamp(Duration::from_millis(10), Duration::from_secs(1));
    loop {
        tokio::select! {
            () = shutdown.cancelled() => return,
            () = tokio::time::sleep(pause) => {}
        }
        if let Err(error) = reaper.sweep(&store, start.elapsed()).await {
            tracing::error!(%error, cause = ?std::error::Error::source(&error), "leases were not looked at");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TERM: Duration = Duration::from_secs(30);

    fn at(seconds: u64) -> Duration {
        Duration::from_secs(seconds)
    }

    #[test]
    fn silent_lease_is_stale_after_a_full_term_and_not_before() {
        let mut reaper = Reaper::default();
        let lease = LeaseId::new();
        assert!(reaper.stale(&[(lease, 3)], at(100), TERM).is_empty());
        assert!(reaper.stale(&[(lease, 3)], at(129), TERM).is_empty());
        assert_eq!(reaper.stale(&[(lease, 3)], at(130), TERM), [(lease, 3)]);
    }

    #[test]
    fn every_beat_gives_a_new_term() {
        let mut reaper = Reaper::default();
        let lease = LeaseId::new();
        for beat in 0..100 {
            assert!(
                reaper
                    .stale(&[(lease, beat)], at(29 * beat), TERM)
                    .is_empty()
            );
        }
    }

    #[test]
    fn restart_gives_every_lease_a_full_term() {
        let lease = LeaseId::new();
        assert!(
            Reaper::default()
                .stale(&[(lease, 0)], at(0), TERM)
                .is_empty()
        );
    }
}
