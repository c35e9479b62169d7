//! Hertz's normal force between viscoelastic spheres, Eq. (3): f_n = max(0, k_n p^(3/2) + γ_n √p ṗ).

use crate::lanes::Lane;

/// f_n from √p and ṗ; never attractive.
#[inline(always)]
pub fn normal_force<L: Lane>(
    stiffness: L,
    damping: L,
    overlap: L,
    root_overlap: L,
    overlap_rate: L,
) -> L {
    let per_root = stiffness.mul_add(overlap, damping * overlap_rate);
    (root_overlap * per_root).max(L::constant(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::F64x1;

    fn force(overlap: f64, rate: f64) -> f64 {
        let one = |x| F64x1([x]);
        normal_force(
            one(2.0),
            one(0.5),
            one(overlap),
            one(overlap.sqrt()),
            one(rate),
        )
        .0[0]
    }

    #[test]
    fn force_is_hertz_plus_damping_and_never_pulls() {
        assert!((force(0.04, 0.0) - 2.0 * 0.008).abs() < 1e-17);
        assert!((force(0.04, 0.1) - (0.016 + 0.5 * 0.2 * 0.1)).abs() < 1e-17);
        assert!(force(0.04, -10.0).abs() < f64::MIN_POSITIVE);
    }
}
