//! The stage `classifier`: a small network that learns which binary word a signal is, without ever seeing a pack (App. C).
//!
//! It is trained on the integrals J(u) of all words of L bits, shifted, scaled and with noise, and asked afterwards which word each
//! recalled signal is. Where fidelity counts every distortion, it forgives those that leave a word readable.

mod network;
pub mod settings;
mod signals;
pub(crate) mod training;

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

pub use network::Network;
pub use training::network_of;

/// Bits of the words that classifiers tell apart: the paper's sets.
pub const BITS: RangeInclusive<u32> = 3..=10;

/// Neurons of each hidden layer (App. C).
pub const HIDDEN: usize = 1024;

/// Signals of a step of the training (App. C).
pub const BATCH: usize = 32;

/// Transformed signals of a set: some batches, and no more than three times the paper's largest set.
const FEWEST_SIGNALS: u64 = 100;
const MOST_SIGNALS: u64 = 1 << 26;

/// One transformed signal in so many is kept for validation.
pub const VALIDATION: u64 = 10;

/// Everything that enters the stage `classifier`; field order is part of its identity.
///
/// Transformations are all combinations of shifts, amplitudes and draws of noise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClassifierSpec {
    /// L.
    pub bits: u32,
    /// Of initial weights, noise and the order of the signals.
    pub classifier_seed: u64,
    /// Shifts in u, evenly from minus to plus the largest.
    pub shifts: u32,
    /// Factors, evenly from 1 minus to 1 plus the largest change.
    pub amplitudes: u32,
    /// Draws of noise.
    pub noises: u32,
    /// The largest shift in u.
    pub largest_shift: f64,
    /// The largest change of the factor.
    pub largest_amplitude_change: f64,
    /// Standard deviation of Gaussian noise, independent at every sample, in units of ⟨|J|⟩.
    pub noise: f64,
    /// Of stochastic gradient descent.
    pub learning_rate: f64,
    /// How often every signal is learned from.
    pub epochs: u32,
}

impl ClassifierSpec {
    /// 2^L.
    #[must_use]
    pub fn words(&self) -> u64 {
        1 << self.bits
    }

    /// Transformations of each word.
    #[must_use]
    pub fn transformations(&self) -> u64 {
        u64::from(self.shifts) * u64::from(self.amplitudes) * u64::from(self.noises)
    }

    /// Transformed signals, of which one in [`VALIDATION`] is never learned from.
    #[must_use]
    pub fn signals(&self) -> u64 {
        self.words() * self.transformations()
    }

    /// Signals that are kept for validation.
    #[must_use]
    pub fn validation_signals(&self) -> u64 {
        self.signals() / VALIDATION
    }

    /// Steps of an epoch; what is left of its order fills no batch, and is other signals in each.
    pub(crate) fn batches(&self) -> u64 {
        (self.signals() - self.validation_signals()) / BATCH as u64
    }

    /// Steps of the whole training, the validation among them.
    #[must_use]
    pub fn steps(&self) -> u64 {
        let validation = self
            .validation_signals()
            .div_ceil(training::LOOKED_AT as u64);
        u64::from(self.epochs) * self.batches() + validation
    }

    /// Neurons that compute anything.
    #[must_use]
    pub fn neurons(&self) -> u64 {
        2 * HIDDEN as u64 + self.words()
    }

    /// Memory that it takes, not to be exceeded \[bytes\].
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let (words, hidden) = (self.words(), HIDDEN as u64);
        let weights = 4 * (hidden * (super::waveform::SAMPLES as u64 + hidden + words + 2) + words);
        let table = 4 * words * u64::from(self.shifts) * super::waveform::SAMPLES as u64;
        // The network, a checkpoint of it in the making, and the order of the signals, as they are split and as they are learned.
        (16 << 20) + 3 * weights + table + 8 * self.signals()
    }

    /// That there is such a classifier.
    ///
    /// # Errors
    /// The rule that is broken, in words.
    pub fn check(&self) -> Result<(), String> {
        if !BITS.contains(&self.bits) {
            let (fewest, most) = (BITS.start(), BITS.end());
            return Err(format!(
                "words of {} bits: there are classifiers of {fewest} … {most}",
                self.bits
            ));
        }
        let signals = self.signals();
        if !(FEWEST_SIGNALS..=MOST_SIGNALS).contains(&signals) {
            return Err(format!(
                "{signals} transformed signals of all words: there may be {FEWEST_SIGNALS} … {MOST_SIGNALS}"
            ));
        }
        Ok(())
    }
}

/// The words that `network` takes a set of signals for, of 256 samples each; none if all of them are zero.
///
/// The set, not each signal, is scaled to ⟨|p|⟩ = 1 (App. C).
#[must_use]
pub fn recognize(network: &Network, signals: &[Vec<f64>]) -> Option<Vec<u32>> {
    let (sum, count) = signals
        .iter()
        .flatten()
        .fold((0.0, 0_u64), |(sum, count), p| (sum + p.abs(), count + 1));
    let scale = count as f64 / sum;
    if !(scale.is_finite() && scale > 0.0) {
        return None;
    }
    let chunks = signals.chunks(training::LOOKED_AT);
    let scaled = |signals: &[Vec<f64>]| -> Vec<f32> {
        let all = signals.iter().flatten();
        all.map(|p| (p * scale) as f32).collect()
    };
    Some(
        chunks
            .flat_map(|chunk| network.words(&scaled(chunk)))
            .collect(),
    )
}
