//! The stage `pack`: gas, servo, and two frictionless compression cycles (Sec. II.2).

mod settle;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use self::settle::{Preparation, SERVO_SPEED};
use super::cycle::{Cycle, Drive, Segment, Track};
use super::gas::Lattice;
use super::ramp_steps;
use super::run;
use super::spec::{PackSpec, ShapeName};
use super::state::{Checkpoint, Past};
use crate::contact::frictionless::Frictionless;
use crate::grains::{Grains, Motion, Pose, spatial_order};
use crate::guard::Guard;
use crate::lanes::{F64x1, VectorWidth};
use crate::material::Material;
use crate::math::plain;
use crate::observable::critical_time_step::{Across, CriticalTimeStep, critical_time_step};
use crate::observable::observe;
use crate::outcome::{Outcome, Progress, STATE, StageFailure};
use crate::protocol::{Box2, Servo};
use crate::scene::{Laws, Scene, With};
use crate::shape::{Body, Shape};
use crate::wall::{WALLS, Walls};

/// The physics of preparation.
type Smooth<S> = With<S, Frictionless, ()>;

/// How far lists reach at least; they reach farther while grains fly \[R\].
const SKIN: f64 = 0.05;

/// Where a preparation is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Phase {
    Gas,
    Servo,
    Cycles,
}

/// What a checkpoint of a preparation remembers besides the grains.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Header {
    stage: String,
    step: u64,
    phase: Phase,
    phase_step: u64,
    servo: Servo,
    servo_steps: u64,
    walls: [f64; WALLS],
    critical_at_start: CriticalTimeStep,
    track: Track,
}

/// The guard of a preparation.
fn guard(critical_at_start: CriticalTimeStep) -> Guard {
    Guard {
        parameter: "preparation_time_step",
        deepest_slice: None,
        critical_at_start,
    }
}

/// The laws of preparation.
fn laws<S: Shape>(spec: &PackSpec, width: VectorWidth) -> Laws<Smooth<S>> {
    Laws {
        body: body(spec),
        material: material(spec),
        tangential: Frictionless,
        body_force: (),
        time_step: spec.preparation_time_step,
        dither: 0.0,
        skin: SKIN,
        width,
    }
}

/// The rigid body of a pack's grains.
pub(super) fn body(spec: &PackSpec) -> Body {
    match spec.shape {
        ShapeName::Sphere => Body::sphere(),
        ShapeName::Tetrahedron => Body::tetrahedron(spec.overlap),
    }
}

/// The material of a pack's grains.
pub(super) fn material(spec: &PackSpec) -> Material {
    Material::new(spec.poisson_ratio, spec.normal_damping, spec.wall_stiffness)
}

/// Prepares a pack from its spec, or goes on from a checkpoint.
pub(crate) fn run<S: Shape>(
    spec: &PackSpec,
    stage: &str,
    checkpoint: Option<&[u8]>,
    width: VectorWidth,
    progress: &mut Progress<'_>,
) -> Result<Outcome, StageFailure> {
    let mut saved = match checkpoint {
        Some(bytes) => Some(read::<S>(spec, stage, bytes, width)?),
        None => None,
    };
    let mut preparation = match saved.take() {
        Some(Saved::Free(preparation)) => *preparation,
        Some(Saved::Cycling(drive, servo_steps)) => {
            return cycles(spec, stage, drive, servo_steps, progress);
        }
        None => Preparation::new(spec, stage, width),
    };
    preparation.gas(progress)?;
    preparation.settle(progress)?;
    let servo_steps = preparation.servo_steps;
    let drive = packed(&preparation, width)?;
    cycles(spec, stage, drive, servo_steps, progress)
}

/// What a checkpoint holds.
enum Saved<'a, S: Shape> {
    Free(Box<Preparation<'a, S>>),
    Cycling(Box<Drive<F64x1, Smooth<S>>>, u64),
}

fn lone_scene<S: Shape>(
    laws: Laws<Smooth<S>>,
    poses: Vec<Pose>,
    motions: &[Motion],
    walls: [f64; WALLS],
) -> Scene<F64x1, Smooth<S>> {
    let mut grains = Grains::at_rest(poses, &laws.body, S::SPHERES > 1);
    for (i, &motion) in motions.iter().enumerate() {
        grains.set_motion(i, 0, motion);
    }
    Scene::new(laws, grains, Walls::at_rest(walls))
}

/// The packed grains, renumbered by place, at the start of the cycles.
fn packed<S: Shape>(
    preparation: &Preparation<'_, S>,
    width: VectorWidth,
) -> Result<Box<Drive<F64x1, Smooth<S>>>, StageFailure> {
    let walls: [f64; WALLS] = std::array::from_fn(|w| preparation.scene.walls.position(w, 0));
    // The middle of the box is the origin again, about which it will be compressed.
    let middle = [0.0, 0.0, 0.5 * (walls[4] + walls[5])];
    let half = 0.5 * (walls[5] - walls[4]);
    let walls = [walls[0], walls[1], walls[2], walls[3], -half, half];
    let grains = &preparation.scene.grains;
    let poses: Vec<Pose> = (0..grains.len())
        .map(|i| grains.pose(i, 0))
        .map(|pose| Pose {
            position: plain::sub(pose.position, middle),
            ..pose
        })
        .collect();
    let order = spatial_order(&poses);
    let motions: Vec<Motion> = order.iter().map(|&i| grains.motion(i, 0)).collect();
    let poses = order.iter().map(|&i| poses[i]).collect();
    let laws = laws::<S>(preparation.spec, width);
    let scene = lone_scene(laws, poses, &motions, walls);
    let critical = critical_time_step(&scene, 0, Across::default());
    guard(critical)
        .admit(scene.laws.time_step, critical)
        .map_err(|stop| run::stopped(preparation.step(), stop))?;
    Ok(Box::new(cycling(preparation.spec, scene, walls, critical)))
}

/// The compression cycles of a preparation.
fn cycling<S: Shape>(
    spec: &PackSpec,
    mut scene: Scene<F64x1, Smooth<S>>,
    walls: [f64; WALLS],
    critical: CriticalTimeStep,
) -> Drive<F64x1, Smooth<S>> {
    let steps = ramp_steps(spec.preparation_ramp, spec.preparation_time_step);
    scene.laws.time_step = spec.preparation_ramp / steps as f64;
    let segments = (0..2 * spec.preparation_cycles)
        .map(|n| Segment::ramp(steps, n % 2 == 0, false, None))
        .collect();
    let extent = Box2 {
        x: walls[1] - walls[0],
        y: walls[3] - walls[2],
    };
    let cycle = Cycle {
        segments,
        delta0: spec.delta0,
        extent,
    };
    Drive::new(
        scene,
        cycle,
        vec![run::silent()],
        Across::default(),
        guard(critical),
    )
}

/// Goes through the cycles and writes the prepared pack.
fn cycles<S: Shape>(
    spec: &PackSpec,
    stage: &str,
    mut drive: Box<Drive<F64x1, Smooth<S>>>,
    servo_steps: u64,
    progress: &mut Progress<'_>,
) -> Result<Outcome, StageFailure> {
    let before = servo_steps + (spec.gas_time / spec.preparation_time_step).ceil() as u64;
    let last = drive.cycle.steps();
    let walls = drive.scene.walls.reference();
    run::drive(
        &mut drive,
        (before.cast_signed(), last),
        progress,
        &|drive, k| {
            let header = Header {
                stage: stage.to_owned(),
                step: before + drive.step,
                phase: Phase::Cycles,
                phase_step: drive.step,
                servo: Servo::new(spec.servo_pressure, SERVO_SPEED),
                servo_steps,
                walls,
                critical_at_start: drive.critical_at_start(),
                track: drive.tracks[k].clone(),
            };
            run::checkpoint_of(&drive.scene, k, header).to_bytes()
        },
    )?;
    if let Some((step, stop)) = drive.stops[0].take() {
        return Err(run::stopped(before + step, stop));
    }
    let past = Past {
        pack: spec.clone(),
        train: None,
        walls,
        unsheared: vec![],
        sound: None,
    };
    let seen = observe(&drive.scene)[0];
    let steps = before + last;
    let mut results = run::observed(&seen, "");
    results.insert("servo_steps".to_owned(), Some(servo_steps as f64));
    results.extend(run::measured(drive.tracks[0].critical_time_step));
    for (name, axis) in [("extent_x", 0), ("extent_y", 1), ("extent_z", 2)] {
        results.insert(
            name.to_owned(),
            Some(drive.scene.walls.extent(axis, 0) * spec.radius),
        );
    }
    let state = run::state_of(&drive.scene, past);
    Ok(Outcome {
        results,
        reasons: BTreeMap::new(),
        artifacts: BTreeMap::from([(STATE.to_owned(), state.to_bytes())]),
        warnings: vec![],
        steps,
    })
}

fn read<'a, S: Shape>(
    spec: &'a PackSpec,
    stage: &str,
    bytes: &[u8],
    width: VectorWidth,
) -> Result<Saved<'a, S>, StageFailure> {
    let saved: Checkpoint<Header> =
        run::read_checkpoint(&[stage], bytes, |header: &Header| &header.stage)?;
    let header = saved.header.clone();
    let laws = laws::<S>(spec, width);
    if header.phase == Phase::Cycles {
        let scene = run::restored(laws, header.walls, &[saved])?;
        let mut drive = cycling(spec, scene, header.walls, header.critical_at_start);
        drive.step = header.phase_step;
        drive.tracks = vec![header.track];
        drive.place_walls();
        return Ok(Saved::Cycling(Box::new(drive), header.servo_steps));
    }
    let reference = Lattice::new(spec.grains, &laws.body).walls();
    let mut scene: Scene<F64x1, Smooth<S>> = run::restored(laws, reference, &[saved])?;
    for (w, &position) in header.walls.iter().enumerate() {
        scene.walls.place(w, 0, position);
    }
    scene.renew_contacts();
    Ok(Saved::Free(Box::new(Preparation {
        spec,
        stage: stage.to_owned(),
        scene,
        phase: header.phase,
        phase_step: header.phase_step,
        servo: header.servo,
        servo_steps: header.servo_steps,
        good: None,
    })))
}
