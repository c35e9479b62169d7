//! Global bond order: whether the directions from grain to grain agree throughout the packing, as in a crystal.

use serde::{Deserialize, Serialize};

use super::cells::PointGrid;
use super::{AllAndBulk, Packing};

/// Grains closer than this, in d_p, share a bond: the first minimum of g(r).
const BOND: f64 = 1.4;

/// Q6 and what it is made of.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BondOrder {
    /// Q6 = √((4π/13) Σ_m |⟨Y_6m⟩|²), averaged over all bonds: 0.575 in fcc, about 1/√bonds where there is no order.
    pub global: f64,
    /// The number of bonds.
    pub bonds: usize,
}

/// Q6 over the bonds that start at any grain and over those that start in the bulk; `None` without bonds.
#[must_use]
pub fn bond_order(packing: &Packing<'_>) -> AllAndBulk<Option<BondOrder>> {
    let mut sums = AllAndBulk::<Sum>::default();
    let reach = BOND * packing.mean_diameter().unwrap_or(0.0);
    let positions = packing.snapshot().positions;
    let grid = PointGrid::new(positions, reach);
    for (i, &position) in positions.iter().enumerate() {
        grid.visit(position, reach, |j, branch, square| {
            // Y_6m is even, so the bond seen from its other end adds the same.
            if square > 0.0 && j != i {
                let harmonics = harmonics(branch.map(|x| x / square.sqrt()));
                sums.all.add(&harmonics);
                if packing.bulk()[i] {
                    sums.bulk.add(&harmonics);
                }
            }
        });
    }
    AllAndBulk {
        all: sums.all.order(),
        bulk: sums.bulk.order(),
    }
}

#[derive(Default)]
struct Sum {
    harmonics: [f64; 13],
    bonds: usize,
}

impl Sum {
    fn add(&mut self, harmonics: &[f64; 13]) {
        for (sum, value) in self.harmonics.iter_mut().zip(harmonics) {
            *sum += value;
        }
        self.bonds += 1;
    }

    fn order(&self) -> Option<BondOrder> {
        let count = self.bonds as f64;
        let squares = self
            .harmonics
            .iter()
            .map(|sum| (sum / count) * (sum / count));
        (self.bonds > 0).then(|| BondOrder {
            global: squares.sum::<f64>().sqrt(),
            bonds: self.bonds,
        })
    }
}

/// √(4π/13) Y_6m in real form of a unit vector; the sum of their squares is 1.
///
/// Y_6m ∝ P_m(z) (x + iy)^m, with the m-th derivative of the Legendre polynomial (231 z⁶ − 315 z⁴ + 105 z² − 5)/16.
fn harmonics([x, y, z]: [f64; 3]) -> [f64; 13] {
    let q = z * z;
    let legendre = [
        (((231.0 * q - 315.0) * q + 105.0) * q - 5.0) / 16.0,
        z * ((693.0 * q - 630.0) * q + 105.0) / 8.0,
        ((3465.0 * q - 1890.0) * q + 105.0) / 8.0,
        z * (3465.0 * q - 945.0) / 2.0,
        (10395.0 * q - 945.0) / 2.0,
        10395.0 * z,
        10395.0,
    ];
    let mut found = [0.0; 13];
    found[0] = legendre[0];
    let (mut real, mut imaginary, mut ratio) = (1.0, 0.0, 2.0);
    for m in 1..7 {
        (real, imaginary) = (real * x - imaginary * y, real * y + imaginary * x);
        // 2 (6 − m)!/(6 + m)!
        ratio /= ((6 + m) * (7 - m)) as f64;
        let factor = f64::sqrt(ratio) * legendre[m];
        found[2 * m - 1] = factor * real;
        found[2 * m] = factor * imaginary;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::structure::fixture::{Beam, box_membrane, indices};
    use crate::math::plain::rotate;
    use crate::random::{Purpose, rotation, uniform3};

    #[test]
    fn harmonics_of_any_direction_have_length_1() {
        for n in 0..100 {
            let turned = rotate(rotation(1, Purpose::GasVelocity, n), [0.0, 0.0, 1.0]);
            let length: f64 = harmonics(turned).iter().map(|value| value * value).sum();
            assert!((length - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn known_lattices_have_their_known_order_however_they_are_turned() {
        // Steinhardt, Nelson, Ronchetti 1983: simple cubic 0.354, fcc 0.575.
        let step = 0.5 * 2.0f64.sqrt();
        let fcc = indices([12; 3]).filter(|at| (at[0] + at[1] + at[2]) % 2 == 0);
        let fcc: Vec<[f64; 3]> = fcc.map(|at| at.map(|k| step * (k as f64 + 1.0))).collect();
        let simple = indices([9; 3])
            .map(|at| at.map(|k| k as f64 + 1.0))
            .collect();
        for (positions, expected) in [(fcc, 0.574_524), (simple, 0.353_553)] {
            let mesh = box_membrane([0.0; 3], [10.0; 3], [10; 3]);
            let beam = Beam::of(mesh, positions, 0.5);
            let turn = rotation(2, Purpose::GasOrientation, 0);
            for beam in [&beam, &beam.moved(|at| rotate(turn, at))] {
                let found = bond_order(&beam.packing()).bulk.expect("bonds").global;
                assert!((found - expected).abs() < 1e-6, "{found}");
            }
        }
    }

    #[test]
    fn grains_anywhere_have_no_order() {
        let positions = (0..6000).map(|n| uniform3(3, Purpose::GasVelocity, n).map(|x| 18.0 * x));
        let mesh = box_membrane([0.0; 3], [18.0; 3], [9; 3]);
        let found = bond_order(&Beam::of(mesh, positions, 0.5).packing());
        assert!(found.all.expect("bonds").global < 0.05);
        assert!(found.bulk.expect("bonds").global < 0.05);
    }

    #[test]
    fn without_bonds_there_is_no_order() {
        let mesh = || box_membrane([0.0; 3], [9.0; 3], [9; 3]);
        assert_eq!(bond_order(&Beam::empty(mesh()).packing()).all, None);
        // Coincident grains have no direction.
        let beam = Beam::of(mesh(), [[4.5; 3]; 2], 0.5);
        assert_eq!(bond_order(&beam.packing()).all, None);
    }
}
