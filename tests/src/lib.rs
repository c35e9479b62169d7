//! Whole-system tests: real binaries, free ports, temporary directories.
//!
//! This library is their harness: it builds `granary` once, runs its commands, and minds its servers and workers.

mod crashes;
mod process;
mod sandbox;

pub use crashes::crash;
pub use process::Process;
pub use sandbox::{Finished, Sandbox, binary, tiny};
