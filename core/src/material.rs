//! Materials: Hertz stiffness and damping in the engine's units (R = ρ = E = 1).

/// The elastic constants of one grain material against itself and against rigid walls.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Material {
    /// k_n \[E R^½\]: f = k_n p^(3/2) between two spheres of radius R (Eq. 3).
    pub normal_stiffness: f64,
    /// γ_n \[E R^½ t_c\]: f = γ_n √p ṗ (Eq. 3).
    pub normal_damping: f64,
    /// k_w \[E R^½\]: the same for a sphere at a flat rigid wall.
    pub wall_stiffness: f64,
    /// γ_w \[E R^½ t_c\].
    pub wall_damping: f64,
}

impl Material {
    /// A material from Poisson's ratio, γ_n/k_n \[t_c\] and k_w/k_n.
    #[must_use]
    pub fn new(poisson_ratio: f64, normal_damping: f64, wall_stiffness: f64) -> Self {
        // 2^(−3/2) (4/3)/(1 − ν²): Hertz with R_eff = R/2 and E_eff = E/(2(1 − ν²)).
        let k_n = std::f64::consts::FRAC_1_SQRT_2 * 0.5 * (4.0 / 3.0)
            / (1.0 - poisson_ratio * poisson_ratio);
        let k_w = wall_stiffness * k_n;
        Self {
            normal_stiffness: k_n,
            normal_damping: normal_damping * k_n,
            wall_stiffness: k_w,
            wall_damping: normal_damping * k_w,
        }
    }

    /// Viscoelastic spheres of different sizes, of the materials of `pair`, with the relaxation time A \[s\]; no walls.
    ///
    /// f = K √R_eff √p (p + (3/2) A ṗ) with K = (4/3) E: Eq. (A1) of Phys. Rev. Research 6, 013061 (2024), whose ξ̇ is
    /// the velocity of separation, since otherwise an impact would gain energy.
    #[must_use]
    pub fn viscoelastic(pair: Pair, relaxation_time: f64) -> Self {
        let stiffness = 4.0 / 3.0 * pair.modulus;
        Self {
            normal_stiffness: stiffness,
            normal_damping: 1.5 * relaxation_time * stiffness,
            wall_stiffness: 0.0,
            wall_damping: 0.0,
        }
    }
}

/// The elastic constants of a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic {
    /// E \[Pa\].
    pub youngs_modulus: f64,
    /// ν, in (−1, 0.5\].
    pub poisson_ratio: f64,
}

/// Two solids against each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// 1/E = (1 − ν_i²)/E_i + (1 − ν_j²)/E_j \[Pa\].
    pub modulus: f64,
    /// 1/G = (2 − ν_i)/G_i + (2 − ν_j)/G_j with G_i = E_i/(2(1 + ν_i)) \[Pa\].
    pub shear_modulus: f64,
}

impl Elastic {
    /// This solid against one that does not give: 1/E = (1 − ν²)/E_i, and likewise across.
    #[must_use]
    pub fn against_rigid(self) -> Pair {
        let same = self.against(self);
        Pair {
            modulus: 2.0 * same.modulus,
            shear_modulus: 2.0 * same.shear_modulus,
        }
    }

    /// This solid against `other`.
    #[must_use]
    pub fn against(self, other: Self) -> Pair {
        let along = |of: Self| (1.0 - of.poisson_ratio * of.poisson_ratio) / of.youngs_modulus;
        let across = |of: Self| {
            2.0 * (1.0 + of.poisson_ratio) * (2.0 - of.poisson_ratio) / of.youngs_modulus
        };
        Pair {
            modulus: 1.0 / (along(self) + along(other)),
            shear_modulus: 1.0 / (across(self) + across(other)),
        }
    }
}

impl Pair {
    /// The tangent stiffness of a contact of radius a along its normal, over a \[Pa\]: 2 E.
    #[must_use]
    pub fn normal_slope(self) -> f64 {
        2.0 * self.modulus
    }
}

/// The scales that turn the engine's units into SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// R \[m\].
    pub length: f64,
    /// E \[Pa\].
    pub pressure: f64,
    /// t_c = R √(ρ/E) \[s\].
    pub time: f64,
}

impl Units {
    /// From R \[m\], ρ \[kg/m³\] and E \[Pa\].
    #[must_use]
    pub fn new(radius: f64, density: f64, youngs_modulus: f64) -> Self {
        Self {
            length: radius,
            pressure: youngs_modulus,
            time: radius * (density / youngs_modulus).sqrt(),
        }
    }

    /// A stiffness \[N/m\] in units of E R.
    #[must_use]
    pub fn stiffness_from_si(&self, stiffness: f64) -> f64 {
        stiffness / (self.pressure * self.length)
    }

    /// A stiffness over the root of an overlap \[N/m^(3/2)\], as k_n and k_M, in units of E R^½.
    #[must_use]
    pub fn stiffness_per_root_from_si(&self, stiffness: f64) -> f64 {
        stiffness / (self.pressure * self.length.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stiffness_is_the_papers_for_silicone_rubber() {
        // The peers' scripts print k_n = 1.3870e5 N m^(−3/2) for R = 0.5 mm, E = 10 MPa, ν = 0.49.
        let units = Units::new(0.5e-3, 1200.0, 1e7);
        let si = Material::new(0.49, 0.23, 2f64.powf(1.5)).normal_stiffness
            * units.pressure
            * units.length.sqrt();
        assert!((si - 138_714.640_530_261_85).abs() < 1e-6, "{si}");
        assert!((units.time - 5.4772e-6).abs() < 1e-10);
    }

    #[test]
    fn moduli_are_finite_for_every_poisson_ratio_that_is_allowed() {
        for poisson_ratio in [-0.989, -0.5, 0.0, 0.245, 0.5] {
            let solid = Elastic {
                youngs_modulus: 1e8,
                poisson_ratio,
            };
            let pair = solid.against(solid);
            let along = 1e8 / (2.0 * (1.0 - poisson_ratio * poisson_ratio));
            let across = 1e8 / (4.0 * (1.0 + poisson_ratio) * (2.0 - poisson_ratio));
            assert!((pair.modulus / along - 1.0).abs() < 1e-12);
            assert!((pair.shear_modulus / across - 1.0).abs() < 1e-12);
        }
    }
}
