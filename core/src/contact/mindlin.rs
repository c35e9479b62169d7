//! Mindlin's spring without slip, its stiffness taken at the present overlap, under a Coulomb limit.
//!
//! Eqs. (A2) to (A5) of H. Götz, T. Pöschel and O. D'Angelo, Phys. Rev. Research 6, 013061 (2024).
//! The trial force −κ a ξ, with the contact's radius a = √(R_eff p), is used if it does not exceed μ f_n; then the dashpot
//! −γ √(m k_t) v_t is added, and the sum limited again, which (A5) leaves out.
//! Otherwise the force is the trial force scaled to the limit, without a dashpot, and ξ is set so that the spring gives it.
//! The spring is not conservative while the overlap changes.

use serde::{Deserialize, Serialize};

use super::elongation::carried;
use super::{Contact, Slices, TangentialLaw};
use crate::lanes::{Lane, Row};
use crate::material::Pair;
use crate::math::Vec3;

/// Which stiffness of the spring is meant; G is 1/G = (2 − ν_i)/G_i + (2 − ν_j)/G_j, with G_i = E_i/(2(1 + ν_i)).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TangentialStiffness {
    /// (2/3)·16 G a: (A2) and (A3) as printed, with the modulus of one body.
    Paper,
    /// (2/3)·8 G a: Di Maio and Di Renzo's.
    Dimaio,
    /// 8 G a: Mindlin's.
    Mindlin,
}

/// The law of one pair of materials.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Mindlin {
    /// κ: the spring's stiffness over the contact's radius \[Pa\].
    stiffness: f64,
    /// k_t over the contact's radius, as the dashpot takes it \[Pa\].
    damped_stiffness: f64,
    /// γ: twice the damping ratio.
    damping: f64,
    /// μ.
    friction_coefficient: f64,
}

impl Mindlin {
    /// The law between the materials of `pair`, with the dashpot's γ and μ.
    #[must_use]
    pub fn new(
        pair: Pair,
        model: TangentialStiffness,
        damping: f64,
        friction_coefficient: f64,
    ) -> Self {
        let mindlin = 8.0 * pair.shear_modulus;
        let (damped_stiffness, share) = match model {
            TangentialStiffness::Paper => (2.0 * mindlin, 2.0 / 3.0),
            TangentialStiffness::Dimaio => (mindlin, 2.0 / 3.0),
            TangentialStiffness::Mindlin => (mindlin, 1.0),
        };
        Self {
            stiffness: share * damped_stiffness,
            damped_stiffness,
            damping,
            friction_coefficient,
        }
    }

    /// κ: the spring's stiffness over the contact's radius \[Pa\].
    #[must_use]
    pub fn stiffness(&self) -> f64 {
        self.stiffness
    }

    /// The same law with another μ.
    #[must_use]
    pub fn with_friction(self, friction_coefficient: f64) -> Self {
        Self {
            friction_coefficient,
            ..self
        }
    }
}

/// The law's constants in registers.
#[derive(Clone, Copy, Debug)]
pub struct MindlinConstants<L> {
    stiffness: L,
    damped_stiffness: L,
    damping: L,
    friction_coefficient: L,
}

impl TangentialLaw for Mindlin {
    /// ξ \[m\], the elongation of the spring: the path that `i` slid over `j`.
    type History<T: Copy + Send + Sync> = [T; 3];
    type Slices<R: Row> = ();
    type Constants<L: Lane> = MindlinConstants<L>;
    const TANGENTIAL: bool = true;

    #[inline(always)]
    fn constants<L: Lane>(&self) -> MindlinConstants<L> {
        MindlinConstants {
            stiffness: L::constant(self.stiffness),
            damped_stiffness: L::constant(self.damped_stiffness),
            damping: L::constant(self.damping),
            friction_coefficient: L::constant(self.friction_coefficient),
        }
    }

    #[inline(always)]
    fn force<L: Lane>(
        law: &MindlinConstants<L>,
        contact: &Contact<L>,
        history: &mut [L; 3],
        _slices: &mut impl Slices<L::Scalar>,
    ) -> Vec3<L> {
        let [x, y, z] = *history;
        let carried = carried(Vec3 { x, y, z }, contact.normal);
        let elongation = contact
            .sliding_velocity
            .scale_add(contact.time_step, carried);
        let stiffness = law.stiffness * contact.root_overlap;
        let trial = elongation.scale(-stiffness);
        let limit = law.friction_coefficient * contact.normal_force;
        let square = trial.dot(trial);
        let slipping = (limit * limit).lt(square);

        let damping = law.damping
            * (contact.reduced_mass * law.damped_stiffness * contact.root_overlap).sqrt();
        let damped = contact.sliding_velocity.scale_sub(damping, trial);
        let damped_square = damped.dot(damped);
        let beyond = (limit * limit).lt(damped_square);
        // Both are cut to the limit by one root and one division; most eights hold a contact that needs them.
        let pull = trial.select(slipping, damped);
        let share = limit / square.select(slipping, damped_square).sqrt();
        let cut = pull.scale(share);
        let force = cut.select(slipping, cut.select(beyond, damped));
        let kept = elongation.scale(share).select(slipping, elongation);
        *history = [kept.x, kept.y, kept.z];
        force
    }
}

#[cfg(test)]
mod tests;
