//! Law H, Eq. (4): a linear spring and dashpot in the contact plane under a Coulomb limit.
//!
//! The trial force −(k ξ + γ v_t) is used if it does not exceed μ f_n.
//! Otherwise it is scaled to the limit, and ξ is set so that elastic and damping force together equal it (Luding 2008).
//! Apart from the damping this is the law of Cundall and Strack.

use super::elongation::{turn, turned};
use super::{Contact, Slices, TangentialLaw};
use crate::lanes::{Lane, Mask, Row, Scalar};
use crate::math::Vec3;

/// Law H.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hooke {
    /// k_H \[E R\].
    pub stiffness: f64,
    /// γ_H \[E R t_c\].
    pub damping: f64,
    /// μ.
    pub friction_coefficient: f64,
}

/// Law H's constants in registers.
#[derive(Clone, Copy, Debug)]
pub struct HookeConstants<L> {
    stiffness: L,
    compliance: L,
    damping: L,
    friction_coefficient: L,
}

impl TangentialLaw for Hooke {
    /// ξ \[R\], the elongation of the spring: the path that `i` slid over `j`.
    type History<T: Copy + Send + Sync> = [T; 3];
    type Slices<R: Row> = ();
    type Constants<L: Lane> = HookeConstants<L>;
    const TANGENTIAL: bool = true;

    #[inline(always)]
    fn constants<L: Lane>(&self) -> HookeConstants<L> {
        HookeConstants {
            stiffness: L::constant(self.stiffness),
            compliance: L::constant(1.0 / self.stiffness),
            damping: L::constant(self.damping),
            friction_coefficient: L::constant(self.friction_coefficient),
        }
    }

    #[inline(always)]
    fn force<L: Lane>(
        law: &HookeConstants<L>,
        contact: &Contact<L>,
        history: &mut [L; 3],
        _slices: &mut impl Slices<L::Scalar>,
    ) -> Vec3<L> {
        let [x, y, z] = *history;
        let before = Vec3 { x, y, z };
        let sliding = contact.sliding_velocity;
        let elongation = if L::Scalar::COARSE {
            let change = sliding.scale_add(contact.time_step, turn(before, contact.normal));
            before.grown(change, contact.dither)
        } else {
            sliding.scale_add(contact.time_step, turned(before, contact.normal))
        };
        // The force on `i` opposes the path of `i`.
        let trial = elongation.scale_sub(law.stiffness, sliding.scale(-law.damping));

        let limit = law.friction_coefficient * contact.normal_force;
        let square = trial.dot(trial);
        let slipping = (limit * limit).lt(square);
        let (mut force, mut kept) = (trial, elongation);
        if slipping.any() {
            let limited = trial.scale(limit / square.sqrt());
            // −k ξ − γ v_t = limited.
            let relaxed = sliding
                .scale_add(law.damping, limited)
                .scale(-law.compliance);
            force = limited.select(slipping, trial);
            kept = relaxed.select(slipping, elongation);
        }
        *history = [kept.x, kept.y, kept.z];
        force
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::F64x1;

    const LAW: Hooke = Hooke {
        stiffness: 0.13,
        damping: 0.009,
        friction_coefficient: 0.5,
    };

    fn vector([x, y, z]: [f64; 3]) -> Vec3<F64x1> {
        Vec3 {
            x: F64x1([x]),
            y: F64x1([y]),
            z: F64x1([z]),
        }
    }

    fn contact(normal: [f64; 3], sliding_velocity: [f64; 3], normal_force: f64) -> Contact<F64x1> {
        Contact {
            normal: vector(normal),
            sliding_velocity: vector(sliding_velocity),
            root_overlap: F64x1([0.2]),
            reduced_mass: F64x1([2.0]),
            normal_force: F64x1([normal_force]),
            time_step: F64x1([0.1]),
            dither: F64x1([0.0]),
        }
    }

    fn force(contact: &Contact<F64x1>, history: &mut [F64x1; 3]) -> [f64; 3] {
        Hooke::force(&LAW.constants(), contact, history, &mut ()).lane(0)
    }

    #[test]
    fn sticking_force_is_spring_plus_dashpot() {
        let mut history = [F64x1([0.01]), F64x1([0.0]), F64x1([0.0])];
        let [x, y, z] = force(
            &contact([0.0, 0.0, 1.0], [0.02, 0.0, 0.0], 1.0),
            &mut history,
        );
        assert!(
            (x + 0.13 * (0.01 + 0.002) + 0.009 * 0.02).abs() < 1e-17,
            "{x}"
        );
        assert!(y == 0.0 && z == 0.0);
        assert!((history[0].0[0] - 0.012).abs() < 1e-17);
    }

    #[test]
    fn sliding_force_stays_on_the_coulomb_cone() {
        let mut history = [F64x1([1.0]), F64x1([-2.0]), F64x1([0.0])];
        let slid = contact([0.0, 0.0, 1.0], [0.3, 0.1, 0.0], 0.02);
        let [x, y, z] = force(&slid, &mut history);
        assert!((x.hypot(y) - 0.5 * 0.02).abs() < 1e-16);
        assert!(z == 0.0);
        // Elastic and damping force together are the limited force.
        assert!((-0.13 * history[0].0[0] - 0.009 * 0.3 - x).abs() < 1e-16);
    }

    #[test]
    fn spring_keeps_its_length_when_the_pair_turns() {
        // 90° about y in 300 steps of 5.2e-3: the series leaves 5/128 x⁴ with x = 2.7e-5, 1e-19 a step.
        // Projecting shortens the part of ξ that turns by cos θ, restoring the length lengthens both parts alike: the
        // direction drifts by θ²/2 a step, which is 1e-10 for the turns of a packing.
        let steps = 300;
        let step = std::f64::consts::FRAC_PI_2 / f64::from(steps);
        let mut history = [F64x1([0.004]), F64x1([0.003]), F64x1([0.0])];
        for k in 1..=steps {
            let angle = f64::from(k) * step;
            force(
                &contact([angle.sin(), 0.0, angle.cos()], [0.0; 3], 1.0),
                &mut history,
            );
        }
        let [x, y, z] = history.map(|h| h.0[0]);
        assert!((x * x + y * y + z * z - 25e-6).abs() < 25e-6 * 1e-12);
        let ratio = 4.0 / 3.0 * step.cos().powi(steps);
        assert!((z / y + ratio).abs() < 1e-12, "{z} {y} {ratio}");
    }
}
