//! The waveform-memory experiment: its parameters and the stages they lead to.
//!
//! Source: E. Dwight, D. Candela, *Mechanical waveform memory in an athermal random medium*, arXiv:2603.14595 ("the paper").

pub mod classifier;
pub mod cycle;
pub mod gas;
pub(crate) mod pack;
pub mod parameters;
pub(crate) mod recall;
pub mod results;
pub(crate) mod run;
pub mod score;
pub mod sound;
pub mod spec;
pub mod state;
pub(crate) mod train;
pub mod waveform;

/// Steps of one ramp: a multiple of 255, so that every sample is a step (docs/choices.md §3).
#[must_use]
pub fn ramp_steps(ramp: f64, time_step: f64) -> u64 {
    255 * (ramp / (255.0 * time_step)).ceil().max(1.0) as u64
}

/// Steps of a hold of `hold` ramps of `ramp_steps` each.
#[must_use]
pub fn hold_steps(hold: f64, ramp_steps: u64) -> u64 {
    (hold * ramp_steps as f64).ceil() as u64
}
