//! What the worker knows about the machine that it runs on.

use std::cell::Cell;
use std::time::Duration;

use granary_core::lanes::VectorWidth;
use rustix::time::{ClockId, clock_gettime};

/// Memory taken for granted where the system does not tell \[bytes\].
const FALLBACK_MEMORY: u64 = 4 << 30;

/// The host's name, as the system gives it.
#[must_use]
pub fn host_name() -> String {
    rustix::system::uname()
        .nodename()
        .to_string_lossy()
        .into_owned()
}

/// Four fifths of the machine's memory \[bytes\]: the rest is left to the system and the page cache.
#[must_use]
pub fn memory_bytes() -> u64 {
    let table = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    total_memory(&table).map_or(FALLBACK_MEMORY, |total| total / 5 * 4)
}

/// `MemTotal` of a table in the form of `/proc/meminfo` \[bytes\].
fn total_memory(table: &str) -> Option<u64> {
    let line = table
        .lines()
        .find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// Processor, system and the widest vectors: `x86_64-linux avx512`.
#[must_use]
pub fn target() -> String {
    format!(
        "{}-{} {}",
        std::env::consts::ARCH,
        std::env::consts::OS,
        VectorWidth::widest().name()
    )
}

thread_local! {
    /// What threads used that helped this one.
    static HELP: Cell<Duration> = const { Cell::new(Duration::ZERO) };
}

/// CPU time that the calling thread has used so far, and what others were charged to it.
#[must_use]
pub fn thread_cpu_time() -> Duration {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    let own = Duration::new(
        time.tv_sec.unsigned_abs(),
        time.tv_nsec.unsigned_abs() as u32,
    );
    own + HELP.get()
}

/// Charges the calling thread with the CPU time of others that worked for it.
pub fn charge(help: Duration) {
    HELP.set(HELP.get() + help);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_read_in_kibibytes() {
        assert_eq!(
            total_memory("MemTotal:       2048 kB\nMemFree: 1 kB\n"),
            Some(2 << 20)
        );
        assert_eq!(total_memory("nothing of the kind"), None);
    }

    #[test]
    fn what_others_did_is_charged() {
        let (before, help) = (thread_cpu_time(), Duration::from_secs(3));
        charge(help);
        assert!(thread_cpu_time() >= before + help);
    }

    #[test]
    fn cpu_time_of_a_thread_never_goes_back() {
        let before = thread_cpu_time();
        assert!(thread_cpu_time() >= before);
    }
}
