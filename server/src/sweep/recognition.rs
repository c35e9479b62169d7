//! What a spec says of the classifiers that are to recognize words.

use granary_core::memory::classifier::settings::{PRESETS, SETTINGS, defaults};
use granary_core::memory::classifier::{BITS, ClassifierSpec};
use granary_core::memory::waveform::Waveform;
use granary_core::parameter::shown;
use serde_json::{Map, Value, json};

use super::mistakes::{Mistakes, pointer, unknown};
use super::reduction::About;

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
    let bits = mistakes.keep(&pointer(at, "kind"), bits(about))?;
    let classifiers: Result<Vec<ClassifierSpec>, String> = (1..=trainings)
        .map(|seed| ClassifierSpec::from_settings(bits, seed, settings.clone()))
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

/// L, if all waveforms of the sweep are words of so many bits.
fn bits(about: &About<'_>) -> Result<u32, String> {
    let axes = about.grids.iter().flatten();
    let of_axes: Vec<&Value> = axes
        .filter(|axis| axis.name == "waveform")
        .flat_map(|axis| &axis.values)
        .collect();
    let some_grid_has_none = about
        .grids
        .iter()
        .any(|grid| grid.iter().all(|axis| axis.name != "waveform"));
    let fixed = some_grid_has_none.then(|| &about.fixed["waveform"]);
    let mut found = None;
    for value in of_axes.into_iter().chain(fixed) {
        let bits = match Waveform::parse(value) {
            Ok(Waveform::BinaryWord { bits, .. }) => u32::from(bits),
            _ => {
                return Err(format!(
                    "only binary words can be recognized, and {} is none: use {{ suite = \"binary_words\", bits = … }}",
                    shown(value)
                ));
            }
        };
        if found.is_some_and(|found| found != bits) {
            return Err(
                "words of several lengths are not recognized together: make a sweep of each"
                    .to_owned(),
            );
        }
        if !BITS.contains(&bits) {
            let (fewest, most) = (BITS.start(), BITS.end());
            return Err(format!(
                "words of {bits} bits: there are classifiers of {fewest} … {most}"
            ));
        }
        found = Some(bits);
    }
    found.ok_or_else(|| "there is no waveform to be recognized".to_owned())
}
