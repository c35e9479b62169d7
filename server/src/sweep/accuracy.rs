//! `[accuracy]`: how large the error of each result may be, and the pilot that finds the cheapest settings that keep it.
//!
//! The pilot is a study like any other: the first packings of the sweep, a part of its waveforms, the first and the last
//! combination of its other axes, each setting that the experiment offers, and the reference.
//! What the spec writes is never chosen over.

use std::collections::BTreeSet;

use granary_api::sweep::Choice;
use granary_api::table::SetRow;
use granary_core::model::Model;
use granary_core::parameter::shown;
use serde_json::{Map, Value, json};

use super::mistakes::{Mistakes, pointer, unknown};
use super::section::Sections;
use super::study::{self, told};
use super::{Axis, Limits, Plan, SECTIONS, reduction::Reduction, rules};

/// Packings of a pilot where nobody says: three degrees of freedom, so that a bound is 2.6 standard deviations.
const PACKINGS: u64 = 4;
/// The fewest and the most packings of a pilot.
const FEWEST_AND_MOST: (u64, u64) = (2, 32);
/// The most waveforms of a pilot: with the zero waveform they fill the lanes of an ensemble.
const WAVEFORMS: usize = 15;
/// The most scenes of a pilot.
const SCENES: usize = 8;

/// What a sweep's results must keep to, and how that is found.
#[derive(Clone, Debug)]
pub struct Accuracy {
    /// The largest error of each result, in the order of the experiment's; a share where the experiment says so.
    pub targets: Vec<(&'static str, f64)>,
    /// The study that decides.
    pub pilot: Box<Plan>,
    /// The parameters that are chosen.
    pub names: Vec<String>,
}

/// What the spec says besides.
pub(crate) struct Around<'a> {
    pub(crate) spec: &'a Map<String, Value>,
    pub(crate) sections: &'a Sections,
    pub(crate) grids: &'a [Vec<Axis>],
    pub(crate) limits: Limits,
}

/// Reads `[accuracy]`.
pub(crate) fn read(
    value: &Value,
    around: &Around<'_>,
    mistakes: &mut Mistakes,
) -> Option<Accuracy> {
    let Some(table) = value.as_object() else {
        mistakes.add("/accuracy", format!("{} is not a table", shown(value)));
        return None;
    };
    let model = around.sections.model;
    let names = || model.judged().iter().map(|judged| judged.name);
    let mut targets = vec![];
    let mut packings = PACKINGS;
    for (name, value) in table {
        let at = pointer("/accuracy", name);
        if name == "packings" {
            packings = mistakes.keep(&at, count(value)).unwrap_or(PACKINGS);
        } else if let Some(known) = names().find(|known| known == name) {
            targets.extend(mistakes.keep(&at, bound(value)).map(|bound| (known, bound)));
        } else {
            let known = names().chain(["packings"]).collect::<Vec<_>>();
            mistakes.add(&at, unknown("field of accuracy", name, known.into_iter()));
        }
    }
    if targets.is_empty() && mistakes.is_empty() {
        let list = names().collect::<Vec<_>>().join(" or ");
        mistakes.add(
            "/accuracy",
            format!("no error is named: say how large that of {list} may be"),
        );
    }
    let order = |name: &str| names().position(|known| known == name);
    targets.sort_by_key(|(name, _)| order(name));
    if around.spec.contains_key("study") {
        let detail = "a study compares settings itself: a sweep has [study] or [accuracy]";
        mistakes.add("/accuracy", detail);
    }
    let free = free(around);
    if free.is_empty() {
        let all = model.choices().names.join(", ");
        mistakes.add(
            "/accuracy",
            format!("nothing is left to choose: the spec says {all} itself"),
        );
    }
    if !mistakes.is_empty() {
        return None;
    }
    let spec = pilot(around, &free, packings);
    offers(around, &spec["study"], mistakes);
    if !mistakes.is_empty() {
        return None;
    }
    match Plan::read(&spec, around.limits) {
        Ok(pilot) => Some(Accuracy {
            targets,
            pilot: Box::new(pilot),
            names: free.into_iter().map(str::to_owned).collect(),
        }),
        Err(found) => {
            for mistake in found {
                mistakes.add(
                    "/accuracy",
                    format!("in the pilot, {}: {}", mistake.pointer, mistake.detail),
                );
            }
            None
        }
    }
}

/// Adds every rule that some point of the sweep, not of its pilot alone, would break in a setting that may be chosen.
fn offers(around: &Around<'_>, study: &Value, mistakes: &mut Mistakes) {
    let mut found = Mistakes::default();
    let study = study::read(study, around.sections, around.grids, &mut found);
    let settings = study.as_ref().map(|study| study.settings.as_slice());
    rules::check(None, around.grids, around.sections, settings, &mut found);
    // Settings differ in little, and so do their mistakes.
    let told: BTreeSet<String> = found.into_list().into_iter().map(|m| m.detail).collect();
    for detail in told {
        mistakes.add(
            "/accuracy",
            format!("a setting that may be chosen breaks a rule: {detail}"),
        );
    }
}

fn count(value: &Value) -> Result<u64, String> {
    let (fewest, most) = FEWEST_AND_MOST;
    let count = value
        .as_u64()
        .filter(|count| (fewest..=most).contains(count));
    count.ok_or_else(|| {
        format!(
            "{} is not a whole number in {fewest} … {most}",
            shown(value)
        )
    })
}

fn bound(value: &Value) -> Result<f64, String> {
    let bound = value.as_f64().filter(|bound| *bound > 0.0 && *bound <= 1.0);
    bound.ok_or_else(|| format!("{} is not in (0, 1]", shown(value)))
}

/// The parameters of the experiment's choices that the spec leaves open.
fn free(around: &Around<'_>) -> Vec<&'static str> {
    let is_axis = |name: &str| around.grids.iter().flatten().any(|axis| axis.name == name);
    let is_written = |name: &str| {
        // What takes another parameter's place is written with it.
        let model = around.sections.model;
        let twin = model.taken_back().iter().find(|(first, _)| *first == name);
        let said = |name: &str| around.sections.written.contains_key(name) || is_axis(name);
        said(name) || twin.is_some_and(|(_, second)| said(second))
    };
    let choices = around.sections.model.choices();
    choices
        .names
        .iter()
        .copied()
        .filter(|name| !is_written(name))
        .collect()
}

/// The spec of the pilot, which anyone could submit.
fn pilot(around: &Around<'_>, free: &[&str], packings: u64) -> Value {
    let choices = around.sections.model.choices();
    let only_free = |values| -> Map<String, Value> {
        let table = choices.table(values);
        let kept = table
            .into_iter()
            .filter(|(name, _)| free.contains(&name.as_str()));
        kept.collect()
    };
    let mut settings: Vec<Value> = vec![];
    for values in choices.settings {
        let setting = Value::Object(only_free(values));
        if !settings.contains(&setting) {
            settings.push(setting);
        }
    }
    let mut spec = Map::new();
    let name = around.spec.get("name").and_then(Value::as_str);
    let name: String = name
        .unwrap_or(around.sections.model.name())
        .chars()
        .take(180)
        .collect();
    spec.insert("name".to_owned(), json!(format!("pilot of {name}")));
    for field in ["model", "preset", "priority"].into_iter().chain(SECTIONS) {
        if let Some(value) = around.spec.get(field) {
            spec.insert(field.to_owned(), value.clone());
        }
    }
    spec.insert("grid".to_owned(), json!(scenes(around, packings)));
    let is_score = |link: &&Value| link["kind"] == "gain_fidelity";
    let links = around.spec.get("reduce").and_then(Value::as_array);
    let scores: Vec<&Value> = links.into_iter().flatten().filter(is_score).collect();
    if !scores.is_empty() {
        spec.insert("reduce".to_owned(), json!(scores));
    }
    let reference = only_free(choices.reference);
    spec.insert(
        "study".to_owned(),
        json!({"reference": reference, "setting": settings}),
    );
    Value::Object(spec)
}

/// The first and the last combination of each grid's axes, each with its packings and a part of its waveforms.
fn scenes(around: &Around<'_>, packings: u64) -> Vec<Map<String, Value>> {
    let mut scenes: Vec<Map<String, Value>> = vec![];
    let fixed = |name: &str| vec![around.sections.fixed[name].clone()];
    for grid in around.grids {
        for last in [false, true] {
            let mut scene = Map::new();
            for axis in grid {
                let value = if last {
                    axis.values.last()
                } else {
                    axis.values.first()
                };
                scene.insert(axis.name.to_owned(), json!(value));
            }
            let of_axis = |name: &str| {
                let axis = grid.iter().find(|axis| axis.name == name);
                axis.map_or_else(|| fixed(name), |axis| axis.values.clone())
            };
            let seeds = seeds(&of_axis("packing_seed"), packings);
            scene.insert("packing_seed".to_owned(), json!(seeds));
            if around.sections.model == Model::Memory {
                let waveforms = spread(&of_axis("waveform"));
                scene.insert("waveform".to_owned(), json!(waveforms));
            }
            if scenes.len() < SCENES && !scenes.contains(&scene) {
                scenes.push(scene);
            }
        }
    }
    scenes
}

/// The first `count` seeds of the sweep, and those after the largest of them where it has fewer.
fn seeds(of_sweep: &[Value], count: u64) -> Vec<u64> {
    let mut seeds: Vec<u64> = of_sweep.iter().filter_map(Value::as_u64).collect();
    let largest = seeds.iter().copied().max().unwrap_or_default();
    seeds.truncate(count as usize);
    let more = count - seeds.len() as u64;
    // Seeds end where whole numbers of JSON do; a sweep at that end takes those before.
    let next = |k: u64| {
        let after = largest + k;
        if after < 1 << 53 {
            after
        } else {
            largest - count - k
        }
    };
    seeds.extend((1..=more).map(next));
    seeds
}

/// At most [`WAVEFORMS`] of them, evenly spread.
fn spread(all: &[Value]) -> Vec<Value> {
    let count = all.len().min(WAVEFORMS);
    (0..count)
        .map(|k| all[k * all.len() / count].clone())
        .collect()
}

impl Accuracy {
    /// What the rows of the finished pilot say: the first, and so the cheapest, setting whose bounds keep every target in
    /// every scene, else the reference.
    #[must_use]
    pub fn choose(&self, rows: &[SetRow], pilot_core_seconds: f64) -> Choice {
        let Some(Reduction::Study { settings, .. }) = self.pilot.reductions.last() else {
            unreachable!("a pilot is a study");
        };
        let of = |label: &str| -> Vec<SetRow> {
            let same = |row: &&SetRow| row.setting.as_deref() == Some(label);
            rows.iter().filter(same).cloned().collect()
        };
        let values = |values: &Map<String, Value>| -> Map<String, Value> {
            let value = |name: &String| {
                let own = values.get(name).or_else(|| self.pilot.fixed.get(name));
                own.map(|value| (name.clone(), value.clone()))
            };
            self.names.iter().filter_map(value).collect()
        };
        let offered = self.pilot.model.choices();
        for offer in offered.settings {
            let offer = values(&offered.table(offer));
            // A setting that is the spec as it is written stands under that name.
            let found = settings
                .iter()
                .find(|setting| values(&setting.values) == offer);
            let evidence = found.map_or(vec![], |setting| of(&setting.label));
            if !evidence.is_empty() && evidence.iter().all(|row| self.keeps(row)) {
                return Choice {
                    setting: label(&offer),
                    values: offer,
                    relative_cost: relative_cost(&evidence),
                    evidence,
                    pilot_core_seconds,
                    reason: None,
                };
            }
        }
        let reference = values(&settings[0].values);
        let evidence = of(&settings[0].label);
        let reason = "no cheaper setting keeps what was asked for in every scene of the pilot";
        Choice {
            setting: label(&reference),
            values: reference,
            relative_cost: relative_cost(&evidence),
            evidence,
            pilot_core_seconds,
            reason: Some(reason.to_owned()),
        }
    }

    /// Whether every error of a setting, with its uncertainty, is within its target.
    fn keeps(&self, row: &SetRow) -> bool {
        let within = |(name, target): &(&str, f64)| {
            let bound = row.results.get(&format!("{name}_deviation_bound"));
            bound
                .copied()
                .flatten()
                .is_some_and(|bound| bound <= *target)
        };
        row.n == row.of && self.targets.iter().all(within)
    }
}

/// The mean over scenes of what a setting costs, relative to the reference.
fn relative_cost(evidence: &[SetRow]) -> Option<f64> {
    let cost = |row: &SetRow| row.results.get("relative_cost").copied().flatten();
    let costs: Vec<f64> = evidence.iter().map(cost).collect::<Option<_>>()?;
    let n = costs.len() as f64;
    (!costs.is_empty()).then(|| costs.iter().sum::<f64>() / n)
}

/// A setting in words.
fn label(values: &Map<String, Value>) -> String {
    let parts: Vec<String> = values
        .iter()
        .map(|(name, value)| told(name, value))
        .collect();
    parts.join(", ")
}

impl Plan {
    /// This plan with what its pilot has chosen, as axes of one value, so that every row shows them.
    #[must_use]
    pub fn settled(mut self, choice: &Choice) -> Self {
        for grid in &mut self.grids {
            for (name, value) in &choice.values {
                if let Some(row) = self.model.parameter(name) {
                    grid.push(Axis {
                        name: row.name,
                        values: vec![value.clone()],
                    });
                }
            }
        }
        for (first, second) in self.model.taken_back() {
            if choice.values.contains_key(*first) {
                self.fixed.insert((*second).to_owned(), Value::Null);
            }
        }
        self.accuracy = None;
        self
    }
}
