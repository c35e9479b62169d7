//! The stage `bend`: the compacted beam released from its mold, put on its supports and bent by two rods.
//!
//! 1. The mold is drawn away, and the beam comes to rest with the friction of the test.
//! 2. The bottom edges at its ends are held, and rods are put above the thirds of the span.
//! 3. The rods come down, smoothly at first, and the forces on them are recorded until the strain asked for is reached.

mod history;
mod outcome;
mod places;
mod record;
mod rods;
mod snapshots;

use serde::{Deserialize, Serialize};

use super::interior::Interior;
use super::jam::{CALMER, mold, not_at_rest, velocities};
use super::rig::{Friction, Rig};
use super::run::{Course, Rest, Run, stopped};
use super::spec::{BendSpec, JamSpec, MembraneRest, Support};
use super::state::{Past, Snapshot};
use super::structure::coordination::{Coordination, coordination};
use crate::contact::frictionless::Frictionless;
use crate::contact::mindlin::Mindlin;
use crate::guard::Stop;
use crate::lanes::VectorWidth;
use crate::math::plain;
use crate::membrane::Mesh;
use crate::outcome::{Outcome, Progress, StageFailure};
use crate::wall::press::{Plane, Rod};

use places::{Places, mean, places};
use record::{Record, Row};
use rods::Drive;
use snapshots::Snapshots;

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
    /// The largest pull of one support at a sample \[N\].
    largest_pull: f64,
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
    let mut snapshots = Snapshots::default();
    let (mut run, mut phase) = match checkpoint {
        Some(bytes) => {
            let (saved, rest) =
                Snapshot::<Header>::of_stage_with_rest(bytes, stage, |header| &header.stage)?;
            let (run, phase) = bench.resumed::<T>(&rig, &saved, &state)?;
            snapshots = Snapshots::from_bytes(rest, (&run.beam, run.step), spec)?;
            (run, phase)
        }
        None => bench.begun::<T>(&rig, &state)?,
    };
    loop {
        phase = match phase {
            Phase::Release => bench.release(&mut run, progress)?,
            Phase::Relax(rest) => bench.relax(&mut run, rest, progress)?,
            Phase::Bend(mut bending) => {
                bench.bend(&mut run, (&mut bending, &mut snapshots), progress)?;
                return Ok(outcome::outcome(&bench, &run, (&bending, &snapshots)));
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
        let extent = casing.membrane.mesh().extent();
        let distances = extent.map(|side| 0.5 * side + self.jam.vertex_radius);
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
            beam.surroundings.press.drag = self.spec.bending_damping;
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

    fn save<T: Friction>(&self, run: &Run<T>, phase: Phase, snapshots: &Snapshots) -> Vec<u8> {
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
        let mut bytes = Snapshot::of(&run.beam, header).to_bytes();
        bytes.extend(snapshots.to_bytes());
        bytes
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
            run.advance(progress, &|run| {
                self.save(run, Phase::Release, &Snapshots::default())
            })?;
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
            run.advance(progress, &|run| {
                self.save(run, Phase::Relax(saved), &Snapshots::default())
            })?;
            if due && rest.check(&self.spec.rest, run, &before) {
                return Ok(self.mount(run));
            }
            if run.time > self.spec.release_time + self.spec.rest.longest {
                return Err(not_at_rest(run, self.spec.rest.longest, CALMER));
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
        run.beam.surroundings.press.drag = self.spec.bending_damping;
        run.time = 0.0;
        Phase::Bend(Box::new(Bending {
            drive,
            record: Record::default(),
            actual: [length, height, depth],
            volume_fraction: super::probe::grain_volume(&run.beam) / volume,
            largest_pull: 0.0,
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
        (bending, snapshots): (&mut Bending, &mut Snapshots),
        progress: &mut Progress<'_>,
    ) -> Result<(), StageFailure> {
        let all: Vec<u32> = self.places.supports.concat();
        while !bending.drive.is_over() {
            let velocity = bending.drive.velocity(run.time);
            for rod in &mut run.beam.surroundings.press.rods {
                rod.velocity = -velocity;
            }
            run.advance(progress, &|run| {
                self.save(run, Phase::Bend(Box::new(bending.clone())), snapshots)
            })?;
            let way = velocity * run.beam.laws.time_step;
            let casing = &run.beam.surroundings;
            let force: f64 = casing.press.rods.iter().map(|rod| rod.force).sum();
            let reaction = casing.membrane.reaction(&all)[2];
            let height = self.middle_height(casing.membrane.mesh());
            bending.record.add([force, reaction, height], way);
            if bending.record.is_due(bending.drive.sample_way()) {
                self.close_row(run, bending)?;
            }
            if bending.drive.zero().is_some() {
                let moved = (way, bending.record.travel());
                snapshots.follow(run, self.spec, moved, bending.actual[1])?;
            }
        }
        Ok(())
    }

    /// Keeps a row of the record, and lets the rods follow it.
    fn close_row<T: Friction>(
        &self,
        run: &Run<T>,
        bending: &mut Bending,
    ) -> Result<(), StageFailure> {
        let row = Row::of(run, self.spec, bending.record.mean(run.time));
        let row = bending.record.close(row);
        bending.largest_pull = bending.largest_pull.max(self.pull(run));
        bending
            .drive
            .follow(&row, run.time)
            .map_err(|stop: Stop| stopped(run.step, stop))?;
        if let Some(zero) = bending.drive.zero() {
            let rows = bending.record.since_touch(zero);
            bending.drive.look_for_yield(rows);
        }
        if bending.coordination.is_none() && bending.drive.zero().is_some() {
            let interior = Interior::of(&run.beam, self.spec.friction_coefficient);
            bending.coordination = Some(coordination(&interior.packing(run.step)?));
        }
        Ok(())
    }

    /// The larger pull of the two supports \[N\].
    fn pull<T: Friction>(&self, run: &Run<T>) -> f64 {
        let membrane = &run.beam.surroundings.membrane;
        let [left, right] = self.places.supports.each_ref();
        let pull = |support: &[u32]| plain::norm(membrane.reaction(support));
        pull(left).max(pull(right))
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

#[cfg(test)]
mod tests;
