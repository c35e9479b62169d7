//! Wire types: what server, workers, command line and page say to one another, as JSON.
//!
//! `snake_case` fields, UTC RFC 3339 times, SI units.
//! Errors are [`problem::Problem`] documents (RFC 9457).

pub mod id;
pub mod problem;

pub mod figure;
pub mod job;
pub mod lease;
pub mod model;
pub mod sweep;
pub mod table;
pub mod token;
