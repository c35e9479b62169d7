//! Sweeps: from a spec as JSON to grids, points and stages; pure.
//!
//! [`Plan::read`] finds every mistake at once and counts the points before anything is expanded.
//! [`expansion::Expansion`] then yields the rows to queue, a chunk at a time.

pub mod accuracy;
mod axis;
pub mod expansion;
mod mistakes;
mod recognition;
pub mod reduction;
mod rules;
mod section;
mod study;
mod suite;

use std::collections::BTreeMap;

use granary_api::problem::Mistake;
use granary_core::memory::classifier::ClassifierSpec;
use granary_core::model::Model;
use granary_core::parameter::shown;
use granary_core::stage::StageKind;
use serde::Serialize;
use serde_json::{Map, Value};

pub use accuracy::Accuracy;
pub use axis::Axis;
pub(crate) use mistakes::nearest as nearest_name;
use mistakes::{Mistakes, pointer, unknown};
use reduction::Reduction;
use section::Sections;

/// How large a sweep may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Points of one sweep.
    pub points: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { points: 1_000_000 }
    }
}

/// A sweep without mistakes, not expanded yet.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What the user calls it.
    pub name: String,
    /// The experiment.
    pub model: Model,
    /// The named choice of parameters.
    pub preset: String,
    /// Sweeps of higher priority are served first; none if the spec does not say.
    pub priority: Option<i64>,
    /// Every parameter's value where no axis says otherwise.
    pub fixed: Map<String, Value>,
    /// Products of axes, joined.
    pub grids: Vec<Vec<Axis>>,
    /// The chain of reductions.
    pub reductions: Vec<Reduction>,
    /// The spec as submitted.
    pub spec: Value,
    /// Points of all grids together, before equal ones are merged.
    pub points: u64,
    /// How accurate results must be; a pilot then decides on settings before anything is expanded.
    pub accuracy: Option<Accuracy>,
}

/// The sections that fix parameters.
const SECTIONS: [&str; 3] = ["fixed", "numerics", "preparation"];
/// Every field of a spec.
const FIELDS: [&str; 11] = [
    "name",
    "model",
    "preset",
    "priority",
    "fixed",
    "numerics",
    "preparation",
    "grid",
    "reduce",
    "study",
    "accuracy",
];
/// Values of an axis that reductions look at.
const FIRST_VALUES: usize = 4;
/// The most grids of one sweep.
const MOST_GRIDS: usize = 100;

impl Plan {
    /// Reads a spec; otherwise every mistake in it.
    pub fn read(spec: &Value, limits: Limits) -> Result<Self, Vec<Mistake>> {
        let mut mistakes = Mistakes::default();
        let Some(table) = spec.as_object() else {
            mistakes.add(
                "",
                format!("{} is not a sweep: a table is expected", shown(spec)),
            );
            return Err(mistakes.into_list());
        };
        let Some(model) = model(table, &mut mistakes) else {
            return Err(mistakes.into_list());
        };
        fields(table, model, &mut mistakes);
        let preset = preset(table.get("preset"), model, &mut mistakes);
        let mut sections = Sections::new(model, &preset);
        for name in SECTIONS {
            sections.read(name, table.get(name), &mut mistakes);
        }
        let (grids, points) = grids(table.get("grid"), &sections, limits, &mut mistakes);
        sections.take_back(&grids, &mut mistakes);
        let study = table.get("study");
        let study = study.and_then(|study| study::read(study, &sections, &grids, &mut mistakes));
        let settings = study.as_ref().map(|study| study.settings.as_slice());
        rules::check(
            table.get("grid"),
            &grids,
            &sections,
            settings,
            &mut mistakes,
        );
        let fixed = sections.fixed.clone();
        let axes = values_by_axis(table.get("grid"), &grids);
        let about = reduction::About {
            model,
            axes: &axes,
            grids: &grids,
            fixed: &fixed,
        };
        let mut reductions = match table.get("reduce") {
            Some(value) => reduction::read(value, &about, &mut mistakes),
            None if study.is_some() => reduction::before_study(&about),
            None => reduction::usual(&about),
        };
        let points = points.saturating_mul(settings.map_or(1, |all| all.len() as u64));
        if points > limits.points {
            let most = limits.points;
            let detail =
                format!("{points} points in all settings: a sweep may have at most {most}");
            mistakes.add("/study", detail);
        }
        if let Some(study) = &study {
            let link = reduction::study(study, &reductions, &axes, &mut mistakes);
            reductions.push(link);
        }
        let around = accuracy::Around {
            spec: table,
            sections: &sections,
            grids: &grids,
            limits,
        };
        let accuracy = table.get("accuracy");
        let accuracy = accuracy.and_then(|value| accuracy::read(value, &around, &mut mistakes));
        let said = spec.pointer("/numerics/second_cycle").is_some();
        let wanted = said || reductions.iter().any(Reduction::needs_second_cycle);
        let fixed = without_second_cycle(fixed, wanted);
        let compared = study.map(|study| compared(&grids, &study, model));
        drop(axes);
        let grids = compared.unwrap_or(grids);
        let name = name(table.get("name"), model, &mut mistakes);
        let priority = priority(table.get("priority"), &mut mistakes);
        if !mistakes.is_empty() {
            return Err(mistakes.into_list());
        }
        Ok(Self {
            name,
            model,
            preset,
            priority,
            fixed,
            grids,
            reductions,
            spec: spec.clone(),
            points,
            accuracy,
        })
    }

    /// The parameters that vary, in the order in which the spec first names them.
    #[must_use]
    pub fn axes(&self) -> Vec<&'static str> {
        let mut names = vec![];
        for axis in self.grids.iter().flatten() {
            if !names.contains(&axis.name) {
                names.push(axis.name);
            }
        }
        names
    }

    /// Whether the zero waveform must be recalled in every trained pack.
    #[must_use]
    pub fn needs_zero(&self) -> bool {
        self.reductions.iter().any(Reduction::needs_zero)
    }

    /// The classifiers that its reductions ask.
    #[must_use]
    pub fn classifiers(&self) -> Vec<ClassifierSpec> {
        let all = self.reductions.iter().flat_map(Reduction::classifiers);
        all.cloned().collect()
    }

    /// What makes two sweeps the same: everything but the priority, after defaults, and the physics that computes it.
    #[must_use]
    pub fn identity(&self) -> [u8; 32] {
        let asks = !self.classifiers().is_empty();
        let of_model = |kind: &StageKind| {
            Model::of(*kind) == self.model && (asks || *kind != StageKind::Classifier)
        };
        let kinds = StageKind::ALL.into_iter().filter(of_model);
        self.identity_with(&kinds.map(StageKind::physics).collect::<Vec<u32>>())
    }

    /// The identity where the model's stages are of the versions `physics`.
    ///
    /// # Panics
    /// Never: a plan is plain data, and hashing does not fail.
    #[must_use]
    pub fn identity_with(&self, physics: &[u32]) -> [u8; 32] {
        #[derive(Serialize)]
        struct Identity<'a> {
            physics: &'a [u32],
            name: &'a str,
            model: Model,
            preset: &'a str,
            fixed: BTreeMap<&'a String, &'a Value>,
            grids: Vec<Vec<(&'a str, &'a [Value])>>,
            reductions: &'a [Reduction],
            #[serde(skip_serializing_if = "Option::is_none")]
            accuracy: Option<&'a [(&'static str, f64)]>,
            #[serde(skip_serializing_if = "Option::is_none")]
            pilot: Option<[u8; 32]>,
        }
        let axes = |grid: &'_ Vec<Axis>| -> Vec<(&'static str, Vec<Value>)> {
            grid.iter()
                .map(|axis| (axis.name, axis.values.clone()))
                .collect()
        };
        let owned: Vec<_> = self.grids.iter().map(axes).collect();
        let grids = owned
            .iter()
            .map(|grid| {
                grid.iter()
                    .map(|(name, values)| (*name, values.as_slice()))
                    .collect()
            })
            .collect();
        let accuracy = self.accuracy.as_ref();
        let identity = Identity {
            physics,
            name: &self.name,
            model: self.model,
            preset: &self.preset,
            fixed: self.fixed.iter().collect(),
            grids,
            reductions: &self.reductions,
            accuracy: accuracy.map(|accuracy| accuracy.targets.as_slice()),
            pilot: accuracy.map(|accuracy| accuracy.pilot.identity_with(physics)),
        };
        let mut hasher = blake3::Hasher::new();
        serde_json::to_writer(&mut hasher, &identity).expect("plain data, and hashing never fails");
        *hasher.finalize().as_bytes()
    }
}

/// Leaves a recall's second cycle out, which is half of its cost, unless it is `wanted`.
fn without_second_cycle(mut fixed: Map<String, Value>, wanted: bool) -> Map<String, Value> {
    if let Some(second_cycle) = fixed.get_mut("second_cycle").filter(|_| !wanted) {
        *second_cycle = Value::Bool(false);
    }
    fixed
}

/// The grids of every setting of a study, the reference's first.
fn compared(grids: &[Vec<Axis>], study: &study::Study, model: Model) -> Vec<Vec<Axis>> {
    let of_setting = |setting: &study::Setting| -> Vec<Vec<Axis>> {
        let with = |grid: &Vec<Axis>| grid.iter().cloned().chain(setting.axes(model)).collect();
        grids.iter().map(with).collect()
    };
    study.settings.iter().flat_map(of_setting).collect()
}

/// The model, if the spec can be read any further.
fn model(table: &Map<String, Value>, mistakes: &mut Mistakes) -> Option<Model> {
    let names = || Model::ALL.into_iter().map(Model::name);
    let either = || names().collect::<Vec<_>>().join(" or ");
    match table.get("model") {
        Some(Value::String(name)) => {
            let model = Model::named(name);
            if model.is_none() {
                mistakes.add("/model", unknown("model", name, names()));
            }
            model
        }
        Some(other) => {
            mistakes.add(
                "/model",
                format!("{} is not a model: {}", shown(other), either()),
            );
            None
        }
        None => {
            mistakes.add("/model", format!("missing: {}", either()));
            // The other mistakes are told too, by the model whose parameters the spec names.
            Model::ALL
                .into_iter()
                .rev()
                .max_by_key(|model| named(*model, table))
        }
    }
}

/// How many parameters of `model` the sections name.
fn named(model: Model, table: &Map<String, Value>) -> usize {
    let sections = SECTIONS
        .iter()
        .filter_map(|name| table.get(*name)?.as_object());
    sections
        .flat_map(Map::keys)
        .filter(|name| model.parameter(name).is_some())
        .count()
}

fn fields(table: &Map<String, Value>, model: Model, mistakes: &mut Mistakes) {
    for key in table.keys().filter(|key| !FIELDS.contains(&key.as_str())) {
        let detail = match model.parameter(key) {
            Some(row) => format!(
                "{key} is a parameter: it belongs in [{}] or in a [[grid]]",
                row.section.name()
            ),
            None => unknown("field of a sweep", key, FIELDS.into_iter()),
        };
        mistakes.add(&pointer("", key), detail);
    }
}

fn preset(value: Option<&Value>, model: Model, mistakes: &mut Mistakes) -> String {
    let names = || model.presets().iter().map(|preset| preset.name);
    match value {
        None => {}
        Some(Value::String(name)) if names().any(|known| known == name) => return name.clone(),
        Some(Value::String(name)) => mistakes.add("/preset", unknown("preset", name, names())),
        Some(other) => mistakes.add("/preset", format!("{} is not a preset", shown(other))),
    }
    "standard".to_owned()
}

fn name(value: Option<&Value>, model: Model, mistakes: &mut Mistakes) -> String {
    match value {
        None => model.name().to_owned(),
        Some(Value::String(name)) if (1..=200).contains(&name.chars().count()) => name.clone(),
        Some(other) => {
            mistakes.add(
                "/name",
                format!("{} is not a name of 1 … 200 characters", shown(other)),
            );
            String::new()
        }
    }
}

fn priority(value: Option<&Value>, mistakes: &mut Mistakes) -> Option<i64> {
    let value = value?;
    let priority = value.as_i64().filter(|p| (-1000..=1000).contains(p));
    if priority.is_none() {
        mistakes.add(
            "/priority",
            format!("{} is not a whole number in -1000 … 1000", shown(value)),
        );
    }
    priority
}

/// The grids and the number of their points; without `[[grid]]` there is one point.
fn grids(
    value: Option<&Value>,
    sections: &Sections,
    limits: Limits,
    mistakes: &mut Mistakes,
) -> (Vec<Vec<Axis>>, u64) {
    let Some(value) = value else {
        return (vec![vec![]], 1);
    };
    let Some(tables) = value.as_array() else {
        mistakes.add(
            "/grid",
            format!("{} is not a list of tables: write [[grid]]", shown(value)),
        );
        return (vec![], 0);
    };
    if tables.is_empty() || tables.len() > MOST_GRIDS {
        mistakes.add(
            "/grid",
            format!("{} grids: there must be 1 … {MOST_GRIDS}", tables.len()),
        );
        return (vec![], 0);
    }
    let mut grids = vec![];
    let mut points: Option<u128> = Some(0);
    for (k, table) in tables.iter().enumerate() {
        let at = pointer("/grid", &k.to_string());
        let (grid, count) = grid(table, &at, sections, limits, mistakes);
        grids.push(grid);
        points = points.zip(count).and_then(|(a, b)| a.checked_add(b));
    }
    match points {
        Some(points) if points <= u128::from(limits.points) => (grids, points as u64),
        other => {
            let count = other.map_or("more than 10^38".to_owned(), |n| n.to_string());
            mistakes.add(
                "/grid",
                format!("{count} points: a sweep may have at most {}", limits.points),
            );
            (grids, 0)
        }
    }
}

/// One grid and its number of points; `None` if that number is beyond counting.
fn grid(
    value: &Value,
    at: &str,
    sections: &Sections,
    limits: Limits,
    mistakes: &mut Mistakes,
) -> (Vec<Axis>, Option<u128>) {
    let Some(table) = value.as_object().filter(|table| !table.is_empty()) else {
        mistakes.add(
            at,
            format!(
                "{} is not a grid: a table with at least one axis",
                shown(value)
            ),
        );
        return (vec![], Some(0));
    };
    let mut axes = vec![];
    let mut points: Option<u128> = Some(1);
    for (name, value) in table {
        let place = pointer(at, name);
        let Some(row) = sections.model.parameter(name) else {
            mistakes.add(&place, section::unknown_parameter(sections.model, name));
            continue;
        };
        if let Some(section) = sections.written.get(row.name) {
            mistakes.add(&place, format!("{name} is an axis here, but fixed at /{section}/{name}: it can be one of them only"));
        }
        if let Some(counted) = axis::read(row, value, &place, limits.points, mistakes) {
            points = points.and_then(|n| n.checked_mul(counted.count));
            axes.extend(counted.axis);
        }
    }
    (axes, points)
}

/// Every axis that the spec names, even a wrong one, with values that it takes.
fn values_by_axis<'a>(
    value: Option<&'a Value>,
    grids: &'a [Vec<Axis>],
) -> BTreeMap<&'a str, Vec<Value>> {
    let tables = value
        .and_then(Value::as_array)
        .map_or(&[][..], Vec::as_slice);
    let names = tables
        .iter()
        .filter_map(Value::as_object)
        .flat_map(Map::keys);
    let mut map: BTreeMap<&str, Vec<Value>> = names.map(|name| (name.as_str(), vec![])).collect();
    for axis in grids.iter().flatten() {
        let values = map.entry(axis.name).or_default();
        // Flags are looked at by value, and a fit needs a few points, so the first ones of a long axis are enough.
        values.extend(axis.values.iter().take(FIRST_VALUES).cloned());
    }
    map
}
