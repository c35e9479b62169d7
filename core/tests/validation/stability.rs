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
use granary_core::model::Model;
use granary_core::random::{Purpose, uniform3};
use granary_core::stage::StageFailure;
use serde_json::{Map, json};

use super::*;
use crate::tiny_beam;

#[path = "stability/drawn.rs"]
mod drawn;

/// Corners of the hypercube.
const CORNERS: usize = 200;

/// Grains of a pack where nothing else is said.
const GRAINS: u32 = 325;

/// The reference's sensitivity is what it changes by with steps of these shares of its own.
const OTHER_STEPS: [f64; 3] = [0.8, 0.65, 0.5];

/// What a deviation may be besides three times the reference's sensitivity: 𝒢 (relative), 𝓕.
///
/// Half a percent and 0.008 are what steps cost at most in packs of 325 (docs/choices.md §4); a cell is one pack: twice that.
const ALLOWED: [f64; 2] = [0.01, 0.016];

/// The same for the stiffness of a beam of 20 grains: docs/accuracy.md finds half the step to change nothing above 0.3 %
/// for 1,070 grains; √(1070/20) = 7 times that.
const ALLOWED_OF_BEAMS: f64 = 0.022;

/// A scene.
struct Cell {
    factor: &'static str,
    value: String,
    changes: Map<String, Value>,
    beam: bool,
}

/// What became of it.
#[derive(Clone, Debug)]
enum Found {
    Measured(Measured),
    /// The stage, and why it was stopped; or that the spec was refused.
    Stopped(String),
}

#[derive(Clone, Debug)]
struct Measured {
    /// Largest stable time step, t_c for packs; of beams the share of the critical one that runs.
    critical: f64,
    /// Deviation at 0.9 of it, of every judged result.
    deviation: Vec<f64>,
    /// What the reference changes by with other, small steps: root of the mean square.
    own: Vec<f64>,
    /// Deviation of single precision from double at 0.9 of it; none where it is refused.
    single: Option<Vec<f64>>,
    /// What happens beyond the critical time step.
    beyond: String,
}

impl Measured {
    fn allowed(&self, beam: bool) -> Vec<f64> {
        let base: &[f64] = if beam { &[ALLOWED_OF_BEAMS] } else { &ALLOWED };
        let both = base.iter().zip(&self.own);
        both.map(|(base, own)| base + 3.0 * own.abs()).collect()
    }

    fn is_right(&self, beam: bool) -> bool {
        let within = |deviation: &[f64]| {
            let mut pairs = deviation.iter().zip(self.allowed(beam));
            pairs.all(|(deviation, most)| deviation.abs() <= most)
        };
        within(&self.deviation)
            && self.single.as_deref().is_none_or(within)
            && self.beyond != "runs"
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
        let processed = Processing::Sub0.apply(&signal(outcome), Some(&zero));
        dots += Dots::of(&processed.expect("complete signals"), &waveform.bumps());
    }
    let score = Score::of(&dots, point.youngs_modulus, point.delta0, point.gamma0);
    let number = |name: &str| {
        let all = outcomes.iter().filter_map(|outcome| outcome.results[name]);
        all.fold(f64::INFINITY, f64::min)
    };
    match (score.gain_e_delta0, score.fidelity) {
        (Some(gain), Some(fidelity)) => Ok(Recalled {
            scores: [gain / point.youngs_modulus, fidelity],
            critical: number("critical_time_step"),
            time_step: number("time_step"),
        }),
        _ => Err("no score".to_owned()),
    }
}

/// What the second departs by from the first: 𝒢 relatively, 𝓕 absolutely.
fn deviation(from: &Recalled, of: &Recalled) -> Vec<f64> {
    let [gain, fidelity] = from.scores;
    vec![of.scores[0] / gain - 1.0, of.scores[1] - fidelity]
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
        "ramp": 6000.0,
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

fn measured_pack(point: &MemoryPoint) -> Result<Measured, String> {
    let (preparation_time_step, packed) = with_smaller_steps(1.0, |preparation_time_step| {
        let point = MemoryPoint {
            preparation_time_step,
            ..point.clone()
        };
        stage(&StageSpec::Pack(point.pack()), &[])
    })?;
    let at = |time_step: f64, precision: Precision| {
        let point = MemoryPoint {
            preparation_time_step,
            time_step,
            precision,
            ..point.clone()
        };
        recalled(&point, &packed)
    };
    let double = |time_step: f64| at(time_step, Precision::F64);
    let of_pack = packed.results["critical_time_step"].filter(|&c| c < 1e3);
    let (time_step, reference) = with_smaller_steps(0.25 * of_pack.unwrap_or(4.0), double)?;
    let mut squares = vec![0.0; ALLOWED.len()];
    for share in OTHER_STEPS {
        let other = deviation(&reference, &double(share * time_step)?);
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
    Ok(Measured {
        critical,
        deviation: deviation(&reference, &near),
        own: squares.into_iter().map(f64::sqrt).collect(),
        single: single.map(|single| deviation(&near, &single)),
        beyond,
    })
}

fn beam_cell(changes: &Map<String, Value>) -> Found {
    let point = |fraction: f64| {
        let mut changes = changes.clone();
        changes.insert("time_step_fraction".to_owned(), Value::from(fraction));
        tiny_beam::tiny(&Value::Object(changes))
    };
    let usual = point(0.2);
    if let Some(reason) = refused(Model::Beam, &usual) {
        return Found::Stopped(reason);
    }
    let measured = || -> Result<Measured, String> {
        let one = |spec: StageSpec, input: &[u8]| -> Result<(StageSpec, Outcome), String> {
            let result = tiny_beam::finish(&spec, (input, None), VectorWidth::widest());
            let outcome = result.map_err(|failure| told(&failure, spec.kind().name()))?;
            Ok((spec, outcome))
        };
        let (grow, grown) = one(StageSpec::Grow(usual.grow()), &[])?;
        let (jam, jammed) = one(
            StageSpec::Jam(usual.jam(grow.id())),
            &grown.artifacts[STATE],
        )?;
        let bent = |point: &BeamPoint| -> Result<f64, String> {
            let (_, bent) = one(
                StageSpec::Bend(point.bend(jam.id())),
                &jammed.artifacts[STATE],
            )?;
            bent.results["beam_stiffness"].ok_or_else(|| "bend: no stiffness".to_owned())
        };
        let reference = bent(&usual)?;
        let change = |fraction: f64| Ok::<f64, String>(bent(&point(fraction))? / reference - 1.0);
        let (deviation, own) = (change(0.9)?, change(0.1)?);
        let beyond = match bent(&point(1.1)) {
            Err(reason) => reason.split(" (").next().unwrap_or_default().to_owned(),
            Ok(_) => "runs".to_owned(),
        };
        Ok(Measured {
            critical: 1.0,
            deviation: vec![deviation],
            own: vec![own],
            single: None,
            beyond,
        })
    };
    match measured() {
        Ok(measured) => Found::Measured(measured),
        Err(reason) => Found::Stopped(reason),
    }
}

/// One factor at a time.
fn one_at_a_time() -> Vec<Cell> {
    let factors: [(&str, Vec<Value>); 14] = [
        ("default", vec![json!(null)]),
        ("shape", vec![json!("sphere")]),
        ("overlap", [0.0, 0.3, 0.9, 0.999].map(Value::from).to_vec()),
        (
            "friction_coefficient",
            [0.0, 1e-6, 1e3].map(Value::from).to_vec(),
        ),
        (
            "poisson_ratio",
            [-0.9, -0.5, 0.0, 0.3, 0.5].map(Value::from).to_vec(),
        ),
        (
            "delta0",
            [1e-4, 1e-3, 1e-2, 0.1, 0.15].map(Value::from).to_vec(),
        ),
        (
            "gamma0",
            [1e-8, 1e-6, 1e-4, 1e-2, 0.05, 0.2]
                .map(Value::from)
                .to_vec(),
        ),
        ("youngs_modulus", [1e2, 1e5, 1e12].map(Value::from).to_vec()),
        ("radius", [1e-6, 1e-2, 1.0].map(Value::from).to_vec()),
        (
            "normal_damping",
            [0.0, 0.023, 2.3, 23.0].map(Value::from).to_vec(),
        ),
        (
            "tangential_damping_ratio",
            [0.0, 1.0, 10.0].map(Value::from).to_vec(),
        ),
        (
            "servo_pressure",
            [1e-6, 1e-5, 1e-4, 1e-2, 5e-2].map(Value::from).to_vec(),
        ),
        ("typical_overlap", [1e-4, 0.5].map(Value::from).to_vec()),
        ("grains", [1, 2, 8, 64, 325, 1024].map(Value::from).to_vec()),
    ];
    let beams: [(&str, Vec<Value>); 5] = [
        ("beam: default", vec![json!(null)]),
        (
            "youngs_modulus",
            [1e5, 1e6, 1e9, 1e12].map(Value::from).to_vec(),
        ),
        (
            "confining_pressure",
            [0.0, 1e3, 1e6].map(Value::from).to_vec(),
        ),
        (
            "membrane_edge",
            [2e-3, 4e-3, 6e-3, 2e-2].map(Value::from).to_vec(),
        ),
        ("rod_speed", [5e-4, 5e-3, 0.5].map(Value::from).to_vec()),
    ];
    let cells = |(factor, values): (&'static str, Vec<Value>), beam: bool| {
        values.into_iter().map(move |value| {
            let mut changes = Map::new();
            if !value.is_null() {
                changes.insert(factor.to_owned(), value.clone());
            }
            Cell {
                factor,
                value: if value.is_null() {
                    "–".to_owned()
                } else {
                    value.to_string()
                },
                changes,
                beam,
            }
        })
    };
    let packs = factors.into_iter().flat_map(|factor| cells(factor, false));
    packs
        .chain(beams.into_iter().flat_map(|factor| cells(factor, true)))
        .collect()
}

/// Corners of all ranges at once: every factor's range is cut into as many parts as there are corners, and each part is taken
/// once.
fn corners() -> Vec<Cell> {
    // Name, from, to; by decades where both are above zero and far apart.
    let factors: [(&str, f64, f64); 11] = [
        ("overlap", 0.0, 0.999),
        ("friction_coefficient", 1e-6, 1e3),
        ("poisson_ratio", -0.9, 0.5),
        ("delta0", 1e-4, 0.15),
        ("gamma0", 1e-8, 0.2),
        ("youngs_modulus", 1e2, 1e12),
        ("radius", 1e-6, 1.0),
        ("normal_damping", 2.3e-3, 23.0),
        ("tangential_damping_ratio", 1e-2, 10.0),
        ("servo_pressure", 1e-6, 5e-2),
        ("grains", 8.0, 325.0),
    ];
    let mut corners = vec![Map::new(); CORNERS];
    for (n, (name, from, to)) in factors.into_iter().enumerate() {
        let draw = |i: usize| uniform3(4, Purpose::GasVelocity, (1000 * n + i) as u64);
        let mut order: Vec<usize> = (0..CORNERS).collect();
        order.sort_by(|&a, &b| draw(a)[0].total_cmp(&draw(b)[0]));
        for (part, &i) in order.iter().enumerate() {
            let share = (part as f64 + draw(i)[1]) / CORNERS as f64;
            let value = if from > 0.0 && to / from > 30.0 {
                from * (to / from).powf(share)
            } else {
                from + (to - from) * share
            };
            let value = match name {
                "grains" => json!(value.round() as u32),
                // Three digits are enough to name a corner by.
                _ => json!(format!("{value:.2e}").parse::<f64>().expect("a number")),
            };
            corners[i].insert(name.to_owned(), value);
        }
    }
    let cell = |(i, mut changes): (usize, Map<String, Value>)| {
        if i.is_multiple_of(4) {
            changes.insert("shape".to_owned(), json!("sphere"));
        }
        Cell {
            factor: "corner",
            value: (i + 1).to_string(),
            changes,
            beam: false,
        }
    };
    corners.into_iter().enumerate().map(cell).collect()
}

/// Looks at all cells, on all cores; tells how far it is.
#[expect(clippy::disallowed_methods, reason = "no result depends on it")]
fn all(cells: &[Cell]) -> Vec<Found> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let (next, start) = (AtomicUsize::new(0), Instant::now());
    let work = || {
        let mut found = BTreeMap::new();
        loop {
            let n = next.fetch_add(1, Ordering::Relaxed);
            let Some(cell) = cells.get(n) else {
                return found;
            };
            let (began, looked) = (
                Instant::now(),
                if cell.beam { beam_cell } else { pack_cell },
            );
            let seen = looked(&cell.changes);
            let elapsed = start.elapsed().as_secs_f64();
            let left = elapsed / (n + 1) as f64 * (cells.len() - n - 1) as f64;
            eprintln!(
                "{:3}/{} {} {} {:.0} s, {left:.0} s left: {seen:?}",
                n + 1,
                cells.len(),
                cell.factor,
                cell.value,
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

/// The table of what was found.
fn table(cells: &[Cell], found: &[Found]) -> String {
    let mut text = String::from(
        "| factor | value | Δt_crit | at 0.9: 𝒢 or E_b | 𝓕 | reference's own 𝒢 or E_b | 𝓕 | f32 𝒢 | 𝓕 | beyond | verdict |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    let percent = |x: Option<&f64>| x.map_or("–".to_owned(), |x| format!("{:+.2} %", 100.0 * x));
    let plain = |x: Option<&f64>| x.map_or("–".to_owned(), |x| format!("{x:+.4}"));
    for (cell, found) in cells.iter().zip(found) {
        let row = match found {
            Found::Measured(m) => {
                let single = m.single.as_deref().unwrap_or_default();
                format!(
                    "{:.3} | {} | {} | {} | {} | {} | {} | {} | {}",
                    m.critical,
                    percent(m.deviation.first()),
                    plain(m.deviation.get(1)),
                    percent(m.own.first()),
                    plain(m.own.get(1)),
                    percent(single.first()),
                    plain(single.get(1)),
                    m.beyond,
                    if m.is_right(cell.beam) {
                        "right"
                    } else {
                        "**off**"
                    }
                )
            }
            Found::Stopped(reason) => format!("– | – | – | – | – | – | – | – | {reason}"),
        };
        let _ = writeln!(text, "| {} | {} | {row} |", cell.factor, cell.value);
    }
    text
}

#[test]
fn every_cell_is_right_or_stopped_with_a_reason() {
    let mut cells = one_at_a_time();
    cells.extend(corners());
    if let Ok(only) = std::env::var("ONLY") {
        cells.retain(|cell| cell.factor == only);
    }
    let found = all(&cells);
    let mut text = table(&cells, &found);
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
    if std::env::var("ONLY").is_err() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/stability");
        std::fs::create_dir_all(&folder).expect("a folder to write to");
        std::fs::write(folder.join("cells.md"), &text).expect("a folder to write to");
        std::fs::write(folder.join("map.svg"), drawn::map(&cells, &found)).expect("a folder");
    }
    let off: Vec<String> = cells
        .iter()
        .zip(&found)
        .filter(|(cell, found)| matches!(found, Found::Measured(m) if !m.is_right(cell.beam)))
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
