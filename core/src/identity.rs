//! Identity: names for stages and files that follow from their content.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The prefix of every printed hash: BLAKE3.
const PREFIX: &str = "b3:";

/// A text that is not a hash of the form `b3:` and 64 hexadecimal digits.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a hash: `b3:` and 64 lower-case hexadecimal digits")]
pub struct HashError(pub String);

macro_rules! hash_type {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name([u8; 32]);

        impl $name {
            /// The 32 bytes of the hash.
            #[must_use]
            pub fn as_bytes(&self) -> &[u8; 32] {
                &self.0
            }

            /// The 64 hexadecimal digits, without the prefix.
            #[must_use]
            pub fn to_hex(&self) -> String {
                blake3::Hash::from_bytes(self.0).to_hex().to_string()
            }

            /// The BLAKE3 hash of `bytes`.
            #[must_use]
            pub fn of_bytes(bytes: &[u8]) -> Self {
                Self(*blake3::hash(bytes).as_bytes())
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{PREFIX}{}", blake3::Hash::from_bytes(self.0).to_hex())
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                fmt::Display::fmt(self, f)
            }
        }

        impl FromStr for $name {
            type Err = HashError;

            fn from_str(text: &str) -> Result<Self, HashError> {
                let lower = |c: char| c.is_ascii_digit() || ('a'..='f').contains(&c);
                text.strip_prefix(PREFIX)
                    .filter(|hex| hex.len() == 64 && hex.chars().all(lower))
                    .and_then(|hex| blake3::Hash::from_hex(hex).ok())
                    .map(|hash| Self(*hash.as_bytes()))
                    .ok_or_else(|| HashError(text.chars().take(80).collect()))
            }
        }

        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
            }
        }
    };
}

hash_type! {
    /// The identity of a stage: BLAKE3 of its canonical spec, kind and physics version.
    StageId
}

hash_type! {
    /// The name of an immutable file: BLAKE3 of its bytes.
    ArtifactHash
}

hash_type! {
    /// BLAKE3 of a result: its scalars and the hashes of its artifacts, nothing that depends on the machine.
    ResultHash
}

/// The canonical text of `value`: JSON without blanks, fields as declared, numbers in shortest round-trip form.
///
/// # Panics
/// If `value` cannot be written as JSON, which no spec or outcome of this crate can cause.
#[must_use]
pub fn canonical_json<T: Serialize>(value: &T) -> String {
    serde_json::to_string(value).expect("specs and outcomes are plain data with text keys")
}

/// `value` with −0 turned into 0, so that equal numbers have one canonical text.
#[must_use]
pub fn canonical_number(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn printed_hash_parses_to_itself() {
        let hash = ArtifactHash::of_bytes(b"a pack of grains");
        assert_eq!(hash.to_string().parse::<ArtifactHash>(), Ok(hash));
    }

    #[test]
    fn upper_case_short_or_unprefixed_text_is_no_hash() {
        let hash = StageId::of_bytes(b"x").to_string();
        for text in [
            hash.to_uppercase(),
            hash[..60].to_owned(),
            hash[3..].to_owned(),
            String::new(),
        ] {
            assert!(text.parse::<StageId>().is_err(), "{text}");
        }
    }

    #[test]
    fn minus_zero_is_written_as_zero() {
        assert_eq!(canonical_json(&canonical_number(-0.0)), "0.0");
    }
}
