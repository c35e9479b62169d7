//! The stage `recall`: encode a waveform, hold, decode, and a second cycle without it (Sec. II.3, III).

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::cycle::{Cycle, Drive, Program, Sample, Segment, Track};
use super::run;
use super::score::Signal;
use super::sound::Sound;
use super::spec::RecallSpec;
use super::state::{Checkpoint, PackState, Past};
use super::train::{Chosen, extent, laws};
use super::waveform::{SAMPLES, sample_u};
use super::{hold_steps, ramp_steps};
use crate::grains::Grains;
use crate::identity::canonical_json;
use crate::lanes::Scalar;
use crate::observable::critical_time_step::{CriticalTimeStep, critical_time_step};
use crate::outcome::{HISTORY, Outcome, Progress, SIGNAL, STATE, StageFailure};
use crate::physics;
use crate::scene::{Physics, Replicas, Scene};
use crate::state_file::Reader;
use crate::wall::Walls;

/// The series of a recall, in order.
const SERIES: [&str; 4] = ["encode", "decode", "second_encode", "second_decode"];
const ENCODE: usize = 0;
const DECODE: usize = 1;
const SECOND_ENCODE: usize = 2;
const SECOND_DECODE: usize = 3;

/// What a checkpoint of a recall remembers besides the grains.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Header {
    stage: String,
    step: u64,
    critical_at_start: CriticalTimeStep,
    track: Track,
    stop: Option<(u64, String, String, String)>,
    /// What led to the trained pack: recalls that go on from an encoding are told nothing else of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    past: Option<Past>,
}

/// Recalls of one trained pack, side by side.
pub(crate) struct Recalls<'a> {
    /// What each is told; all but waveform and γ0 are equal.
    pub(crate) specs: &'a [RecallSpec],
    /// The identity of each.
    pub(crate) stages: &'a [String],
    /// What led to the trained pack.
    pub(crate) past: &'a Past,
    pub(crate) start: Start<'a>,
    /// The step before which encodings end and leave their states, if they are that.
    pub(crate) until: Option<u64>,
}

/// Where recalls begin.
pub(crate) enum Start<'a> {
    /// In the trained pack.
    Trained(&'a PackState),
    /// A checkpoint for each, or the state of its encoding, all of one step.
    Saved(&'a [Vec<u8>]),
}

/// What led to the trained pack that an encoding went on from.
pub(crate) fn past(state: &[u8]) -> Result<Past, StageFailure> {
    let detail = |detail: String| StageFailure::Input { detail };
    let (header, _) = Reader::new::<Header>(physics::MEMORY, state).map_err(detail)?;
    header
        .past
        .ok_or_else(|| detail("the input is no encoding".to_owned()))
}

/// Runs all recalls, or goes on from their checkpoints; one result for each.
pub(crate) fn run<R: Replicas, P: Physics>(
    recalls: &Recalls<'_>,
    chosen: &Chosen<P>,
    progress: &mut Progress<'_>,
) -> Result<Vec<Result<Outcome, StageFailure>>, StageFailure> {
    let mut drive: Drive<R, P> = match recalls.start {
        Start::Saved(checkpoints) => resumed(recalls, checkpoints, chosen)?,
        Start::Trained(input) => begun(recalls, input, chosen)?,
    };
    let save = |drive: &Drive<R, P>, k: usize| {
        let stop = drive.stops[k].as_ref().map(|(step, stop)| {
            (
                *step,
                stop.kind.to_owned(),
                stop.detail.clone(),
                stop.remedy.clone(),
            )
        });
        let header = Header {
            stage: recalls.stages[k].clone(),
            step: drive.step,
            critical_at_start: drive.critical_at_start(),
            track: drive.tracks[k].clone(),
            stop,
            past: recalls.until.map(|_| recalls.past.clone()),
        };
        run::checkpoint_of(&drive.scene, k, header).to_bytes()
    };
    // The last sample, at u = 0, is the step after the last ramp.
    let end = recalls.until.unwrap_or(drive.cycle.steps() + 1);
    let before = -recalls.specs[0].steps_before().cast_signed();
    run::drive(&mut drive, (before, end), progress, &save)?;
    let outcome = |(k, spec): (usize, &RecallSpec)| match &drive.stops[k] {
        Some((step, stop)) => Err(run::stopped(*step, stop.clone())),
        None if recalls.until.is_some() => Ok(encoded(&drive, k, save(&drive, k))),
        None => Ok(outcome(spec, recalls.past, &drive, k)),
    };
    Ok(recalls.specs.iter().enumerate().map(outcome).collect())
}

/// The second cycle rests as long as the first, so that both decompressions stir up the same sound.
fn cycle(spec: &RecallSpec, past: &Past) -> Cycle {
    let steps = ramp_steps(spec.ramp, spec.time_step);
    let cycle = |sheared, up, down| {
        [
            Segment::ramp(steps, true, sheared, Some(up)),
            Segment::hold(hold_steps(spec.hold, steps)),
            Segment::ramp(steps, false, false, Some(down)),
        ]
    };
    let second = spec
        .second_cycle
        .then(|| cycle(false, SECOND_ENCODE, SECOND_DECODE));
    let first = cycle(true, ENCODE, DECODE);
    Cycle {
        segments: first
            .into_iter()
            .chain(second.into_iter().flatten())
            .collect(),
        delta0: past.pack.delta0,
        extent: extent(past),
    }
}

fn programs(recalls: &Recalls<'_>) -> Vec<Program> {
    recalls
        .specs
        .iter()
        .map(|spec| Program {
            gamma0: spec.gamma0,
            curve: spec.waveform.curve(),
        })
        .collect()
}

fn begun<R: Replicas, P: Physics>(
    recalls: &Recalls<'_>,
    input: &PackState,
    chosen: &Chosen<P>,
) -> Result<Drive<R, P>, StageFailure> {
    let spec = &recalls.specs[0];
    let laws = laws(&input.past, chosen, spec.skin, spec.ramp, spec.time_step);
    let time_step = laws.time_step;
    let mut grains = Grains::<R>::at_rest(input.poses.clone(), &laws.body, P::SPINS);
    for k in 0..R::K {
        for (i, &motion) in input.motions.iter().enumerate() {
            grains.set_motion(i, k, motion);
        }
    }
    let mut scene = Scene::new(laws, grains, Walls::at_rest(input.past.walls));
    for k in 0..R::K {
        run::give_memory(&mut scene, k, &input.contacts)?;
    }
    // Every replica starts alike, in the reference itself, so one measurement holds for all.
    let guard = run::guard(critical_time_step(&scene, 0, chosen.across), chosen.slices);
    guard
        .admit(time_step, guard.critical_at_start)
        .map_err(|stop| run::stopped(0, stop))?;
    Ok(Drive::new(
        scene,
        cycle(spec, &input.past),
        programs(recalls),
        chosen.across,
        guard,
    ))
}

fn resumed<R: Replicas, P: Physics>(
    recalls: &Recalls<'_>,
    checkpoints: &[Vec<u8>],
    chosen: &Chosen<P>,
) -> Result<Drive<R, P>, StageFailure> {
    let mut saved: Vec<Checkpoint<Header>> = vec![];
    for ((stage, spec), bytes) in recalls.stages.iter().zip(recalls.specs).zip(checkpoints) {
        let encode = spec.encode.map(|id| id.to_string());
        let mut stages = vec![stage.as_str()];
        stages.extend(encode.as_deref());
        saved.push(run::read_checkpoint(&stages, bytes, |header: &Header| {
            &header.stage
        })?);
    }
    let headers: Vec<Header> = saved
        .iter()
        .map(|checkpoint| checkpoint.header.clone())
        .collect();
    let step = headers.first().map_or(0, |header| header.step);
    if headers.len() != recalls.specs.len() || headers.iter().any(|header| header.step != step) {
        let detail = "checkpoint: the jobs of one ensemble must be at the same step".to_owned();
        return Err(StageFailure::Input { detail });
    }
    let (spec, past) = (&recalls.specs[0], recalls.past);
    let laws = laws(past, chosen, spec.skin, spec.ramp, spec.time_step);
    let scene = run::restored(laws, past.walls, &saved)?;
    let guard = run::guard(headers[0].critical_at_start, chosen.slices);
    let mut drive = Drive::new(
        scene,
        cycle(spec, past),
        programs(recalls),
        chosen.across,
        guard,
    );
    drive.step = step;
    for (k, header) in headers.into_iter().enumerate() {
        // An encoding has not the series of a second cycle.
        let series = std::mem::take(&mut drive.tracks[k].series);
        drive.tracks[k] = header.track;
        let missing = series.into_iter().skip(drive.tracks[k].series.len());
        drive.tracks[k].series.extend(missing);
        if let Some((at, kind, detail, remedy)) = header.stop {
            drive.restore_stop(k, at, &kind, detail, remedy);
        }
    }
    drive.place_walls();
    Ok(drive)
}

/// What an encoding leaves to the recalls that go on from it.
fn encoded<R: Replicas, P: Physics>(drive: &Drive<R, P>, k: usize, state: Vec<u8>) -> Outcome {
    let track = &drive.tracks[k];
    let mut results = BTreeMap::new();
    results.insert("largest_overlap".to_owned(), Some(track.largest_overlap));
    results.extend(run::measured(track.critical_time_step));
    results.insert("time_step".to_owned(), Some(drive.scene.laws.time_step));
    Outcome {
        results,
        reasons: BTreeMap::new(),
        artifacts: BTreeMap::from([(STATE.to_owned(), state)]),
        warnings: vec![],
        steps: drive.step,
    }
}

fn outcome<R: Replicas, P: Physics>(
    spec: &RecallSpec,
    past: &Past,
    drive: &Drive<R, P>,
    k: usize,
) -> Outcome {
    let track = &drive.tracks[k];
    let series: Vec<Vec<Sample>> = (0..track.series.len())
        .map(|s| track.complete(s).unwrap_or_default())
        .collect();
    let p_xy = |s: usize| -> Vec<f64> {
        let samples = series.get(s).map_or(&[][..], Vec::as_slice);
        samples
            .iter()
            .map(|sample| sample.pressure[0] - sample.pressure[1])
            .collect()
    };
    let in_pascal = |p: Vec<f64>| {
        p.into_iter()
            .map(|p| p * past.pack.youngs_modulus)
            .collect()
    };
    let signal = Signal {
        encode: in_pascal(p_xy(ENCODE)),
        decode: in_pascal(p_xy(DECODE)),
        second_decode: in_pascal(p_xy(SECOND_DECODE)),
        resolution: Some(
            R::Scalar::EPSILON * mean_pressure(&series[DECODE]) * past.pack.youngs_modulus,
        ),
    };
    let mut results = BTreeMap::new();
    results.insert(
        "encode_correlation".to_owned(),
        encode_correlation(spec, past, &p_xy(ENCODE)),
    );
    // The first decoding sample is taken at the last moment of the hold.
    let held = series[DECODE]
        .last()
        .map(|sample| sample.seen.kinetic_energy);
    results.insert("hold_kinetic_energy".to_owned(), held);
    results.insert("largest_overlap".to_owned(), Some(track.largest_overlap));
    results.extend(run::measured(track.critical_time_step));
    results.insert("time_step".to_owned(), Some(drive.scene.laws.time_step));
    if let (Some(first), Some(last)) = (series[ENCODE].first(), series[ENCODE].last()) {
        results.extend(run::observed(&first.seen, ""));
        results.extend(run::observed(&last.seen, "_compressed"));
    }
    results.extend(Sound::results(past.sound));
    let warning = past
        .sound
        .and_then(|sound| sound.warning(spec.ramp, spec.drag));
    let history = history(&series, past.pack.youngs_modulus);
    Outcome {
        results,
        reasons: BTreeMap::new(),
        artifacts: BTreeMap::from([
            (SIGNAL.to_owned(), canonical_json(&signal).into_bytes()),
            (HISTORY.to_owned(), canonical_json(&history).into_bytes()),
        ]),
        warnings: warning.into_iter().collect(),
        steps: drive.cycle.steps() - spec.steps_before(),
    }
}

/// The mean of p_x and p_y over all samples \[E\].
fn mean_pressure(samples: &[Sample]) -> f64 {
    let both = samples.iter().map(|s| s.pressure[0] + s.pressure[1]);
    both.sum::<f64>() / (2 * samples.len().max(1)) as f64
}

/// Correlation of the encode response with I(u): how quasi-static the encoding was (docs/choices.md §4).
///
/// The training compression, which carried no waveform, is subtracted first; `None` for the zero waveform.
fn encode_correlation(spec: &RecallSpec, past: &Past, p_xy: &[f64]) -> Option<f64> {
    let curve = spec.waveform.curve();
    let (mut i_p, mut i_i, mut p_p) = (0.0, 0.0, 0.0);
    for (k, (p, background)) in p_xy.iter().zip(&past.unsheared).enumerate() {
        let (i, p) = (curve.shear(sample_u(k)), p - background);
        i_p += i * p;
        i_i += i * i;
        p_p += p * p;
    }
    (i_i > 0.0 && p_p > 0.0).then(|| i_p / (i_i.sqrt() * p_p.sqrt()))
}

/// What is taken from a sample.
type Quantity<'a> = &'a dyn Fn(&Sample) -> f64;

/// One quantity at the 256 values of u, by the name of the series.
type Columns = BTreeMap<&'static str, BTreeMap<&'static str, Vec<f64>>>;

/// Everything recorded, by series and quantity; index 0 is u = 0 in every series.
#[derive(Serialize)]
struct History {
    u: Vec<f64>,
    units: BTreeMap<&'static str, &'static str>,
    series: Columns,
}

fn history(series: &[Vec<Sample>], youngs_modulus: f64) -> History {
    let quantities: [(&str, &str, Quantity<'_>); 8] = [
        ("p_x", "Pa", &|s| s.pressure[0] * youngs_modulus),
        ("p_y", "Pa", &|s| s.pressure[1] * youngs_modulus),
        ("p_z", "Pa", &|s| s.pressure[2] * youngs_modulus),
        ("volume_fraction", "", &|s| s.seen.volume_fraction),
        ("coordination_number", "", &|s| s.seen.coordination_number),
        ("sphere_contacts_per_grain", "", &|s| {
            s.seen.sphere_contacts_per_grain
        }),
        ("wall_contacts_per_grain", "", &|s| {
            s.seen.wall_contacts_per_grain
        }),
        ("kinetic_energy", "E R³ per grain", &|s| {
            s.seen.kinetic_energy
        }),
    ];
    let mut columns = Columns::new();
    for (name, samples) in SERIES.into_iter().zip(series) {
        let of = |quantity: Quantity<'_>| samples.iter().map(quantity).collect();
        columns.insert(
            name,
            quantities
                .iter()
                .map(|(name, _, quantity)| (*name, of(quantity)))
                .collect(),
        );
    }
    History {
        u: (0..SAMPLES).map(sample_u).collect(),
        units: quantities
            .iter()
            .map(|(name, unit, _)| (*name, *unit))
            .collect(),
        series: columns,
    }
}
