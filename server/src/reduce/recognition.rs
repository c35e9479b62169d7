//! Recognition: which words classifiers take the recalled signals of a set for (App. C).

use std::collections::BTreeMap;

use granary_api::table::{Confused, SetRow};
use granary_core::memory::score::Processing;
use serde_json::{Map, Value};

/// The most confusions that a set lists.
const MOST_CONFUSED: usize = 1000;

/// The recalled words of a set.
#[derive(Clone, Debug, Default)]
pub struct Recalled {
    /// The parameters that vary in the sweep and that it is not taken over.
    pub parameters: Map<String, Value>,
    /// The words whose signals are there.
    pub words: Vec<u32>,
    /// Members in all.
    pub of: u64,
    /// Whether members, or what they are compared with, are still to come.
    pub open: bool,
    /// What stopped the first member that has failed.
    pub failure: Option<String>,
}

/// How well a classifier tells what it was trained for.
#[derive(Clone, Debug, PartialEq)]
pub struct Validation {
    /// Share of its own validation that it tells.
    pub accuracy: f64,
    /// That it has not learned its words.
    pub warning: Option<String>,
}

/// What a classifier says of a set.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// It is still to be trained.
    Untrained,
    /// It could not be trained, and why.
    Failed(String),
    /// Nothing was recalled.
    Silence,
    /// The word that each signal is taken for.
    Words(Vec<u32>, Validation),
}

/// The set's row, from what each training of the classifier says of it.
#[must_use]
pub fn recognized(set: &Recalled, processing: Processing, answers: &[Answer]) -> SetRow {
    let told: Vec<(&Vec<u32>, &Validation)> = answers
        .iter()
        .filter_map(|answer| match answer {
            Answer::Words(words, validation) => Some((words, validation)),
            _ => None,
        })
        .collect();
    let right = |taken_for: &Vec<u32>| {
        let right = taken_for.iter().zip(&set.words).filter(|(a, b)| a == b);
        right.count() as f64 / set.words.len() as f64
    };
    let accuracies: Vec<f64> = match set.words.len() {
        0 => vec![],
        _ => told.iter().map(|(taken_for, _)| right(taken_for)).collect(),
    };
    let (mean, sem) = super::moments(&accuracies);
    let validation = told.iter().map(|(_, of)| of.accuracy).reduce(f64::min);
    let warning = told.iter().find_map(|(_, of)| of.warning.clone());
    let untrained = answers.contains(&Answer::Untrained);
    let results = [
        ("recognition_accuracy", mean),
        ("recognition_accuracy_sem", sem),
        ("validation_accuracy", validation),
    ];
    SetRow {
        set: 0,
        reduce: "recognition".to_owned(),
        processing: Some(processing.name().to_owned()),
        shape: None,
        setting: None,
        verdict: None,
        parameters: set.parameters.clone(),
        results: results
            .into_iter()
            .map(|(name, value)| (name.to_owned(), value))
            .collect(),
        n: set.words.len() as u64,
        of: set.of,
        provisional: set.open || untrained,
        missing_reason: reason(set, answers, mean, sem),
        warning,
        confused: confused(&set.words, &told),
    }
}

/// Every word that was taken for another, and by how many trainings; the most often confused first.
fn confused(words: &[u32], told: &[(&Vec<u32>, &Validation)]) -> Vec<Confused> {
    let mut counts: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    for (taken_for, _) in told {
        for (&word, &taken_for) in words.iter().zip(*taken_for) {
            if word != taken_for {
                *counts.entry((word, taken_for)).or_default() += 1;
            }
        }
    }
    let pairs = counts
        .into_iter()
        .map(|((word, taken_for), trainings)| Confused {
            word,
            taken_for,
            trainings,
        });
    let mut pairs: Vec<Confused> = pairs.collect();
    pairs.sort_by_key(|pair| std::cmp::Reverse(pair.trainings));
    pairs.truncate(MOST_CONFUSED);
    pairs
}

/// Why a number is missing, or, once nothing is still to come, why members are.
fn reason(
    set: &Recalled,
    answers: &[Answer],
    mean: Option<f64>,
    sem: Option<f64>,
) -> Option<String> {
    let failed = answers.iter().find_map(|answer| match answer {
        Answer::Failed(why) => Some(why),
        _ => None,
    });
    if mean.is_none() {
        return Some(match (set.words.len(), failed) {
            (0, _) if set.open => "no member is done yet".to_owned(),
            (0, _) => match &set.failure {
                Some(failure) => format!("no member has an outcome: {failure}"),
                None => "no member has an outcome".to_owned(),
            },
            (n, _) if set.open => format!(
                "words are recognized once all of the set are done: {n} of {} so far",
                set.of
            ),
            _ if answers.contains(&Answer::Untrained) => {
                "the classifier is not trained yet".to_owned()
            }
            (_, Some(why)) => format!("the classifier could not be trained: {why}"),
            _ => "nothing was recalled".to_owned(),
        });
    }
    let missing = set.of - set.words.len() as u64;
    if !set.open && missing > 0 {
        let why = set.failure.as_deref().unwrap_or("failed or cancelled");
        return Some(format!(
            "{missing} of {} members are missing: {why}",
            set.of
        ));
    }
    sem.is_none()
        .then(|| "one training has no standard error".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(words: &[u32], of: u64) -> Recalled {
        Recalled {
            words: words.to_vec(),
            of,
            ..Recalled::default()
        }
    }

    fn words(words: &[u32]) -> Answer {
        let validation = Validation {
            accuracy: 1.0,
            warning: None,
        };
        Answer::Words(words.to_vec(), validation)
    }

    #[test]
    fn accuracy_is_the_share_of_words_that_are_right_and_its_error_that_of_trainings() {
        let answers = [words(&[0, 1, 2, 2]), words(&[0, 3, 2, 2])];
        let row = recognized(&set(&[0, 1, 2, 3], 4), Processing::Sub2Baseline, &answers);
        assert_eq!(row.results["recognition_accuracy"], Some(0.625));
        // Of 0.75 and 0.5: √(2 × 0.125²/1/2).
        assert_eq!(row.results["recognition_accuracy_sem"], Some(0.125));
        let pair = |word, taken_for, trainings| Confused {
            word,
            taken_for,
            trainings,
        };
        assert_eq!(row.confused, [pair(3, 2, 2), pair(1, 3, 1)]);
        assert_eq!((row.n, row.of, row.provisional), (4, 4, false));
        assert_eq!(row.missing_reason, None);
    }

    #[test]
    fn what_is_missing_is_said() {
        let of = |set: &Recalled, answers: &[Answer]| {
            let row = recognized(set, Processing::Sub2, answers);
            (
                row.results["recognition_accuracy"],
                row.provisional,
                row.missing_reason.unwrap_or_default(),
            )
        };
        let whole = set(&[0, 1], 2);
        assert_eq!(
            of(&whole, &[Answer::Untrained]),
            (None, true, "the classifier is not trained yet".to_owned())
        );
        assert_eq!(
            of(&whole, &[Answer::Failed("lost".to_owned())]),
            (
                None,
                false,
                "the classifier could not be trained: lost".to_owned()
            )
        );
        assert_eq!(of(&whole, &[Answer::Silence]).2, "nothing was recalled");
        assert_eq!(
            of(&whole, &[words(&[0, 1])]).2,
            "one training has no standard error"
        );
        let part = set(&[0], 2);
        assert_eq!(
            of(&part, &[words(&[0])]),
            (
                Some(1.0),
                false,
                "1 of 2 members are missing: failed or cancelled".to_owned()
            )
        );
        let half = Recalled {
            open: true,
            ..set(&[0], 2)
        };
        let told = of(&half, &[]).2;
        assert_eq!(
            told,
            "words are recognized once all of the set are done: 1 of 2 so far"
        );
        let weak = Validation {
            accuracy: 0.5,
            warning: Some("not learned".to_owned()),
        };
        let row = recognized(&whole, Processing::Sub2, &[Answer::Words(vec![0, 1], weak)]);
        assert_eq!(row.warning.as_deref(), Some("not learned"));
        let to_come = Recalled {
            open: true,
            ..set(&[], 2)
        };
        assert_eq!(
            of(&to_come, &[]),
            (None, true, "no member is done yet".to_owned())
        );
        let gone = Recalled {
            failure: Some("unstable".to_owned()),
            ..set(&[], 2)
        };
        assert_eq!(
            of(&gone, &[words(&[])]).2,
            "no member has an outcome: unstable"
        );
    }
}
