//! The guard: when a run has left the physics.
//!
//! It never lets a plausible wrong number pass: a stopped replica has a reason and a remedy, and no outcome.

use crate::lanes::Scalar;
use crate::math::Vec3;
use crate::observable::Observation;
use crate::observable::critical_time_step::CriticalTimeStep;
use crate::scene::{Physics, Replicas, Scene};

/// Overlap beyond which two spheres are no longer the ones that Hertz's law describes \[R\].
pub const LARGEST_OVERLAP: f64 = 0.5;

/// Kinetic energy per grain below which a run cannot be unstable \[E R³\]: instability saturates at 1e-5 (docs/choices.md §4).
const QUIET: f64 = 1e-9;

/// Why a replica was stopped.
#[derive(Clone, Debug, PartialEq)]
pub struct Stop {
    /// `unstable`, `non_finite` or `overlap`.
    pub kind: &'static str,
    /// What was seen.
    pub detail: String,
    /// What to change.
    pub remedy: String,
}

/// What the guard of one replica goes by.
#[derive(Clone, Copy, Debug)]
pub struct Guard {
    /// The parameter that sets the time step, for remedies.
    pub parameter: &'static str,
    /// The critical time step when the stage began.
    pub critical_at_start: CriticalTimeStep,
    /// p_max of law M2, which knows no contact that is deeper \[R\].
    pub deepest_slice: Option<f64>,
}

impl Guard {
    /// Refuses a time step that is not below the critical one as it was measured.
    pub fn admit(self, time_step: f64, critical: CriticalTimeStep) -> Result<(), Stop> {
        let critical = critical.at_least;
        if time_step < critical {
            return Ok(());
        }
        Err(Stop {
            kind: "unstable",
            detail: format!(
                "the time step {time_step:.4} t_c is not below the measured critical one, {critical:.4} t_c"
            ),
            remedy: self.slower(0.85 * critical),
        })
    }

    /// The remedy that limits the time step.
    fn slower(self, most: f64) -> String {
        format!("use a {} of at most {most:.2}", self.parameter)
    }

    /// Judges one replica by an observation; `alternation` as [`alternation`] measures it.
    pub fn judge(
        self,
        time_step: f64,
        seen: &Observation,
        alternation: Option<f64>,
    ) -> Result<(), Stop> {
        // Compression stiffens contacts by less than 2 (√(0.06/0.02) of the overlaps, docs/choices.md §2), so by 1.4 in time.
        let suspicious = time_step > self.critical_at_start.at_least / 1.4;
        if !seen.is_finite() {
            return Err(self.blame(
                time_step,
                suspicious,
                "non_finite",
                "a position or velocity is not a number",
            ));
        }
        if seen.largest_overlap > LARGEST_OVERLAP {
            let detail = format!(
                "two spheres overlap by {:.2} R, more than {LARGEST_OVERLAP} R",
                seen.largest_overlap
            );
            return Err(self.blame(time_step, suspicious, "overlap", &detail));
        }
        if let Some(deepest) = self.deepest_slice.filter(|&p| seen.largest_overlap > p) {
            return Err(Stop {
                kind: "overlap",
                detail: format!(
                    "two spheres overlap by {:.3} R, more than slice_overlap = {deepest:?} R, the last that law M2 knows",
                    seen.largest_overlap
                ),
                remedy: "use a larger slice_overlap".to_owned(),
            });
        }
        if seen.largest_wall_overlap > LARGEST_OVERLAP {
            let detail = format!(
                "a sphere and a wall overlap by {:.2} R, more than {LARGEST_OVERLAP} R",
                seen.largest_wall_overlap
            );
            return Err(self.blame(time_step, suspicious, "overlap", &detail));
        }
        if let Some(alternation) = alternation.filter(|&a| a > 1.0 && seen.kinetic_energy > QUIET) {
            return Err(Stop {
                kind: "unstable",
                detail: format!(
                    "velocities alternate from step to step ({alternation:.1} times more than they last) at a kinetic \
                     energy of {:.1e} E R³ per grain",
                    seen.kinetic_energy
                ),
                remedy: self.slower(0.85 * self.critical_at_start.at_least.min(time_step)),
            });
        }
        Ok(())
    }

    fn blame(self, time_step: f64, suspicious: bool, kind: &'static str, detail: &str) -> Stop {
        if suspicious {
            return Stop {
                kind: "unstable",
                detail: format!("{detail}, at a time step of {time_step:.3} t_c"),
                remedy: self.slower(0.85 * self.critical_at_start.at_least / 1.4),
            };
        }
        let remedy = "use a smaller delta0, gamma0 or servo_pressure, or a longer ramp".to_owned();
        Stop {
            kind,
            detail: detail.to_owned(),
            remedy,
        }
    }
}

/// How much velocities alternate from one step to the next: Σ|v' − v|² over Σ|v' + v|², per replica.
///
/// Motion that the time step resolves gives far less than 1; an unstable mode changes sign at every step and gives more.
#[must_use]
pub fn alternation<R: Replicas, P: Physics>(
    before: &[Vec3<R>],
    scene: &Scene<R, P>,
    k: usize,
) -> f64 {
    let (mut changing, mut lasting) = (0.0, 0.0);
    for (before, after) in before.iter().zip(&scene.grains.velocity) {
        for (old, new) in [
            (&before.x, &after.x),
            (&before.y, &after.y),
            (&before.z, &after.z),
        ] {
            let (old, new) = (old.lanes()[k].to_f64(), new.lanes()[k].to_f64());
            changing += (new - old) * (new - old);
            lasting += (new + old) * (new + old);
        }
    }
    changing / lasting
}
