//! The worker: leases jobs, runs them as ensembles on its own threads, and reports what they yield.
//!
//! One slot is one engine thread and one [`lease_loop`]: take, execute, report.
//! How a slot reaches the queue is a [`lease_client::LeaseClient`]: over HTTP, or directly inside the server's process.
//! A worker never opens the database and never decides whether a job is tried again; it only says how a try ended.

pub mod archive;
pub mod backoff;
pub mod config;
pub mod lease_client;
pub mod machine;

pub mod execute;

mod checkpoint;
mod held;
mod report;
mod slot;
mod spool;

pub mod lease_loop;
