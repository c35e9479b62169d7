//! The rods' program: down to the strain of a cycle and up again, as often as asked, then down to the last strain,
//! or less far once the beam has yielded.

use serde::{Deserialize, Serialize};

use super::record::Row;
use crate::beam::curve::{Curve, Dimensions};
use crate::beam::prediction::rod_travel;
use crate::beam::spec::{BendSpec, JamSpec};
use crate::beam::state::Past;
use crate::beam::stiffness::ELASTIC_STRAIN;
use crate::beam::strength::ultimate_strength;
use crate::guard::Stop;

/// Stress at which the test begins, over Δp.
const CONTACT_STRESS: f64 = 1e-3;

/// Strain before which no beam counts as bent far enough.
const LEAST_STRAIN_END: f64 = 0.05;

/// Rows between two looks for the beam's yield.
const ROWS_PER_LOOK: usize = 20;

/// How the rods move, and how far the test has come.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Drive {
    mold: Dimensions,
    /// v_rod \[m/s\].
    speed: f64,
    /// How long a change of speed takes \[s\].
    start: f64,
    /// Where the speed changes from, and to, as a share of v_rod, and since when.
    from: f64,
    to: f64,
    since: f64,
    /// Stress at which the rods touch \[Pa\].
    contact_stress: f64,
    /// Height of the middle when they first did.
    zero: Option<f64>,
    /// Cycles still to do.
    cycles: u32,
    cycle_strain: f64,
    strain_end: f64,
    strain_end_over_yield: f64,
    sample_way: f64,
    over: bool,
}

impl Drive {
    pub(super) fn new(spec: &BendSpec, jam: &JamSpec, past: &Past) -> Self {
        let mold = past.grow.dimensions();
        let frequency = jam.prediction(&past.grow).first_frequency();
        let elastic = rod_travel(&mold, ELASTIC_STRAIN) / spec.rod_speed;
        Self {
            mold,
            speed: spec.rod_speed,
            start: (1.0 / frequency).max(0.1 * elastic),
            from: 0.0,
            to: 1.0,
            since: 0.0,
            contact_stress: CONTACT_STRESS * jam.confining_pressure.abs(),
            zero: None,
            cycles: spec.cycles,
            cycle_strain: spec.cycle_strain,
            strain_end: spec.strain_end,
            strain_end_over_yield: spec.strain_end_over_yield,
            sample_way: rod_travel(&mold, spec.sample_strain),
            over: false,
        }
    }

    /// How far above the beam the rods begin, so that they reach their speed before they touch it.
    pub(super) fn gap(&self) -> f64 {
        0.5 * self.start * self.speed + 1e-5
    }

    pub(super) fn is_over(&self) -> bool {
        self.over
    }

    /// Way of the rods between two samples \[m\].
    pub(super) fn sample_way(&self) -> f64 {
        self.sample_way
    }

    /// Velocity of the rods, down \[m/s\]: half a cosine from one speed to the next.
    pub(super) fn velocity(&self, time: f64) -> f64 {
        let share = ((time - self.since) / self.start).clamp(0.0, 1.0);
        let done = 0.5 * (1.0 - libm::cos(std::f64::consts::PI * share));
        self.speed * (self.from + (self.to - self.from) * done)
    }

    /// ε of a row, from the first touch.
    pub(super) fn strain(&self, row: &Row) -> Option<f64> {
        self.zero.map(|zero| self.mold.strain(zero - row.height))
    }

    /// Height of the middle when the rods first touched.
    pub(super) fn zero(&self) -> Option<f64> {
        self.zero
    }

    /// Turns the rods, or ends the test, as the last row says.
    pub(super) fn follow(&mut self, row: &Row, time: f64) -> Result<(), Stop> {
        let stress = self.mold.stress(row.force);
        if self.zero.is_none() && row.force > 0.0 && stress > self.contact_stress {
            self.zero = Some(row.height);
        }
        let Some(strain) = self.strain(row) else {
            return self.check_contact(row);
        };
        if self.cycles > 0 {
            let down = self.to > 0.0;
            if down && strain >= self.cycle_strain {
                self.turn(-1.0, time);
            } else if !down && stress <= self.contact_stress {
                self.cycles -= 1;
                self.turn(1.0, time);
            }
            return Ok(());
        }
        self.over = strain >= self.strain_end;
        // The rods also press themselves into the top of the beam.
        let most =
            2.0 * (rod_travel(&self.mold, self.strain_end) + self.gap()) + 0.1 * self.mold.height;
        if !self.over && row.travel > most {
            return Err(Stop {
                kind: "run_too_short",
                detail: format!(
                    "the rods went {:.1} mm and the beam is bent by ε = {strain:.4} of {} only",
                    1e3 * row.travel,
                    self.strain_end
                ),
                remedy: "use a smaller strain_end".to_owned(),
            });
        }
        Ok(())
    }

    /// Ends the test if the beam is found to have yielded, and to be bent far enough beyond; `rows` are those since the first touch.
    pub(super) fn look_for_yield(&mut self, rows: &[Row]) {
        let (Some(zero), Some(last)) = (self.zero, rows.last()) else {
            return;
        };
        let strain = self.mold.strain(zero - last.height);
        let due = self.strain_end_over_yield > 0.0 && rows.len().is_multiple_of(ROWS_PER_LOOK);
        if !due || self.cycles > 0 || strain < LEAST_STRAIN_END {
            return;
        }
        let samples: Vec<_> = rows.iter().map(|row| row.sample(zero)).collect();
        if let Ok(found) = ultimate_strength(&Curve::of(&samples, &self.mold)) {
            self.over |= strain >= self.strain_end_over_yield * found.strain;
        }
    }

    fn check_contact(&self, row: &Row) -> Result<(), Stop> {
        let most = 2.0 * (self.gap() + rod_travel(&self.mold, ELASTIC_STRAIN));
        if row.travel <= most {
            return Ok(());
        }
        Err(Stop {
            kind: "no_contact",
            detail: format!("the rods went {:.1} mm and touch nothing", 1e3 * row.travel),
            remedy: "look at the beam: its membrane may be slack or its top far from where it was"
                .to_owned(),
        })
    }

    fn turn(&mut self, to: f64, time: f64) {
        self.from = self.velocity(time) / self.speed;
        self.to = to;
        self.since = time;
    }
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod yield_tests;
