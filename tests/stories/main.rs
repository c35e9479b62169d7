//! Stories of the whole system.

mod commands;
mod exit_codes;
mod faults;
mod same_bits;
