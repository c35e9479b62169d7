//! What has left the physics: numbers, contacts, places and speeds.

use super::{LOOK_EVERY, Run};
use crate::beam::probe::{self, CriticalTimeStep};
use crate::beam::rig::Friction;
use crate::beam::structure::membrane::Membrane;
use crate::math::plain;
use crate::outcome::StageFailure;

/// Steps between two looks for grains outside of the membrane; a multiple of those between two looks at contacts.
const OUTSIDE_EVERY: u64 = 5 * LOOK_EVERY;

/// A grain that moves farther in one step passes through others unseen \[R\].
const FARTHEST_STEP: f64 = 0.1;

/// Centers nearer than this have no normal \[R_i + R_j\]: their distance is found as a difference of squares, whose rounding is
/// that of (R_i + R_j)², so that no digit is left below √ε = 1.5e-8.
const COINCIDENT: f64 = 1e-7;

/// Where the damping of contacts leaves less than `DAMPING_TELLS` of the critical step, as for grains of a gigapascal and more,
/// no step is longer than `MOST_OF_DAMPED` of what it leaves: with 0.93 of it E_b was off by 0.9 % there, with 1.05 by 20 %.
const DAMPING_TELLS: f64 = 0.9;
const MOST_OF_DAMPED: f64 = 0.8;

/// What to change about a time step.
pub(super) const SLOWER: &str =
    "use a smaller time_step_fraction and preparation_time_step_fraction";

impl<T: Friction> Run<T> {
    pub(super) fn check_numbers(&self) -> Result<(), StageFailure> {
        let grains = &self.beam.grains;
        let grain = (0..grains.len()).find(|&i| {
            let (place, motion) = (grains.pose(i, 0).position, grains.motion(i, 0));
            let numbers = place.iter().chain(&motion.velocity).chain(&motion.spin);
            !numbers.copied().all(f64::is_finite)
        });
        let membrane = &self.beam.surroundings.membrane;
        let numbers = membrane.mesh().positions().iter();
        let vertex = numbers
            .zip(membrane.velocities())
            .position(|(x, v)| !x.iter().chain(v).copied().all(f64::is_finite));
        let what = match (grain, vertex) {
            (None, None) => return Ok(()),
            (Some(i), _) => format!("grain {i}"),
            (None, Some(v)) => format!("vertex {v} of the membrane"),
        };
        let detail = format!("place or velocity of {what} is not a number");
        Err(self.failed("non_finite", detail, SLOWER))
    }

    /// Looks at all contacts: renews the time step, and stops what has left the physics.
    pub(super) fn look(&mut self) -> Result<(), StageFailure> {
        self.contacts = probe::contacts(&self.beam);
        self.look_for_coincident()?;
        let critical = probe::critical_time_step(&self.beam, &self.contacts);
        let CriticalTimeStep {
            undamped: critical,
            damped,
        } = critical;
        self.critical = self.critical.min(critical);
        if self.fraction >= 1.0 {
            let detail = format!(
                "a time step of {} of the critical one, {critical:.2e} s, is not stable",
                self.fraction
            );
            let remedy = "use a time_step_fraction of at most 0.8 and a preparation_time_step_fraction of at most 0.4";
            return Err(self.failed("unstable", detail, remedy));
        }
        self.check_energy()?;
        self.look_for_deep()?;
        self.look_for_fast()?;
        if self.step.is_multiple_of(OUTSIDE_EVERY) {
            self.look_for_escaped()?;
        }
        let mut longest = self.longest_step.min(self.fraction * critical);
        if damped < DAMPING_TELLS * critical {
            longest = longest.min(MOST_OF_DAMPED * damped);
        }
        self.beam.laws.time_step = longest;
        Ok(())
    }

    fn look_for_coincident(&self) -> Result<(), StageFailure> {
        let grains = &self.beam.grains;
        let one = self.contacts.iter().find(|c| {
            let reach = grains.radius(c.i) + grains.radius(c.j);
            reach - c.overlap < COINCIDENT * reach
        });
        one.map_or(Ok(()), |c| {
            let detail = format!("grains {} and {} are at the same place", c.i, c.j);
            let remedy = "use stiffer grains or less pressure, or a smaller overlap_limit";
            Err(self.failed("coincident_centres", detail, remedy))
        })
    }

    fn look_for_deep(&mut self) -> Result<(), StageFailure> {
        let grains = &self.beam.grains;
        let (mut most, mut pair) = (0.0f64, [0; 2]);
        for c in &self.contacts {
            let depth = c.overlap / grains.radius(c.i).min(grains.radius(c.j));
            if depth > most {
                (most, pair) = (depth, [c.i, c.j]);
            }
        }
        if most > self.deepest {
            (self.deepest, self.deepest_pair) = (most, pair);
        }
        if most > self.limits.stop {
            let detail = format!(
                "grains {} and {} overlap by {most:.2} of the smaller radius, more than {}",
                pair[0], pair[1], self.limits.stop
            );
            let remedy = "use stiffer grains or less pressure, or raise overlap_limit";
            return Err(self.failed("overlap_limit", detail, remedy));
        }
        Ok(())
    }

    fn look_for_fast(&self) -> Result<(), StageFailure> {
        let grains = &self.beam.grains;
        let way = |i: usize| {
            let speed = plain::norm(grains.motion(i, 0).velocity);
            speed * self.beam.laws.time_step / grains.radius(i)
        };
        let fast = (0..grains.len()).find(|&i| way(i) > FARTHEST_STEP);
        fast.map_or(Ok(()), |i| {
            let detail = format!("grain {i} moves by {:.2} of its radius in one step", way(i));
            Err(self.failed("escaped_particle", detail, SLOWER))
        })
    }

    /// Stops if a grain lies outside of the membrane, and no contact is left that would push it back.
    fn look_for_escaped(&self) -> Result<(), StageFailure> {
        let grains = &self.beam.grains;
        if grains.is_empty() {
            return Ok(());
        }
        let casing = &self.beam.surroundings;
        let mesh = casing.membrane.mesh();
        let triangles: Vec<[usize; 3]> = mesh
            .triangles()
            .iter()
            .map(|corners| corners.map(|vertex| vertex as usize))
            .collect();
        let membrane = Membrane::new(mesh.positions(), &triangles)
            .map_err(|error| self.collapsed(error.to_string()))?;
        let touching: Vec<u32> = casing.held().map(|held| held.grain).collect();
        let held = |i: usize| touching.binary_search(&(i as u32)).is_ok();
        let outside = |&i: &usize| membrane.winding(grains.pose(i, 0).position) <= 0 && !held(i);
        (0..grains.len()).find(outside).map_or(Ok(()), |i| {
            Err(self.failed(
                "escaped_particle",
                format!("grain {i} is outside the membrane"),
                "use a finer membrane_edge or a smaller time_step_fraction",
            ))
        })
    }

    /// What a reader of the run's numbers should know; `when` names the stage.
    pub(in crate::beam) fn warnings(&self, when: &str) -> Vec<String> {
        let deep = (self.deepest > self.limits.warning).then(|| {
            format!(
                "deep_overlap: grains {} and {} overlap by {:.2} of the smaller radius {when}",
                self.deepest_pair[0], self.deepest_pair[1], self.deepest
            )
        });
        deep.into_iter().chain(self.sheet.warnings(when)).collect()
    }
}
