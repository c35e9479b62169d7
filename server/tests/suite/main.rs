//! The server's tests: each on a fresh, migrated database, through the store or through the routes.

mod harness;

mod accuracy;
mod archived;
mod artifacts;
mod beam;
mod endings;
mod events;
mod gate;
mod intake;
mod leases;
mod refusals;
mod results;
mod routes;
mod spec;
mod study;
mod walk;
mod wanting;
