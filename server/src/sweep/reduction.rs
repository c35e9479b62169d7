//! Reductions of a sweep: which points are scored together, and over what means are taken.

use std::collections::BTreeMap;

use granary_core::memory::score::Processing;
use granary_core::model::Model;
use granary_core::parameter::shown;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::mistakes::{Mistakes, nearest, pointer, unknown};
use super::study::Study;

/// One link of a chain of reductions.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Reduction {
    /// Gain, fidelity and correlation of all points that differ in `over` only; one set per processing.
    GainFidelity {
        /// Parameters.
        over: Vec<String>,
        /// Ways to process a signal.
        processing: Vec<Processing>,
    },
    /// Mean and its standard error of the points, or of the sets of the link before.
    MeanSem {
        /// Parameters.
        over: Vec<String>,
    },
    /// Eq. (4) through the strengths of the points, or of the sets of the link before.
    UltimateStrengthFit {
        /// Parameters, friction among them.
        over: Vec<String>,
    },
    /// How far each setting of a study is from the first of them, and what it costs.
    Study {
        /// Parameters, such as the seed of the packing: settings are compared at equal values of them.
        over: Vec<String>,
        /// The reference first.
        settings: Vec<Studied>,
    },
}

/// A setting of a study.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Studied {
    /// What tables call it: `time_step 0.5`.
    pub label: String,
    /// The parameters in which settings differ, in the order in which the study first names them.
    pub values: Map<String, Value>,
}

impl Reduction {
    /// The name in specs and tables.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::GainFidelity { .. } => "gain_fidelity",
            Self::MeanSem { .. } => "mean_sem",
            Self::UltimateStrengthFit { .. } => "ultimate_strength_fit",
            Self::Study { .. } => "study",
        }
    }

    /// The parameters that it is taken over.
    #[must_use]
    pub fn over(&self) -> &[String] {
        match self {
            Self::GainFidelity { over, .. }
            | Self::MeanSem { over }
            | Self::UltimateStrengthFit { over }
            | Self::Study { over, .. } => over,
        }
    }

    /// Whether the zero waveform must be recalled in every trained pack.
    #[must_use]
    pub fn needs_zero(&self) -> bool {
        matches!(self, Self::GainFidelity { processing, .. } if processing.iter().any(|p| p.needs_zero()))
    }
}

/// The kinds of reductions of a model, those that a chain may begin with first.
fn kinds(model: Model) -> &'static [Kind] {
    match model {
        Model::Memory => &[Kind::GainFidelity, Kind::MeanSem],
        Model::Beam => &[Kind::MeanSem, Kind::UltimateStrengthFit],
    }
}

/// A reduction without what it says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    GainFidelity,
    MeanSem,
    UltimateStrengthFit,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::GainFidelity => "gain_fidelity",
            Self::MeanSem => "mean_sem",
            Self::UltimateStrengthFit => "ultimate_strength_fit",
        }
    }

    /// The parameter that it is taken over where nobody says.
    fn usual_over(self) -> &'static str {
        match self {
            Self::GainFidelity => "waveform",
            Self::MeanSem => "packing_seed",
            Self::UltimateStrengthFit => FRICTION,
        }
    }
}

/// The parameter of Eq. (4).
const FRICTION: &str = "friction_coefficient";
/// The fewest strengths that Eq. (4) is fitted to.
const LEAST_STRENGTHS: usize = 4;
/// What a score is scaled by; one set cannot have several values of it.
const SCALES: [&str; 3] = ["youngs_modulus", "delta0", "gamma0"];

/// The model's usual chain, for a sweep with these axes.
pub(crate) fn usual(model: Model, axes: &BTreeMap<&str, Vec<Value>>) -> Vec<Reduction> {
    let mut chain = vec![];
    if model == Model::Memory {
        chain.push(Reduction::GainFidelity {
            over: vec!["waveform".to_owned()],
            processing: vec![Processing::Sub0],
        });
    }
    if axes.contains_key("packing_seed") {
        chain.push(Reduction::MeanSem {
            over: vec!["packing_seed".to_owned()],
        });
    }
    let frictions = axes.get(FRICTION).map_or(0, Vec::len);
    if model == Model::Beam && frictions >= LEAST_STRENGTHS {
        chain.push(Reduction::UltimateStrengthFit {
            over: vec![FRICTION.to_owned()],
        });
    }
    chain
}

/// What a study looks at where the spec does not say.
pub(crate) fn before_study(model: Model) -> Vec<Reduction> {
    usual(model, &BTreeMap::new())
}

/// The last link of a study's chain, whose other links are `before`.
pub(crate) fn study(
    study: &Study,
    before: &[Reduction],
    axes: &BTreeMap<&str, Vec<Value>>,
    mistakes: &mut Mistakes,
) -> Reduction {
    for (k, link) in before.iter().enumerate() {
        if !matches!(link, Reduction::GainFidelity { .. }) {
            let at = pointer(&pointer("/reduce", &k.to_string()), "kind");
            let name = link.name();
            mistakes.add(
                &at,
                format!("a study takes its means itself: leave {name} out"),
            );
        }
    }
    let over = axes.contains_key("packing_seed");
    Reduction::Study {
        over: over
            .then(|| "packing_seed".to_owned())
            .into_iter()
            .collect(),
        settings: study
            .settings
            .iter()
            .map(|setting| setting.studied.clone())
            .collect(),
    }
}

/// Reads `[[reduce]]`; `axes` are the values that each axis takes, `fixed` the parameters without one.
pub(crate) fn read(
    value: &Value,
    model: Model,
    axes: &BTreeMap<&str, Vec<Value>>,
    fixed: &Map<String, Value>,
    mistakes: &mut Mistakes,
) -> Vec<Reduction> {
    let Some(tables) = value.as_array() else {
        mistakes.add(
            "/reduce",
            format!("{} is not a list of tables: write [[reduce]]", shown(value)),
        );
        return vec![];
    };
    if tables.len() > 8 {
        mistakes.add(
            "/reduce",
            format!("{} reductions: there may be at most 8", tables.len()),
        );
        return vec![];
    }
    let mut chain: Vec<Reduction> = vec![];
    for (k, table) in tables.iter().enumerate() {
        let at = pointer("/reduce", &k.to_string());
        let Some(link) = link(table, model, &at, mistakes) else {
            continue;
        };
        rules(&link, model, &chain, &at, axes, mistakes);
        if second_cycle_is_missing(&link, axes, fixed) {
            mistakes.add(
                &pointer(&at, "processing"),
                "SUB2 and SUB2-BL need the second cycle, but second_cycle is false",
            );
        }
        chain.push(link);
    }
    chain
}

fn link(value: &Value, model: Model, at: &str, mistakes: &mut Mistakes) -> Option<Reduction> {
    let Some(table) = value.as_object() else {
        mistakes.add(at, format!("{} is not a table", shown(value)));
        return None;
    };
    let written = table
        .get("kind")
        .and_then(Value::as_str)
        .unwrap_or_default();
    let Some(&kind) = kinds(model).iter().find(|kind| kind.name() == written) else {
        let names = kinds(model).iter().map(|kind| kind.name());
        mistakes.add(&pointer(at, "kind"), unknown("reduction", written, names));
        return None;
    };
    let scores = kind == Kind::GainFidelity;
    let allowed = ["kind", "over"]
        .into_iter()
        .chain(scores.then_some("processing"));
    for key in table
        .keys()
        .filter(|key| !allowed.clone().any(|name| name == *key))
    {
        mistakes.add(
            &pointer(at, key),
            unknown("field of this reduction", key, allowed.clone()),
        );
    }
    let over = over(table.get("over"), (model, kind), at, mistakes)?;
    match kind {
        Kind::GainFidelity => {}
        Kind::MeanSem => return Some(Reduction::MeanSem { over }),
        Kind::UltimateStrengthFit => return Some(Reduction::UltimateStrengthFit { over }),
    }
    let processing = processing(
        table.get("processing"),
        &pointer(at, "processing"),
        mistakes,
    )?;
    Some(Reduction::GainFidelity { over, processing })
}

fn over(
    value: Option<&Value>,
    (model, kind): (Model, Kind),
    at: &str,
    mistakes: &mut Mistakes,
) -> Option<Vec<String>> {
    let usual = json!([kind.usual_over()]);
    let scores = kind == Kind::GainFidelity;
    let names = words(value.unwrap_or(&usual));
    let at = pointer(at, "over");
    let Some(names) = names.filter(|names| !names.is_empty()) else {
        mistakes.add(
            &at,
            format!(
                "{} is not a list of parameters",
                shown(value.unwrap_or(&usual))
            ),
        );
        return None;
    };
    let known = || model.parameters().iter().map(|row| row.name);
    for (k, name) in names.iter().enumerate() {
        let place = pointer(&at, &k.to_string());
        if model.parameter(name).is_none() {
            let detail = match nearest(name, known()) {
                Some(near) => format!(
                    "{} is not a parameter; did you mean {near}?",
                    shown(&json!(name))
                ),
                None => format!("{} is not a parameter", shown(&json!(name))),
            };
            mistakes.add(&place, detail);
        } else if names[..k].contains(name) {
            mistakes.add(&place, format!("{name} is named twice"));
        } else if scores && SCALES.contains(&name.as_str()) {
            mistakes.add(
                &place,
                format!(
                    "a gain is scaled by {name}, so it cannot be taken over several values of it"
                ),
            );
        }
    }
    Some(names)
}

fn processing(value: Option<&Value>, at: &str, mistakes: &mut Mistakes) -> Option<Vec<Processing>> {
    let usual = json!(["SUB0"]);
    let value = value.unwrap_or(&usual);
    let Some(names) = words(value).filter(|names| !names.is_empty()) else {
        mistakes.add(
            at,
            format!("{} is not a list of SUB0, SUB2, SUB2-BL", shown(value)),
        );
        return None;
    };
    let known = || Processing::ALL.into_iter().map(|(name, _)| name);
    let mut found = vec![];
    for (k, name) in names.iter().enumerate() {
        let place = pointer(at, &k.to_string());
        match Processing::ALL.into_iter().find(|(known, _)| known == name) {
            None => mistakes.add(&place, unknown("processing", name, known())),
            Some((_, p)) if found.contains(&p) => {
                mistakes.add(&place, format!("{name} is named twice"));
            }
            Some((_, p)) => found.push(p),
        }
    }
    (found.len() == names.len()).then_some(found)
}

/// One word or a list of at most 64.
fn words(value: &Value) -> Option<Vec<String>> {
    match value {
        Value::String(word) => Some(vec![word.clone()]),
        Value::Array(list) if list.len() <= 64 => list
            .iter()
            .map(|word| word.as_str().map(str::to_owned))
            .collect(),
        _ => None,
    }
}

/// The rules between the links of a chain, and between a link and the axes.
fn rules(
    link: &Reduction,
    model: Model,
    before: &[Reduction],
    at: &str,
    axes: &BTreeMap<&str, Vec<Value>>,
    mistakes: &mut Mistakes,
) {
    let scores = matches!(link, Reduction::GainFidelity { .. });
    if model == Model::Memory && scores != before.is_empty() {
        mistakes.add(
            &pointer(at, "kind"),
            "a chain starts with gain_fidelity, and mean_sem follows it",
        );
    }
    if let Reduction::UltimateStrengthFit { over } = link {
        strengths(over, before, at, mistakes);
    }
    for (k, name) in link.over().iter().enumerate() {
        let place = pointer(&pointer(at, "over"), &k.to_string());
        if before.iter().any(|link| link.over().contains(name)) {
            mistakes.add(
                &place,
                format!("{name} is gone: an earlier reduction was taken over it"),
            );
        } else if !scores && model.parameter(name).is_some() && !axes.contains_key(name.as_str()) {
            let what = match link {
                Reduction::UltimateStrengthFit { .. } => "fit",
                _ => "mean",
            };
            mistakes.add(
                &place,
                format!("{name} is not an axis of this sweep, so there is no {what} over it"),
            );
        }
    }
}

/// The rules of a fit of Eq. (4).
fn strengths(over: &[String], before: &[Reduction], at: &str, mistakes: &mut Mistakes) {
    if !over.iter().any(|name| name == FRICTION) {
        mistakes.add(
            &pointer(at, "over"),
            format!("Eq. (4) is a law of {FRICTION}: the fit must be taken over it"),
        );
    }
    let fit = |link: &Reduction| matches!(link, Reduction::UltimateStrengthFit { .. });
    if before.iter().any(fit) {
        mistakes.add(
            &pointer(at, "kind"),
            "an earlier fit has used up the strengths: a chain may have one",
        );
    }
}

fn second_cycle_is_missing(
    link: &Reduction,
    axes: &BTreeMap<&str, Vec<Value>>,
    fixed: &Map<String, Value>,
) -> bool {
    let Reduction::GainFidelity { processing, .. } = link else {
        return false;
    };
    let off = Value::Bool(false);
    let missing = match axes.get("second_cycle") {
        Some(values) => values.contains(&off),
        None => fixed.get("second_cycle") == Some(&off),
    };
    missing && processing.iter().any(|p| !p.needs_zero())
}
