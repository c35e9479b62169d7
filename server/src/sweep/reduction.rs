//! Reductions of a sweep: which points are scored together, and over what means are taken.

use std::collections::BTreeMap;

use granary_core::memory::classifier::ClassifierSpec;
use granary_core::memory::score::Processing;
use granary_core::memory::waveform::Waveform;
use granary_core::model::Model;
use granary_core::parameter::shown;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::mistakes::{Mistakes, nearest, pointer, unknown};
use super::study::Study;
use super::{Axis, recognition};

/// One link of a chain of reductions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Reduction {
    /// Gain, fidelity and correlation of all points that differ in `over` only; one set per processing.
    GainFidelity {
        /// Parameters.
        over: Vec<String>,
        /// Ways to process a signal.
        processing: Vec<Processing>,
        /// Whether the sweep has binary words of several lengths: those of each length are sets of their own.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        by_length: bool,
    },
    /// Which words classifiers take the recalled signals of a set for; one set per processing.
    Recognition {
        /// Parameters, the waveform among them.
        over: Vec<String>,
        /// Ways to process a signal.
        processing: Vec<Processing>,
        /// One for each training, of each length.
        classifiers: Vec<ClassifierSpec>,
        /// As above.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        by_length: bool,
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
            Self::Recognition { .. } => "recognition",
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
            | Self::Recognition { over, .. }
            | Self::MeanSem { over }
            | Self::UltimateStrengthFit { over }
            | Self::Study { over, .. } => over,
        }
    }

    /// How signals are processed, of a reduction that sees signals.
    #[must_use]
    pub fn processing(&self) -> Option<&[Processing]> {
        match self {
            Self::GainFidelity { processing, .. } | Self::Recognition { processing, .. } => {
                Some(processing)
            }
            _ => None,
        }
    }

    /// Whether binary words of each length are sets of their own.
    #[must_use]
    pub fn by_length(&self) -> bool {
        matches!(
            self,
            Self::GainFidelity {
                by_length: true,
                ..
            } | Self::Recognition {
                by_length: true,
                ..
            }
        )
    }

    /// Whether the zero waveform must be recalled in every trained pack.
    #[must_use]
    pub fn needs_zero(&self) -> bool {
        let processing = self.processing().unwrap_or_default();
        processing.iter().any(|processing| processing.needs_zero())
    }

    /// Whether recalls must have a second cycle.
    #[must_use]
    pub fn needs_second_cycle(&self) -> bool {
        let processing = self.processing().unwrap_or_default();
        processing.iter().any(|processing| !processing.needs_zero())
    }

    /// The classifiers that it asks.
    #[must_use]
    pub fn classifiers(&self) -> &[ClassifierSpec] {
        match self {
            Self::Recognition { classifiers, .. } => classifiers,
            _ => &[],
        }
    }
}

/// The kinds of reductions of a model, those that a chain may begin with first.
fn kinds(model: Model) -> &'static [Kind] {
    match model {
        Model::Memory => &[Kind::GainFidelity, Kind::Recognition, Kind::MeanSem],
        Model::Beam => &[Kind::MeanSem, Kind::UltimateStrengthFit],
    }
}

/// A reduction without what it says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    GainFidelity,
    Recognition,
    MeanSem,
    UltimateStrengthFit,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::GainFidelity => "gain_fidelity",
            Self::Recognition => "recognition",
            Self::MeanSem => "mean_sem",
            Self::UltimateStrengthFit => "ultimate_strength_fit",
        }
    }

    /// Whether it sees signals, and so comes before what is taken of its numbers.
    fn sees_signals(self) -> bool {
        matches!(self, Self::GainFidelity | Self::Recognition)
    }

    /// Its fields in specs.
    fn fields(self) -> &'static [&'static str] {
        match self {
            Self::GainFidelity => &["kind", "over", "processing"],
            Self::Recognition => &["kind", "over", "processing", "classifier", "trainings"],
            Self::MeanSem | Self::UltimateStrengthFit => &["kind", "over"],
        }
    }

    /// The parameter that it is taken over where nobody says.
    fn usual_over(self) -> &'static str {
        match self {
            Self::GainFidelity | Self::Recognition => "waveform",
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
pub(crate) fn usual(about: &About<'_>) -> Vec<Reduction> {
    let (model, axes) = (about.model, about.axes);
    let by_length = about.has_several_lengths();
    let mut chain = vec![];
    if model == Model::Memory {
        chain.push(Reduction::GainFidelity {
            over: vec!["waveform".to_owned()],
            processing: vec![Processing::Sub0],
            by_length,
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
pub(crate) fn before_study(about: &About<'_>) -> Vec<Reduction> {
    let without_axes = About {
        axes: &BTreeMap::new(),
        ..*about
    };
    usual(&without_axes)
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

/// What reductions are about.
pub(crate) struct About<'a> {
    pub(crate) model: Model,
    /// Some values that each axis takes.
    pub(crate) axes: &'a BTreeMap<&'a str, Vec<Value>>,
    /// All of them.
    pub(crate) grids: &'a [Vec<Axis>],
    /// The parameters without an axis.
    pub(crate) fixed: &'a Map<String, Value>,
}

impl About<'_> {
    /// Every waveform of the sweep.
    pub(crate) fn waveforms(&self) -> impl Iterator<Item = &Value> {
        let of_grid = |grid: &'_ Vec<Axis>| grid.iter().all(|axis| axis.name != "waveform");
        let fixed = self.fixed.get("waveform");
        let fixed = fixed.filter(|_| self.grids.iter().any(of_grid));
        let axes = self.grids.iter().flatten();
        let axes = axes.filter(|axis| axis.name == "waveform");
        axes.flat_map(|axis| &axis.values).chain(fixed)
    }

    fn has_several_lengths(&self) -> bool {
        let mut lengths = self.waveforms().filter_map(|value| bits(Some(value)));
        let first = lengths.next();
        lengths.any(|length| Some(length) != first)
    }
}

/// L of a binary word.
pub(crate) fn bits(waveform: Option<&Value>) -> Option<u32> {
    match Waveform::parse(waveform?) {
        Ok(Waveform::BinaryWord { bits, .. }) => Some(u32::from(bits)),
        _ => None,
    }
}

/// Reads `[[reduce]]`.
pub(crate) fn read(value: &Value, about: &About<'_>, mistakes: &mut Mistakes) -> Vec<Reduction> {
    let About {
        model, axes, fixed, ..
    } = *about;
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
        let Some(link) = link(table, about, &at, mistakes) else {
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

fn link(value: &Value, about: &About<'_>, at: &str, mistakes: &mut Mistakes) -> Option<Reduction> {
    let model = about.model;
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
    let fields = || kind.fields().iter().copied();
    for key in table
        .keys()
        .filter(|key| !fields().any(|name| name == *key))
    {
        mistakes.add(
            &pointer(at, key),
            unknown("field of this reduction", key, fields()),
        );
    }
    let over = over(table.get("over"), (model, kind), at, mistakes)?;
    let processing = |usual: Value, mistakes: &mut Mistakes| {
        let written = table.get("processing").unwrap_or(&usual);
        processing(written, &pointer(at, "processing"), mistakes)
    };
    match kind {
        Kind::MeanSem => Some(Reduction::MeanSem { over }),
        Kind::UltimateStrengthFit => Some(Reduction::UltimateStrengthFit { over }),
        Kind::GainFidelity => {
            let processing = processing(json!(["SUB0"]), mistakes)?;
            Some(Reduction::GainFidelity {
                over,
                processing,
                by_length: about.has_several_lengths(),
            })
        }
        Kind::Recognition => {
            let classifiers = recognition::read(table, &over, about, at, mistakes);
            let processing = processing(json!(["SUB2-BL"]), mistakes)?;
            Some(Reduction::Recognition {
                over,
                processing,
                classifiers: classifiers?,
                by_length: about.has_several_lengths(),
            })
        }
    }
}

fn over(
    value: Option<&Value>,
    (model, kind): (Model, Kind),
    at: &str,
    mistakes: &mut Mistakes,
) -> Option<Vec<String>> {
    let usual = json!([kind.usual_over()]);
    let scores = kind.sees_signals();
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

fn processing(value: &Value, at: &str, mistakes: &mut Mistakes) -> Option<Vec<Processing>> {
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
    let sees_signals = |link: &Reduction| link.processing().is_some();
    let scores = sees_signals(link);
    let place_is_right = if scores {
        before.iter().all(sees_signals)
    } else {
        !before.is_empty()
    };
    if model == Model::Memory && !place_is_right {
        mistakes.add(
            &pointer(at, "kind"),
            "a chain starts with gain_fidelity or recognition, and mean_sem follows them",
        );
    }
    if scores && before.iter().any(|other| other.name() == link.name()) {
        let detail = format!(
            "{} is there already: name every processing in one",
            link.name()
        );
        mistakes.add(&pointer(at, "kind"), detail);
    }
    if let Reduction::UltimateStrengthFit { over } = link {
        strengths(over, before, at, mistakes);
    }
    for (k, name) in link.over().iter().enumerate() {
        let place = pointer(&pointer(at, "over"), &k.to_string());
        if !scores && before.iter().any(|link| link.over().contains(name)) {
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
    let off = Value::Bool(false);
    let missing = match axes.get("second_cycle") {
        Some(values) => values.contains(&off),
        None => fixed.get("second_cycle") == Some(&off),
    };
    missing && link.needs_second_cycle()
}
