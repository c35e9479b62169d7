//! Waveforms: the shear I(u) that a pack is told, and its integral J(u) that it recalls.
//!
//! The paper's waveforms are sums of half-cycle cosine bumps (Eq. 6), whose J is a closed form (Eq. 10); others are tables, straight
//! from row to row, whose J is exact too.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Value, json};

use crate::parameter::shown;

mod sampled;

pub use sampled::Sampled;

/// The number of evenly spaced values of u, from 0 to 1, at which pressures are recorded (App. C).
pub const SAMPLES: usize = 256;

/// The largest number of bumps in a custom waveform.
pub const MAX_BUMPS: usize = 256;

/// u at sample `k`, exactly 0 at the first and 1 at the last.
#[must_use]
pub fn sample_u(k: usize) -> f64 {
    k as f64 / (SAMPLES - 1) as f64
}

/// The name or the description of a waveform, as a point's parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Waveform {
    /// I = 0: the background that SUB0 subtracts.
    Zero,
    /// `six/s`: signal s = 1 … 6 of Table 1.
    Six(u8),
    /// `binary_words/L/w`: the word w = 0 … 2^L − 1 of L bits (App. A.2; the paper's s is w + 1).
    BinaryWord {
        /// L, 1 … 16.
        bits: u8,
        /// The word, most significant bit first.
        word: u32,
    },
    /// A custom list of bumps.
    Bumps(Bumps),
    /// A custom table.
    Sampled(Sampled),
}

/// A waveform as a function of u.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve {
    /// See [`Bumps`].
    Bumps(Bumps),
    /// See [`Sampled`].
    Sampled(Sampled),
}

impl Curve {
    /// I(u).
    #[must_use]
    pub fn shear(&self, u: f64) -> f64 {
        match self {
            Self::Bumps(bumps) => bumps.shear(u),
            Self::Sampled(table) => table.shear(u),
        }
    }

    /// J(u) = ∫₀ᵘ I(v) dv, exact.
    #[must_use]
    pub fn integral(&self, u: f64) -> f64 {
        match self {
            Self::Bumps(bumps) => bumps.integral(u),
            Self::Sampled(table) => table.integral(u),
        }
    }
}

/// Words of fewer bits share no encoding: there would be little to share.
const FEWEST_SHARED_BITS: u8 = 5;

/// The last bits of a word, which an encoding leaves open: eight words go on from each.
const OPEN_BITS: u8 = 3;

/// Half-cycle cosine bumps of one width.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bumps {
    /// δu, the full width of every bump.
    pub width: f64,
    /// u_0b, where each bump is centred.
    pub centers: Vec<f64>,
    /// I_0b, the height of each bump, |I_0b| ≤ 1.
    pub amplitudes: Vec<f64>,
}

impl Waveform {
    /// Reads a waveform from its name or its table of bumps; the error says which rule is broken.
    pub fn parse(value: &Value) -> Result<Self, String> {
        match value {
            Value::String(name) => Self::parse_name(name),
            Value::Object(table) if table.contains_key("csv") => match &table["csv"] {
                Value::String(text) if table.len() == 1 => {
                    Sampled::from_csv(text).map(Self::Sampled)
                }
                _ => Err(format!(
                    "{} is not a table: {{ csv = \"…\" }} has lines of u and I",
                    shown(value)
                )),
            },
            Value::Object(table) if table.contains_key("u") || table.contains_key("shear") => {
                let table: Sampled = serde_json::from_value(value.clone()).map_err(|error| {
                    format!("{} is not a table of u and shear: {error}", shown(value))
                })?;
                table.check(|row| format!("row {}", row + 1))?;
                Ok(Self::Sampled(table))
            }
            Value::Object(_) => {
                let bumps: Bumps = serde_json::from_value(value.clone())
                    .map_err(|error| format!("{} is not a list of bumps: {error}", shown(value)))?;
                bumps.check()?;
                Ok(Self::Bumps(bumps))
            }
            _ => Err(format!(
                "{} is not a waveform: a name, a table of bumps, or one of u and shear",
                shown(value)
            )),
        }
    }

    fn parse_name(name: &str) -> Result<Self, String> {
        let unknown = || {
            format!(
                "{} is not zero, six/1 … six/6 or binary_words/BITS/WORD",
                shown(&json!(name))
            )
        };
        let parts: Vec<&str> = name.split('/').collect();
        match parts.as_slice() {
            ["zero"] => Ok(Self::Zero),
            ["six", s] => match s.parse() {
                Ok(s @ 1..=6) if parts[1].len() == 1 => Ok(Self::Six(s)),
                _ => Err(unknown()),
            },
            ["binary_words", bits, word] => {
                let canonical =
                    |text: &str| text.parse::<u32>().ok().filter(|n| n.to_string() == text);
                let bits = canonical(bits)
                    .filter(|bits| (1..=16).contains(bits))
                    .ok_or_else(unknown)?;
                let word = canonical(word)
                    .filter(|&word| word < (1 << bits))
                    .ok_or_else(unknown)?;
                Ok(Self::BinaryWord {
                    bits: bits as u8,
                    word,
                })
            }
            _ => Err(unknown()),
        }
    }

    /// The canonical JSON: a name, or the table of bumps, or of u and shear.
    #[must_use]
    pub fn to_value(&self) -> Value {
        match self {
            Self::Bumps(bumps) => json!(bumps),
            Self::Sampled(table) => json!(table),
            named => json!(named.to_string()),
        }
    }

    /// The waveform as a function of u.
    #[must_use]
    pub fn curve(&self) -> Curve {
        Curve::Bumps(match self {
            Self::Zero => Bumps {
                width: 0.2,
                centers: vec![],
                amplitudes: vec![],
            },
            Self::Six(s) => six(*s),
            Self::BinaryWord { bits, word } => binary_word(*bits, *word),
            Self::Bumps(bumps) => bumps.clone(),
            Self::Sampled(table) => return Curve::Sampled(table.clone()),
        })
    }

    /// The word with the same beginning whose last bits are zero, and the u up to which the two are the same waveform.
    #[must_use]
    pub fn beginning(&self) -> Option<(Self, f64)> {
        match *self {
            Self::BinaryWord { bits, word } if bits >= FEWEST_SHARED_BITS => {
                let word = word >> OPEN_BITS << OPEN_BITS;
                let first_open = P + f64::from(bits - OPEN_BITS) - 0.5;
                let u = first_open / (f64::from(bits) + 2.0 * P);
                Some((Self::BinaryWord { bits, word }, u))
            }
            _ => None,
        }
    }
}

impl fmt::Display for Waveform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Zero => f.write_str("zero"),
            Self::Six(s) => write!(f, "six/{s}"),
            Self::BinaryWord { bits, word } => write!(f, "binary_words/{bits}/{word}"),
            Self::Bumps(bumps) => f.write_str(&json!(bumps).to_string()),
            Self::Sampled(table) => f.write_str(&json!(table).to_string()),
        }
    }
}

impl Serialize for Waveform {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.to_value().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Waveform {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::parse(&Value::deserialize(deserializer)?).map_err(serde::de::Error::custom)
    }
}

impl Bumps {
    /// Refuses bumps that are empty, not finite, too many, too high, overlapping or outside [0, 1].
    fn check(&self) -> Result<(), String> {
        let n = self.centers.len();
        if n == 0 || n > MAX_BUMPS {
            return Err(format!("{n} bumps: there must be 1 … {MAX_BUMPS}"));
        }
        if self.amplitudes.len() != n {
            return Err(format!(
                "{n} centers but {} amplitudes",
                self.amplitudes.len()
            ));
        }
        if !(self.width > 0.0 && self.width <= 1.0) {
            return Err(format!("width {} is not in (0, 1]", self.width));
        }
        for (b, (&center, &amplitude)) in self.centers.iter().zip(&self.amplitudes).enumerate() {
            let half = self.width / 2.0;
            // Half a rounding error of room, so that bumps may touch the ends and each other.
            let room = 1e-12;
            if !(center - half >= -room && center + half <= 1.0 + room) {
                return Err(format!(
                    "bump {b} at {center} with width {} leaves [0, 1]",
                    self.width
                ));
            }
            if !(-1.0..=1.0).contains(&amplitude) {
                return Err(format!(
                    "amplitude {amplitude} of bump {b} is not in [-1, 1]"
                ));
            }
            if b > 0 && center - self.centers[b - 1] < self.width - room {
                return Err(format!(
                    "bump {b} at {center} overlaps the one before it: centers must rise by the width"
                ));
            }
        }
        Ok(())
    }

    /// I(u), Eq. (6).
    #[must_use]
    pub fn shear(&self, u: f64) -> f64 {
        let mut sum = 0.0;
        for (&center, &amplitude) in self.centers.iter().zip(&self.amplitudes) {
            let x = (u - center) / self.width;
            if x.abs() < 0.5 {
                sum += amplitude * libm::cos(std::f64::consts::PI * x);
            }
        }
        sum
    }

    /// J(u) = ∫₀ᵘ I(v) dv in closed form, Eq. (10).
    #[must_use]
    pub fn integral(&self, u: f64) -> f64 {
        let mut sum = 0.0;
        for (&center, &amplitude) in self.centers.iter().zip(&self.amplitudes) {
            let x = (u - center) / self.width;
            let scale = self.width / std::f64::consts::PI;
            if x >= 0.5 {
                sum += amplitude * 2.0 * scale;
            } else if x > -0.5 {
                sum += amplitude * scale * (libm::sin(std::f64::consts::PI * x) + 1.0);
            }
        }
        sum
    }
}

/// Table 1: the six signals, all of width 0.2.
fn six(s: u8) -> Bumps {
    let (centers, amplitudes): (&[f64], &[f64]) = match s {
        1 => (&[0.3], &[1.0]),
        2 => (&[0.7], &[1.0]),
        3 => (&[0.3, 0.7], &[1.0, 1.0]),
        4 => (&[0.3, 0.7], &[-1.0, 1.0]),
        5 => (&[0.3, 0.7], &[1.0, -1.0]),
        _ => (&[0.2, 0.5, 0.8], &[0.5, -1.0, 0.5]),
    };
    Bumps {
        width: 0.2,
        centers: centers.to_vec(),
        amplitudes: amplitudes.to_vec(),
    }
}

/// The p of App. A.2: bit lengths without a signal at each end.
const P: f64 = 2.0;

/// App. A.2, Eqs. (15), (16) with p = 2: the bumps in order of u, so that the one at the start comes first.
fn binary_word(bits: u8, word: u32) -> Bumps {
    let length = usize::from(bits);
    let bit = |b: usize| f64::from((word >> (length - 1 - b)) & 1);
    let unit = 1.0 / (length as f64 + 2.0 * P);
    let mut centers = vec![P * unit];
    let mut amplitudes = vec![bit(0) - 0.5];
    for b in 0..length - 1 {
        centers.push((P + b as f64 + 1.0) * unit);
        amplitudes.push(bit(b + 1) - bit(b));
    }
    centers.push((P + length as f64) * unit);
    amplitudes.push(0.5 - bit(length - 1));
    Bumps {
        width: unit,
        centers,
        amplitudes,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> Vec<Waveform> {
        let mut all: Vec<_> = (1..=6).map(Waveform::Six).collect();
        all.extend((0..8).map(|word| Waveform::BinaryWord { bits: 3, word }));
        all.push(Waveform::BinaryWord {
            bits: 10,
            word: 682,
        });
        all.push(Waveform::Zero);
        let table = Sampled::from_csv("0,0\n0.3,1\n0.7,-1\n1,0.5").expect("a table");
        all.push(Waveform::Sampled(table));
        all
    }

    #[test]
    fn integral_is_the_integral_of_the_shear() {
        // Midpoint rule with n = 20,000: error ≤ h²/24 · max|I''| ≤ (5e-5)²/24 · (π/δu)², below 1e-6 for δu ≥ 1/14.
        for waveform in all() {
            let curve = waveform.curve();
            let h = 1.0 / 20_000.0;
            let mut sum = 0.0;
            for k in 0..20_000 {
                sum += curve.shear((f64::from(k) + 0.5) * h) * h;
                let u = (f64::from(k) + 1.0) * h;
                assert!((sum - curve.integral(u)).abs() < 1e-6, "{waveform} at {u}");
            }
        }
    }

    #[test]
    fn words_are_their_beginnings_up_to_where_they_part() {
        for bits in [5_u8, 7, 10] {
            for word in 0..1 << bits {
                let parts_at_once = word >> (OPEN_BITS - 1) & 1 == 1;
                let word = Waveform::BinaryWord { bits, word };
                let (beginning, until) = word.beginning().expect("a long word");
                let (word, beginning) = (word.curve(), beginning.curve());
                let same = |u: f64| word.shear(u).to_bits() == beginning.shear(u).to_bits();
                assert!((0..1000).all(|k| same(f64::from(k) / 1000.0 * (until - 1e-9))));
                assert_eq!(same(until + 0.1 / f64::from(bits + 4)), !parts_at_once);
            }
        }
        assert_eq!(Waveform::Six(1).beginning(), None);
        assert_eq!(Waveform::BinaryWord { bits: 4, word: 9 }.beginning(), None);
    }

    #[test]
    fn integral_of_a_word_follows_its_bits_and_ends_at_zero() {
        // J is ±δu/π at the middle of each bit: the 3-bit word 001 reads −, −, + (Fig. 5b).
        let curve = Waveform::BinaryWord { bits: 3, word: 1 }.curve();
        let unit = 1.0 / 7.0;
        for (b, sign) in [(0.0, -1.0), (1.0, -1.0), (2.0, 1.0)] {
            let value = curve.integral((2.0 + b + 0.5) * unit);
            assert!(
                (value - sign * unit / std::f64::consts::PI).abs() < 1e-15,
                "{value}"
            );
        }
        assert!(curve.integral(1.0).abs() < 1e-16);
    }

    #[test]
    fn names_parse_to_themselves() {
        for waveform in all() {
            assert_eq!(Waveform::parse(&waveform.to_value()), Ok(waveform));
        }
    }

    #[test]
    fn wrong_names_and_bumps_are_refused() {
        let wrong = [
            json!("six/0"),
            json!("six/7"),
            json!("six/01"),
            json!("binary_words/0/0"),
            json!("binary_words/17/0"),
            json!("binary_words/3/8"),
            json!("binary_words/3/+1"),
            json!(3),
            json!({"width": 0.2, "centers": [], "amplitudes": []}),
            json!({"width": 0.2, "centers": [0.05], "amplitudes": [1]}),
            json!({"width": 0.2, "centers": [0.5, 0.6], "amplitudes": [1, 1]}),
            json!({"width": 0.2, "centers": [0.5], "amplitudes": [1.5]}),
            json!({"width": 0.2, "centers": [0.5], "amplitudes": [1], "heigth": 1}),
            json!({"u": [0.0, 1.0], "shear": [0.0]}),
            json!({"u": [0.0, 0.5], "shear": [0.0, 0.0]}),
            json!({"u": [0.0, 1.0], "shear": [0.0, 2.0]}),
            json!({"shear": [0.0, 0.0]}),
            json!({"csv": 3}),
            json!({"csv": "0,0\n1,0", "u": [0.0]}),
        ];
        for value in wrong {
            assert!(Waveform::parse(&value).is_err(), "{value}");
        }
    }
}
