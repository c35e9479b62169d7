//! Suites: named lists of waveforms.
//!
//! `"zero"`, `"six/3"`, a table of bumps, `{ suite = "six" }`, `{ suite = "binary_words", bits = L }`,
//! `{ suite = "bumps", bumps = [tables] }`, or a list of any of these.

use granary_core::memory::waveform::Waveform;
use granary_core::parameter::shown;
use serde_json::{Map, Value, json};

use super::mistakes::unknown;

const SUITES: [&str; 3] = ["six", "binary_words", "bumps"];

/// The waveforms that `value` stands for; each is still to be checked.
pub(crate) fn waveforms(value: &Value) -> Result<Vec<Value>, String> {
    match value {
        Value::Array(parts) => {
            let lists: Result<Vec<_>, _> = parts.iter().map(part).collect();
            Ok(lists?.into_iter().flatten().collect())
        }
        one => part(one),
    }
}

fn part(value: &Value) -> Result<Vec<Value>, String> {
    match value {
        Value::Object(form) if form.contains_key("suite") => suite(value, form),
        Value::String(name) if SUITES.contains(&name.as_str()) => Err(format!(
            "{} is a suite: write {{ suite = \"{name}\" }}",
            shown(value)
        )),
        other => Ok(vec![other.clone()]),
    }
}

fn suite(value: &Value, form: &Map<String, Value>) -> Result<Vec<Value>, String> {
    let name = form
        .get("suite")
        .and_then(Value::as_str)
        .unwrap_or_default();
    let argument = match name {
        "six" => None,
        "binary_words" => Some("bits"),
        "bumps" => Some("bumps"),
        _ => return Err(unknown("suite", name, SUITES.into_iter())),
    };
    let allowed = ["suite"].into_iter().chain(argument);
    if let Some(other) = form
        .keys()
        .find(|key| !allowed.clone().any(|name| name == *key))
    {
        return Err(unknown("field of this suite", other, allowed));
    }
    match name {
        "six" => Ok((1..=6).map(|s| Waveform::Six(s).to_value()).collect()),
        "binary_words" => words(form.get("bits").unwrap_or(&Value::Null)),
        _ => match form.get("bumps") {
            Some(Value::Array(tables)) => Ok(tables.clone()),
            _ => Err(format!("{} needs bumps: a list of tables", shown(value))),
        },
    }
}

fn words(bits: &Value) -> Result<Vec<Value>, String> {
    let whole = |x: f64| (x.fract() == 0.0).then_some(x);
    match bits.as_f64().and_then(whole) {
        Some(bits @ 1.0..=16.0) => {
            let bits = bits as u8;
            let word = |word| json!(format!("binary_words/{bits}/{word}"));
            Ok((0..1_u32 << bits).map(word).collect())
        }
        _ => Err(format!(
            "bits = {} is not a whole number in 1 … 16",
            shown(bits)
        )),
    }
}
