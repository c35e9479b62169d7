//! The gas: grains on a dilute lattice with random orientations and velocities, before they are packed.

use super::spec::PackSpec;
use crate::grains::{Motion, Pose, UPRIGHT};
use crate::random::{Purpose, rotation, uniform3};
use crate::shape::Body;

/// A lattice of `nx` × `nx` × `nz` sites \[R\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Sites along x and along y.
    pub nx: u32,
    /// Sites along z.
    pub nz: u32,
    /// Distance of neighboring sites.
    pub spacing: f64,
}

impl Lattice {
    /// The paper's lattices for its numbers of grains; the last sites stay empty for others (docs/choices.md §1).
    #[must_use]
    pub fn new(grains: u32, body: &Body) -> Self {
        let nx = (libm::cbrt(f64::from(grains) / 2.3).round() as u32).max(1);
        let nz = grains.div_ceil(nx * nx);
        // 3.08 R is the trial's; more elongated grains need room to turn without touching at the start.
        let spacing = (2.067 * (1.0 + body.reach())).max(3.08);
        Self { nx, nz, spacing }
    }

    /// The walls of the box around the lattice, its middle at the origin.
    #[must_use]
    pub fn walls(&self) -> [f64; 6] {
        let (side, height) = (
            f64::from(self.nx) * self.spacing,
            f64::from(self.nz) * self.spacing,
        );
        let (side, height) = (0.5 * side, 0.5 * height);
        [-side, side, -side, side, -height, height]
    }

    /// The place of grain `n`: along x first, then y, then z.
    #[must_use]
    pub fn site(&self, n: u32) -> [f64; 3] {
        let (x, y, z) = (n % self.nx, n / self.nx % self.nx, n / (self.nx * self.nx));
        let along =
            |site: u32, count: u32| (f64::from(site) + 0.5 - 0.5 * f64::from(count)) * self.spacing;
        [along(x, self.nx), along(y, self.nx), along(z, self.nz)]
    }
}

/// Where the grains of the gas start and how they move.
#[must_use]
pub fn start(spec: &PackSpec, body: &Body, lattice: &Lattice) -> (Vec<Pose>, Vec<Motion>) {
    let seed = spec.packing_seed;
    let oriented = body.arms.len() > 1;
    (0..spec.grains)
        .map(|n| {
            let counter = u64::from(n);
            let orientation = if oriented {
                rotation(seed, Purpose::GasOrientation, counter)
            } else {
                UPRIGHT
            };
            let velocity = uniform3(seed, Purpose::GasVelocity, counter)
                .map(|x| spec.gas_speed * (2.0 * x - 1.0));
            (
                Pose {
                    position: lattice.site(n),
                    orientation,
                },
                Motion {
                    velocity,
                    spin: [0.0; 3],
                },
            )
        })
        .unzip()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lattices_are_the_papers() {
        let body = Body::tetrahedron(0.6);
        let expected = [
            (325, 5, 13),
            (1024, 8, 16),
            (3267, 11, 27),
            (10_240, 16, 40),
            (31_680, 24, 55),
        ];
        for (n, nx, nz) in expected {
            let lattice = Lattice::new(n, &body);
            assert_eq!((lattice.nx, lattice.nz), (nx, nz));
            assert!((lattice.spacing - 3.08).abs() < 1e-12);
        }
        assert_eq!(Lattice::new(1, &body).nx, 1);
    }
}
