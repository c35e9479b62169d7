//! `[study]`: which settings of its own scene a sweep compares, and with what.
//!
//! A field named like a parameter is a *knob*: each of its values, written like an axis, makes one setting, with
//! everything else as the spec says. `[[study.setting]]` changes several parameters at once, or takes a preset's.
//! `reference` says what all are compared with, as changes to the spec; without it, the spec as it stands.

use granary_core::model::Model;
use granary_core::parameter::{Domain, shown};
use serde_json::{Map, Value};

use super::Axis;
use super::axis;
use super::mistakes::{Mistakes, pointer, unknown};
use super::reduction::Studied;
use super::section::{Sections, unknown_parameter};

/// The most settings of one study.
const MOST_SETTINGS: usize = 200;
/// The spec as it stands.
const AS_WRITTEN: &str = "as written";
/// The fields that are not knobs.
const FIELDS: [&str; 2] = ["reference", "setting"];

/// The settings that a sweep compares.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Study {
    /// The reference first, then the spec as it stands, then what the study names; no two alike.
    pub(crate) settings: Vec<Setting>,
}

/// One setting.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Setting {
    /// What tables call it, and what it says of the parameters in which settings differ.
    pub(crate) studied: Studied,
    /// Where the spec names it.
    pub(crate) place: String,
    /// The parameters that it names itself.
    named: Vec<String>,
}

impl Setting {
    /// Whether the setting is what says `name`.
    pub(crate) fn names(&self, name: &str) -> bool {
        self.named.iter().any(|named| named == name)
    }

    /// The values as axes of one value each.
    pub(crate) fn axes(&self, model: Model) -> impl Iterator<Item = Axis> {
        self.studied.values.iter().filter_map(move |(name, value)| {
            Some(Axis {
                name: model.parameter(name)?.name,
                values: vec![value.clone()],
            })
        })
    }
}

/// Reads `[study]` for a sweep with these grids.
pub(crate) fn read(
    value: &Value,
    sections: &Sections,
    grids: &[Vec<Axis>],
    mistakes: &mut Mistakes,
) -> Option<Study> {
    let Some(table) = value.as_object() else {
        mistakes.add("/study", format!("{} is not a table", shown(value)));
        return None;
    };
    let reader = Reader { sections, grids };
    let reference = match table.get("reference") {
        Some(value) => reader.change(value, "/study/reference", mistakes),
        None => Change::default(),
    };
    let mut changes = vec![
        Change {
            label: "reference".to_owned(),
            ..reference
        },
        Change {
            label: AS_WRITTEN.to_owned(),
            ..Change::default()
        },
    ];
    for (name, value) in table
        .iter()
        .filter(|(name, _)| !FIELDS.contains(&name.as_str()))
    {
        reader.knob(name, value, &mut changes, mistakes);
    }
    if let Some(value) = table.get("setting") {
        reader.listed(value, &mut changes, mistakes);
    }
    if changes.len() > MOST_SETTINGS {
        let count = changes.len();
        mistakes.add(
            "/study",
            format!("{count} settings: a study may have at most {MOST_SETTINGS}"),
        );
        return None;
    }
    let settings = reader.settings(changes);
    if settings.len() < 2 && mistakes.is_empty() {
        mistakes.add(
            "/study",
            "there is nothing to compare: name a knob such as time_step = [0.5, 1.5], a [[study.setting]] or a reference",
        );
    }
    Some(Study { settings })
}

/// What every setting starts from.
struct Reader<'a> {
    sections: &'a Sections,
    grids: &'a [Vec<Axis>],
}

/// What a setting changes.
#[derive(Default)]
struct Change {
    label: String,
    place: String,
    values: Map<String, Value>,
}

impl Reader<'_> {
    fn model(&self) -> Model {
        self.sections.model
    }

    /// The parameter called `name`, if a setting may change it.
    fn row(
        &self,
        name: &str,
        at: &str,
        mistakes: &mut Mistakes,
    ) -> Option<&'static granary_core::parameter::Parameter> {
        let Some(row) = self.model().parameter(name) else {
            mistakes.add(at, unknown_parameter(self.model(), name));
            return None;
        };
        if matches!(row.domain, Domain::Notation(_)) || name == "packing_seed" {
            mistakes.add(
                at,
                format!("{name} is what results are taken over, not a knob: make it an axis"),
            );
            return None;
        }
        let is_axis = |grid: &Vec<Axis>| grid.iter().any(|axis| axis.name == name);
        if self.grids.iter().any(is_axis) {
            mistakes.add(
                at,
                format!("{name} is an axis of this sweep, so it cannot be a knob too"),
            );
            return None;
        }
        Some(row)
    }

    fn knob(&self, name: &str, value: &Value, changes: &mut Vec<Change>, mistakes: &mut Mistakes) {
        let at = pointer("/study", name);
        if self.model().parameter(name).is_none() && FIELDS.iter().any(|field| near(field, name)) {
            mistakes.add(&at, unknown("field of a study", name, FIELDS.into_iter()));
            return;
        }
        let Some(row) = self.row(name, &at, mistakes) else {
            return;
        };
        let read = axis::read(row, value, &at, MOST_SETTINGS as u64, mistakes);
        let Some(counted) = read else {
            return;
        };
        let Some(axis) = counted.axis else {
            if counted.count > MOST_SETTINGS as u128 {
                let count = counted.count;
                mistakes.add(
                    &at,
                    format!("{count} values: a study may have at most {MOST_SETTINGS} settings"),
                );
            }
            return;
        };
        let listed = value.is_array();
        for (k, value) in axis.values.into_iter().enumerate() {
            let place = if listed {
                pointer(&at, &k.to_string())
            } else {
                at.clone()
            };
            changes.push(Change {
                label: told(name, &value),
                place,
                values: self.whole(Map::from_iter([(name.to_owned(), value)])),
            });
        }
    }

    fn listed(&self, value: &Value, changes: &mut Vec<Change>, mistakes: &mut Mistakes) {
        let Some(tables) = value.as_array() else {
            let detail = format!(
                "{} is not a list of tables: write [[study.setting]]",
                shown(value)
            );
            mistakes.add("/study/setting", detail);
            return;
        };
        // One too many is enough to be told so.
        for (k, table) in tables.iter().take(MOST_SETTINGS).enumerate() {
            let at = pointer("/study/setting", &k.to_string());
            let change = self.change(table, &at, mistakes);
            if change.values.is_empty() && mistakes.is_empty() {
                mistakes.add(&at, "this setting changes nothing");
            }
            changes.push(change);
        }
    }

    /// What a table changes; `preset` stands for all that presets set and the spec does not.
    fn change(&self, value: &Value, at: &str, mistakes: &mut Mistakes) -> Change {
        let Some(table) = value.as_object() else {
            mistakes.add(at, format!("{} is not a table", shown(value)));
            return Change::default();
        };
        let mut values = match table.get("preset") {
            Some(preset) => self.preset(preset, &pointer(at, "preset"), mistakes),
            None => Map::new(),
        };
        let mut written = Map::new();
        for (name, value) in table.iter().filter(|(name, _)| *name != "preset") {
            let place = pointer(at, name);
            let Some(row) = self.row(name, &place, mistakes) else {
                continue;
            };
            if let Some(value) = mistakes.keep(&place, row.check(value)) {
                written.insert(name.clone(), value);
            }
        }
        values.extend(self.whole(written));
        let parts: Vec<String> = table
            .iter()
            .map(|(name, value)| told(name, value))
            .collect();
        Change {
            label: parts.join(", "),
            place: at.to_owned(),
            values,
        }
    }

    /// `values` with those taken back that one of them replaces.
    fn whole(&self, mut values: Map<String, Value>) -> Map<String, Value> {
        for (first, second) in self.model().taken_back() {
            if values.contains_key(*first) && !values.contains_key(*second) {
                values.insert((*second).to_owned(), Value::Null);
            }
        }
        values
    }

    fn preset(&self, value: &Value, at: &str, mistakes: &mut Mistakes) -> Map<String, Value> {
        let presets = self.model().presets();
        let names = presets.iter().map(|preset| preset.name);
        let named = value.as_str().and_then(|name| self.model().defaults(name));
        let Some(defaults) = named else {
            let written = value.as_str().unwrap_or_default();
            mistakes.add(at, unknown("preset", written, names));
            return Map::new();
        };
        let set = presets.iter().flat_map(|preset| preset.values);
        let is_free = |name: &str| {
            let is_axis = |grid: &Vec<Axis>| grid.iter().any(|axis| axis.name == name);
            !self.sections.written.contains_key(name) && !self.grids.iter().any(is_axis)
        };
        set.filter(|(name, _)| is_free(name))
            .map(|(name, _)| ((*name).to_owned(), defaults[*name].clone()))
            .collect()
    }

    /// The settings, each once, with the parameters in which they differ.
    fn settings(&self, changes: Vec<Change>) -> Vec<Setting> {
        let as_written = |name: &str| self.sections.fixed[name].clone();
        let mut names: Vec<String> = vec![];
        for (name, value) in changes.iter().flat_map(|change| &change.values) {
            if *value != as_written(name) && !names.contains(name) {
                names.push(name.clone());
            }
        }
        let mut settings: Vec<Setting> = vec![];
        for change in changes {
            let value = |name: &String| change.values.get(name).cloned();
            let values: Map<String, Value> = names
                .iter()
                .map(|name| {
                    (
                        name.clone(),
                        value(name).unwrap_or_else(|| as_written(name)),
                    )
                })
                .collect();
            let known = settings
                .iter_mut()
                .find(|known| known.studied.values == values);
            match known {
                // The study's own words for it say more.
                Some(known) if known.studied.label == AS_WRITTEN => {
                    known.studied.label = change.label;
                }
                Some(_) => {}
                None => settings.push(Setting {
                    studied: Studied {
                        label: change.label,
                        values,
                    },
                    place: change.place,
                    named: change.values.keys().cloned().collect(),
                }),
            }
        }
        settings
    }
}

/// `time_step 0.5`: a parameter and its value in words.
pub(crate) fn told(name: &str, value: &Value) -> String {
    match value {
        Value::Number(number) if number.is_f64() => {
            format!("{name} {}", number.as_f64().unwrap_or(f64::NAN))
        }
        Value::String(word) => format!("{name} {word}"),
        other => format!("{name} {}", shown(other)),
    }
}

fn near(field: &str, name: &str) -> bool {
    super::nearest_name(name, std::iter::once(field)).is_some()
}
