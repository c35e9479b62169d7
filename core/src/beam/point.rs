//! One point of the beam experiment: all its parameters, and the three stages they lead to.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::parameters::{PARAMETERS, PRESETS};
use super::prediction::{Prediction, rod_travel};
use super::spec::{
    BendSpec, GrowSpec, JamSpec, MembraneRest, Mold, OverlapLimits, RestCriteria, Support,
};
use super::stiffness::ELASTIC_STRAIN;
use crate::contact::mindlin::TangentialStiffness;
use crate::identity::StageId;
use crate::parameter;

/// μ_init of protocol B.
pub const PROTOCOL_B_FRICTION: f64 = 0.3;

/// How the beam is put under pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Protocol {
    /// With the friction of the test.
    A,
    /// With [`PROTOCOL_B_FRICTION`], whatever that of the test.
    B,
}

/// All parameters of one point, after defaults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is a parameter that users switch on its own"
)]
#[expect(
    missing_docs,
    reason = "the parameter table documents every field, and a test keeps the two equal"
)]
pub struct BeamPoint {
    pub protocol: Protocol,
    pub friction_coefficient: f64,
    pub youngs_modulus: f64,
    pub poisson_ratio: f64,
    pub density: f64,
    pub relaxation_time: f64,
    pub tangential_damping: f64,
    pub kt_model: TangentialStiffness,
    pub radius_min: f64,
    pub radius_max: f64,
    pub growth_factor: f64,
    pub initial_volume_fraction: f64,
    pub length: f64,
    pub height: f64,
    pub depth: f64,
    pub packing_seed: u64,
    pub confining_pressure: f64,
    pub allow_inflation: bool,
    pub membrane_youngs_modulus: f64,
    pub membrane_thickness: Option<f64>,
    pub scale_membrane: bool,
    pub membrane_density: f64,
    pub membrane_damping_ratio: f64,
    pub membrane_friction_coefficient: f64,
    pub membrane_bending_stiffness: f64,
    pub membrane_bending_damping: f64,
    pub membrane_edge: Option<f64>,
    pub membrane_rest: MembraneRest,
    pub vertex_radius: f64,
    pub rod_radius: Option<f64>,
    pub support: Support,
    pub cycles: u32,
    pub cycle_strain: f64,
    pub overlap_warning: f64,
    pub overlap_limit: f64,
    pub growth_time: f64,
    pub growth_rest: f64,
    pub pressure_ramp: f64,
    pub mold: Mold,
    pub mold_speed: f64,
    pub mold_load: f64,
    pub release_time: f64,
    pub rest_window: f64,
    pub rest_volume_rate: f64,
    pub rest_force_ratio: f64,
    pub rest_energy_ratio: f64,
    pub longest_rest: f64,
    pub background_damping: f64,
    pub preparation_time_step_fraction: f64,
    pub time_step_fraction: f64,
    pub periods: f64,
    pub rod_speed: Option<f64>,
    pub bending_damping: f64,
    pub strain_end: f64,
    pub sample_strain: f64,
    pub structure: bool,
    pub snapshots: bool,
    pub snapshot_travel: f64,
    pub strain_end_over_yield: f64,
}

impl BeamPoint {
    /// The table's defaults with those of `preset` over them; `None` if there is no such preset.
    #[must_use]
    pub fn defaults(preset: &str) -> Option<Map<String, Value>> {
        parameter::defaults(PARAMETERS, PRESETS, preset)
    }

    /// A point from all its parameters, each already checked against the table.
    ///
    /// # Errors
    /// If a parameter is missing, unknown or of the wrong type, in serde's words.
    pub fn from_parameters(parameters: Map<String, Value>) -> Result<Self, String> {
        serde_json::from_value(Value::Object(parameters)).map_err(|error| error.to_string())
    }

    /// μ_init: that of the test by protocol A, [`PROTOCOL_B_FRICTION`] by B.
    #[must_use]
    pub fn initial_friction_coefficient(&self) -> f64 {
        match self.protocol {
            Protocol::A => self.friction_coefficient,
            Protocol::B => PROTOCOL_B_FRICTION,
        }
    }

    /// t_m \[m\]: as given, or 0.3 mm, which `scale_membrane` keeps in its ratio to a smaller side of 4 cm.
    #[must_use]
    pub fn resolved_membrane_thickness(&self) -> f64 {
        let scale = if self.scale_membrane {
            self.height.min(self.depth) / 0.04
        } else {
            1.0
        };
        self.membrane_thickness.unwrap_or(0.3e-3 * scale)
    }

    /// v_rod \[m/s\]: as given, or the way to ε = 0.002 in `periods` of the predicted first mode.
    #[must_use]
    pub fn resolved_rod_speed(&self) -> f64 {
        self.rod_speed.unwrap_or_else(|| {
            let grow = self.grow();
            let way = rod_travel(&grow.dimensions(), ELASTIC_STRAIN);
            way * self.prediction(&grow).first_frequency() / self.periods
        })
    }

    /// What is known of the beam before it is made.
    #[must_use]
    pub fn prediction<'a>(&self, grow: &'a GrowSpec) -> Prediction<'a> {
        Prediction {
            grow,
            confining_pressure: Some(self.confining_pressure),
            membrane_thickness: self.resolved_membrane_thickness(),
            membrane_density: self.membrane_density,
        }
    }

    fn rest(&self) -> RestCriteria {
        RestCriteria {
            window: self.rest_window,
            volume_rate: self.rest_volume_rate,
            force_ratio: self.rest_force_ratio,
            energy_ratio: self.rest_energy_ratio,
            longest: self.longest_rest,
        }
    }

    fn overlap(&self) -> OverlapLimits {
        OverlapLimits {
            warning: self.overlap_warning,
            stop: self.overlap_limit,
        }
    }

    /// The stage `grow` of this point.
    #[must_use]
    pub fn grow(&self) -> GrowSpec {
        GrowSpec {
            packing_seed: self.packing_seed,
            length: self.length,
            height: self.height,
            depth: self.depth,
            initial_volume_fraction: self.initial_volume_fraction,
            radius_min: self.radius_min,
            radius_max: self.radius_max,
            growth_factor: self.growth_factor,
            density: self.density,
            youngs_modulus: self.youngs_modulus,
            poisson_ratio: self.poisson_ratio,
            relaxation_time: self.relaxation_time,
            membrane_edge: self
                .membrane_edge
                .unwrap_or(self.radius_min + self.radius_max),
            membrane_youngs_modulus: self.membrane_youngs_modulus,
            growth_time: self.growth_time,
            growth_rest: self.growth_rest,
            time_step_fraction: self.preparation_time_step_fraction,
            background_damping: self.background_damping,
            overlap: self.overlap(),
        }
    }

    /// The stage `jam` of this point, of the grains named `grow`.
    #[must_use]
    pub fn jam(&self, grow: StageId) -> JamSpec {
        JamSpec {
            grow,
            initial_friction_coefficient: self.initial_friction_coefficient(),
            confining_pressure: self.confining_pressure,
            kt_model: self.kt_model,
            tangential_damping: self.tangential_damping,
            membrane_thickness: self.resolved_membrane_thickness(),
            membrane_density: self.membrane_density,
            membrane_damping_ratio: self.membrane_damping_ratio,
            membrane_friction_coefficient: self.membrane_friction_coefficient,
            membrane_bending_stiffness: self.membrane_bending_stiffness,
            membrane_bending_damping: self.membrane_bending_damping,
            vertex_radius: self.vertex_radius,
            pressure_ramp: self.pressure_ramp,
            mold: self.mold,
            mold_speed: self.mold_speed,
            mold_load: self.mold_load,
            rest: self.rest(),
            time_step_fraction: self.preparation_time_step_fraction,
            background_damping: self.background_damping,
            overlap: self.overlap(),
        }
    }

    /// The stage `bend` of this point, of the beam named `jam`.
    ///
    /// What means nothing without cycles or snapshots is 0 without them, so that it makes no other stage.
    #[must_use]
    pub fn bend(&self, jam: StageId) -> BendSpec {
        let looked_at = self.structure || self.snapshots;
        BendSpec {
            jam,
            friction_coefficient: self.friction_coefficient,
            support: self.support,
            membrane_rest: self.membrane_rest,
            rod_radius: self.rod_radius.unwrap_or(0.25 * self.height),
            rod_speed: self.resolved_rod_speed(),
            strain_end: self.strain_end,
            cycles: self.cycles,
            cycle_strain: if self.cycles > 0 {
                self.cycle_strain
            } else {
                0.0
            },
            sample_strain: self.sample_strain,
            release_time: self.release_time,
            rest: self.rest(),
            release_time_step_fraction: self.preparation_time_step_fraction,
            time_step_fraction: self.time_step_fraction,
            background_damping: self.background_damping,
            bending_damping: self.bending_damping,
            overlap: self.overlap(),
            structure: self.structure,
            snapshots: self.snapshots,
            snapshot_travel: if looked_at { self.snapshot_travel } else { 0.0 },
            strain_end_over_yield: self.strain_end_over_yield,
        }
    }
}

#[cfg(test)]
mod tests;
