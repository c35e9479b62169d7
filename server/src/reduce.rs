//! Reductions: pure functions from points to sets, and from sets to means.
//!
//! They apply to whatever has finished, in point order, so a half-done sweep shows provisional values with `n` of `of`.

use std::collections::{BTreeMap, HashMap};

use granary_api::table::SetRow;
use granary_core::memory::score::{Dots, Processing, Score};
use serde_json::{Map, Value};

use crate::sweep::reduction::bits;

pub mod recognition;
pub mod strength;
pub mod study;

/// One point as a score sees it.
#[derive(Clone, Debug)]
pub struct Member {
    /// The parameters that vary in the sweep.
    pub parameters: Map<String, Value>,
    /// Whether it, or the zero waveform that it is compared with, is still to be done.
    pub open: bool,
    /// Its dot products, if everything they need is there.
    pub dots: Option<Dots>,
    /// Whether it has an outcome, with dot products or without.
    pub done: bool,
    /// What stopped it, in a word, if it has failed.
    pub failure: Option<String>,
    /// E \[Pa\], δ0 and γ0.
    pub scale: [f64; 3],
}

/// Collects members into sets, in the order in which the sets first appear.
#[derive(Debug)]
pub struct Scorer {
    over: Vec<String>,
    processing: Processing,
    by_length: bool,
    places: HashMap<String, usize>,
    sets: Vec<Collected>,
}

#[derive(Debug)]
struct Collected {
    parameters: Map<String, Value>,
    scale: [f64; 3],
    dots: Dots,
    n: u64,
    of: u64,
    open: bool,
    /// Members with an outcome of their own.
    done: u64,
    /// Whether a member is done and the zero waveform that it is compared with is not.
    awaits_zero: bool,
    /// What stopped the first member that has failed.
    failure: Option<String>,
}

impl Scorer {
    /// No sets yet; `by_length` keeps words of different lengths apart.
    #[must_use]
    pub fn new(over: &[String], processing: Processing, by_length: bool) -> Self {
        Self {
            over: over.to_vec(),
            processing,
            by_length,
            places: HashMap::new(),
            sets: vec![],
        }
    }

    /// Adds one point to its set.
    pub fn add(&mut self, member: &Member) {
        let length = length(&member.parameters, self.by_length);
        let key = set_key(&member.parameters, &self.over, length);
        let place = *self.places.entry(key).or_insert_with(|| {
            self.sets.push(Collected {
                parameters: set_parameters(&member.parameters, &self.over, length),
                scale: member.scale,
                dots: Dots::default(),
                n: 0,
                of: 0,
                open: false,
                done: 0,
                awaits_zero: false,
                failure: None,
            });
            self.sets.len() - 1
        });
        let set = &mut self.sets[place];
        set.of += 1;
        set.open |= member.open;
        set.done += u64::from(member.done);
        set.awaits_zero |= member.done && member.open;
        if set.failure.is_none() {
            set.failure.clone_from(&member.failure);
        }
        if let Some(dots) = member.dots {
            set.n += 1;
            set.dots += dots;
        }
    }

    /// The sets, unnumbered.
    #[must_use]
    pub fn finish(self) -> Vec<SetRow> {
        let processing = self.processing;
        self.sets
            .into_iter()
            .map(|set| scored(set, processing))
            .collect()
    }
}

fn scored(set: Collected, processing: Processing) -> SetRow {
    let [youngs_modulus, delta0, gamma0] = set.scale;
    let score = Score::of(&set.dots, youngs_modulus, delta0, gamma0);
    let reason = score_reason(&set);
    let results = [
        ("gain", score.gain),
        ("gain_e_delta0", score.gain_e_delta0),
        ("fidelity", score.fidelity),
        ("correlation", score.correlation),
        ("rounding_error", score.rounding_error),
        ("noise_to_signal", score.noise_to_signal),
    ];
    SetRow {
        set: 0,
        reduce: "gain_fidelity".to_owned(),
        processing: Some(processing.name().to_owned()),
        shape: None,
        setting: None,
        verdict: None,
        parameters: set.parameters,
        results: results
            .into_iter()
            .map(|(name, value)| (name.to_owned(), value))
            .collect(),
        n: set.n,
        of: set.of,
        provisional: set.open,
        missing_reason: reason,
        warning: score.warning(),
        confused: vec![],
    }
}

/// Why a number is missing, or, once nothing is still to come, why members are.
fn score_reason(set: &Collected) -> Option<String> {
    let text = match set.n {
        0 if set.awaits_zero => {
            "the zero waveform that the signals are compared with is not done yet"
        }
        0 if set.done > 0 => {
            "what the signals are compared with is missing: the zero waveform has failed"
        }
        0 if set.open => "no member is done yet",
        0 => match &set.failure {
            Some(failure) => return Some(format!("no member has an outcome: {failure}")),
            None => "no member has an outcome",
        },
        _ => match Score::missing_reason(&set.dots) {
            Some(reason) if set.open => return Some(so_far(reason)),
            Some(reason) => reason,
            None if !set.open && set.n < set.of => {
                let why = set.failure.as_deref().unwrap_or("failed or cancelled");
                let missing = set.of - set.n;
                return Some(format!(
                    "{missing} of {} members are missing: {why}",
                    set.of
                ));
            }
            None => return None,
        },
    };
    Some(text.to_owned())
}

/// A reason that members to come may take away.
fn so_far(reason: &str) -> String {
    format!("so far: {reason}")
}

/// Mean and standard error of the mean of the sets that differ in `over` only.
#[must_use]
pub fn mean_sem(sets: &[SetRow], over: &[String]) -> Vec<SetRow> {
    let groups = groups(sets, over).into_iter();
    groups
        .map(|(parameters, members)| mean(parameters, &members))
        .collect()
}

/// The parameters that the members of a group have in common, and the members.
type Group<'a> = (Map<String, Value>, Vec<&'a SetRow>);

/// The sets that differ in `over` only, in the order in which each group first appears.
fn groups<'a>(sets: &'a [SetRow], over: &[String]) -> Vec<Group<'a>> {
    let mut places: HashMap<String, usize> = HashMap::new();
    let mut groups: Vec<Group<'_>> = vec![];
    for set in sets {
        // Scores and recognitions of one processing stand side by side.
        let recognized = set.results.contains_key("recognition_accuracy");
        let key = format!(
            "{:?} {recognized} {}",
            set.processing,
            key(&set.parameters, over)
        );
        let place = *places.entry(key).or_insert_with(|| {
            groups.push((without(&set.parameters, over), vec![]));
            groups.len() - 1
        });
        groups[place].1.push(set);
    }
    groups
}

fn mean(parameters: Map<String, Value>, members: &[&SetRow]) -> SetRow {
    let mut results = BTreeMap::new();
    let names = members[0]
        .results
        .keys()
        .filter(|name| !name.ends_with("_sem"));
    for name in names {
        let values: Vec<f64> = members
            .iter()
            .filter_map(|set| set.results.get(name).copied().flatten())
            .collect();
        let (mean, sem) = moments(&values);
        results.insert(name.clone(), mean);
        results.insert(format!("{name}_sem"), sem);
    }
    let counted: Vec<&SetRow> = members.iter().copied().filter(|set| counts(set)).collect();
    let provisional = members.iter().any(|set| set.provisional);
    let count = |name: &String| {
        let has = |set: &&&SetRow| set.results.get(name).copied().flatten().is_some();
        members.iter().filter(has).count()
    };
    let null = results.values().any(Option::is_none);
    let partial = results
        .keys()
        .filter(|name| !name.ends_with("_sem"))
        .any(|name| (1..counted.len()).contains(&count(name)));
    let gaps = Gaps { null, partial };
    SetRow {
        set: 0,
        reduce: "mean_sem".to_owned(),
        processing: members[0].processing.clone(),
        shape: None,
        setting: None,
        verdict: None,
        parameters,
        n: counted.len() as u64,
        of: members.len() as u64,
        provisional,
        missing_reason: mean_reason(members, &counted, provisional, gaps),
        warning: warning_of(&counted),
        confused: vec![],
        results,
    }
}

/// What a reader of numbers taken from these should know: the first warning, and of how many.
fn warning_of(members: &[&SetRow]) -> Option<String> {
    let warnings: Vec<&String> = members
        .iter()
        .filter_map(|set| set.warning.as_ref())
        .collect();
    let first = warnings.first()?;
    Some(format!(
        "{} of {} members: {first}",
        warnings.len(),
        members.len()
    ))
}

/// What the results of a mean lack.
#[derive(Clone, Copy)]
struct Gaps {
    /// A number is missing.
    null: bool,
    /// A number is the mean of fewer members than count.
    partial: bool,
}

/// Whether a set has any number for a mean.
fn counts(set: &SetRow) -> bool {
    set.results.values().any(Option::is_some)
}

/// Why a number of a mean is missing, or, once nothing is still to come, why members are.
///
/// What is still to come is no reason for anything once a number is there, so a half-done mean never quotes
/// the reason of a member that it waits for.
fn mean_reason(
    members: &[&SetRow],
    counted: &[&SetRow],
    provisional: bool,
    gaps: Gaps,
) -> Option<String> {
    let of_some = |sets: &[&SetRow]| sets.iter().find_map(|set| set.missing_reason.clone());
    if provisional {
        return match counted.len() {
            0 => Some("no member has a number yet".to_owned()),
            1 => Some(so_far(&alone(counted[0]))),
            _ if gaps.null => of_some(counted),
            _ => None,
        };
    }
    let absent: Vec<&SetRow> = members.iter().copied().filter(|set| !counts(set)).collect();
    let missing = of_some(&absent).map(|reason| match counted.len() {
        0 => reason,
        _ => format!(
            "{} of {} members have no number: {reason}",
            absent.len(),
            members.len()
        ),
    });
    let own = match counted.len() {
        1 => Some(alone(counted[0])),
        _ if gaps.null => of_some(counted),
        _ if gaps.partial => {
            of_some(counted).map(|reason| format!("some numbers are of fewer members: {reason}"))
        }
        _ => None,
    };
    match (own, missing) {
        (Some(own), Some(missing)) => Some(format!("{own}; {missing}")),
        (own, missing) => own.or(missing),
    }
}

/// Why the mean of one member lacks numbers.
fn alone(member: &SetRow) -> String {
    let no_error = "one member has no standard error of the mean";
    match &member.missing_reason {
        Some(reason) if !member.provisional => format!("{no_error}; {reason}"),
        _ => no_error.to_owned(),
    }
}

/// Mean and SEM = √(Σ(x − m)²/(n − 1)/n); `None` where there are too few values.
fn moments(values: &[f64]) -> (Option<f64>, Option<f64>) {
    let n = values.len() as f64;
    if values.is_empty() {
        return (None, None);
    }
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    (
        Some(mean),
        (values.len() > 1).then(|| (squares / (n - 1.0) / n).sqrt()),
    )
}

/// A text that two points have in common if they differ in `over` only.
pub(crate) fn key(parameters: &Map<String, Value>, over: &[String]) -> String {
    let mut key = String::new();
    for (name, value) in parameters.iter().filter(|(name, _)| !over.contains(name)) {
        key.push_str(name);
        key.push(' ');
        key.push_str(&value.to_string());
        key.push(' ');
    }
    key
}

/// The length of a point's word, where words of each are sets of their own.
pub(crate) fn length(parameters: &Map<String, Value>, by_length: bool) -> Option<u32> {
    by_length
        .then(|| bits(parameters.get("waveform")))
        .flatten()
}

/// A text that the points of one set have in common.
pub(crate) fn set_key(
    parameters: &Map<String, Value>,
    over: &[String],
    length: Option<u32>,
) -> String {
    let key = key(parameters, over);
    match length {
        Some(bits) => format!("{key}bits {bits} "),
        None => key,
    }
}

/// What the members of a set have in common: all but what it is taken over, and the length of its words.
pub(crate) fn set_parameters(
    parameters: &Map<String, Value>,
    over: &[String],
    length: Option<u32>,
) -> Map<String, Value> {
    let mut common = without(parameters, over);
    common.extend(length.map(|bits| ("bits".to_owned(), bits.into())));
    common
}

fn without(parameters: &Map<String, Value>, over: &[String]) -> Map<String, Value> {
    let kept = parameters.iter().filter(|(name, _)| !over.contains(name));
    kept.map(|(name, value)| (name.clone(), value.clone()))
        .collect()
}

#[cfg(test)]
mod tests;
