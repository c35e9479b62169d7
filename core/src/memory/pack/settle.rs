//! Gas and servo: grains fly in a fixed box, then the +z wall presses them together until they rest (Sec. II.2).

use super::{Header, Phase, Smooth, guard, laws, lone_scene};
use crate::grains::Grains;
use crate::guard::Stop;
use crate::lanes::{F64x1, VectorWidth};
use crate::memory::cycle::{REPORT_EVERY, Track};
use crate::memory::gas::{self, Lattice};
use crate::memory::run;
use crate::memory::spec::PackSpec;
use crate::observable::critical_time_step::{Across, CriticalTimeStep, critical_time_step};
use crate::observable::{Observation, observe};
use crate::outcome::{Progress, StageFailure};
use crate::protocol::Servo;
use crate::scene::{Physics, Scene};
use crate::shape::Shape;
use crate::wall::Walls;

/// How fast the servo's wall may advance \[R/t_c\].
pub(super) const SERVO_SPEED: f64 = 0.01;

/// How long the servo may take \[t_c\]: ten times what packs need (docs/choices.md §3).
const SERVO_TIME: f64 = 250_000.0;

/// How often the critical time step is measured under the servo \[steps\]: it costs about a hundred steps, a hundredth.
const MEASURE_EVERY: u64 = 10_000;

/// How close the servo must be to its pressure.
const SETTLED: f64 = 0.01;

/// A preparation between two steps.
pub(super) struct Preparation<'a, S: Shape> {
    pub(super) spec: &'a PackSpec,
    pub(super) stage: String,
    pub(super) scene: Scene<F64x1, Smooth<S>>,
    pub(super) phase: Phase,
    pub(super) phase_step: u64,
    pub(super) servo: Servo,
    pub(super) servo_steps: u64,
    /// The last moment that was looked at and found good.
    pub(super) good: Option<Moment>,
}

/// What the steps of gas and servo start from.
pub(super) struct Moment {
    step: u64,
    grains: Grains<F64x1>,
    walls: Walls<F64x1>,
    servo: Servo,
}

/// One step, under the servo's wall or, in the gas, in a fixed box.
fn advance<P: Physics>(scene: &mut Scene<F64x1, P>, servo: Option<&mut Servo>) {
    match servo {
        None => scene.step(),
        Some(servo) => {
            servo.advance(scene);
            scene.step();
            servo.feel(scene);
        }
    }
}

impl<'a, S: Shape> Preparation<'a, S> {
    /// Grains of a gas in the box of their lattice.
    pub(super) fn new(spec: &'a PackSpec, stage: &str, width: VectorWidth) -> Self {
        let laws = laws::<S>(spec, width);
        let lattice = Lattice::new(spec.grains, &laws.body);
        let (poses, motions) = gas::start(spec, &laws.body, &lattice);
        let scene = lone_scene(laws, poses, &motions, lattice.walls());
        Self {
            spec,
            stage: stage.to_owned(),
            scene,
            phase: Phase::Gas,
            phase_step: 0,
            servo: Servo::new(spec.servo_pressure, SERVO_SPEED),
            servo_steps: 0,
            good: None,
        }
    }

    /// Steps since the gas began.
    pub(super) fn step(&self) -> u64 {
        let gas = self.gas_steps();
        match self.phase {
            Phase::Gas => self.phase_step,
            Phase::Servo | Phase::Cycles => gas + self.phase_step,
        }
    }

    fn gas_steps(&self) -> u64 {
        (self.spec.gas_time / self.spec.preparation_time_step).ceil() as u64
    }

    /// Mixes the gas in its fixed box.
    pub(super) fn gas(&mut self, progress: &mut Progress<'_>) -> Result<(), StageFailure> {
        while self.phase == Phase::Gas {
            if self.phase_step >= self.gas_steps() {
                (self.phase, self.phase_step) = (Phase::Servo, 0);
                break;
            }
            self.look()?;
            self.report(progress)?;
            self.advance();
        }
        Ok(())
    }

    /// Lets the +z wall press until the grains are at rest under it.
    pub(super) fn settle(&mut self, progress: &mut Progress<'_>) -> Result<(), StageFailure> {
        while self.phase == Phase::Servo {
            if let Some(seen) = self.look()? {
                if seen.kinetic_energy < self.spec.rest_kinetic_energy
                    && self.servo.is_settled(SETTLED)
                {
                    self.servo_steps = self.phase_step;
                    break;
                }
                self.measure()?;
                self.give_up(&seen)?;
            }
            self.report(progress)?;
            self.advance();
        }
        Ok(())
    }

    /// One step of gas or servo.
    fn advance(&mut self) {
        if self.phase_step.is_multiple_of(REPORT_EVERY) {
            self.good = Some(self.moment());
        }
        let servo = (self.phase == Phase::Servo).then_some(&mut self.servo);
        advance(&mut self.scene, servo);
        self.phase_step += 1;
    }

    /// Every hundred steps: tells the caller, who may save what [`Preparation::look`] found good.
    fn report(&self, progress: &mut Progress<'_>) -> Result<(), StageFailure> {
        if self.phase_step.is_multiple_of(REPORT_EVERY) {
            progress.ask(self.step(), &|| vec![self.checkpoint()])?;
        }
        Ok(())
    }

    /// Every hundred steps: observes and guards.
    fn look(&self) -> Result<Option<Observation>, StageFailure> {
        if !self.phase_step.is_multiple_of(REPORT_EVERY) {
            return Ok(None);
        }
        let seen = observe(&self.scene)[0];
        let judged = guard(CriticalTimeStep::NONE).judge(self.scene.laws.time_step, &seen, None);
        match judged {
            Ok(()) => Ok(Some(seen)),
            Err(stop) => Err(match &self.good {
                Some(good) => self.traced(good, self.step(), stop),
                None => run::stopped(self.step(), stop),
            }),
        }
    }

    /// Every ten thousand steps under the servo: an unstable pack rests as little as one that is only slow, and is told at
    /// once.
    fn measure(&self) -> Result<(), StageFailure> {
        if self.phase_step == 0 || !self.phase_step.is_multiple_of(MEASURE_EVERY) {
            return Ok(());
        }
        let measured = critical_time_step(&self.scene, 0, Across::default());
        let admitted = guard(CriticalTimeStep::NONE).admit(self.scene.laws.time_step, measured);
        admitted.map_err(|stop| run::stopped(self.step(), stop))
    }

    fn moment(&self) -> Moment {
        Moment {
            step: self.step(),
            grains: self.scene.grains.clone(),
            walls: self.scene.walls.clone(),
            servo: self.servo,
        }
    }

    /// A failure, told from its cause: goes again from a good moment to step `until`, and if any step on the way is above
    /// the critical one of its contacts, the time step is to blame, whatever was noticed later.
    fn traced(&self, good: &Moment, until: u64, noticed: Stop) -> StageFailure {
        let laws = self.scene.laws.clone();
        let time_step = laws.time_step;
        let mut scene: Scene<F64x1, Smooth<S>> =
            Scene::new(laws, good.grains.clone(), good.walls.clone());
        let mut servo = good.servo;
        for step in good.step..=until {
            let measured = critical_time_step(&scene, 0, Across::default());
            let admitted = guard(CriticalTimeStep::NONE).admit(time_step, measured);
            if let Err(stop) = admitted {
                return run::stopped(step, stop);
            }
            let pressed = step >= self.gas_steps();
            advance(&mut scene, pressed.then_some(&mut servo));
        }
        run::stopped(self.step(), noticed)
    }

    fn give_up(&self, seen: &Observation) -> Result<(), StageFailure> {
        if self.phase_step as f64 * self.spec.preparation_time_step < SERVO_TIME {
            return Ok(());
        }
        let stop = Stop {
            kind: "not_at_rest",
            detail: format!(
                "after {SERVO_TIME} t_c under the servo the kinetic energy per grain is {:.1e} E R³ and the pressure \
                 {:.3} of its target",
                seen.kinetic_energy,
                self.servo.smoothed / self.servo.target
            ),
            remedy: "use a larger rest_kinetic_energy, a smaller preparation_time_step or another packing_seed".to_owned(),
        };
        // An unstable pack never rests either.
        Err(self.traced(&self.moment(), self.step() + REPORT_EVERY, stop))
    }

    fn checkpoint(&self) -> Vec<u8> {
        let header = Header {
            stage: self.stage.clone(),
            step: self.step(),
            phase: self.phase,
            phase_step: self.phase_step,
            servo: self.servo,
            servo_steps: self.servo_steps,
            walls: std::array::from_fn(|w| self.scene.walls.position(w, 0)),
            critical_at_start: CriticalTimeStep::NONE,
            track: Track::default(),
        };
        run::checkpoint_of(&self.scene, 0, header).to_bytes()
    }
}
