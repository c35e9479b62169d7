//! Stories of the whole system.

mod crashes;
mod exit_codes;
mod faults;
mod same_bits;
