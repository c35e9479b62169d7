//! The stage `train`: one compression cycle with friction and without a waveform, shared by every waveform (Sec. II.3).

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::cycle::{Cycle, Drive, Segment, Track};
use super::pack::{body, material};
use super::ramp_steps;
use super::run;
use super::sound::{self, Sound};
use super::spec::{Slices, TrainSpec};
use super::state::{Checkpoint, PackState, Past};
use crate::grains::Grains;
use crate::lanes::{F64x1, VectorWidth};
use crate::observable::critical_time_step::{Across, CriticalTimeStep, critical_time_step};
use crate::observable::observe;
use crate::outcome::{Outcome, Progress, STATE, StageFailure};
use crate::protocol::Box2;
use crate::scene::{Laws, Physics, Scene};
use crate::wall::Walls;

/// What a checkpoint of a training remembers besides the grains.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Header {
    stage: String,
    step: u64,
    critical_at_start: CriticalTimeStep,
    track: Track,
}

/// The laws of a pack with friction and a body force, as a spec chose them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chosen<P: Physics> {
    /// The tangential law.
    pub(crate) tangential: P::Tangential,
    /// Its stiffness before it slips.
    pub(crate) across: Across,
    /// Law M2's slices.
    pub(crate) slices: Option<Slices>,
    /// The body force.
    pub(crate) body_force: P::Body,
    /// The vector instructions.
    pub(crate) width: VectorWidth,
}

/// The laws of a scene with friction; the time step divides a ramp as samples need.
pub(crate) fn laws<P: Physics>(
    past: &Past,
    chosen: &Chosen<P>,
    skin: f64,
    ramp: f64,
    time_step: f64,
) -> Laws<P> {
    Laws {
        body: body(&past.pack),
        material: material(&past.pack),
        tangential: chosen.tangential,
        body_force: chosen.body_force,
        time_step: ramp / ramp_steps(ramp, time_step) as f64,
        dither: 0.0,
        skin,
        width: chosen.width,
    }
}

/// The box of a pack at u = 0.
pub(crate) fn extent(past: &Past) -> Box2 {
    Box2 {
        x: past.walls[1] - past.walls[0],
        y: past.walls[3] - past.walls[2],
    }
}

/// Trains a prepared pack, or goes on from a checkpoint.
pub(crate) fn run<P: Physics>(
    spec: &TrainSpec,
    stage: &str,
    (input, checkpoint): (&PackState, Option<&[u8]>),
    chosen: &Chosen<P>,
    progress: &mut Progress<'_>,
) -> Result<Outcome, StageFailure> {
    let mut drive = match checkpoint {
        Some(bytes) => resumed(spec, stage, input, bytes, chosen)?,
        None => begun(spec, input, chosen)?,
    };
    // The first step of a recall stands where the last one of a training would.
    let end = drive.cycle.steps();
    let save = |drive: &Drive<F64x1, P>, k: usize| {
        let header = Header {
            stage: stage.to_owned(),
            step: drive.step,
            critical_at_start: drive.critical_at_start(),
            track: drive.tracks[k].clone(),
        };
        run::checkpoint_of(&drive.scene, k, header).to_bytes()
    };
    run::drive(&mut drive, (0, end), progress, &save)?;
    if let Some((step, stop)) = drive.stops[0].take() {
        return Err(run::stopped(step, stop));
    }
    let mut ask = || progress.ask(end, &|| vec![save(&drive, 0)]);
    let sound = sound::measure(&drive.scene, &mut ask)?;
    Ok(outcome(spec, input, &drive, sound))
}

fn cycle(spec: &TrainSpec, past: &Past) -> Cycle {
    let steps = ramp_steps(spec.ramp, spec.time_step);
    let segments = vec![
        Segment::ramp(steps, true, false, Some(0)),
        Segment::ramp(steps, false, false, None),
    ];
    Cycle {
        segments,
        delta0: past.pack.delta0,
        extent: extent(past),
    }
}

fn begun<P: Physics>(
    spec: &TrainSpec,
    input: &PackState,
    chosen: &Chosen<P>,
) -> Result<Drive<F64x1, P>, StageFailure> {
    let laws = laws(&input.past, chosen, spec.skin, spec.ramp, spec.time_step);
    let time_step = laws.time_step;
    let mut grains = Grains::at_rest(input.poses.clone(), &laws.body, P::SPINS);
    for (i, &motion) in input.motions.iter().enumerate() {
        grains.set_motion(i, 0, motion);
    }
    let scene = Scene::new(laws, grains, Walls::at_rest(input.past.walls));
    let guard = run::guard(critical_time_step(&scene, 0, chosen.across), chosen.slices);
    guard
        .admit(time_step, guard.critical_at_start)
        .map_err(|stop| run::stopped(0, stop))?;
    Ok(Drive::new(
        scene,
        cycle(spec, &input.past),
        vec![run::silent()],
        chosen.across,
        guard,
    ))
}

fn resumed<P: Physics>(
    spec: &TrainSpec,
    stage: &str,
    input: &PackState,
    bytes: &[u8],
    chosen: &Chosen<P>,
) -> Result<Drive<F64x1, P>, StageFailure> {
    let saved: Checkpoint<Header> =
        run::read_checkpoint(&[stage], bytes, |header: &Header| &header.stage)?;
    let header = saved.header.clone();
    let laws = laws(&input.past, chosen, spec.skin, spec.ramp, spec.time_step);
    let scene = run::restored(laws, input.past.walls, &[saved])?;
    let guard = run::guard(header.critical_at_start, chosen.slices);
    let mut drive = Drive::new(
        scene,
        cycle(spec, &input.past),
        vec![run::silent()],
        chosen.across,
        guard,
    );
    drive.step = header.step;
    drive.tracks = vec![header.track];
    drive.place_walls();
    Ok(drive)
}

fn outcome<P: Physics>(
    spec: &TrainSpec,
    input: &PackState,
    drive: &Drive<F64x1, P>,
    sound: Option<Sound>,
) -> Outcome {
    let top = drive.tracks[0].complete(0).unwrap_or_default();
    let mut results = run::observed(&observe(&drive.scene)[0], "");
    if let Some(last) = top.last() {
        results.extend(run::observed(&last.seen, "_compressed"));
    }
    results.insert(
        "largest_overlap".to_owned(),
        Some(drive.tracks[0].largest_overlap),
    );
    results.extend(run::measured(drive.tracks[0].critical_time_step));
    results.insert("time_step".to_owned(), Some(drive.scene.laws.time_step));
    results.extend(Sound::results(sound));
    let past = Past {
        sound,
        train: Some(spec.clone()),
        unsheared: top
            .iter()
            .map(|sample| sample.pressure[0] - sample.pressure[1])
            .collect(),
        ..input.past.clone()
    };
    let state = run::state_of(&drive.scene, past);
    Outcome {
        results,
        reasons: BTreeMap::new(),
        artifacts: BTreeMap::from([(STATE.to_owned(), state.to_bytes())]),
        warnings: vec![],
        steps: drive.cycle.steps(),
    }
}
