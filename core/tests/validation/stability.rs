//! The stability map: the largest stable time step of packs and beams at the ends of every range, what steps of nine tenths
//! of it cost in accuracy, and that what cannot be computed is stopped with a reason.
//!
//! One factor at a time departs from a default scene, then two hundred corners of all ranges at once (a Latin hypercube).
//! Every cell must be right, or stopped with a reason; `docs/stability/` holds what this found.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use granary_core::beam::point::BeamPoint;
use granary_core::identity::canonical_json;
use granary_core::model::Model;
use granary_core::stage::StageFailure;
use serde::{Deserialize, Serialize};
use serde_json::{Map, json};

use super::*;
use crate::tiny_beam;

#[path = "stability/cells.rs"]
mod cells;
#[path = "stability/drawn.rs"]
mod drawn;
#[path = "stability/kept.rs"]
mod kept;

use cells::{Cell, corners, one_at_a_time};
use kept::Kept;

/// Grains of a pack where nothing else is said.
const GRAINS: u32 = 325;

/// The reference's sensitivity is what it changes by with steps of these shares of its own.
const OTHER_STEPS: [f64; 3] = [0.8, 0.65, 0.5];

/// What a deviation may be besides the scatter of the reference: the recalled signal relative to its norm, 𝓕.
///
/// Half a percent and 0.008 are what steps cost at most in packs of 325 (docs/choices.md §4); a cell is one pack: twice that.
/// With c the correlation of what is recalled with J, an error ε of the signal is one of ε/c in 𝒢.
const ALLOWED: [f64; 2] = [0.01, 0.016];

/// Times the scatter of the reference: Student's t for 99 % and three degrees of freedom, those of [`OTHER_STEPS`].
const SCATTERS: f64 = 5.84;

/// The same for the stiffness of a beam of 20 grains: docs/accuracy.md finds half the step to change nothing above 0.3 %
/// for 1,070 grains; √(1070/20) = 7 times that.
const ALLOWED_OF_BEAMS: f64 = 0.022;

/// Times what the next smaller step changes E_b by: there is one such step, and its own scatter is not known.
const CHANGES_OF_BEAMS: f64 = 3.0;

/// Packs of more grains than this are looked at briefly.
const LARGE: u64 = 2_000;

/// What became of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
enum Found {
    Measured(Measured),
    /// The stage, and why it was stopped; or that the spec was refused.
    Stopped(String),
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct Measured {
    /// Largest stable time step, t_c for packs; of beams the share of the critical one that runs.
    critical: f64,
    /// Deviation at 0.9 of it, of every judged result.
    deviation: Vec<f64>,
    /// What the reference changes by with other, small steps: root of the mean square.
    own: Vec<f64>,
    /// Deviation of single precision from double at 0.9 of it; none where it is refused or has no score.
    single: Option<Vec<f64>>,
    /// What single precision itself says that rounding may move recalled signals by.
    rounding: f64,
    /// How much of the reference's signals scatters; not told of beams, nor by cells of before it was looked at.
    #[serde(default)]
    noise: f64,
    /// Whether a score is told to be noisy.
    #[serde(default)]
    noisy: bool,
    /// What happens beyond the critical time step.
    beyond: String,
    /// 𝓕 of the reference; none of beams.
    fidelity: Option<f64>,
    /// Standard deviations over packings, looked at where the deviation is larger than allowed.
    packings: Vec<f64>,
}

/// What a cell is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Verdict {
    /// Within what is allowed.
    Right,
    /// Off by less than packings differ: what is told of several packings has that as its error.
    Scattered,
    /// Off, but not by more than its score says that noise may move it, or told to be noisy.
    Noise,
    Off,
}

impl Verdict {
    fn name(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Scattered => "less than packings differ",
            Self::Noise => "noise, as it says",
            Self::Off => "**off**",
        }
    }
}

impl Measured {
    /// What deviations may be, where recalled signals are uncertain by this share of themselves.
    fn allowed(&self, uncertain: f64) -> Vec<f64> {
        let (base, times) = match self.fidelity {
            Some(fidelity) => {
                let c = (fidelity * (2.0 - fidelity)).sqrt();
                let signal = ALLOWED[0] + uncertain;
                (vec![signal / c, ALLOWED[1] + uncertain], SCATTERS)
            }
            None => (vec![ALLOWED_OF_BEAMS], CHANGES_OF_BEAMS),
        };
        let both = base.iter().zip(&self.own);
        both.map(|(base, own)| base + times * own.abs()).collect()
    }

    fn verdict(&self) -> Verdict {
        let below = |deviation: &[f64], most: &[f64]| {
            let mut pairs = deviation.iter().zip(most);
            deviation.len() <= most.len() && pairs.all(|(d, most)| d.abs() <= *most)
        };
        let within = |most: &[f64], single_most: &[f64]| {
            let single = |single| below(single, single_most);
            below(&self.deviation, most) && self.single.as_deref().is_none_or(single)
        };
        let uncertain = |by: f64| within(&self.allowed(by), &self.allowed(by + self.rounding));
        if self.beyond == "runs" {
            Verdict::Off
        } else if uncertain(0.0) {
            Verdict::Right
        } else if self.noisy || uncertain(self.noise) {
            Verdict::Noise
        } else if within(&self.packings, &self.packings) {
            Verdict::Scattered
        } else {
            Verdict::Off
        }
    }

    /// The same with a look at three other packings, if it is needed; `relative` says of which results.
    fn with_packings(
        mut self,
        relative: &[bool],
        first: &[f64],
        of: impl Fn(u32) -> Result<Vec<f64>, String>,
    ) -> Self {
        if matches!(self.verdict(), Verdict::Right | Verdict::Noise) {
            return self;
        }
        let others = (2..=4).filter_map(|seed| of(seed).ok());
        let all: Vec<Vec<f64>> = std::iter::once(first.to_vec()).chain(others).collect();
        let n = all.len() as f64;
        if all.len() < 3 {
            return self;
        }
        let of_result = |(k, &relative): (usize, &bool)| {
            let mean = all.iter().map(|one| one[k]).sum::<f64>() / n;
            let squares = all.iter().map(|one| (one[k] - mean).powi(2)).sum::<f64>();
            let deviation = (squares / (n - 1.0)).sqrt();
            if relative {
                deviation / first[k].abs()
            } else {
                deviation
            }
        };
        self.packings = relative.iter().enumerate().map(of_result).collect();
        self
    }
}

/// Why something was stopped, in a few words.
fn told(failure: &StageFailure, stage: &str) -> String {
    match failure {
        StageFailure::Stopped { kind, detail, .. } => format!("{stage}: {kind} ({detail})"),
        other => panic!("{stage}: {other}"),
    }
}

/// One stage, or why it stopped.
fn stage(spec: &StageSpec, input: &[u8]) -> Result<Outcome, String> {
    let result = finish(std::slice::from_ref(spec), input, VectorWidth::widest()).remove(0);
    let outcome = result.map_err(|failure| told(&failure, spec.kind().name()))?;
    for (name, value) in &outcome.results {
        assert!(value.is_none_or(f64::is_finite), "{name} is {value:?}");
    }
    Ok(outcome)
}

/// What one cycle with six signals gives.
struct Recalled {
    /// 𝒢, relative to nothing, and 𝓕.
    scores: [f64; 2],
    /// How far rounding may move what is recalled, relative to its size.
    rounding: f64,
    /// How much of it scatters from sample to sample, and whether the score says that this is too much.
    noise: f64,
    noisy: bool,
    critical: f64,
    time_step: f64,
}

/// Trains a pack and recalls six signals.
fn recalled(point: &MemoryPoint, packed: &Outcome) -> Result<Recalled, String> {
    let train = StageSpec::Train(point.train(StageSpec::Pack(point.pack()).id()));
    let trained = stage(&train, &packed.artifacts[STATE])?;
    let waveforms: Vec<Waveform> = std::iter::once(Waveform::Zero)
        .chain((1..=6).map(Waveform::Six))
        .collect();
    let recall = |waveform: &Waveform| {
        let waveform = waveform.clone();
        let point = MemoryPoint {
            waveform,
            ..point.clone()
        };
        StageSpec::Recall(point.recall(train.id()))
    };
    let specs: Vec<StageSpec> = waveforms.iter().map(recall).collect();
    let results = finish(&specs, &trained.artifacts[STATE], VectorWidth::widest());
    let outcomes: Result<Vec<Outcome>, String> = results
        .into_iter()
        .map(|result| result.map_err(|failure| told(&failure, "recall")))
        .collect();
    let outcomes = outcomes?;
    let signal = |outcome: &Outcome| -> Signal {
        serde_json::from_slice(&outcome.artifacts[SIGNAL]).expect("a signal")
    };
    let zero = signal(&outcomes[0]);
    let mut dots = Dots::default();
    for (outcome, waveform) in outcomes.iter().zip(&waveforms).skip(1) {
        let signal = signal(outcome);
        let processed = Processing::Sub0.apply(&signal, Some(&zero));
        let processed = processed.expect("complete signals");
        dots += Dots::of(&processed, &waveform.curve(), signal.resolution);
    }
    let score = Score::of(&dots, point.youngs_modulus, point.delta0, point.gamma0);
    let number = |name: &str| {
        let all = outcomes.iter().filter_map(|outcome| outcome.results[name]);
        all.fold(f64::INFINITY, f64::min)
    };
    match (score.gain_e_delta0, score.fidelity) {
        (Some(gain), Some(fidelity)) => Ok(Recalled {
            scores: [gain / point.youngs_modulus, fidelity],
            rounding: score.rounding_error.unwrap_or_default(),
            noise: score.noise_to_signal.unwrap_or_default(),
            noisy: score.warning().is_some(),
            critical: number("critical_time_step"),
            time_step: number("time_step"),
        }),
        _ => Err(format!(
            "no score: {}",
            Score::missing_reason(&dots).unwrap_or_default()
        )),
    }
}

/// What `of` departs by from another: 𝒢 in units of the reference's, 𝓕 absolutely.
///
/// Not of the other's own: where there is next to no memory, that is next to nothing.
fn deviation(reference: &Recalled, from: &Recalled, of: &Recalled) -> Vec<f64> {
    let [gain, fidelity] = from.scores;
    vec![
        (of.scores[0] - gain) / reference.scores[0],
        of.scores[1] - fidelity,
    ]
}

/// Which rule a point breaks, if any: it would not be queued.
fn refused(model: Model, point: &impl serde::Serialize) -> Option<String> {
    let point = serde_json::to_value(point).expect("parameters");
    let point = point.as_object().expect("by name");
    let broken = model.rules().iter().find_map(|rule| (rule.broken)(point));
    broken.map(|reason| format!("refused: {reason}"))
}

fn pack_cell(changes: &Map<String, Value>) -> Found {
    let mut map = MemoryPoint::defaults("standard").expect("a preset");
    let short = json!({
        "grains": GRAINS, "gas_time": 1000.0, "preparation_cycles": 1, "preparation_ramp": 3000.0,
        "ramp": 6000.0, "drag": 0.0,
        "precision": "f64", "second_cycle": false,
    });
    map.extend(short.as_object().expect("an object").clone());
    map.extend(changes.clone());
    let point = match MemoryPoint::from_parameters(map) {
        Ok(point) => point,
        Err(refusal) => return Found::Stopped(format!("refused: {refusal:?}")),
    };
    if let Some(reason) = refused(Model::Memory, &point) {
        return Found::Stopped(reason);
    }
    match measured_pack(&point) {
        Ok(measured) => Found::Measured(measured),
        Err(reason) => Found::Stopped(reason),
    }
}

/// Calls `run` with ever smaller steps as long as it is stopped for its step.
fn with_smaller_steps<T>(
    mut time_step: f64,
    run: impl Fn(f64) -> Result<T, String>,
) -> Result<(f64, T), String> {
    for _ in 0..8 {
        match run(time_step) {
            Err(reason) if reason.contains("unstable") => time_step *= 0.5,
            other => return other.map(|found| (time_step, found)),
        }
    }
    run(time_step).map(|found| (time_step, found))
}

/// A pack, with the time step that it could be made with.
fn packed(point: &MemoryPoint) -> Result<(f64, Outcome), String> {
    with_smaller_steps(1.0, |preparation_time_step| {
        let point = MemoryPoint {
            preparation_time_step,
            ..point.clone()
        };
        stage(&StageSpec::Pack(point.pack()), &[])
    })
}

fn measured_pack(point: &MemoryPoint) -> Result<Measured, String> {
    let (preparation_time_step, pack) = packed(point)?;
    let at = |time_step: f64, precision: Precision| {
        let point = MemoryPoint {
            preparation_time_step,
            time_step,
            precision,
            ..point.clone()
        };
        recalled(&point, &pack)
    };
    let double = |time_step: f64| at(time_step, Precision::F64);
    let of_pack = pack.results["critical_time_step"].filter(|&c| c < 1e3);
    let large = u64::from(point.grains) > LARGE;
    let (time_step, reference) = with_smaller_steps(0.25 * of_pack.unwrap_or(4.0), double)?;
    let mut squares = vec![0.0; ALLOWED.len()];
    let others: &[f64] = if large { &[] } else { &OTHER_STEPS };
    for share in others {
        let other = deviation(&reference, &reference, &double(share * time_step)?);
        for (square, other) in squares.iter_mut().zip(other) {
            *square += other * other / OTHER_STEPS.len() as f64;
        }
    }
    let near = double(0.9 * reference.critical)?;
    let critical = near.critical.min(reference.critical);
    let alike = MemoryPoint {
        precision: Precision::F32,
        ..point.clone()
    };
    let single = match refused(Model::Memory, &alike) {
        None => at(0.9 * critical, Precision::F32).ok(),
        Some(_) => None,
    };
    // Samples fall on steps, so the next longer step divides their distance.
    let sample = point.ramp / 255.0;
    let beyond = match double(sample / (sample / (1.02 * critical)).floor().max(1.0)) {
        Err(reason) => reason.split(" (").next().unwrap_or_default().to_owned(),
        Ok(run) if run.time_step < run.critical => "none longer".to_owned(),
        Ok(_) => "runs".to_owned(),
    };
    let measured = Measured {
        critical,
        deviation: deviation(&reference, &reference, &near),
        own: squares.into_iter().map(f64::sqrt).collect(),
        rounding: single.as_ref().map_or(0.0, |single| single.rounding),
        noise: reference.noise,
        noisy: reference.noisy || near.noisy,
        single: single.map(|single| deviation(&reference, &near, &single)),
        beyond,
        fidelity: Some(reference.scores[1]),
        packings: vec![],
    };
    let of_packing = |packing_seed: u32| {
        let point = MemoryPoint {
            packing_seed: packing_seed.into(),
            ..point.clone()
        };
        let (preparation_time_step, pack) = packed(&point)?;
        let point = MemoryPoint {
            preparation_time_step,
            time_step: reference.time_step,
            ..point
        };
        Ok(recalled(&point, &pack)?.scores.to_vec())
    };
    Ok(measured.with_packings(&[true, false], &reference.scores, of_packing))
}

fn beam_cell(changes: &Map<String, Value>) -> Found {
    let point = |fraction: f64| {
        let mut changes = changes.clone();
        changes.insert("time_step_fraction".to_owned(), Value::from(fraction));
        tiny_beam::tiny(&Value::Object(changes))
    };
    // The step of stiff beams is limited by damping, whatever the fraction, and a thousand times shorter.
    let stiff = changes.get("youngs_modulus").and_then(Value::as_f64) > Some(1e10);
    let (share, other) = if stiff { (0.5, 0.35) } else { (0.2, 0.1) };
    let usual = point(share);
    if let Some(reason) = refused(Model::Beam, &usual) {
        return Found::Stopped(reason);
    }
    match measured_beam(&usual, other, point) {
        Ok(measured) => Found::Measured(measured),
        Err(reason) => Found::Stopped(reason),
    }
}

/// One stage of a beam, or why it stopped.
fn beam_stage(spec: &StageSpec, input: &[u8]) -> Result<Outcome, String> {
    let result = tiny_beam::finish(spec, (input, None), VectorWidth::widest());
    result.map_err(|failure| told(&failure, spec.kind().name()))
}

/// A beam before it is bent, and the name of the stage.
fn jammed(point: &BeamPoint) -> Result<(StageSpec, Outcome), String> {
    let grow = StageSpec::Grow(point.grow());
    let grown = beam_stage(&grow, &[])?;
    let jam = StageSpec::Jam(point.jam(grow.id()));
    let jammed = beam_stage(&jam, &grown.artifacts[STATE])?;
    Ok((jam, jammed))
}

/// E_b.
fn bent(point: &BeamPoint, (jam, jammed): &(StageSpec, Outcome)) -> Result<f64, String> {
    let bend = StageSpec::Bend(point.bend(jam.id()));
    let bent = beam_stage(&bend, &jammed.artifacts[STATE])?;
    bent.results["beam_stiffness"].ok_or_else(|| "bend: no stiffness".to_owned())
}

fn measured_beam(
    usual: &BeamPoint,
    other: f64,
    point: impl Fn(f64) -> BeamPoint,
) -> Result<Measured, String> {
    let beam = jammed(usual)?;
    let reference = bent(usual, &beam)?;
    let change =
        |fraction: f64| Ok::<f64, String>(bent(&point(fraction), &beam)? / reference - 1.0);
    let (deviation, own) = (change(0.9)?, change(other)?);
    let beyond = match bent(&point(1.1), &beam) {
        Err(reason) => reason.split(" (").next().unwrap_or_default().to_owned(),
        Ok(_) => "runs".to_owned(),
    };
    let measured = Measured {
        critical: 1.0,
        deviation: vec![deviation],
        own: vec![own],
        single: None,
        rounding: 0.0,
        noise: 0.0,
        noisy: false,
        beyond,
        fidelity: None,
        packings: vec![],
    };
    let of_packing = |packing_seed: u32| {
        let point = BeamPoint {
            packing_seed: packing_seed.into(),
            ..usual.clone()
        };
        Ok(vec![bent(&point, &jammed(&point)?)?])
    };
    Ok(measured.with_packings(&[true], &[reference], of_packing))
}

/// Looks at all cells, on all cores; tells how far it is.
#[expect(clippy::disallowed_methods, reason = "no result depends on it")]
fn all(cells: &[Cell], kept: &Kept) -> Vec<Found> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let (next, start) = (AtomicUsize::new(0), Instant::now());
    let work = || {
        let mut found = BTreeMap::new();
        loop {
            let n = next.fetch_add(1, Ordering::Relaxed);
            let Some(cell) = cells.get(n) else {
                return found;
            };
            let began = Instant::now();
            let seen = kept.or(cell, if cell.beam { beam_cell } else { pack_cell });
            let elapsed = start.elapsed().as_secs_f64();
            let left = elapsed / (n + 1) as f64 * (cells.len() - n - 1) as f64;
            eprintln!(
                "{:3}/{} {} {} {} {:.0} s, {left:.0} s left: {seen:?}",
                n + 1,
                cells.len(),
                cell.factor,
                cell.value,
                canonical_json(&cell.changes),
                began.elapsed().as_secs_f64()
            );
            found.insert(n, seen);
        }
    };
    let mut found = BTreeMap::new();
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        for worker in workers {
            found.extend(worker.join().expect("no cell panics"));
        }
    });
    found.into_values().collect()
}

#[test]
fn every_cell_is_right_or_stopped_with_a_reason() {
    let mut cells = one_at_a_time();
    cells.extend(corners());
    let (kept, only) = (Kept::open(), std::env::var("ONLY").ok());
    match only.as_deref() {
        None => {}
        // Draws the map of what has been found.
        Some("kept") => cells.retain(|cell| kept.knows(cell)),
        Some(factor) => cells.retain(|cell| cell.factor == factor),
    }
    let found = all(&cells, &kept);
    let mut text = drawn::table(&cells, &found);
    text.push_str("\nThe corners:\n\n");
    for cell in cells.iter().filter(|cell| cell.factor == "corner") {
        let _ = writeln!(
            text,
            "{}. {}",
            cell.value,
            Value::Object(cell.changes.clone())
        );
    }
    println!("{text}");
    if only.is_none_or(|only| only == "kept") {
        kept::rewrite(&cells, &found);
        let folder = kept::folder();
        std::fs::write(folder.join("cells.md"), &text).expect("a folder to write to");
        std::fs::write(folder.join("map.svg"), drawn::map(&cells, &found)).expect("a folder");
    }
    let off: Vec<String> = cells
        .iter()
        .zip(&found)
        .filter(|(_, found)| matches!(found, Found::Measured(m) if m.verdict() == Verdict::Off))
        .map(|(cell, found)| format!("{} {}: {found:?}", cell.factor, cell.value))
        .collect();
    assert!(off.is_empty(), "{}", off.join("\n"));
}

#[test]
fn the_same_problem_in_other_units_has_the_same_answer() {
    // Everything dimensionless is alike, so that only the units' own rounding differs.
    let one = |changes: Value| {
        let mut map = MemoryPoint::defaults("draft").expect("a preset");
        map.extend(
            json!({"grains": GRAINS, "ramp": 3000.0, "precision": "f64"})
                .as_object()
                .expect("an object")
                .clone(),
        );
        map.extend(changes.as_object().expect("an object").clone());
        let point = MemoryPoint::from_parameters(map).expect("valid parameters");
        let packed = stage(&StageSpec::Pack(point.pack()), &[]).expect("a pack");
        recalled(&point, &packed).expect("scores").scores
    };
    let usual = one(json!({}));
    for (modulus, radius, density) in [(1e2, 0.5e-3, 1200.0), (1e12, 1.0, 8e3), (1e7, 1e-6, 1.0)] {
        let scores = one(json!({"youngs_modulus": modulus, "radius": radius, "density": density}));
        for (other, usual) in scores.iter().zip(usual) {
            assert!(
                (other / usual - 1.0).abs() < 1e-9,
                "E = {modulus}, R = {radius}: {scores:?} {usual:?}"
            );
        }
    }
}
