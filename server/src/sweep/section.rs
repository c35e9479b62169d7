//! The sections `[fixed]`, `[numerics]` and `[preparation]`: parameters that do not vary.

use std::collections::BTreeMap;

use granary_core::memory::parameters::{PARAMETERS, parameter};
use granary_core::parameter::{Domain, Parameter, shown};
use serde_json::{Map, Value, json};

use super::axis::named;
use super::mistakes::{Mistakes, nearest, pointer};

/// Reads one section into `fixed`; `written` remembers which section named which parameter.
pub(crate) fn read(
    section: &'static str,
    value: Option<&Value>,
    fixed: &mut Map<String, Value>,
    written: &mut BTreeMap<&'static str, &'static str>,
    mistakes: &mut Mistakes,
) {
    let Some(value) = value else {
        return;
    };
    let at = pointer("", section);
    let Some(table) = value.as_object() else {
        mistakes.add(&at, format!("{} is not a table", shown(value)));
        return;
    };
    for (name, value) in table {
        let place = pointer(&at, name);
        let Some(row) = parameter(name) else {
            mistakes.add(&place, unknown_parameter(name));
            continue;
        };
        written.insert(row.name, section);
        if row.section.name() != section {
            let detail = format!(
                "{name} belongs in [{}], not in [{section}]",
                row.section.name()
            );
            mistakes.add(&place, detail);
        }
        match row.check(value) {
            Ok(value) => {
                fixed.insert(name.clone(), value);
            }
            Err(detail) => mistakes.add(&place, as_axis(row, value, &named(row, &detail))),
        }
    }
}

/// A list where one value is expected was probably meant as an axis.
fn as_axis(row: &Parameter, value: &Value, detail: &str) -> String {
    let bumps = matches!(row.domain, Domain::Notation(_)) && value.get("suite").is_none();
    match value {
        Value::Array(_) => format!("{detail}; several values make an axis, in [[grid]]"),
        Value::Object(_) if !bumps => {
            format!("{detail}; several values make an axis, in [[grid]]")
        }
        _ => detail.to_owned(),
    }
}

/// "`x` is not a parameter", with the nearest one.
pub(crate) fn unknown_parameter(name: &str) -> String {
    let name_shown = shown(&json!(name));
    // The names of other tools, and the symbols of the paper.
    let alias = PARAMETERS.iter().find(|row| row.symbol == name);
    let near = alias
        .map(|row| row.name)
        .or_else(|| nearest(name, PARAMETERS.iter().map(|row| row.name)));
    match near {
        Some(near) => format!("{name_shown} is not a parameter; did you mean {near}?"),
        None => format!("{name_shown} is not a parameter of the model (see /api/v1/models/memory)"),
    }
}
