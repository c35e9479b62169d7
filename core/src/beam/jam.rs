//! The stage `jam`: pressure on the membrane compacts the grains, and the walls of the mold follow.
//!
//! Walls move inward only, both of a pair alike, so that the beam stays a cuboid.
//! 1. By default all move by one strain rate and take the membrane with them ([`even`]), under a part of Δp, until the grains
//!    bear half of that.
//! 2. Then the pressure rises to Δp, and each pair follows the membrane for itself until all is at rest: at its largest speed
//!    where it carries nothing, and slower the more of `mold_load` Δp A it carries.

mod even;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::probe;
use super::rig::{Friction, Rig};
use super::run::{Course, Rest, Run, stopped};
use super::spec::{JamSpec, Mold};
use super::state::{Past, Snapshot};
use crate::contact::frictionless::Frictionless;
use crate::contact::mindlin::Mindlin;
use crate::grains::Motion;
use crate::guard::Stop;
use crate::lanes::VectorWidth;
use crate::outcome::{Outcome, Progress, STATE, StageFailure};
use crate::wall::press::Plane;
use even::Faces;

/// Pressure of grown grains on one another, over Δp, from which on they are not loose before they are compacted.
const LARGEST_GROWTH_PRESSURE: f64 = 0.1;

/// What a checkpoint remembers besides what moves.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Header {
    stage: String,
    course: Course,
    step: u64,
    rest: Rest,
    /// Position, velocity and last load of the six walls.
    walls: Vec<[f64; 3]>,
    phase: Phase,
}

/// Where a compaction is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Phase {
    /// All walls move inward, by this strain rate \[1/s\].
    Even(f64),
    /// The pressure rises, from walls that stand at this share of the mold's sides.
    Rising(f64),
}

impl Phase {
    /// What to do about a beam that is in this phase for too long.
    fn remedy(self) -> &'static str {
        match self {
            Self::Even(_) => "use a larger mold_speed: the walls have not met the grains yet",
            Self::Rising(_) => CALMER,
        }
    }
}

/// Compacts the grown grains of `input`, or goes on from a checkpoint.
pub(crate) fn run(
    spec: &JamSpec,
    stage: &str,
    from: (&[u8], Option<&[u8]>),
    width: VectorWidth,
    progress: &mut Progress<'_>,
) -> Result<Outcome, StageFailure> {
    if spec.initial_friction_coefficient == 0.0 {
        compacted::<Frictionless>(spec, stage, from, width, progress)
    } else {
        compacted::<Mindlin>(spec, stage, from, width, progress)
    }
}

fn compacted<T: Friction>(
    spec: &JamSpec,
    stage: &str,
    (input, checkpoint): (&[u8], Option<&[u8]>),
    width: VectorWidth,
    progress: &mut Progress<'_>,
) -> Result<Outcome, StageFailure> {
    let state = Snapshot::<Past>::from_bytes(input)?;
    let grow = &state.header.grow;
    progress.steps = spec.predicted_steps(grow);
    let rig = Rig {
        grow,
        jam: Some(spec),
        friction_coefficient: spec.initial_friction_coefficient,
        damping: spec.background_damping,
        width,
    };
    let sides = [grow.length, grow.depth, grow.height];
    let faces = Faces::of(rig.membrane()?.mesh(), spec, grow);
    let mut walls = outside(spec, sides);
    let (mut beam, course, mut rest, mut phase) = match checkpoint {
        Some(bytes) => {
            let saved = Snapshot::<Header>::of_stage(bytes, stage, |header| &header.stage)?;
            let header = &saved.header;
            for (wall, &[position, velocity, force]) in walls.iter_mut().zip(&header.walls) {
                (wall.position, wall.velocity, wall.force) = (position, velocity, force);
            }
            let beam = rig.restored::<T, _>(&saved)?;
            (beam, header.course, header.rest, header.phase)
        }
        None => (
            rig.restored::<T, _>(&still(&state))?,
            Course::BEGINNING,
            Rest::from(spec.pressure_ramp),
            if spec.mold == Mold::Even && faces.are_loose() {
                Phase::Even(faces.fastest)
            } else {
                Phase::Rising(1.0)
            },
        ),
    };
    let casing = &mut beam.surroundings;
    match phase {
        Phase::Even(_) => faces.hold(&mut casing.membrane),
        Phase::Rising(_) => casing.press.planes = walls,
    }
    let mut run = Run::new(
        beam,
        course,
        (spec.time_step_fraction, f64::MAX),
        spec.overlap,
    );
    loop {
        let casing = &mut run.beam.surroundings;
        match phase {
            Phase::Even(rate) => {
                casing.press.pressure = faces.pressure;
                faces.drive(&mut casing.membrane, rate);
            }
            Phase::Rising(scale) => {
                let risen = (run.time / spec.pressure_ramp).min(1.0);
                casing.press.pressure = spec.confining_pressure * risen;
                faces.relax(&mut casing.membrane, scale + (1.0 - scale) * risen);
                follow(spec, &mut casing.press.planes);
            }
        }
        let due = matches!(phase, Phase::Rising(_)) && rest.is_due(run.time);
        let before = if due { velocities(&run) } else { vec![] };
        let saved_rest = rest;
        run.advance(progress, &|run| {
            let planes = &run.beam.surroundings.press.planes;
            let header = Header {
                stage: stage.to_owned(),
                course: run.course(),
                step: run.step,
                rest: saved_rest,
                walls: planes
                    .iter()
                    .map(|wall| [wall.position, wall.velocity, wall.force])
                    .collect(),
                phase,
            };
            Snapshot::of(&run.beam, header).to_bytes()
        })?;
        if let Phase::Even(rate) = phase {
            let casing = &mut run.beam.surroundings;
            if let Some(rate) = faces.next(rate, &casing.membrane, run.beam.laws.time_step) {
                phase = Phase::Even(rate);
            } else {
                faces.release(&mut casing.membrane);
                casing.press.planes = outside(spec, casing.membrane.mesh().extent());
                // The pressure rises from what the walls moved under.
                run.time = even::PRESSURE * spec.pressure_ramp;
                phase = Phase::Rising(faces.scale(casing.membrane.mesh()));
            }
        }
        if due && rest.check(&spec.rest, &mut run, &before) {
            break;
        }
        if run.time > spec.pressure_ramp + spec.rest.longest {
            return Err(not_at_rest(&run, spec.rest.longest, phase.remedy()));
        }
    }
    let overgrown = pressed_by_growth::<T>(spec, &rig, &state)?;
    Ok(outcome(spec, (&state.header, overgrown), &run))
}

/// What to do about a beam that stays in motion.
pub(super) const CALMER: &str = "use background_damping, or a larger longest_rest";

/// A run that does not come to rest.
pub(super) fn not_at_rest<T: Friction>(run: &Run<T>, longest: f64, remedy: &str) -> StageFailure {
    let stop = Stop {
        kind: "not_at_rest",
        detail: format!("the beam has not come to rest within {longest} s"),
        remedy: remedy.to_owned(),
    };
    stopped(run.step, stop)
}

/// The velocities of all grains.
pub(super) fn velocities<T: Friction>(run: &Run<T>) -> Vec<[f64; 3]> {
    let grains = &run.beam.grains;
    (0..grains.len())
        .map(|i| grains.motion(i, 0).velocity)
        .collect()
}

/// The warning that grown grains press on one another by more than a tenth of Δp: p = (1/3V) Σ f l, with l the branch.
fn pressed_by_growth<T: Friction>(
    spec: &JamSpec,
    rig: &Rig<'_>,
    state: &Snapshot<Past>,
) -> Result<Option<String>, StageFailure> {
    let beam = rig.restored::<T, _>(&still(state))?;
    let branch =
        |c: &probe::GrainContact| beam.grains.radius(c.i) + beam.grains.radius(c.j) - c.overlap;
    let contacts = probe::contacts(&beam);
    let virial: f64 = contacts.iter().map(|c| c.normal_force * branch(c)).sum();
    let pressure = virial / (3.0 * beam.surroundings.membrane.mesh().volume());
    let most = LARGEST_GROWTH_PRESSURE * spec.confining_pressure;
    Ok((most > 0.0 && pressure > most).then(|| {
        format!(
            "growth_overshoot: grown grains press on one another by {pressure:.1e} Pa, more than a tenth of the \
             confining pressure: use a smaller initial_volume_fraction or a longer growth_time"
        )
    }))
}

/// The state with everything at rest: what growth stirred up has no part in compaction.
fn still<H: Clone>(state: &Snapshot<H>) -> Snapshot<H> {
    Snapshot {
        motions: vec![Motion::default(); state.motions.len()],
        velocities: vec![[0.0; 3]; state.velocities.len()],
        ..state.clone()
    }
}

/// Six walls at these distances from the middle: −x, +x, −y, +y, −z, +z.
pub(super) fn mold(distances: [f64; 3]) -> Vec<Plane> {
    let wall = |axis: usize, inward: f64| Plane {
        axis,
        inward,
        position: -inward * distances[axis],
        velocity: 0.0,
        force: 0.0,
    };
    (0..3)
        .flat_map(|axis| [wall(axis, 1.0), wall(axis, -1.0)])
        .collect()
}

/// The walls of a mold that vertices touch when they fill a cuboid of these sides.
fn outside(spec: &JamSpec, sides: [f64; 3]) -> Vec<Plane> {
    mold(sides.map(|side| 0.5 * side + spec.vertex_radius))
}

/// Sets the walls' speeds by what they carried in the last step.
fn follow(spec: &JamSpec, walls: &mut [Plane]) {
    let extent =
        |walls: &[Plane], axis: usize| walls[2 * axis + 1].position - walls[2 * axis].position;
    for axis in 0..3 {
        let area = extent(walls, (axis + 1) % 3) * extent(walls, (axis + 2) % 3);
        let most = spec.mold_load * spec.confining_pressure * area;
        let carried = 0.5 * (walls[2 * axis].force + walls[2 * axis + 1].force);
        let share = if most > 0.0 { carried / most } else { 1.0 };
        let speed = spec.mold_speed * (1.0 - share).clamp(0.0, 1.0);
        for wall in &mut walls[2 * axis..2 * axis + 2] {
            wall.velocity = wall.inward * speed;
        }
    }
}

fn outcome<T: Friction>(
    spec: &JamSpec,
    (past, overgrown): (&Past, Option<String>),
    run: &Run<T>,
) -> Outcome {
    let mesh = run.beam.surroundings.membrane.mesh();
    let [length, depth, height] = mesh.extent();
    let grains = run.beam.grains.len() as f64;
    let touched = grains > 0.0;
    let results = [
        ("grains", Some(grains)),
        (
            "volume_fraction",
            Some(probe::grain_volume(&run.beam) / mesh.volume()),
        ),
        (
            "coordination_number",
            touched.then(|| 2.0 * run.contacts.len() as f64 / grains),
        ),
        ("largest_overlap", Some(run.deepest)),
        ("actual_length", Some(length)),
        ("actual_height", Some(height)),
        ("actual_depth", Some(depth)),
        ("critical_time_step", Some(run.critical)),
    ];
    let earlier = past.warnings.iter().cloned();
    let own = run.warnings("in compaction");
    let warnings: Vec<String> = earlier.chain(overgrown).chain(own).collect();
    let past = Past {
        grow: past.grow.clone(),
        jam: Some(spec.clone()),
        warnings: warnings.clone(),
    };
    let state = Snapshot::of(&run.beam, past).to_bytes();
    Outcome {
        results: results
            .into_iter()
            .map(|(name, value)| (name.to_owned(), value))
            .collect(),
        artifacts: BTreeMap::from([(STATE.to_owned(), state)]),
        reasons: BTreeMap::new(),
        warnings,
        steps: run.step,
    }
}
