//! Waiting between tries: short while a server restarts, long while it is away.

use std::time::Duration;

use tokio::time::Instant;

use crate::lease_client::ClientError;

/// The first wait, before jitter.
const FIRST: Duration = Duration::from_millis(100);
/// The longest wait in the first minute, so that workers are busy soon after a server's return.
const EARLY_CAP: Duration = Duration::from_secs(2);
/// The longest wait after the first minute.
const LATE_CAP: Duration = Duration::from_secs(30);
/// How long a server is thought to be restarting rather than away.
const EARLY: Duration = Duration::from_mins(1);

/// The waits of one row of failed tries.
#[derive(Clone, Copy, Debug)]
pub struct Backoff {
    started: Instant,
    tries: u32,
}

impl Backoff {
    /// No try has failed yet.
    #[must_use]
    pub fn new() -> Self {
        Self {
            started: Instant::now(),
            tries: 0,
        }
    }

    /// Waits before the next try, longer each time.
    pub async fn wait(&mut self) {
        let wait = delay(self.tries, self.started.elapsed(), fastrand::f64());
        self.tries = self.tries.saturating_add(1);
        tokio::time::sleep(wait).await;
    }
}

impl Default for Backoff {
    fn default() -> Self {
        Self::new()
    }
}

/// The wait after `tries` earlier ones, `elapsed` after the first; `jitter` in \[0, 1) spreads workers apart.
fn delay(tries: u32, elapsed: Duration, jitter: f64) -> Duration {
    let cap = if elapsed < EARLY { EARLY_CAP } else { LATE_CAP };
    let whole = FIRST.saturating_mul(1 << tries.min(16)).min(cap);
    whole.mul_f64(0.5 + 0.5 * jitter)
}

/// Makes `call` until it answers or fails for good.
///
/// # Errors
/// The first failure that no further try can mend.
pub async fn persist<T, F>(mut call: impl FnMut() -> F) -> Result<T, ClientError>
where
    F: Future<Output = Result<T, ClientError>>,
{
    let mut backoff = Backoff::new();
    loop {
        match call().await {
            Err(error) if error.is_retryable() => {
                tracing::debug!(error = %error, "will try again");
                backoff.wait().await;
            }
            answer => return answer,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waits_double_up_to_two_seconds_in_the_first_minute() {
        let waits: Vec<u128> = (0..7)
            .map(|tries| delay(tries, Duration::ZERO, 1.0).as_millis())
            .collect();
        assert_eq!(waits, [100, 200, 400, 800, 1600, 2000, 2000]);
    }

    #[test]
    fn waits_reach_thirty_seconds_once_the_server_is_away() {
        assert_eq!(delay(40, EARLY, 1.0), LATE_CAP);
    }

    #[test]
    fn jitter_takes_at_most_half_away() {
        assert_eq!(delay(5, Duration::ZERO, 0.0), EARLY_CAP / 2);
    }
}
