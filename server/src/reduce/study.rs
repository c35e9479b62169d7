//! Studies: how far the results of each setting are from the reference's on the same packings, and what each costs.

use std::collections::BTreeMap;

use granary_api::table::SetRow;
use granary_core::model::Model;
use granary_core::study::{Deviation, Judged, Trade, front};
use serde_json::{Map, Value};

use super::{key, without};
use crate::sweep::reduction::Studied;

/// What the jobs behind one row of the link before took \[core-seconds\]; `None` where one has no outcome.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Making the packing.
    pub preparation: Option<f64>,
    /// Everything after it.
    pub run: Option<f64>,
}

/// One row for each setting of `settings`, for each group of rows that differ in nothing but settings and `over`.
///
/// `cost` tells what stands behind a row.
#[must_use]
pub fn study(
    rows: &[SetRow],
    over: &[String],
    settings: &[Studied],
    model: Model,
    cost: impl Fn(&SetRow) -> Cost,
) -> Vec<SetRow> {
    let Some(reference) = settings.first() else {
        return vec![];
    };
    let knobs: Vec<String> = reference.values.keys().cloned().collect();
    let scenes = scenes(rows, over, &knobs);
    let compared = |scene: &Scene<'_>| {
        let settings: Vec<SetRow> = settings
            .iter()
            .map(|setting| {
                Compared {
                    model,
                    over,
                    cost: &cost,
                    scene,
                    reference: scene.of(reference),
                    own: scene.of(setting),
                    is_reference: setting == reference,
                }
                .row(setting)
            })
            .collect();
        judged(settings, model)
    };
    scenes.iter().flat_map(compared).collect()
}

/// Rows of one scene: all settings, all packings.
struct Scene<'a> {
    parameters: Map<String, Value>,
    processing: Option<String>,
    rows: Vec<&'a SetRow>,
}

impl<'a> Scene<'a> {
    fn of(&self, setting: &Studied) -> Vec<&'a SetRow> {
        let same = |row: &&&SetRow| {
            let of_row = |name: &String| row.parameters.get(name);
            setting
                .values
                .iter()
                .all(|(name, value)| of_row(name) == Some(value))
        };
        self.rows.iter().filter(same).copied().collect()
    }
}

fn scenes<'a>(rows: &'a [SetRow], over: &[String], knobs: &[String]) -> Vec<Scene<'a>> {
    let apart: Vec<String> = over.iter().chain(knobs).cloned().collect();
    let mut places = BTreeMap::new();
    let mut scenes: Vec<Scene<'_>> = vec![];
    for row in rows {
        let key = format!("{:?} {}", row.processing, key(&row.parameters, &apart));
        let place = *places.entry(key).or_insert_with(|| {
            scenes.push(Scene {
                parameters: without(&row.parameters, &apart),
                processing: row.processing.clone(),
                rows: vec![],
            });
            scenes.len() - 1
        });
        scenes[place].rows.push(row);
    }
    scenes
}

/// The rows of one setting beside the reference's.
struct Compared<'a, F> {
    model: Model,
    over: &'a [String],
    cost: &'a F,
    scene: &'a Scene<'a>,
    reference: Vec<&'a SetRow>,
    own: Vec<&'a SetRow>,
    is_reference: bool,
}

impl<F: Fn(&SetRow) -> Cost> Compared<'_, F> {
    fn row(&self, setting: &Studied) -> SetRow {
        let mut parameters = self.scene.parameters.clone();
        parameters.extend(
            setting
                .values
                .iter()
                .map(|(name, value)| (name.clone(), value.clone())),
        );
        let mut results = BTreeMap::new();
        for judged in self.model.judged() {
            self.judge(*judged, &mut results);
        }
        // Where a run was interrupted, what it took is not known; that of the other packings is.
        let mean = |part: fn(Cost) -> Option<f64>, rows: &[&SetRow]| {
            let known = rows.iter().filter_map(|row| part((self.cost)(row)));
            mean(known.map(Some))
        };
        let run = mean(|cost| cost.run, &self.own);
        let of_reference = mean(|cost| cost.run, &self.reference);
        let relative = run.zip(of_reference).filter(|(_, of)| *of > 0.0);
        results.insert("core_seconds".to_owned(), run);
        results.insert(
            "relative_cost".to_owned(),
            relative.map(|(own, of)| own / of),
        );
        let preparation = mean(|cost| cost.preparation, &self.own);
        results.insert("preparation_core_seconds".to_owned(), preparation);
        SetRow {
            set: 0,
            reduce: "study".to_owned(),
            processing: self.scene.processing.clone(),
            shape: None,
            setting: Some(setting.label.clone()),
            verdict: self.is_reference.then(|| "reference".to_owned()),
            parameters,
            results,
            n: self.own.iter().filter(|row| is_whole(row)).count() as u64,
            of: self.own.len() as u64,
            provisional: self
                .own
                .iter()
                .chain(&self.reference)
                .any(|row| row.provisional),
            missing_reason: self.reason(),
            confused: vec![],
            warning: super::warning_of(&self.own),
        }
    }

    /// Mean and deviation of one result.
    fn judge(&self, judged: Judged, results: &mut BTreeMap<String, Option<f64>>) {
        let of_reference = |own: &SetRow| {
            let own = key_of(own, self.over);
            let same = |row: &&&SetRow| key_of(row, self.over) == own;
            self.reference.iter().find(same).copied()
        };
        let pairs = self.own.iter().filter_map(|own| {
            let reference = number(of_reference(own)?, judged.name)?;
            judged.deviation(number(own, judged.name)?, reference)
        });
        let deviation = Deviation::of(&pairs.collect::<Vec<f64>>());
        let numbers = self.own.iter().map(|row| number(row, judged.name));
        let known: Vec<f64> = numbers.flatten().collect();
        let name = judged.name;
        let mut put = |name: String, value| results.insert(name, value);
        put(name.to_owned(), mean(known.into_iter().map(Some)));
        put(format!("{name}_deviation"), deviation.map(|d| d.mean));
        put(
            format!("{name}_deviation_sem"),
            deviation.and_then(|d| d.sem),
        );
        put(
            format!("{name}_deviation_bound"),
            deviation.and_then(|d| d.bound),
        );
    }

    /// Why packings are missing.
    fn reason(&self) -> Option<String> {
        let told = |rows: &[&SetRow]| {
            let missing = rows.iter().filter(|row| !row.provisional && !is_whole(row));
            let reasons: Vec<&String> = missing
                .filter_map(|row| row.missing_reason.as_ref())
                .collect();
            let first = reasons.first()?;
            Some(format!(
                "{} of {} packings: {first}",
                reasons.len(),
                rows.len()
            ))
        };
        let reference = told(&self.reference).map(|reason| format!("of the reference, {reason}"));
        told(&self.own).or(reference)
    }
}

/// The place of a row among those that a study is taken over.
fn key_of(row: &SetRow, over: &[String]) -> Vec<Option<Value>> {
    over.iter()
        .map(|name| row.parameters.get(name).cloned())
        .collect()
}

/// Whether all its members count: of a set with a stopped waveform the others alone say nothing comparable.
fn is_whole(row: &SetRow) -> bool {
    row.n == row.of
}

fn number(row: &SetRow, name: &str) -> Option<f64> {
    row.results
        .get(name)
        .copied()
        .flatten()
        .filter(|_| is_whole(row))
}

/// The mean; `None` if any value is missing or there is none.
fn mean(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let values: Vec<f64> = values.collect::<Option<_>>()?;
    let n = values.len() as f64;
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / n)
}

/// Adds to each setting of a scene whether it is worth its cost.
fn judged(mut rows: Vec<SetRow>, model: Model) -> Vec<SetRow> {
    let trade = |row: &SetRow| {
        let get = |name: &str| row.results.get(name).copied().flatten();
        let size = |judged: &Judged| {
            let name = format!("{}_deviation", judged.name);
            get(&format!("{name}_bound")).or_else(|| get(&name).map(f64::abs))
        };
        Some(Trade {
            cost: get("core_seconds")? + get("preparation_core_seconds").unwrap_or_default(),
            errors: model.judged().iter().map(size).collect::<Option<_>>()?,
        })
    };
    // What stopped or is still to come is neither on the front nor behind it.
    let whole = |row: &SetRow| row.n == row.of && !row.provisional;
    let trades: Vec<Option<Trade>> = rows
        .iter()
        .map(|row| trade(row).filter(|_| whole(row)))
        .collect();
    let known: Vec<Trade> = trades.iter().flatten().cloned().collect();
    let mut on_front = front(&known).into_iter();
    for (row, trade) in rows.iter_mut().zip(&trades) {
        let verdict = match trade {
            Some(_) if on_front.next() == Some(true) => "front",
            Some(_) => "beaten",
            None if row.provisional => continue,
            None => "incomplete",
        };
        if row.verdict.is_none() {
            row.verdict = Some(verdict.to_owned());
        }
    }
    rows
}

#[cfg(test)]
mod tests;
