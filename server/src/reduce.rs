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
        let parameters = without(&member.parameters, &self.over);
        let key = Value::Object(parameters.clone()).to_string();
        let place = *self.places.entry(key).or_insert_with(|| {
            self.sets.push(Collected {
                parameters,
                scale: member.scale,
                dots: Dots::default(),
                n: 0,
                of: 0,
                open: false,
                done: 0,
            });
            self.sets.len() - 1
        });
        let set = &mut self.sets[place];
        set.of += 1;
        set.open |= member.open;
        set.done += u64::from(member.done);
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
    let reason = match set.n {
        0 if set.open => Some("no member is done yet"),
        0 if set.done > 0 => {
            Some("what the signals are compared with is missing: the zero waveform has failed")
        }
        0 => Some("no member has an outcome"),
        _ => Score::missing_reason(&set.dots),
    };
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
        missing_reason: reason.map(str::to_owned),
    }
}

/// Mean and standard error of the mean of the sets that differ in `over` only.
#[must_use]
pub fn mean_sem(sets: &[SetRow], over: &[String]) -> Vec<SetRow> {
    let mut places: HashMap<String, usize> = HashMap::new();
    let mut groups: Vec<(Map<String, Value>, Vec<&SetRow>)> = vec![];
    for set in sets {
        let parameters = without(&set.parameters, over);
        let key = format!("{:?}{}", set.processing, Value::Object(parameters.clone()));
        let place = *places.entry(key).or_insert_with(|| {
            groups.push((parameters, vec![]));
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
    let counts = |set: &&&SetRow| set.results.values().any(Option::is_some);
    let n = members.iter().filter(counts).count() as u64;
    let reason = match n {
        0 => members.iter().find_map(|set| set.missing_reason.clone()),
        1 => Some("one member has no standard error of the mean".to_owned()),
        _ => members.iter().find_map(|set| set.missing_reason.clone()),
    };
    SetRow {
        set: 0,
        reduce: "mean_sem".to_owned(),
        processing: members[0].processing.clone(),
        parameters,
        results,
        n,
        of: members.len() as u64,
        provisional: members.iter().any(|set| set.provisional),
        missing_reason: reason,
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

fn without(parameters: &Map<String, Value>, over: &[String]) -> Map<String, Value> {
    let kept = parameters.iter().filter(|(name, _)| !over.contains(name));
    kept.map(|(name, value)| (name.clone(), value.clone()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn member(seed: u64, waveform: &str, dots: Option<Dots>) -> Member {
        let parameters = json!({"packing_seed": seed, "waveform": waveform});
        Member {
            parameters: parameters.as_object().expect("an object").clone(),
            open: dots.is_none(),
            dots,
            done: dots.is_some(),
            scale: [1e7, 0.05, 1e-3],
        }
    }

    /// Dots of a signal that is `gain_e_delta0 γ0` times its J.
    fn recalled(gain_e_delta0: f64) -> Dots {
        let p = gain_e_delta0 * 1e-3;
        Dots {
            j_p: p,
            j_j: 1.0,
            p_p: p * p,
        }
    }

    fn scores(members: &[Member]) -> Vec<SetRow> {
        let mut scorer = Scorer::new(&["waveform".to_owned()], Processing::Sub0);
        for member in members {
            scorer.add(member);
        }
        scorer.finish()
    }

    #[test]
    fn half_done_set_is_provisional_with_the_members_it_has() {
        let sets = scores(&[
            member(1, "six/1", Some(recalled(1.5e5))),
            member(1, "six/2", None),
        ]);
        assert_eq!(
            (sets.len(), sets[0].n, sets[0].of, sets[0].provisional),
            (1, 1, 2, true)
        );
        let gain = sets[0].results["gain_e_delta0"].expect("one member is done");
        assert!((gain - 1.5e5).abs() < 1e-6);
    }

    #[test]
    fn mean_over_packings_has_the_standard_error_of_two_and_none_of_one() {
        let sets = scores(&[
            member(1, "six/1", Some(recalled(1.0e5))),
            member(2, "six/1", Some(recalled(3.0e5))),
        ]);
        let over = ["packing_seed".to_owned()];
        let means = mean_sem(&sets, &over);
        assert_eq!((means.len(), means[0].n, means[0].of), (1, 2, 2));
        // Two values 1 and 3: mean 2, SEM = √(2/1/2) = 1.
        assert!((means[0].results["gain_e_delta0"].expect("two") - 2.0e5).abs() < 1e-6);
        assert!((means[0].results["gain_e_delta0_sem"].expect("two") - 1.0e5).abs() < 1e-6);
        let one = mean_sem(&sets[..1], &over);
        assert_eq!(one[0].results["gain_sem"], None);
        assert!(one[0].missing_reason.is_some());
    }

    #[test]
    fn nothing_done_is_null_with_a_reason() {
        let sets = scores(&[member(1, "six/1", None)]);
        assert_eq!(sets[0].results["gain"], None);
        assert_eq!(
            sets[0].missing_reason.as_deref(),
            Some("no member is done yet")
        );
    }
}
