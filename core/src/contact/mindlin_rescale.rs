//! Law M1, Eq. (5): a spring whose stiffness grows with the contact, and which is weakened as the contact shrinks.
//!
//! Δf_e = k_M √p Δσ and f_d = γ_M √p σ̇ under a Coulomb limit; where the overlap falls, f_e falls as its root (Walton's
//! approximation), so that no energy is gained by parting what was sheared.
//! (`tangential mindlin_rescale/force` is what LAMMPS calls it.)

use super::elongation::{turn, turned};
use super::{Contact, Slices, TangentialLaw};
use crate::lanes::{Lane, Mask, Row, Scalar};
use crate::math::Vec3;

/// Law M1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MindlinRescale {
    /// k_M \[E R^½\].
    pub stiffness: f64,
    /// γ_M \[E R^½ t_c\].
    pub damping: f64,
    /// μ.
    pub friction_coefficient: f64,
}

/// Law M1's constants in registers.
#[derive(Clone, Copy, Debug)]
pub struct MindlinRescaleConstants<L> {
    stiffness: L,
    damping: L,
    friction_coefficient: L,
}

impl TangentialLaw for MindlinRescale {
    /// −f_e \[E R²\], which points along the path of `i` over `j`, and √p of the last step \[R^½\].
    type History<T: Copy + Send + Sync> = [T; 4];
    type Slices<R: Row> = ();
    type Constants<L: Lane> = MindlinRescaleConstants<L>;
    const TANGENTIAL: bool = true;

    #[inline(always)]
    fn constants<L: Lane>(&self) -> MindlinRescaleConstants<L> {
        MindlinRescaleConstants {
            stiffness: L::constant(self.stiffness),
            damping: L::constant(self.damping),
            friction_coefficient: L::constant(self.friction_coefficient),
        }
    }

    #[inline(always)]
    fn force<L: Lane>(
        law: &MindlinRescaleConstants<L>,
        contact: &Contact<L>,
        history: &mut [L; 4],
        _slices: &mut impl Slices<L::Scalar>,
    ) -> Vec3<L> {
        let [x, y, z, root_before] = *history;
        let root = contact.root_overlap;
        let before = Vec3 { x, y, z };
        // (√p − √p_old)/√p_old, or 0 if the overlap did not fall; a contact that is new has nothing to lose.
        let fallen = -(root_before - root).max(L::constant(0.0));
        let fall = fallen / root_before.max(L::constant(1e-30));
        let sliding = contact.sliding_velocity;
        let path = sliding.scale(law.stiffness * root * contact.time_step);
        let elastic = if L::Scalar::COARSE {
            let change = before.scale_add(fall, turn(before, contact.normal) + path);
            before.grown(change, contact.dither)
        } else {
            let turned = turned(before, contact.normal);
            turned.scale_add(fall, turned) + path
        };
        let damping = law.damping * root;
        // The force on `i` opposes the path of `i`.
        let trial = sliding.scale_add(damping, elastic).scale(L::constant(-1.0));

        let limit = law.friction_coefficient * contact.normal_force;
        let square = trial.dot(trial);
        let slipping = (limit * limit).lt(square);
        let (mut force, mut kept) = (trial, elastic);
        if slipping.any() {
            let limited = trial.scale(limit / square.sqrt());
            // What is kept and the damping force are together the limited force.
            let relaxed = sliding.scale_add(damping, limited).scale(L::constant(-1.0));
            force = limited.select(slipping, trial);
            kept = relaxed.select(slipping, elastic);
        }
        *history = [kept.x, kept.y, kept.z, root];
        force
    }
}
