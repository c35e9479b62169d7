//! The stage `bend`: the compacted beam released from its mold, put on its supports and bent by two rods.
//!
//! 1. The mold is drawn away, and the beam comes to rest with the friction of the test.
//! 2. The bottom edges at its ends are held, and rods are put above the thirds of the span.
//! 3. The rods come down, smoothly at first, and the forces on them are recorded until the strain asked for is reached.

mod outcome;
mod record;
mod rods;

use serde::{Deserialize, Serialize};

use super::interior::Interior;
use super::jam::{mold, not_at_rest, velocities};
use super::rig::{Friction, Rig};
use super::run::{Course, Rest, Run, stopped};
use super::spec::{BendSpec, JamSpec, MembraneRest, Support};
use super::state::{Past, Snapshot};
use super::structure::coordination::{Coordination, coordination};
use crate::contact::frictionless::Frictionless;
use crate::contact::mindlin::Mindlin;
use crate::guard::Stop;
use crate::lanes::VectorWidth;
use crate::membrane::Mesh;
use crate::outcome::{Outcome, Progress, StageFailure};
use crate::wall::press::{Plane, Rod};

use record::{Record, Row};
use rods::Drive;

/// Where a bending is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum Phase {
    /// The mold is drawn away.
    Release,
    /// The beam comes to rest.
    Relax(Rest),
    /// The rods move.
    Bend(Box<Bending>),
}

/// A beam on its supports, under its rods.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Bending {
    drive: Drive,
    record: Record,
    /// Length, height and depth of the beam when bending began \[m\].
    actual: [f64; 3],
    /// φ when bending began.
    volume_fraction: f64,
    /// z under its names when the rods first touched.
    coordination: Option<Coordination>,
}

/// What a checkpoint remembers besides what moves.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Header {
    stage: String,
    course: Course,
    step: u64,
    phase: Phase,
    /// Position of the six walls, while there are any.
    walls: Vec<f64>,
    /// Place and velocity of the rods, once there are any.
    rods: Vec<[f64; 3]>,
}

/// Vertices with a part to play, by where they are in the mold.
struct Places {
    supports: [Vec<u32>; 2],
    /// In the middle of the bottom: their height is the deflection.
    middle: Vec<u32>,
    /// Of each axis the two faces, without their rims, which stick out once the mold is gone.
    faces: [[Vec<u32>; 2]; 3],
}

/// Bends the beam of `input`, or goes on from a checkpoint.
pub(crate) fn run(
    spec: &BendSpec,
    stage: &str,
    from: (&[u8], Option<&[u8]>),
    width: VectorWidth,
    progress: &mut Progress<'_>,
) -> Result<Outcome, StageFailure> {
    if spec.friction_coefficient == 0.0 {
        bent::<Frictionless>(spec, stage, from, width, progress)
    } else {
        bent::<Mindlin>(spec, stage, from, width, progress)
    }
}

fn bent<T: Friction>(
    spec: &BendSpec,
    stage: &str,
    (input, checkpoint): (&[u8], Option<&[u8]>),
    width: VectorWidth,
    progress: &mut Progress<'_>,
) -> Result<Outcome, StageFailure> {
    let state = Snapshot::<Past>::from_bytes(input)?;
    let grow = &state.header.grow;
    let jam = state.header.jam.as_ref().ok_or(StageFailure::Input {
        detail: "the input is a beam that was not compacted".to_owned(),
    })?;
    progress.steps = spec.predicted_steps(jam, grow);
    let rig = Rig {
        grow,
        jam: Some(jam),
        friction_coefficient: spec.friction_coefficient,
        damping: spec.background_damping,
        width,
    };
    let places = places(rig.membrane()?.mesh(), grow.membrane_edge);
    let mut bench = Bench {
        spec,
        past: &state.header,
        jam,
        stage,
        places,
    };
    let (mut run, mut phase) = match checkpoint {
        Some(bytes) => {
            let saved = Snapshot::<Header>::of_stage(bytes, stage, |header| &header.stage)?;
            bench.resumed::<T>(&rig, &saved, &state)?
        }
        None => bench.begun::<T>(&rig, &state)?,
    };
    loop {
        phase = match phase {
            Phase::Release => bench.release(&mut run, progress)?,
            Phase::Relax(rest) => bench.relax(&mut run, rest, progress)?,
            Phase::Bend(mut bending) => {
                bench.bend(&mut run, &mut bending, progress)?;
                return Ok(outcome::outcome(&bench, &run, &bending));
            }
        };
    }
}

/// The test bench: what stays the same through all phases.
struct Bench<'a> {
    spec: &'a BendSpec,
    past: &'a Past,
    jam: &'a JamSpec,
    stage: &'a str,
    places: Places,
}

impl Bench<'_> {
    fn begun<T: Friction>(
        &mut self,
        rig: &Rig<'_>,
        state: &Snapshot<Past>,
    ) -> Result<(Run<T>, Phase), StageFailure> {
        let mut beam = rig.restored::<T, _>(state)?;
        let casing = &mut beam.surroundings;
        self.forget_the_mold(&mut casing.membrane, &state.vertices);
        casing.press.pressure = self.jam.confining_pressure;
        let [low, high] = casing.membrane.mesh().bounds();
        let distances = [0, 1, 2].map(|k| 0.5 * (high[k] - low[k]) + self.jam.vertex_radius);
        casing.press.planes = mold(distances);
        let fractions = (self.spec.release_time_step_fraction, f64::MAX);
        let run = Run::new(beam, Course::BEGINNING, fractions, self.spec.overlap);
        Ok((run, Phase::Release))
    }

    fn resumed<T: Friction>(
        &mut self,
        rig: &Rig<'_>,
        saved: &Snapshot<Header>,
        state: &Snapshot<Past>,
    ) -> Result<(Run<T>, Phase), StageFailure> {
        let header = &saved.header;
        let mut beam = rig.restored::<T, _>(saved)?;
        let casing = &mut beam.surroundings;
        self.forget_the_mold(&mut casing.membrane, &state.vertices);
        casing.press.pressure = self.jam.confining_pressure;
        if matches!(header.phase, Phase::Release) {
            casing.press.planes = mold([0.0; 3]);
            for (plane, &position) in casing.press.planes.iter_mut().zip(&header.walls) {
                plane.position = position;
            }
        }
        let mut fraction = self.spec.release_time_step_fraction;
        if matches!(header.phase, Phase::Bend(_)) {
            self.support(&mut casing.membrane);
            casing.press.rods = header
                .rods
                .iter()
                .map(|&[x, z, v]| self.rod([x, z], v))
                .collect();
            fraction = self.spec.time_step_fraction;
            beam.laws.body_force.rate = self.spec.bending_damping;
        }
        let fractions = (fraction, f64::MAX);
        let run = Run::new(beam, header.course, fractions, self.spec.overlap);
        Ok((run, header.phase.clone()))
    }

    /// Lets the springs take the compacted shape for their rest, if so asked.
    fn forget_the_mold(&self, membrane: &mut crate::membrane::Membrane, compacted: &[[f64; 3]]) {
        if self.spec.membrane_rest == MembraneRest::ResetAfterCompaction {
            let now = membrane.mesh().positions().to_vec();
            membrane.positions_mut().copy_from_slice(compacted);
            membrane.reset_rest();
            membrane.positions_mut().copy_from_slice(&now);
        }
    }

    fn save<T: Friction>(&self, run: &Run<T>, phase: Phase) -> Vec<u8> {
        let press = &run.beam.surroundings.press;
        let header = Header {
            stage: self.stage.to_owned(),
            course: run.course(),
            step: run.step,
            phase,
            walls: press.planes.iter().map(|plane| plane.position).collect(),
            rods: press
                .rods
                .iter()
                .map(|rod| [rod.position[0], rod.position[1], rod.velocity])
                .collect(),
        };
        Snapshot::of(&run.beam, header).to_bytes()
    }

    /// Draws the mold away, by twice the size of a vertex.
    fn release<T: Friction>(
        &self,
        run: &mut Run<T>,
        progress: &mut Progress<'_>,
    ) -> Result<Phase, StageFailure> {
        let speed = 2.0 * self.jam.vertex_radius / self.spec.release_time;
        let draw = |plane: &mut Plane| plane.velocity = -plane.inward * speed;
        run.beam.surroundings.press.planes.iter_mut().for_each(draw);
        while run.time < self.spec.release_time {
            run.advance(progress, &|run| self.save(run, Phase::Release))?;
        }
        run.beam.surroundings.press.planes.clear();
        Ok(Phase::Relax(Rest::from(run.time)))
    }

    fn relax<T: Friction>(
        &self,
        run: &mut Run<T>,
        mut rest: Rest,
        progress: &mut Progress<'_>,
    ) -> Result<Phase, StageFailure> {
        loop {
            let due = rest.is_due(run.time);
            let before = if due { velocities(run) } else { vec![] };
            let saved = rest;
            run.advance(progress, &|run| self.save(run, Phase::Relax(saved)))?;
            if due && rest.check(&self.spec.rest, run, &before) {
                return Ok(self.mount(run));
            }
            if run.time > self.spec.release_time + self.spec.rest.longest {
                return Err(not_at_rest(run, self.spec.rest.longest));
            }
        }
    }

    /// Holds the ends, and puts the rods above the thirds of the span.
    fn mount<T: Friction>(&self, run: &mut Run<T>) -> Phase {
        let casing = &mut run.beam.surroundings;
        self.support(&mut casing.membrane);
        let mesh = casing.membrane.mesh();
        let [left, right] = self
            .places
            .supports
            .each_ref()
            .map(|side| mean(mesh, side, 0));
        let drive = Drive::new(self.spec, self.jam, self.past);
        let rods = [1.0 / 3.0, 2.0 / 3.0].map(|share| {
            let x = left + share * (right - left);
            let reach = self.spec.rod_radius + self.jam.vertex_radius;
            let near = mesh
                .positions()
                .iter()
                .filter(|place| (place[0] - x).abs() <= reach);
            let top = near.map(|place| place[2]).fold(f64::NEG_INFINITY, f64::max);
            self.rod([x, top + reach + drive.gap()], 0.0)
        });
        let volume = mesh.volume();
        let [length, depth, height] = [0, 1, 2].map(|axis| self.extent(mesh, axis));
        casing.press.rods = rods.to_vec();
        run.fraction = self.spec.time_step_fraction;
        run.beam.laws.body_force.rate = self.spec.bending_damping;
        run.time = 0.0;
        Phase::Bend(Box::new(Bending {
            drive,
            record: Record::default(),
            actual: [length, height, depth],
            volume_fraction: super::probe::grain_volume(&run.beam) / volume,
            coordination: None,
        }))
    }

    fn rod(&self, position: [f64; 2], velocity: f64) -> Rod {
        Rod {
            position,
            velocity,
            radius: self.spec.rod_radius,
            force: 0.0,
        }
    }

    fn support(&self, membrane: &mut crate::membrane::Membrane) {
        let [left, right] = &self.places.supports;
        membrane.hold(left, [true; 3]);
        let along = self.spec.support == Support::PinnedPinned;
        membrane.hold(right, [along, true, true]);
    }

    fn bend<T: Friction>(
        &self,
        run: &mut Run<T>,
        bending: &mut Bending,
        progress: &mut Progress<'_>,
    ) -> Result<(), StageFailure> {
        let all: Vec<u32> = self.places.supports.concat();
        while !bending.drive.is_over() {
            let velocity = bending.drive.velocity(run.time);
            for rod in &mut run.beam.surroundings.press.rods {
                rod.velocity = -velocity;
            }
            run.advance(progress, &|run| {
                self.save(run, Phase::Bend(Box::new(bending.clone())))
            })?;
            let way = velocity * run.beam.laws.time_step;
            let casing = &run.beam.surroundings;
            let force: f64 = casing.press.rods.iter().map(|rod| rod.force).sum();
            let reaction = casing.membrane.reaction(&all)[2];
            let height = self.middle_height(casing.membrane.mesh());
            bending.record.add([force, reaction, height], way);
            if bending.record.is_due(bending.drive.sample_way()) {
                let row = Row::of(run, self.spec, bending.record.mean(run.time));
                let row = bending.record.close(row);
                bending
                    .drive
                    .follow(&row, run.time)
                    .map_err(|stop: Stop| stopped(run.step, stop))?;
                if bending.coordination.is_none() && bending.drive.zero().is_some() {
                    let interior = Interior::of(&run.beam, self.spec.friction_coefficient);
                    bending.coordination = Some(coordination(&interior.packing(run.step)?));
                }
            }
        }
        Ok(())
    }

    fn middle_height(&self, mesh: &Mesh) -> f64 {
        mean(mesh, &self.places.middle, 2)
    }

    /// Mean distance of the two faces of an axis.
    fn extent(&self, mesh: &Mesh, axis: usize) -> f64 {
        let [low, high] = &self.places.faces[axis];
        mean(mesh, high, axis) - mean(mesh, low, axis)
    }
}

/// Mean coordinate of vertices.
fn mean(mesh: &Mesh, vertices: &[u32], axis: usize) -> f64 {
    let sum: f64 = vertices
        .iter()
        .map(|&v| mesh.positions()[v as usize][axis])
        .sum();
    sum / vertices.len() as f64
}

/// Finds supports, middle and faces on the mesh as it is in the mold.
fn places(mesh: &Mesh, edge: f64) -> Places {
    let [low, high] = mesh.bounds();
    let pick = |wanted: &dyn Fn(&[f64; 3]) -> bool| {
        (0u32..)
            .zip(mesh.positions())
            .filter(|(_, place)| wanted(place))
            .map(|(vertex, _)| vertex)
            .collect::<Vec<u32>>()
    };
    let bottom = |place: &[f64; 3]| place[2] < low[2] + 1e-6 * edge;
    let inside = |place: &[f64; 3], axis: usize| {
        (0..3).all(|k| k == axis || place[k].abs() < high[k] - 1.5 * edge)
    };
    let face = |axis: usize, sign: f64| {
        pick(&|place| sign * place[axis] > high[axis] - 1e-6 * edge && inside(place, axis))
    };
    Places {
        supports: [
            pick(&|place| bottom(place) && place[0] - low[0] <= 0.75 * edge),
            pick(&|place| bottom(place) && high[0] - place[0] <= 0.75 * edge),
        ],
        middle: pick(&|place| {
            bottom(place) && place[0].abs() <= edge && place[1].abs() <= 0.5 * high[1]
        }),
        faces: [0, 1, 2].map(|axis| [face(axis, -1.0), face(axis, 1.0)]),
    }
}
