//! The sections `[fixed]`, `[numerics]` and `[preparation]`: parameters that do not vary.

use std::collections::BTreeMap;

use granary_core::model::Model;
use granary_core::parameter::{Domain, Parameter, shown};
use serde_json::{Map, Value, json};

use super::Axis;
use super::axis::named;
use super::mistakes::{Mistakes, nearest, pointer};

/// What a spec says of the parameters that do not vary.
pub(crate) struct Sections {
    /// Whose parameters they are.
    pub(crate) model: Model,
    /// Every parameter's value: the preset's, or what was written over it.
    pub(crate) fixed: Map<String, Value>,
    /// Which section named which parameter.
    pub(crate) written: BTreeMap<&'static str, &'static str>,
}

impl Sections {
    /// Nothing written yet.
    pub(crate) fn new(model: Model, preset: &str) -> Self {
        Self {
            model,
            fixed: model.defaults(preset).unwrap_or_default(),
            written: BTreeMap::new(),
        }
    }

    /// Reads one section.
    pub(crate) fn read(
        &mut self,
        section: &'static str,
        value: Option<&Value>,
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
            let Some(row) = self.model.parameter(name) else {
                mistakes.add(&place, unknown_parameter(self.model, name));
                continue;
            };
            self.written.insert(row.name, section);
            if row.section.name() != section {
                let detail = format!(
                    "{name} belongs in [{}], not in [{section}]",
                    row.section.name()
                );
                mistakes.add(&place, detail);
            }
            match row.check(value) {
                Ok(value) => {
                    self.fixed.insert(name.clone(), value);
                }
                Err(detail) => mistakes.add(&place, as_axis(row, value, &named(row, &detail))),
            }
        }
    }

    /// Takes back what the preset says of a parameter that another one, which the spec names, would set.
    pub(crate) fn take_back(&mut self, grids: &[Vec<Axis>], mistakes: &mut Mistakes) {
        for (first, second) in self.model.taken_back() {
            let is_axis = |grid: &[Axis], name: &str| grid.iter().any(|axis| axis.name == name);
            let in_some = |name| grids.iter().any(|grid| is_axis(grid, name));
            let (of_first, of_second) = (self.written.get(first), self.written.get(second));
            let useless = || format!("{first} says nothing where {second} is given");
            if let (Some(section), Some(_)) = (of_first, of_second) {
                mistakes.add(&pointer(&pointer("", section), first), useless());
            }
            for (k, grid) in grids.iter().enumerate() {
                let given = of_second.is_some() || is_axis(grid, second);
                if is_axis(grid, first) && given {
                    let at = pointer("/grid", &k.to_string());
                    mistakes.add(&pointer(&at, first), useless());
                }
            }
            if (of_first.is_some() || in_some(first)) && of_second.is_none() {
                self.fixed.insert((*second).to_owned(), Value::Null);
            }
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
pub(crate) fn unknown_parameter(model: Model, name: &str) -> String {
    let name_shown = shown(&json!(name));
    let rows = model.parameters();
    // The names of other tools, and the symbols of the paper.
    let alias = rows.iter().find(|row| row.symbol == name);
    let near = alias
        .map(|row| row.name)
        .or_else(|| nearest(name, rows.iter().map(|row| row.name)));
    let other = Model::ALL
        .into_iter()
        .find(|other| other.parameter(name).is_some());
    match (other, near) {
        (Some(other), _) => format!(
            "{name_shown} is a parameter of the model {}, not of {}",
            other.name(),
            model.name()
        ),
        (None, Some(near)) => format!("{name_shown} is not a parameter; did you mean {near}?"),
        (None, None) => format!(
            "{name_shown} is not a parameter of the model (see /api/v1/models/{})",
            model.name()
        ),
    }
}
