//! What a classifier learns from: all words, shifted, scaled and with noise, each a function of its number.

use super::ClassifierSpec;
use crate::memory::waveform::{SAMPLES, Waveform, sample_u};
use crate::random::{self, Purpose};

/// The transformed signals of a set of words.
pub(crate) struct Signals<'a> {
    spec: &'a ClassifierSpec,
    /// J of every word at every shift, scaled to ⟨|J|⟩ = 1 over the words as they are.
    shifted: Vec<f32>,
    /// What makes ⟨|J|⟩ of all transformed signals 1.
    scale: f32,
}

impl<'a> Signals<'a> {
    pub(crate) fn new(spec: &'a ClassifierSpec) -> Self {
        let bits = spec.bits as u8;
        let words =
            (0..spec.words() as u32).map(|word| Waveform::BinaryWord { bits, word }.curve());
        let words: Vec<_> = words.collect();
        let size: f64 = words
            .iter()
            .flat_map(|curve| (0..SAMPLES).map(|k| curve.integral(sample_u(k)).abs()))
            .sum();
        let unit = (words.len() * SAMPLES) as f64 / size;
        let mut shifted = Vec::with_capacity(words.len() * spec.shifts as usize * SAMPLES);
        for curve in &words {
            for k in 0..spec.shifts {
                let shift = evenly(k, spec.shifts, spec.largest_shift);
                let j = (0..SAMPLES).map(|k| unit * curve.integral(sample_u(k) - shift));
                shifted.extend(j.map(|j| j as f32));
            }
        }
        let mut signals = Self {
            spec,
            shifted,
            scale: 1.0,
        };
        signals.scale = (1.0 / signals.mean_size()) as f32;
        signals
    }

    /// ⟨|J|⟩ over the first draw of noise; the others are drawn alike.
    fn mean_size(&self) -> f64 {
        let drawn_once = self.spec.signals() / u64::from(self.spec.noises);
        let mut signal = [0.0; SAMPLES];
        let mut sum = 0.0;
        for number in 0..drawn_once {
            self.write(number as u32, &mut signal);
            sum += signal.iter().map(|j| f64::from(j.abs())).sum::<f64>();
        }
        sum / (drawn_once * SAMPLES as u64) as f64
    }

    /// The word that signal `number` is.
    pub(crate) fn word(&self, number: u32) -> usize {
        number as usize % self.spec.words() as usize
    }

    /// Writes signal `number` at the 256 samples.
    pub(crate) fn write(&self, number: u32, signal: &mut [f32]) {
        let spec = self.spec;
        let words = spec.words() as u32;
        let (word, rest) = (number % words, number / words);
        let (shift, rest) = (rest % spec.shifts, rest / spec.shifts);
        let amplitude = rest % spec.amplitudes;
        let change = evenly(amplitude, spec.amplitudes, spec.largest_amplitude_change);
        let factor = self.scale * (1.0 + change) as f32;
        let noise = self.scale * spec.noise as f32;
        let place = (word * spec.shifts + shift) as usize * SAMPLES;
        random::normals(
            spec.classifier_seed,
            Purpose::ClassifierNoise,
            u64::from(number),
            signal,
        );
        for (x, j) in signal.iter_mut().zip(&self.shifted[place..]) {
            *x = factor * j + noise * *x;
        }
    }

    /// The signals to learn from, and those for validation.
    pub(crate) fn split(&self) -> (Vec<u32>, Vec<u32>) {
        let mut all: Vec<u32> = (0..self.spec.signals() as u32).collect();
        random::shuffle(
            self.spec.classifier_seed,
            Purpose::ClassifierOrder,
            0,
            &mut all,
        );
        let validation =
            all.split_off((self.spec.signals() - self.spec.validation_signals()) as usize);
        (all, validation)
    }

    /// The signals to learn from, in the order of an epoch, from 0.
    pub(crate) fn order(&self, training: &[u32], epoch: u64) -> Vec<u32> {
        let mut order = training.to_vec();
        let seed = self.spec.classifier_seed;
        random::shuffle(seed, Purpose::ClassifierOrder, epoch + 1, &mut order);
        order
    }
}

/// Number `k` of `n` evenly from −`largest` to `largest`; 0 if there is one.
fn evenly(k: u32, n: u32, largest: f64) -> f64 {
    if n == 1 {
        return 0.0;
    }
    largest * (2.0 * f64::from(k) / f64::from(n - 1) - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A small classifier.
    fn spec(bits: u32) -> ClassifierSpec {
        ClassifierSpec {
            bits,
            classifier_seed: 1,
            shifts: 3,
            amplitudes: 3,
            noises: 10,
            largest_shift: 5.0 / 255.0,
            largest_amplitude_change: 0.2,
            noise: 0.2,
            learning_rate: 0.02,
            epochs: 4,
        }
    }

    #[test]
    fn transformations_are_all_combinations_and_the_set_has_unit_size() {
        let spec = ClassifierSpec {
            noise: 0.0,
            ..spec(3)
        };
        let signals = Signals::new(&spec);
        let all: Vec<[f32; SAMPLES]> = (0..spec.signals() as u32)
            .map(|number| {
                let mut signal = [0.0; SAMPLES];
                signals.write(number, &mut signal);
                signal
            })
            .collect();
        let size: f64 = all.iter().flatten().map(|x| f64::from(x.abs())).sum();
        // Sums of products of single precision, 6e-8 each.
        assert!((size / (all.len() * SAMPLES) as f64 - 1.0).abs() < 1e-5);
        // The middle shift and factor of word 5 is J itself.
        let middle = 5 + 8 * (spec.shifts / 2 + spec.shifts * (spec.amplitudes / 2));
        let curve = Waveform::BinaryWord { bits: 3, word: 5 }.curve();
        let j: Vec<f64> = (0..SAMPLES).map(|k| curve.integral(sample_u(k))).collect();
        let ratio = f64::from(all[middle as usize][100]) / j[100];
        for (x, j) in all[middle as usize].iter().zip(&j) {
            assert!((f64::from(*x) - ratio * j).abs() < 1e-6);
        }
        // With the first shift it comes later by as much as the largest, in whole samples here.
        let first = middle - 8 * (spec.shifts / 2);
        let late = (spec.largest_shift * 255.0) as usize;
        for k in 0..SAMPLES - late {
            let (early, here) = (all[first as usize][k], all[middle as usize][k + late]);
            assert!((early - here).abs() < 1e-5, "{k}: {early} {here}");
        }
        // Factors are 1 ± 0.2.
        let smallest = (middle - 8 * spec.shifts * (spec.amplitudes / 2)) as usize;
        let largest = (middle + 8 * spec.shifts * (spec.amplitudes / 2)) as usize;
        assert!((all[largest][100] / all[smallest][100] - 1.2 / 0.8).abs() < 1e-5);
    }

    #[test]
    fn noise_is_as_large_as_told_and_differs_from_draw_to_draw() {
        let with = spec(3);
        let without = ClassifierSpec {
            noise: 0.0,
            ..with.clone()
        };
        let (noisy, clean) = (Signals::new(&with), Signals::new(&without));
        let (mut a, mut b) = ([0.0; SAMPLES], [0.0; SAMPLES]);
        let mut squares = 0.0;
        for number in 0..with.signals() as u32 {
            noisy.write(number, &mut a);
            clean.write(number, &mut b);
            for (a, b) in a.iter().zip(&b) {
                squares += f64::from(a / noisy.scale - b / clean.scale).powi(2);
            }
        }
        let n = (with.signals() * SAMPLES as u64) as f64;
        let deviation = (squares / n).sqrt();
        // The standard error of a standard deviation is 1/√(2n) of it: five of them.
        assert!(
            (deviation / with.noise - 1.0).abs() < 5.0 / (2.0 * n).sqrt(),
            "{deviation}"
        );
        let draw = (with.words() * u64::from(with.shifts * with.amplitudes)) as u32;
        noisy.write(0, &mut a);
        noisy.write(draw, &mut b);
        assert_ne!(
            a.map(f32::to_bits),
            b.map(f32::to_bits),
            "two draws of one transformation"
        );
    }

    #[test]
    fn nothing_is_learned_from_that_is_validated() {
        let spec = spec(4);
        let signals = Signals::new(&spec);
        let (training, validation) = signals.split();
        assert_eq!(validation.len() as u64, spec.validation_signals());
        let (first, second) = (signals.order(&training, 0), signals.order(&training, 1));
        assert_ne!(first, second);
        for order in [first, second] {
            let mut all = [order, validation.clone()].concat();
            all.sort_unstable();
            assert!(all.iter().copied().eq(0..spec.signals() as u32));
        }
    }
}
