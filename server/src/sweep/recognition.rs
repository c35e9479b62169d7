//! What a spec says of the classifiers that are to recognize words.

use std::collections::BTreeSet;

use granary_core::memory::classifier::settings::{PRESETS, SETTINGS, defaults};
use granary_core::memory::classifier::{BITS, ClassifierSpec};
use granary_core::parameter::shown;
use serde_json::{Map, Value, json};

use super::mistakes::{Mistakes, pointer, unknown};
use super::reduction::{About, bits};

/// The most networks that are trained for the error bar of an accuracy.
const MOST_TRAININGS: u64 = 20;

/// The classifiers of a reduction, one for each training; `table` is the reduction, taken over `over`.
pub(super) fn read(
    table: &Map<String, Value>,
    over: &[String],
    about: &About<'_>,
    at: &str,
    mistakes: &mut Mistakes,
) -> Option<Vec<ClassifierSpec>> {
    if !over.iter().any(|name| name == "waveform") {
        let detail =
            "words are told apart in sets of them: the reduction must be taken over waveform";
        mistakes.add(&pointer(at, "over"), detail);
        return None;
    }
    let place = pointer(at, "classifier");
    let settings = settings(table.get("classifier"), &place, mistakes)?;
    let one = json!(1);
    let written = table.get("trainings").unwrap_or(&one);
    let trainings = written
        .as_u64()
        .filter(|n| (1..=MOST_TRAININGS).contains(n));
    let Some(trainings) = trainings else {
        let detail = format!(
            "{} is not a whole number in 1 … {MOST_TRAININGS}",
            shown(written)
        );
        mistakes.add(&pointer(at, "trainings"), detail);
        return None;
    };
    let lengths = mistakes.keep(&pointer(at, "kind"), lengths(about))?;
    let seeds = |bits: u32| (1..=trainings).map(move |seed| (bits, seed));
    let classifiers: Result<Vec<ClassifierSpec>, String> = lengths
        .into_iter()
        .flat_map(seeds)
        .map(|(bits, seed)| ClassifierSpec::from_settings(bits, seed, settings.clone()))
        .collect();
    mistakes.keep(&place, classifiers)
}

/// The settings of a classifier: a preset, or a table that may name one and says what differs from it.
fn settings(
    value: Option<&Value>,
    at: &str,
    mistakes: &mut Mistakes,
) -> Option<Map<String, Value>> {
    let draft = json!("draft");
    let (preset, own) = match value.unwrap_or(&draft) {
        Value::Object(table) => (table.get("preset").unwrap_or(&draft), Some(table)),
        preset => (preset, None),
    };
    let names = || PRESETS.iter().map(|preset| preset.name);
    let Some(mut settings) = preset.as_str().and_then(defaults) else {
        let at = if own.is_some() {
            &pointer(at, "preset")
        } else {
            at
        };
        match preset.as_str() {
            Some(name) => mistakes.add(at, unknown("preset of classifiers", name, names())),
            None => mistakes.add(
                at,
                format!("{} is not a preset of classifiers", shown(preset)),
            ),
        }
        return None;
    };
    let mut right = true;
    for (name, value) in own
        .into_iter()
        .flatten()
        .filter(|(name, _)| *name != "preset")
    {
        let place = pointer(at, name);
        let row = SETTINGS.iter().find(|row| row.name == name);
        let checked = if let Some(row) = row {
            mistakes.keep(&place, row.check(value))
        } else {
            let all = SETTINGS.iter().map(|row| row.name).chain(["preset"]);
            mistakes.add(&place, unknown("setting of a classifier", name, all));
            None
        };
        right &= checked.is_some();
        settings.extend(checked.map(|value| (name.clone(), value)));
    }
    right.then_some(settings)
}

/// Every length of the words that are all waveforms of the sweep.
fn lengths(about: &About<'_>) -> Result<BTreeSet<u32>, String> {
    let mut lengths = BTreeSet::new();
    for value in about.waveforms() {
        let Some(length) = bits(Some(value)) else {
            return Err(format!(
                "only binary words can be recognized, and {} is none: use {{ suite = \"binary_words\", bits = … }}",
                shown(value)
            ));
        };
        if !BITS.contains(&length) {
            let (fewest, most) = (BITS.start(), BITS.end());
            return Err(format!(
                "words of {length} bits: there are classifiers of {fewest} … {most}"
            ));
        }
        lengths.insert(length);
    }
    Ok(lengths)
}
