//! Gaussian noise for the synthetic measurements of unit tests.

use std::f64::consts::TAU;

use crate::random::{Purpose, uniform3};

/// The `counter`-th number of the stream of `seed`: mean 0, variance 1 (Box and Muller).
pub(crate) fn gaussian(seed: u64, counter: u64) -> f64 {
    let [a, b, _] = uniform3(seed, Purpose::GasVelocity, counter);
    (-2.0 * libm::log(1.0 - a)).sqrt() * libm::cos(TAU * b)
}
