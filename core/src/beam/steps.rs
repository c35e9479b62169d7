//! How many steps the stages take, and how much they work on, known before they run.
//!
//! One step of the paper's beam costs about 30 ns for each of 31,000 contacts, 5 ns for each of 50,000 near misses, 60 ns for each
//! of 4,700 contacts with the membrane, and some nanoseconds for edges, triangles and bodies: 2.1 ms for 17,000 bodies.

use super::prediction::{Prediction, rod_travel};
use super::spec::{BendSpec, GrowSpec, JamSpec, Mold};
use super::stiffness::ELASTIC_STRAIN;

/// How long a beam takes to come to rest, in windows of the criteria.
const WINDOWS: f64 = 4.0;

/// By how much an even mold shrinks before the grains bear a load: from φ = 0.5 to 0.6.
const EVEN_STRAIN: f64 = 0.06;

/// Memory of a grain or a vertex with all that touches it \[bytes\], generously.
const BODY_BYTES: f64 = 8192.0;

/// Memory of a grain or a vertex in one stored snapshot \[bytes\]: 36 while the beam is bent, and a line of text at the end.
const STORED_BYTES: f64 = 150.0;

impl GrowSpec {
    /// Steps of growth and rest.
    #[must_use]
    pub fn predicted_steps(&self) -> u64 {
        let step = self.time_step_fraction * self.prediction().critical_time_step();
        ((self.growth_time + self.growth_rest) / step) as u64
    }

    /// Grains and vertices of the membrane, at least one.
    #[must_use]
    pub fn predicted_bodies(&self) -> u64 {
        let prediction = self.prediction();
        ((prediction.grains() + prediction.vertices()) as u64).max(1)
    }

    /// Memory of a run \[bytes\].
    #[must_use]
    pub fn predicted_bytes(&self) -> u64 {
        (self.predicted_bodies() as f64 * BODY_BYTES) as u64
    }

    /// What is known of grains that grow; the membrane is frozen, so any will do.
    fn prediction(&self) -> Prediction<'_> {
        Prediction {
            grow: self,
            confining_pressure: None,
            membrane_thickness: 0.0,
            membrane_density: self.density,
        }
    }
}

impl JamSpec {
    /// Steps of an even mold, of the pressure's rise and of the rest after it, of the grains of `grow`.
    #[must_use]
    pub fn predicted_steps(&self, grow: &GrowSpec) -> u64 {
        let step = self.time_step_fraction * self.prediction(grow).critical_time_step();
        let even = match self.mold {
            Mold::Even => EVEN_STRAIN * 0.5 * grow.length / self.mold_speed,
            Mold::Following => 0.0,
        };
        ((even + self.pressure_ramp + WINDOWS * self.rest.window) / step) as u64
    }

    /// What is known of the beam made of `grow`.
    #[must_use]
    pub fn prediction<'a>(&self, grow: &'a GrowSpec) -> Prediction<'a> {
        Prediction {
            grow,
            confining_pressure: Some(self.confining_pressure),
            membrane_thickness: self.membrane_thickness,
            membrane_density: self.membrane_density,
        }
    }
}

impl BendSpec {
    /// Steps of release, rest and bending, of the beam of `grow` and `jam`.
    #[must_use]
    pub fn predicted_steps(&self, jam: &JamSpec, grow: &GrowSpec) -> u64 {
        let prediction = jam.prediction(grow);
        let critical = prediction.critical_time_step();
        let before = self.release_time + WINDOWS * self.rest.window;
        let way = |strain| rod_travel(&grow.dimensions(), strain);
        let cycles = f64::from(self.cycles) * 2.0 * way(self.cycle_strain);
        // The rods start smoothly, so they lose half of the time that this takes.
        let start =
            (1.0 / prediction.first_frequency()).max(0.1 * way(ELASTIC_STRAIN) / self.rod_speed);
        let bending = (way(self.strain_end) + cycles) / self.rod_speed + 0.5 * start;
        let steps = before / (self.release_time_step_fraction * critical)
            + bending / (self.time_step_fraction * critical);
        steps as u64
    }

    /// Memory of the snapshots of the beam of `grow` that are stored \[bytes\].
    #[must_use]
    pub fn predicted_snapshot_bytes(&self, grow: &GrowSpec) -> u64 {
        if !self.snapshots {
            return 0;
        }
        let way = |strain| rod_travel(&grow.dimensions(), strain);
        let way = way(self.strain_end) + f64::from(self.cycles) * 2.0 * way(self.cycle_strain);
        let snapshots = 1.0 + way / self.snapshot_travel;
        (snapshots * STORED_BYTES * grow.predicted_bodies() as f64) as u64
    }
}

#[cfg(test)]
mod tests {
    use crate::beam::point::BeamPoint;
    use crate::identity::StageId;

    #[test]
    fn only_snapshots_that_are_stored_take_memory() {
        let map = BeamPoint::defaults("paper").expect("a preset");
        let plain = BeamPoint::from_parameters(map).expect("valid defaults");
        let bytes = |point: &BeamPoint| {
            let bend = point.bend(StageId::of_bytes(b"before"));
            bend.predicted_snapshot_bytes(&point.grow())
        };
        let analyzed = BeamPoint {
            structure: true,
            ..plain.clone()
        };
        assert_eq!([bytes(&plain), bytes(&analyzed)], [0, 0]);
        // 119.5 snapshots of 11,744 grains and 5,350 vertices, 150 bytes each.
        let stored = BeamPoint {
            snapshots: true,
            ..plain
        };
        let ratio = bytes(&stored) as f64 / (119.5 * 17_094.0 * 150.0);
        assert!((ratio - 1.0).abs() < 2e-3, "{ratio}");
    }

    /// Steps of a preset's bending: those of 8 µs in the cost model, which are 0.4 of the critical one, and else twice as long.
    #[test]
    fn presets_take_the_steps_they_promise() {
        for (preset, steps) in [
            ("draft", 0.4e6),
            ("standard", 1.35e6),
            ("paper_fast", 3.55e6),
            ("paper", 3.7e7),
        ] {
            let map = BeamPoint::defaults(preset).expect("a preset");
            let point = BeamPoint::from_parameters(map).expect("valid defaults");
            let (grow, id) = (point.grow(), StageId::of_bytes(b"before"));
            let jam = point.jam(id);
            let found = point.bend(id).predicted_steps(&jam, &grow) as f64;
            assert!((found / steps - 1.0).abs() < 0.1, "{preset}: {found}");
            let preparation = grow.predicted_steps() + jam.predicted_steps(&grow);
            assert!((6e4..12e4).contains(&(preparation as f64)), "{preparation}");
        }
    }
}
