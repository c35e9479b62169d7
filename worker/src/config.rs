//! What a worker is told when it starts.

use std::path::PathBuf;
use std::time::Duration;

use crate::archive::Archive;
use crate::machine;

/// The settings of one worker process.
#[derive(Clone, Debug)]
pub struct Config {
    /// What the worker calls itself; each slot appends its number.
    pub name: String,
    /// Engine threads, each with its own lease.
    pub slots: usize,
    /// Memory that one ensemble may take \[bytes\].
    pub memory_bytes: u64,
    /// How long a request for work may wait for an answer.
    pub poll: Duration,
    /// How often the state of a running ensemble is stored.
    pub checkpoint_every: Duration,
    /// How long after the word to stop a slot may still checkpoint, hand back and deliver.
    pub grace: Duration,
    /// Where finished outcomes wait that could not be delivered; without it they wait in memory alone.
    pub spool: Option<PathBuf>,
    /// Where finished stages are kept, and looked for first.
    pub archive: Option<Archive>,
}

impl Config {
    /// The usual settings for `slots` engine threads on this machine.
    #[must_use]
    pub fn new(slots: usize) -> Self {
        let slots = slots.max(1);
        Self {
            name: format!("{}/{}", machine::host_name(), std::process::id()),
            slots,
            memory_bytes: machine::memory_bytes() / slots as u64,
            poll: Duration::from_secs(25),
            checkpoint_every: Duration::from_mins(5),
            grace: Duration::from_secs(15),
            spool: None,
            archive: None,
        }
    }
}
