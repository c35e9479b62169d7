//! Axes: the values that one parameter takes in a grid.
//!
//! | form | values |
//! |---|---|
//! | `[0.2, 0.4]` | as listed |
//! | `0.2` | that one |
//! | `{ linspace = [a, b, n] }` | n evenly spaced numbers from a to b, both included |
//! | `{ range = [a, b] }`, `[a, b, step]` | whole numbers from a in steps of 1 or `step`, b included if a step meets it |
//! | `{ suite = "six" }` and its kin | waveforms only, see [`super::suite`] |
//!
//! The same value twice in an axis is a mistake.

use std::collections::HashSet;

use granary_core::parameter::{Domain, Parameter, shown};
use serde_json::{Map, Value, json};

use super::mistakes::{Mistakes, pointer, unknown};
use super::suite;

/// The ways to write an axis as a table.
const FORMS: [&str; 3] = ["linspace", "range", "lhs"];

/// An axis that has been counted and, if it is not too long, listed.
#[derive(Clone, Debug)]
pub struct Axis {
    /// The parameter that it varies.
    pub name: &'static str,
    /// Its values, canonical and all different.
    pub values: Vec<Value>,
}

/// The number of values of an axis, and the values if they are right and at most `most`.
pub(crate) struct Counted {
    pub(crate) count: u128,
    pub(crate) axis: Option<Axis>,
}

/// Reads the axis `value` of `parameter`.
pub(crate) fn read(
    parameter: &'static Parameter,
    value: &Value,
    at: &str,
    most: u64,
    mistakes: &mut Mistakes,
) -> Option<Counted> {
    let listed = mistakes.keep(at, written(parameter, value))?;
    let count = listed.count();
    if count == 0 {
        mistakes.add(at, format!("{} is an empty axis", shown(value)));
        return None;
    }
    if count > u128::from(most) {
        // The sweep's size says what is wrong; nothing is expanded.
        return Some(Counted { count, axis: None });
    }
    let plain = matches!(value, Value::Array(_));
    let values = checked(parameter, &listed, at, plain, mistakes);
    Some(Counted {
        count,
        axis: values.map(|values| Axis {
            name: parameter.name,
            values,
        }),
    })
}

/// An axis as written, before anything is expanded.
enum Written {
    List(Vec<Value>),
    Linspace { from: f64, to: f64, count: u64 },
    Range { from: i64, step: i64, count: u128 },
}

impl Written {
    fn count(&self) -> u128 {
        match self {
            Self::List(values) => values.len() as u128,
            Self::Linspace { count, .. } => u128::from(*count),
            Self::Range { count, .. } => *count,
        }
    }

    fn value(&self, k: usize) -> Value {
        match self {
            Self::List(values) => values[k].clone(),
            Self::Linspace { to, count, .. } if k as u64 + 1 == *count && *count > 1 => json!(to),
            Self::Linspace { from, to, count } => {
                let share = k as f64 / (count - 1).max(1) as f64;
                json!(from + (to - from) * share)
            }
            Self::Range { from, step, .. } => {
                json!(from + step * i64::try_from(k).unwrap_or(i64::MAX))
            }
        }
    }
}

fn written(parameter: &Parameter, value: &Value) -> Result<Written, String> {
    let notation = matches!(parameter.domain, Domain::Notation(_));
    match value {
        _ if notation => suite::waveforms(value).map(Written::List),
        Value::Array(values) => Ok(Written::List(values.clone())),
        Value::Object(form) => table(parameter, value, form),
        scalar => Ok(Written::List(vec![scalar.clone()])),
    }
}

fn table(
    parameter: &Parameter,
    value: &Value,
    form: &Map<String, Value>,
) -> Result<Written, String> {
    let Some((key, argument)) = form.iter().next().filter(|_| form.len() == 1) else {
        return Err(format!(
            "{} is not an axis: a list, or a table with one of linspace, range",
            shown(value)
        ));
    };
    if !matches!(parameter.domain, Domain::Real(..) | Domain::Integer(..)) {
        return Err(format!(
            "{} takes a list: only numbers have {}",
            parameter.name,
            shown(&json!(key))
        ));
    }
    match key.as_str() {
        "linspace" => linspace(argument),
        "range" => range(argument),
        "lhs" => {
            Err("lhs (a Latin hypercube) is not available yet: use a list or linspace".to_owned())
        }
        "suite" => Err(format!(
            "suites are for the axis waveform, not for {}",
            parameter.name
        )),
        other => Err(unknown("form of an axis", other, FORMS.into_iter())),
    }
}

fn linspace(argument: &Value) -> Result<Written, String> {
    let wrong = || format!("{} is not [first, last, count]", shown(argument));
    let parts = argument
        .as_array()
        .filter(|a| a.len() == 3)
        .ok_or_else(wrong)?;
    let (from, to) = (parts[0].as_f64(), parts[1].as_f64());
    let (Some(from), Some(to)) = (from, to) else {
        return Err(wrong());
    };
    let count = whole(&parts[2])
        .and_then(|n| u64::try_from(n).ok())
        .ok_or_else(wrong)?;
    if count == 1 && from.to_bits() != to.to_bits() {
        return Err(format!("one value cannot be both {from} and {to}"));
    }
    Ok(Written::Linspace { from, to, count })
}

fn range(argument: &Value) -> Result<Written, String> {
    let wrong = || {
        format!(
            "{} is not [first, last] or [first, last, step] in whole numbers",
            shown(argument)
        )
    };
    let parts = argument
        .as_array()
        .filter(|a| a.len() == 2 || a.len() == 3)
        .ok_or_else(wrong)?;
    let numbers: Option<Vec<i64>> = parts.iter().map(whole).collect();
    let numbers = numbers.ok_or_else(wrong)?;
    let step = numbers.get(2).copied().unwrap_or(1);
    if step == 0 {
        return Err("a range cannot go in steps of 0".to_owned());
    }
    let (from, to) = (numbers[0], numbers[1]);
    let ahead = (i128::from(to) - i128::from(from)) * i128::from(step.signum());
    let count =
        u128::try_from(ahead).map_or(0, |ahead| ahead / u128::from(step.unsigned_abs()) + 1);
    Ok(Written::Range { from, step, count })
}

/// A whole number that a double holds exactly.
fn whole(value: &Value) -> Option<i64> {
    let real = |x: f64| (x.fract() == 0.0 && x.abs() <= 9e15).then_some(x as i64);
    let number = value.as_i64().or_else(|| value.as_f64().and_then(real))?;
    (number.unsigned_abs() <= 9_007_199_254_740_991).then_some(number)
}

/// The values in canonical form, each allowed and none twice.
fn checked(
    parameter: &'static Parameter,
    listed: &Written,
    at: &str,
    plain: bool,
    mistakes: &mut Mistakes,
) -> Option<Vec<Value>> {
    let count = listed.count() as usize;
    let mut values = Vec::with_capacity(count);
    let mut seen = HashSet::with_capacity(count);
    for k in 0..count {
        // A value of a list has a place of its own, one of a linspace or a suite has the axis'.
        let place = || {
            if plain {
                pointer(at, &k.to_string())
            } else {
                at.to_owned()
            }
        };
        match parameter.check(&listed.value(k)) {
            Err(detail) => mistakes.add(&place(), named(parameter, &detail)),
            Ok(value) if !seen.insert(value.to_string()) => {
                mistakes.add(&place(), format!("{} is twice in this axis", shown(&value)));
            }
            Ok(value) => values.push(value),
        }
    }
    (values.len() == count).then_some(values)
}

/// A rule that a value breaks, with what was perhaps meant if the parameter is a choice of words.
pub(crate) fn named(parameter: &Parameter, detail: &str) -> String {
    let Domain::Choice(words) = parameter.domain else {
        return detail.to_owned();
    };
    let written = detail.split('"').nth(1).unwrap_or_default().to_lowercase();
    let meant = words
        .iter()
        .find(|word| word.to_lowercase() == written)
        .copied()
        .or_else(|| super::mistakes::nearest(&written, words.iter().copied()));
    match meant {
        Some(word) => format!("{detail}; did you mean {word}?"),
        None => detail.to_owned(),
    }
}
