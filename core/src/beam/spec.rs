//! Specs: the three stages of the beam experiment.
//!
//! Field order is part of every stage's identity: add at the end, never reorder.
//! A stage holds what it adds to the one it needs, whose state carries the specs before it; everything is in SI units.

use serde::{Deserialize, Serialize};

use super::curve::Dimensions;
use crate::contact::mindlin::TangentialStiffness;
use crate::identity::StageId;

/// How the ends of the beam are held.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Support {
    /// Both in all directions.
    PinnedPinned,
    /// One may slide along the beam.
    PinnedRoller,
}

/// How the walls of the mold move while the grains are compacted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mold {
    /// All by one strain, the membrane's faces with them.
    Even,
    /// Each pair for itself, as the membrane leaves it.
    Following,
}

/// What the membrane's springs remember.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MembraneRest {
    /// Their lengths in the mold.
    AsBuilt,
    /// Their lengths once the beam is compacted.
    ResetAfterCompaction,
}

/// When a beam is at rest: all three for the whole window.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RestCriteria {
    /// \[s\].
    pub window: f64,
    /// |dV/dt|/V is below this \[1/s\].
    pub volume_rate: f64,
    /// Mean net force on a grain over the mean contact force is below this.
    pub force_ratio: f64,
    /// E_kin/E_el is below this.
    pub energy_ratio: f64,
    /// A beam that is not at rest after so long is given up \[s\].
    pub longest: f64,
}

/// Overlaps of two grains that matter, in their smaller radius.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OverlapLimits {
    /// Above this the outcome is marked.
    pub warning: f64,
    /// Above this the run stops.
    pub stop: f64,
}

/// Grains grown in the mold without friction, the membrane frozen: everything that enters the stage `grow`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GrowSpec {
    /// Which realization.
    pub packing_seed: u64,
    /// L \[m\].
    pub length: f64,
    /// h \[m\].
    pub height: f64,
    /// d \[m\].
    pub depth: f64,
    /// φ_init; 0 is an empty membrane.
    pub initial_volume_fraction: f64,
    /// Smallest radius once grown \[m\].
    pub radius_min: f64,
    /// Largest radius once grown \[m\].
    pub radius_max: f64,
    /// Radius once grown over radius at first.
    pub growth_factor: f64,
    /// ρ \[kg/m³\].
    pub density: f64,
    /// E_p \[Pa\].
    pub youngs_modulus: f64,
    /// ν.
    pub poisson_ratio: f64,
    /// A \[s\].
    pub relaxation_time: f64,
    /// a \[m\], resolved.
    pub membrane_edge: f64,
    /// E_m \[Pa\].
    pub membrane_youngs_modulus: f64,
    /// \[s\].
    pub growth_time: f64,
    /// \[s\].
    pub growth_rest: f64,
    /// Time step over the critical one.
    pub time_step_fraction: f64,
    /// α \[1/s\].
    pub background_damping: f64,
    /// \[smaller radius\].
    pub overlap: OverlapLimits,
}

impl GrowSpec {
    /// The mold: the nominal dimensions.
    #[must_use]
    pub fn dimensions(&self) -> Dimensions {
        Dimensions {
            length: self.length,
            height: self.height,
            depth: self.depth,
        }
    }
}

/// The grown grains compacted by the pressure on the membrane, mold walls following: what enters the stage `jam`.
///
/// Neither the protocol nor the friction of the test is part of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JamSpec {
    /// The grown grains.
    pub grow: StageId,
    /// μ_init.
    pub initial_friction_coefficient: f64,
    /// Δp \[Pa\].
    pub confining_pressure: f64,
    /// Convention of k_t.
    pub kt_model: TangentialStiffness,
    /// γ.
    pub tangential_damping: f64,
    /// t_m \[m\], resolved.
    pub membrane_thickness: f64,
    /// ρ_m \[kg/m³\].
    pub membrane_density: f64,
    /// γ_m.
    pub membrane_damping_ratio: f64,
    /// μ_m.
    pub membrane_friction_coefficient: f64,
    /// k_θ \[N m\]; 0 is no hinges.
    pub membrane_bending_stiffness: f64,
    /// c_θ \[N m s\].
    pub membrane_bending_damping: f64,
    /// r_v \[m\].
    pub vertex_radius: f64,
    /// \[s\].
    pub pressure_ramp: f64,
    /// How the walls of the mold move.
    pub mold: Mold,
    /// Largest speed of a wall of the mold \[m/s\].
    pub mold_speed: f64,
    /// Reaction at which a wall stands still, over Δp A.
    pub mold_load: f64,
    /// When compaction is over.
    pub rest: RestCriteria,
    /// Time step over the critical one.
    pub time_step_fraction: f64,
    /// α \[1/s\].
    pub background_damping: f64,
    /// \[smaller radius\].
    pub overlap: OverlapLimits,
}

/// The compacted beam released from its mold, put on its supports and bent: what enters the stage `bend`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BendSpec {
    /// The compacted beam.
    pub jam: StageId,
    /// μ_p, from the release on.
    pub friction_coefficient: f64,
    /// How the ends are held.
    pub support: Support,
    /// Whether springs forget the mold before the release.
    pub membrane_rest: MembraneRest,
    /// r_rod \[m\], resolved.
    pub rod_radius: f64,
    /// v_rod \[m/s\], resolved.
    pub rod_speed: f64,
    /// ε_end.
    pub strain_end: f64,
    /// Loadings to `cycle_strain` and back before the last.
    pub cycles: u32,
    /// 0 without cycles.
    pub cycle_strain: f64,
    /// Strain between two samples.
    pub sample_strain: f64,
    /// While the mold is drawn away \[s\].
    pub release_time: f64,
    /// When the released beam may be bent.
    pub rest: RestCriteria,
    /// Time step over the critical one until bending begins.
    pub release_time_step_fraction: f64,
    /// Time step over the critical one from then on.
    pub time_step_fraction: f64,
    /// α until bending begins \[1/s\].
    pub background_damping: f64,
    /// α from then on \[1/s\].
    pub bending_damping: f64,
    /// \[smaller radius\].
    pub overlap: OverlapLimits,
    /// Whether the structure is analyzed.
    pub structure: bool,
    /// Whether snapshots are stored.
    pub snapshots: bool,
    /// Way of the rods between two snapshots \[m\]; 0 without any.
    pub snapshot_travel: f64,
    /// Once the beam has yielded, ε_end is at most this times ε_Y, or 0.05 if that is more; 0 is never.
    pub strain_end_over_yield: f64,
}
