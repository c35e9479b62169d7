//! Tables: points, sets, and lists that page by key.

use std::collections::BTreeMap;

use granary_core::identity::ResultHash;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use crate::id::JobId;
use crate::job::{Failure, JobState, Progress};

/// Part of a list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Page<T> {
    /// The rows.
    pub items: Vec<T>,
    /// What `cursor` asks for the rows after these; none at the end.
    pub next: Option<String>,
    /// Rows in all, on every page, after `where`.
    pub total: u64,
}

/// One result.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(untagged)]
pub enum Scalar {
    /// A number.
    Number(f64),
    /// Why another result, `{name}` of a `{name}_reason`, is `null`.
    Word(String),
    /// `null`: no number.
    #[default]
    Missing,
}

impl Scalar {
    /// The number, if it is one.
    #[must_use]
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Word(_) | Self::Missing => None,
        }
    }
}

/// One row of a sweep's table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PointRow {
    /// Its number, from 0, in the order of the spec.
    pub point: u64,
    /// Where its job stands.
    pub state: JobState,
    /// The parameters that vary in the sweep.
    #[schema(value_type = Object)]
    pub parameters: Map<String, Value>,
    /// Scalars by name, and beside one that is `null` the word why, as `{name}_reason`; empty until it is done.
    pub results: BTreeMap<String, Scalar>,
    /// What a reader of the numbers should know.
    pub warnings: Vec<String>,
    /// The job that computes it.
    #[schema(value_type = String)]
    pub job: JobId,
    /// Hash of the outcome.
    #[schema(value_type = Option<String>)]
    pub result_hash: Option<ResultHash>,
    /// How far it is, while it runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub progress: Option<Progress>,
    /// Why it failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failure: Option<Failure>,
}

/// One row of a reduction: points, or other sets, taken together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SetRow {
    /// Its number, from 0, in the order of the reductions.
    pub set: u64,
    /// The reduction.
    pub reduce: String,
    /// How signals were processed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub processing: Option<String>,
    /// The parameters that vary in the sweep and that it was not taken over.
    #[schema(value_type = Object)]
    pub parameters: Map<String, Value>,
    /// Numbers by name; `null` where a number has no meaning (yet).
    pub results: BTreeMap<String, Option<f64>>,
    /// How much of Eq. (4) a fit's strengths determine: `exponential`, `step`, `straight`, `constant` or `too_few_points`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape: Option<String>,
    /// A study's setting in words, such as `time_step 0.5`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub setting: Option<String>,
    /// What a study says of a setting: `reference`, `front` (no other is cheaper and at least as accurate), `beaten` or
    /// `incomplete` (a packing without a result).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verdict: Option<String>,
    /// Members that count so far.
    pub n: u64,
    /// Members in all.
    pub of: u64,
    /// Whether members are still to come.
    pub provisional: bool,
    /// Why a number is `null`; once nothing is still to come, also why `n` is less than `of`.
    ///
    /// While `provisional`, it speaks of the members that count so far, never of those to come.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub missing_reason: Option<String>,
    /// What a reader of the numbers should know: that signals are noisy.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub warning: Option<String>,
    /// Words that a classifier took for others, those that most trainings confuse first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub confused: Vec<Confused>,
}

/// A word that was taken for another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Confused {
    /// The word that was stored.
    pub word: u32,
    /// The word that the recalled signal was taken for.
    pub taken_for: u32,
    /// By how many trainings of the classifier.
    pub trainings: u32,
}

impl SetRow {
    /// Why numbers are missing, what to know of those that are not, and which words are confused.
    #[must_use]
    pub fn remark(&self) -> String {
        let confused = self.confused.first().map(|first| {
            let (
                count,
                Confused {
                    word, taken_for, ..
                },
            ) = (self.confused.len(), first);
            format!("{count} confused, such as word {word} taken for {taken_for}")
        });
        let parts = [&self.missing_reason, &self.warning, &confused];
        let told: Vec<&str> = parts.into_iter().filter_map(Option::as_deref).collect();
        told.join("; ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_words_and_null_keep_what_they_are_on_the_wire() {
        let text = r#"{"a":1.5,"b":null,"b_reason":"not_prominent"}"#;
        let results: BTreeMap<String, Scalar> = serde_json::from_str(text).expect("results");
        assert_eq!(results["a"].number(), Some(1.5));
        assert_eq!(results["b"], Scalar::Missing);
        assert_eq!(results["b_reason"].number(), None);
        assert_eq!(serde_json::to_string(&results).expect("plain data"), text);
    }
}
