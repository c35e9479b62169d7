//! Stories of the whole system.

mod exit_codes;
mod faults;
mod same_bits;
