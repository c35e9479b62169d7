//! Reductions: pure functions from points to sets, and from sets to means.
//!
//! They apply to whatever has finished, in point order, so a half-done sweep shows provisional values with `n` of `of`.

use std::collections::{BTreeMap, HashMap};

use granary_api::table::SetRow;
use granary_core::memory::score::{Dots, Processing, Score};
use serde_json::{Map, Value};

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
    /// E \[Pa\], δ0 and γ0.
    pub scale: [f64; 3],
}

/// Collects members into sets, in the order in which the sets first appear.
#[derive(Debug)]
pub struct Scorer {
    over: Vec<String>,
    processing: Processing,
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
}

impl Scorer {
    /// No sets yet.
    #[must_use]
    pub fn new(over: &[String], processing: Processing) -> Self {
        Self {
            over: over.to_vec(),
            processing,
            places: HashMap::new(),
            sets: vec![],
        }
    }

    /// Adds one point to its set.
    pub fn add(&mut self, member: &Member) {
        let key = key(&member.parameters, &self.over);
        let place = *self.places.entry(key).or_insert_with(|| {
            self.sets.push(Collected {
                parameters: without(&member.parameters, &self.over),
                scale: member.scale,
                dots: Dots::default(),
                n: 0,
                of: 0,
                open: false,
                done: 0,
                awaits_zero: false,
            });
            self.sets.len() - 1
        });
        let set = &mut self.sets[place];
        set.of += 1;
        set.open |= member.open;
        set.done += u64::from(member.done);
        set.awaits_zero |= member.done && member.open;
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
    ];
    SetRow {
        set: 0,
        reduce: "gain_fidelity".to_owned(),
        processing: Some(processing.name().to_owned()),
        parameters: set.parameters,
        results: results
            .into_iter()
            .map(|(name, value)| (name.to_owned(), value))
            .collect(),
        n: set.n,
        of: set.of,
        provisional: set.open,
        missing_reason: reason,
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
        0 => "no member has an outcome",
        _ => match Score::missing_reason(&set.dots) {
            Some(reason) if set.open => return Some(so_far(reason)),
            Some(reason) => reason,
            None if !set.open && set.n < set.of => {
                return Some(format!(
                    "{} of {} members are missing: failed or cancelled",
                    set.of - set.n,
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
    let mut places: HashMap<String, usize> = HashMap::new();
    let mut groups: Vec<(Map<String, Value>, Vec<&SetRow>)> = vec![];
    for set in sets {
        let key = format!("{:?} {}", set.processing, key(&set.parameters, over));
        let place = *places.entry(key).or_insert_with(|| {
            groups.push((without(&set.parameters, over), vec![]));
            groups.len() - 1
        });
        groups[place].1.push(set);
    }
    groups
        .into_iter()
        .map(|(parameters, members)| mean(parameters, &members))
        .collect()
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
    let null = results.values().any(Option::is_none);
    SetRow {
        set: 0,
        reduce: "mean_sem".to_owned(),
        processing: members[0].processing.clone(),
        parameters,
        n: counted.len() as u64,
        of: members.len() as u64,
        provisional,
        missing_reason: mean_reason(members, &counted, provisional, null),
        results,
    }
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
    null: bool,
) -> Option<String> {
    let of_some = |sets: &[&SetRow]| sets.iter().find_map(|set| set.missing_reason.clone());
    if provisional {
        return match counted.len() {
            0 => Some("no member has a number yet".to_owned()),
            1 => Some(so_far("one member has no standard error of the mean")),
            _ if null => of_some(counted),
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
        1 => Some("one member has no standard error of the mean".to_owned()),
        _ if null => of_some(counted),
        _ => None,
    };
    match (own, missing) {
        (Some(own), Some(missing)) => Some(format!("{own}; {missing}")),
        (own, missing) => own.or(missing),
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
fn key(parameters: &Map<String, Value>, over: &[String]) -> String {
    let mut key = String::new();
    for (name, value) in parameters.iter().filter(|(name, _)| !over.contains(name)) {
        key.push_str(name);
        key.push(' ');
        key.push_str(&value.to_string());
        key.push(' ');
    }
    key
}

fn without(parameters: &Map<String, Value>, over: &[String]) -> Map<String, Value> {
    let kept = parameters.iter().filter(|(name, _)| !over.contains(name));
    kept.map(|(name, value)| (name.clone(), value.clone()))
        .collect()
}

#[cfg(test)]
mod tests;
