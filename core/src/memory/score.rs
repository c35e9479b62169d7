//! Scores: gain 𝒢 and fidelity 𝓕 of recalled signals, by the dot products of App. B.
//!
//! A set's score needs only the sums of three dot products over its waveforms, so any subset can be scored at once.

use serde::{Deserialize, Serialize};

use super::waveform::{Curve, SAMPLES, sample_u};

/// The raw boundary shear stress p_xy = p_x − p_y of one recall \[Pa\], at the 256 values of u from 0 to 1.
///
/// Decompressions are stored by u, not by time: the first value is the fully decompressed pack.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Signal {
    /// While the waveform is applied and the pack compressed.
    pub encode: Vec<f64>,
    /// While the pack is decompressed.
    pub decode: Vec<f64>,
    /// During the decompression of the second cycle, which carries no waveform; empty if there was none.
    pub second_decode: Vec<f64>,
    /// What a last digit is worth \[Pa\]: the mean of p_x and p_y while the pack is decompressed, times ε of the number type; not
    /// told by engines before physics version 9.
    #[serde(default)]
    pub resolution: Option<f64>,
}

/// How a recalled signal is freed from the pack's own asymmetry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Processing {
    /// −(p_xy − p_xy of the zero waveform in the same trained pack).
    #[serde(rename = "SUB0")]
    Sub0,
    /// −(p_xy − p_xy of the second decompression of the same run).
    #[serde(rename = "SUB2")]
    Sub2,
    /// SUB2, then minus the straight line through its end points.
    #[serde(rename = "SUB2-BL")]
    Sub2Baseline,
}

impl Processing {
    /// Every processing, with its name in specs.
    pub const ALL: [(&'static str, Self); 3] = [
        ("SUB0", Self::Sub0),
        ("SUB2", Self::Sub2),
        ("SUB2-BL", Self::Sub2Baseline),
    ];

    /// The name in specs and tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL
            .iter()
            .find(|(_, p)| *p == self)
            .expect("ALL holds every processing")
            .0
    }

    /// Whether the zero waveform of the same trained pack is needed.
    #[must_use]
    pub fn needs_zero(self) -> bool {
        self == Self::Sub0
    }

    /// p_sig(u) \[Pa\] at the 256 samples; `None` if what it needs is missing.
    #[must_use]
    pub fn apply(self, signal: &Signal, zero: Option<&Signal>) -> Option<Vec<f64>> {
        let background = match self {
            Self::Sub0 => &zero?.decode,
            Self::Sub2 | Self::Sub2Baseline => &signal.second_decode,
        };
        if signal.decode.len() != SAMPLES || background.len() != SAMPLES {
            return None;
        }
        let mut p_sig: Vec<f64> = signal
            .decode
            .iter()
            .zip(background)
            .map(|(p, b)| -(p - b))
            .collect();
        if self == Self::Sub2Baseline {
            let (first, last) = (p_sig[0], p_sig[SAMPLES - 1]);
            for (k, p) in p_sig.iter_mut().enumerate() {
                *p -= first + (last - first) * sample_u(k);
            }
        }
        Some(p_sig)
    }
}

/// The dot products of one waveform, or their sums over several, Eq. (18).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Dots {
    /// J·p \[Pa\].
    pub j_p: f64,
    /// J·J.
    pub j_j: f64,
    /// p·p \[Pa²\].
    pub p_p: f64,
    /// What p·p would be of a signal of one last digit \[Pa²\]; NaN if that is not known.
    pub lost: f64,
    /// What p·p would be of what scatters from sample to sample \[Pa²\].
    pub scatter: f64,
}

impl Dots {
    /// The dot products of a processed signal with the J of its waveform; `resolution` is that of [`Signal`].
    #[must_use]
    pub fn of(p_sig: &[f64], curve: &Curve, resolution: Option<f64>) -> Self {
        let j: Vec<f64> = (0..SAMPLES).map(|k| curve.integral(sample_u(k))).collect();
        Self {
            j_p: trapezoid(&j, p_sig),
            j_j: trapezoid(&j, &j),
            p_p: trapezoid(p_sig, p_sig),
            lost: resolution.map_or(f64::NAN, |digit| digit * digit),
            scatter: scatter(p_sig),
        }
    }
}

impl std::ops::AddAssign for Dots {
    fn add_assign(&mut self, other: Self) {
        self.j_p += other.j_p;
        self.j_j += other.j_j;
        self.p_p += other.p_p;
        self.lost += other.lost;
        self.scatter += other.scatter;
    }
}

/// ∫₀¹ a(u) b(u) du by the trapezoid rule on the grid of samples.
fn trapezoid(a: &[f64], b: &[f64]) -> f64 {
    let last = a.len() - 1;
    let mut sum = 0.5 * (a[0] * b[0] + a[last] * b[last]);
    for k in 1..last {
        sum += a[k] * b[k];
    }
    sum / last as f64
}

/// The variance of what differs from sample to sample without memory, by fourth differences.
///
/// Independent samples of variance σ² have fourth differences of variance σ² (1 + 16 + 36 + 16 + 1) = 70 σ².
/// A sine that fits L times into 0 … 1 has (2π L/255)⁴/√70 of its size left, 0.003 for L = 16; one jump of its size √(20/70/252) = 0.034.
fn scatter(a: &[f64]) -> f64 {
    let fourth = |w: &[f64]| (w[0] + w[4]) - 4.0 * (w[1] + w[3]) + 6.0 * w[2];
    let squares: f64 = a.windows(5).map(|w| fourth(w) * fourth(w)).sum();
    squares / (70 * (a.len() - 4)) as f64
}

/// What a set of recalled signals says about the memory.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// 𝒢, Eq. (20); `None` if J·J = 0.
    pub gain: Option<f64>,
    /// 𝒢 E δ0 \[Pa\], the number that the authors publish.
    pub gain_e_delta0: Option<f64>,
    /// 𝓕 = 1 − √(1 − C²), Eq. (21); `None` if J·J or p·p is 0.
    pub fidelity: Option<f64>,
    /// C = J·p/√(J·J p·p): the fidelity with the sign of the gain.
    pub correlation: Option<f64>,
    /// What a last digit of a pressure is of the recalled signals: rounding may move 𝒢 by that over |C| of itself, and 𝓕 by that.
    ///
    /// Single precision moved 𝒢 by no more in packs of 64 and 1,024 at γ0 = 10⁻³ … 10⁻⁵ (docs/accuracy.md).
    pub rounding_error: Option<f64>,
    /// How much recalled signals scatter from sample to sample, as a share of their size: what moves the walls that is no memory.
    ///
    /// 0.002 to 0.02 in packs at rest, 0.05 where a ramp is so fast that 𝓕 suffers (docs/accuracy.md).
    pub noise_to_signal: Option<f64>,
}

/// Signals that rounding may move by more than this share of themselves have no score.
const MOST_ROUNDING: f64 = 0.1;

/// Signals that scatter by more than this share of themselves are called noisy.
const MOST_NOISE: f64 = 0.1;

impl Score {
    /// Scores the summed dot products of a set; `youngs_modulus` in Pa.
    #[must_use]
    pub fn of(dots: &Dots, youngs_modulus: f64, delta0: f64, gamma0: f64) -> Self {
        let share = |of: f64| (dots.p_p > 0.0 && of >= 0.0).then(|| (of / dots.p_p).sqrt());
        let (rounding_error, noise_to_signal) = (share(dots.lost), share(dots.scatter));
        if rounding_error > Some(MOST_ROUNDING) {
            return Self {
                gain: None,
                gain_e_delta0: None,
                fidelity: None,
                correlation: None,
                rounding_error,
                noise_to_signal,
            };
        }
        let has_waveform = dots.j_j > 0.0;
        let correlation = (has_waveform && dots.p_p > 0.0)
            .then(|| (dots.j_p / (dots.j_j.sqrt() * dots.p_p.sqrt())).clamp(-1.0, 1.0));
        let per_strain = has_waveform.then(|| dots.j_p / (gamma0 * dots.j_j));
        Self {
            gain: per_strain.map(|g| g / (youngs_modulus * delta0)),
            gain_e_delta0: per_strain,
            fidelity: correlation.map(|c| 1.0 - (1.0 - c * c).max(0.0).sqrt()),
            correlation,
            rounding_error,
            noise_to_signal,
        }
    }

    /// Why there is no fidelity, if there is none.
    #[must_use]
    pub fn missing_reason(dots: &Dots) -> Option<&'static str> {
        if dots.j_j <= 0.0 {
            Some("the waveforms are all zero (J·J = 0)")
        } else if dots.p_p <= 0.0 {
            Some("nothing was recalled (p·p = 0)")
        } else if dots.lost > MOST_ROUNDING * MOST_ROUNDING * dots.p_p {
            Some(
                "what was recalled is less than ten last digits of the pressures: use precision = \"f64\", or a larger gamma0",
            )
        } else {
            None
        }
    }

    /// What a reader of the numbers should know: that the signals are noisy.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let noise = self.noise_to_signal.filter(|&noise| noise > MOST_NOISE)?;
        self.gain.map(|_| {
            format!(
                "noisy: the signals scatter from sample to sample by {noise:.2} of their size, as where sound stays in a pack, or \
                 where it rearranges or does not rest"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::waveform::Waveform;

    fn j_of(s: u8) -> Vec<f64> {
        let curve = Waveform::Six(s).curve();
        (0..SAMPLES).map(|k| curve.integral(sample_u(k))).collect()
    }

    /// A recall whose decompression holds `decode` over a background, and a second one with the background alone.
    fn recall(decode: &[f64]) -> Signal {
        let background: Vec<f64> = (0..SAMPLES)
            .map(|k| 7.0 - 3.0 * sample_u(k) * sample_u(k))
            .collect();
        let decode = background.iter().zip(decode).map(|(b, p)| b - p).collect();
        Signal {
            encode: vec![],
            decode,
            second_decode: background,
            resolution: Some(0.0),
        }
    }

    #[test]
    fn scores_equal_the_integrals_of_appendix_b() {
        // p = 2 J + a disturbance; E² by Eq. (17) on the same grid, then 𝓕 by its definition (21).
        let (e, delta0, gamma0) = (1e7, 0.05, 1e-3);
        let mut dots = Dots::default();
        let mut sets = vec![];
        for s in 1..=6 {
            let j = j_of(s);
            let p: Vec<f64> = j
                .iter()
                .enumerate()
                .map(|(k, j)| 2.0 * j + 0.02 * (k as f64 * 0.1).sin())
                .collect();
            let p_sig = Processing::Sub2.apply(&recall(&p), None).expect("complete");
            dots += Dots::of(&p_sig, &Waveform::Six(s).curve(), Some(0.0));
            sets.push((j, p));
        }
        let score = Score::of(&dots, e, delta0, gamma0);
        let gain = score.gain.expect("J·J > 0");
        let scale = gain * e * delta0 * gamma0;
        let (mut error, mut power) = (0.0, 0.0);
        for (j, p) in &sets {
            let rest: Vec<f64> = j.iter().zip(p).map(|(j, p)| p - scale * j).collect();
            error += trapezoid(&rest, &rest);
            power += trapezoid(p, p);
        }
        let fidelity = 1.0 - (error / power).sqrt();
        // Both sides are sums of 1536 rounded terms; E² is a difference that loses at most a factor 100 of 1e-16.
        assert!((score.fidelity.expect("p·p > 0") - fidelity).abs() < 1e-10);
    }

    #[test]
    fn zero_recall_and_zero_waveform_give_no_fidelity() {
        let silent = Dots::of(&[0.0; SAMPLES], &Waveform::Six(1).curve(), Some(0.0));
        assert_eq!(Score::of(&silent, 1.0, 0.05, 1e-3).fidelity, None);
        assert!(Score::missing_reason(&silent).is_some());
        let zero = Dots::of(&[1.0; SAMPLES], &Waveform::Zero.curve(), Some(0.0));
        assert_eq!(Score::of(&zero, 1.0, 0.05, 1e-3).gain, None);
    }

    #[test]
    fn signal_of_an_older_engine_can_still_be_read() {
        let old = r#"{"encode":[],"decode":[1.0],"second_decode":[]}"#;
        let signal: Signal = serde_json::from_str(old).expect("a signal of physics version 8");
        assert_eq!((signal.decode, signal.resolution), (vec![1.0], None));
    }

    #[test]
    fn signals_of_a_few_last_digits_have_no_score_but_a_reason() {
        let p = j_of(1);
        let size = trapezoid(&p, &p).sqrt();
        let of = |resolution: f64| Dots::of(&p, &Waveform::Six(1).curve(), Some(resolution * size));
        let fine = Score::of(&of(0.02), 1.0, 0.05, 1e-3);
        assert!((fine.rounding_error.expect("recalled") - 0.02).abs() < 1e-12);
        assert!(fine.gain.is_some() && Score::missing_reason(&of(0.02)).is_none());
        let coarse = Score::of(&of(0.2), 1.0, 0.05, 1e-3);
        assert!((coarse.rounding_error.expect("recalled") - 0.2).abs() < 1e-12);
        assert_eq!((coarse.gain, coarse.fidelity), (None, None));
        assert!(Score::missing_reason(&of(0.2)).is_some());
    }

    #[test]
    fn signals_of_an_engine_that_told_no_resolution_have_no_rounding_error_but_a_score() {
        let dots = Dots::of(&j_of(1), &Waveform::Six(1).curve(), None);
        let score = Score::of(&dots, 1.0, 0.05, 1e-3);
        assert_eq!(score.rounding_error, None);
        assert!(score.gain.is_some() && Score::missing_reason(&dots).is_none());
    }

    /// Independent numbers of mean 0 and variance 1/12.
    fn scattered() -> Vec<f64> {
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state) / f64::from(u32::MAX) - 0.5
        };
        (0..SAMPLES).map(|_| next()).collect()
    }

    #[test]
    fn signals_that_scatter_are_told_to_be_noise() {
        let j = j_of(1);
        let size = trapezoid(&j, &j).sqrt();
        let of = |noise: f64| {
            let scatter = scattered()
                .into_iter()
                .map(|x| noise * size * 12_f64.sqrt() * x);
            let p: Vec<f64> = j.iter().zip(scatter).map(|(j, noise)| j + noise).collect();
            Dots::of(&p, &Waveform::Six(1).curve(), Some(0.0))
        };
        for (noise, told) in [(0.05, false), (0.2, true)] {
            let score = Score::of(&of(noise), 1.0, 0.05, 1e-3);
            let found = score.noise_to_signal.expect("recalled");
            // The noise is part of what its share is taken of. The mean of 252 squares of fourth differences, whose squares
            // are correlated over Σ_k (ρ_k)² = 1 + 2 (56² + 28² + 8² + 1)/70² = 2.6, has a standard error of √(2·2.6/252) = 0.14,
            // its root half of that: three of them.
            let expected = noise / (1.0 + noise * noise).sqrt();
            assert!(
                (found / expected - 1.0).abs() < 3.0 * 0.07,
                "{found} {expected}"
            );
            assert!(score.gain.is_some());
            assert_eq!(score.warning().is_some(), told);
        }
    }

    #[test]
    fn the_finest_waveforms_do_not_scatter() {
        // Sixteen bits of alternating sign are the finest word that is on offer.
        for word in ["six/6", "binary_words/10/682", "binary_words/16/43690"] {
            let waveform: Waveform = serde_json::from_value(word.into()).expect("a waveform");
            let curve = waveform.curve();
            let p: Vec<f64> = (0..SAMPLES).map(|k| curve.integral(sample_u(k))).collect();
            let score = Score::of(&Dots::of(&p, &curve, Some(0.0)), 1.0, 0.05, 1e-3);
            let noise = score.noise_to_signal.expect("recalled");
            assert!(noise < 0.005, "{word}: {noise}");
        }
    }

    #[test]
    fn perfect_recall_of_either_sign_has_fidelity_one() {
        for sign in [1.0, -1.0] {
            let p: Vec<f64> = j_of(5).iter().map(|j| sign * 3.0 * j).collect();
            let score = Score::of(
                &Dots::of(&p, &Waveform::Six(5).curve(), Some(0.0)),
                1.0,
                1.0,
                1.0,
            );
            // 𝓕 = 1 − √(1 − C²) turns a rounding error of 1e-16 in C² into 1e-8.
            assert!((score.fidelity.expect("recalled") - 1.0).abs() < 1e-7);
            assert!((score.correlation.expect("recalled") - sign).abs() < 1e-15);
        }
    }

    #[test]
    fn baseline_processing_ends_at_zero() {
        let tilted: Vec<f64> = (0..SAMPLES).map(|k| 1.0 + 4.0 * sample_u(k)).collect();
        let p = Processing::Sub2Baseline
            .apply(&recall(&tilted), None)
            .expect("complete");
        assert!(p.iter().all(|p| p.abs() < 1e-12));
    }

    #[test]
    fn sub0_without_its_zero_signal_is_missing() {
        assert_eq!(Processing::Sub0.apply(&recall(&[0.0; SAMPLES]), None), None);
    }
}
