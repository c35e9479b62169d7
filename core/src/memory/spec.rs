//! Specs: one point of the memory experiment, and the three stages it leads to.
//!
//! Field order is part of every stage's identity: add at the end, never reorder.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::parameters::{PARAMETERS, PRESETS};
use super::waveform::Waveform;
use crate::identity::StageId;
use crate::parameter;

/// From so many slices on, law M2's fidelity changes by less than 0.01 (docs/choices.md).
const CONVERGED_SLICES: u32 = 400;

/// The shape of every grain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ShapeName {
    /// Four overlapping spheres.
    Tetrahedron,
    /// One sphere.
    Sphere,
}

/// The tangential force law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ForceLaw {
    /// Linear spring and dashpot under a Coulomb limit, Eq. (4).
    H,
    /// Mindlin's spring, weakened as the overlap falls, Eq. (5).
    M1,
    /// Mindlin's linearized law with its whole history, by slices of the contact, App. D.2.
    M2,
}

/// The numbers that a recall is computed in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// Single precision displacements from a double precision reference.
    F32,
    /// Double precision.
    F64,
}

/// What a packing is: everything that enters the stage `pack`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PackSpec {
    /// N.
    pub grains: u32,
    /// Which realization.
    pub packing_seed: u64,
    /// The grains' shape.
    pub shape: ShapeName,
    /// 𝒪; 1 for spheres, whatever the user said, since it means nothing to them.
    pub overlap: f64,
    /// R \[m\].
    pub radius: f64,
    /// ρ \[kg/m³\].
    pub density: f64,
    /// E \[Pa\].
    pub youngs_modulus: f64,
    /// ν.
    pub poisson_ratio: f64,
    /// γ_n/k_n \[t_c\].
    pub normal_damping: f64,
    /// k_w/k_n.
    pub wall_stiffness: f64,
    /// δ0.
    pub delta0: f64,
    /// p_z/E.
    pub servo_pressure: f64,
    /// \[R/t_c\].
    pub gas_speed: f64,
    /// \[t_c\].
    pub gas_time: f64,
    /// Frictionless cycles.
    pub preparation_cycles: u32,
    /// \[t_c\].
    pub preparation_time_step: f64,
    /// \[t_c\].
    pub preparation_ramp: f64,
    /// \[E R³\].
    pub rest_kinetic_energy: f64,
}

impl RecallSpec {
    /// The steps that its encoding has done before it.
    #[must_use]
    pub fn steps_before(&self) -> u64 {
        let shared = self.encode.and_then(|_| self.waveform.beginning());
        shared.map_or(0, |(_, until)| {
            steps_until(until, self.ramp, self.time_step)
        })
    }
}

/// The steps of a ramp before u reaches `until`.
pub(crate) fn steps_until(until: f64, ramp: f64, time_step: f64) -> u64 {
    (until * crate::memory::ramp_steps(ramp, time_step) as f64) as u64
}

impl PackSpec {
    /// An estimate of the steps: gas, 20,000 t_c of servo (15,000 to 25,000 in practice), and the cycles.
    #[must_use]
    pub fn predicted_steps(&self) -> u64 {
        let free = ((self.gas_time + 20_000.0) / self.preparation_time_step) as u64;
        free + 2
            * u64::from(self.preparation_cycles)
            * crate::memory::ramp_steps(self.preparation_ramp, self.preparation_time_step)
    }
}

/// The cycle with friction that every waveform of a pack shares: what enters the stage `train`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainSpec {
    /// The prepared pack.
    pub pack: StageId,
    /// μ.
    pub friction_coefficient: f64,
    /// The tangential law.
    pub force_law: ForceLaw,
    /// k_H \[N/m\], resolved, or k_M \[N/m^(3/2)\] of laws M1 and M2.
    pub tangential_stiffness: f64,
    /// (γ_H/k_H)/(γ_n/k_n).
    pub tangential_damping_ratio: f64,
    /// Largest time step \[t_c\].
    pub time_step: f64,
    /// t0 \[t_c\].
    pub ramp: f64,
    /// η \[1/t_c\].
    pub drag: f64,
    /// \[R\].
    pub skin: f64,
    /// Of law M2 only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slices: Option<Slices>,
}

/// How finely law M2 knows what a contact has been through.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Slices {
    /// Q.
    pub number: u32,
    /// p_max \[R\].
    pub largest_overlap: f64,
}

/// The beginning of an encoding, which several words share: what enters the stage `encode`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EncodeSpec {
    /// The trained pack.
    pub train: StageId,
    /// The word whose last bits are zero, see [`Waveform::beginning`].
    pub waveform: Waveform,
    /// γ0.
    pub gamma0: f64,
    /// Largest time step \[t_c\].
    pub time_step: f64,
    /// t0 \[t_c\].
    pub ramp: f64,
    /// η \[1/t_c\].
    pub drag: f64,
    /// Number type.
    pub precision: Precision,
    /// \[R\].
    pub skin: f64,
}

impl EncodeSpec {
    /// Time steps: those before the words part.
    #[must_use]
    pub fn steps(&self) -> u64 {
        let until = self.waveform.beginning().map_or(0.0, |(_, until)| until);
        steps_until(until, self.ramp, self.time_step)
    }

    /// The recall that begins so and is no longer: no hold, no second cycle.
    #[must_use]
    pub(crate) fn as_recall(&self) -> RecallSpec {
        RecallSpec {
            train: self.train,
            encode: None,
            waveform: self.waveform.clone(),
            gamma0: self.gamma0,
            time_step: self.time_step,
            ramp: self.ramp,
            drag: self.drag,
            hold: 0.0,
            precision: self.precision,
            second_cycle: false,
            skin: self.skin,
        }
    }
}

/// One waveform stored and recalled: what enters the stage `recall`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecallSpec {
    /// The trained pack.
    pub train: StageId,
    /// The encoding that it goes on from, if it shares one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub encode: Option<StageId>,
    /// I(u).
    pub waveform: Waveform,
    /// γ0.
    pub gamma0: f64,
    /// Largest time step \[t_c\].
    pub time_step: f64,
    /// t0 \[t_c\].
    pub ramp: f64,
    /// η \[1/t_c\].
    pub drag: f64,
    /// Storage time \[ramps\].
    pub hold: f64,
    /// Number type.
    pub precision: Precision,
    /// Whether the second cycle follows.
    pub second_cycle: bool,
    /// \[R\].
    pub skin: f64,
}

/// All parameters of one point, after defaults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(
    missing_docs,
    reason = "the parameter table documents every field, and a test keeps the two equal"
)]
pub struct MemoryPoint {
    pub grains: u32,
    pub shape: ShapeName,
    pub overlap: f64,
    pub radius: f64,
    pub density: f64,
    pub youngs_modulus: f64,
    pub poisson_ratio: f64,
    pub friction_coefficient: f64,
    pub force_law: ForceLaw,
    pub typical_overlap: f64,
    pub tangential_stiffness: Option<f64>,
    pub normal_damping: f64,
    pub tangential_damping_ratio: f64,
    pub wall_stiffness: f64,
    pub delta0: f64,
    pub gamma0: f64,
    pub servo_pressure: f64,
    pub packing_seed: u64,
    pub waveform: Waveform,
    pub time_step: f64,
    pub ramp: f64,
    pub drag: f64,
    pub hold: f64,
    pub precision: Precision,
    pub second_cycle: bool,
    pub skin: f64,
    pub gas_speed: f64,
    pub gas_time: f64,
    pub preparation_cycles: u32,
    pub preparation_time_step: f64,
    pub preparation_ramp: f64,
    pub rest_kinetic_energy: f64,
    pub slices: u32,
    pub slice_overlap: f64,
}

impl MemoryPoint {
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

    /// What is allowed but unwise, in full sentences.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = vec![];
        if self.gamma0 > 0.05 * self.delta0 {
            warnings.push(format!(
                "gamma0 = {} is more than a twentieth of delta0 = {}: the memory is linear only well below it (Fig. 11)",
                self.gamma0, self.delta0
            ));
        }
        if self.precision == Precision::F32 && self.gamma0 < 5e-4 && self.waveform != Waveform::Zero
        {
            warnings.push(format!(
                "gamma0 = {:?} in single precision: rounding moves a gain by 0.1 % at 1e-3 and 1 % at 1e-4 in small packs; use f64",
                self.gamma0
            ));
        }
        if self.pack().shape == ShapeName::Sphere && self.drag == 0.0 {
            warnings.push(
                "spheres with drag = 0: in some packs rearrangements follow rounding errors, and one packing's fidelity is \
                 uncertain by 0.1 and more; average over packings and compare with drag = 0.1 or longer ramps \
                 (docs/validation.md)"
                    .to_owned(),
            );
        }
        if self.force_law == ForceLaw::M2 && self.slices < CONVERGED_SLICES {
            warnings.push(format!(
                "law M2 with slices = {} is not converged: 𝓕 was 0.675, 0.893, 0.924 and 0.944 at 20, 100, 200 and 1,000 in one pack \
                 (docs/choices.md)",
                self.slices
            ));
        }
        warnings
    }

    /// k_n \[N/m^(3/2)\] = 2^(−3/2) (4/3) √R E/(1 − ν²), Eq. (3).
    fn normal_stiffness(&self) -> f64 {
        let half_root = std::f64::consts::FRAC_1_SQRT_2 * 0.5;
        half_root * (4.0 / 3.0) * self.radius.sqrt() * self.youngs_modulus
            / (1.0 - self.poisson_ratio * self.poisson_ratio)
    }

    /// k_M \[N/m^(3/2)\] = 3 k_n (1 − ν)/(2 − ν), Eq. (5).
    fn mindlin_stiffness(&self) -> f64 {
        3.0 * self.normal_stiffness() * (1.0 - self.poisson_ratio) / (2.0 - self.poisson_ratio)
    }

    /// k_H \[N/m\]: as given, or k_M √p_typ; k_M \[N/m^(3/2)\] of laws M1 and M2.
    #[must_use]
    pub fn resolved_tangential_stiffness(&self) -> f64 {
        let mindlin = self.mindlin_stiffness();
        match self.force_law {
            ForceLaw::H => self
                .tangential_stiffness
                .unwrap_or_else(|| mindlin * (self.typical_overlap * self.radius).sqrt()),
            ForceLaw::M1 | ForceLaw::M2 => mindlin,
        }
    }

    /// The stage `pack` of this point.
    #[must_use]
    pub fn pack(&self) -> PackSpec {
        let sphere = self.shape == ShapeName::Sphere || self.overlap >= 1.0;
        PackSpec {
            grains: self.grains,
            packing_seed: self.packing_seed,
            shape: if sphere {
                ShapeName::Sphere
            } else {
                ShapeName::Tetrahedron
            },
            overlap: if sphere { 1.0 } else { self.overlap },
            radius: self.radius,
            density: self.density,
            youngs_modulus: self.youngs_modulus,
            poisson_ratio: self.poisson_ratio,
            normal_damping: self.normal_damping,
            wall_stiffness: self.wall_stiffness,
            delta0: self.delta0,
            servo_pressure: self.servo_pressure,
            gas_speed: self.gas_speed,
            gas_time: self.gas_time,
            preparation_cycles: self.preparation_cycles,
            preparation_time_step: self.preparation_time_step,
            preparation_ramp: self.preparation_ramp,
            rest_kinetic_energy: self.rest_kinetic_energy,
        }
    }

    /// The stage `train` of this point, on the pack named `pack`.
    #[must_use]
    pub fn train(&self, pack: StageId) -> TrainSpec {
        TrainSpec {
            pack,
            friction_coefficient: self.friction_coefficient,
            force_law: self.force_law,
            tangential_stiffness: self.resolved_tangential_stiffness(),
            tangential_damping_ratio: self.tangential_damping_ratio,
            time_step: self.time_step,
            ramp: self.ramp,
            drag: self.drag,
            skin: self.skin,
            slices: (self.force_law == ForceLaw::M2).then_some(Slices {
                number: self.slices,
                largest_overlap: self.slice_overlap,
            }),
        }
    }

    /// The stage `encode` of this point, in the trained pack named `train`, if its waveform shares one.
    #[must_use]
    pub fn encode(&self, train: StageId) -> Option<EncodeSpec> {
        let (waveform, _) = self.waveform.beginning()?;
        Some(EncodeSpec {
            train,
            waveform,
            gamma0: self.gamma0,
            time_step: self.time_step,
            ramp: self.ramp,
            drag: self.drag,
            precision: self.precision,
            skin: self.skin,
        })
    }

    /// The stage `recall` of this point, in the trained pack named `train`.
    ///
    /// It encodes from the start; [`crate::model::ModelPoint::ends`] lets it go on from a shared encoding.
    ///
    /// The zero waveform has no amplitude: its γ0 is 0 whatever the user said, so that it is run once per trained pack.
    #[must_use]
    pub fn recall(&self, train: StageId) -> RecallSpec {
        RecallSpec {
            train,
            encode: None,
            waveform: self.waveform.clone(),
            gamma0: if self.waveform == Waveform::Zero {
                0.0
            } else {
                self.gamma0
            },
            time_step: self.time_step,
            ramp: self.ramp,
            drag: self.drag,
            hold: self.hold,
            precision: self.precision,
            second_cycle: self.second_cycle,
            skin: self.skin,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(preset: &str) -> MemoryPoint {
        MemoryPoint::from_parameters(MemoryPoint::defaults(preset).expect("preset"))
            .expect("valid defaults")
    }

    #[test]
    fn every_preset_makes_a_valid_point_with_the_tables_fields() {
        for preset in PRESETS {
            let map = MemoryPoint::defaults(preset.name).expect("preset");
            for (name, value) in &map {
                let row = PARAMETERS
                    .iter()
                    .find(|p| p.name == name)
                    .expect("in the table");
                assert_eq!(row.check(value), Ok(value.clone()), "{name}");
            }
            let back = serde_json::to_value(point(preset.name)).expect("plain data");
            assert_eq!(back, Value::Object(map));
        }
    }

    #[test]
    fn default_tangential_stiffness_is_mindlins_at_the_typical_overlap() {
        // The oracle's k_H = 670 N/m is stated as 0.045 R; 666.7 N/m is k_M √(0.045 R) unrounded.
        let stiffness = MemoryPoint {
            typical_overlap: 0.045,
            ..point("standard")
        }
        .resolved_tangential_stiffness();
        assert!((stiffness - 666.7).abs() < 0.05, "{stiffness}");
    }

    #[test]
    fn an_overlap_of_one_is_a_sphere() {
        let tetra = MemoryPoint {
            overlap: 1.0,
            ..point("standard")
        };
        let sphere = MemoryPoint {
            shape: ShapeName::Sphere,
            overlap: 0.3,
            ..point("standard")
        };
        assert_eq!(tetra.pack(), sphere.pack());
    }

    #[test]
    fn spheres_without_drag_and_few_slices_are_warned_about_and_nothing_else_is() {
        let sphere = MemoryPoint {
            overlap: 1.0,
            ..point("standard")
        };
        for preset in ["draft", "standard"] {
            assert!(point(preset).warnings().is_empty());
        }
        assert!(sphere.warnings().is_empty());
        let free = |point: MemoryPoint| MemoryPoint { drag: 0.0, ..point };
        assert_eq!(free(sphere).warnings().len(), 1);
        assert!(free(point("standard")).warnings().is_empty());
        let sliced = |slices: u32| {
            let point = MemoryPoint {
                force_law: ForceLaw::M2,
                slices,
                ..point("standard")
            };
            point.warnings().len()
        };
        assert_eq!((sliced(100), sliced(CONVERGED_SLICES)), (1, 0));
    }

    #[test]
    fn zero_waveform_is_one_recall_per_trained_pack_and_names_its_ensemble() {
        let train = StageId::of_bytes(b"trained");
        let zero = |gamma0| {
            let point = MemoryPoint {
                gamma0,
                ..point("standard")
            };
            crate::stage::StageSpec::Recall(point.recall(train))
        };
        assert_eq!(zero(1e-3).id(), zero(2e-3).id());
        assert_eq!(zero(1e-3).id(), zero(1e-3).ensemble_key());
    }

    #[test]
    fn friction_and_waveform_leave_the_pack_alone() {
        let one = point("standard");
        let other = MemoryPoint {
            friction_coefficient: 0.2,
            waveform: Waveform::Six(3),
            ramp: 500.0,
            ..one.clone()
        };
        assert_eq!(one.pack(), other.pack());
    }
}
