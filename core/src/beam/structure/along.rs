//! All analyses of one snapshot, and of the change from one to the next: what is kept of a beam while it is bent.

use serde::{Deserialize, Serialize};

use super::autocorrelation::{Autocorrelation, autocorrelation};
use super::bond_order::{BondOrder, bond_order};
use super::coordination::{Coordination, coordination};
use super::displacement::{Field, displacement_field};
use super::faces::{Faces, Halves};
use super::force_network::{ForceNetwork, force_network};
use super::neutral_plane::{NeutralPoint, neutral_plane};
use super::non_affine::{Excluded, VICINITY, non_affine};
use super::pair_correlation::{PairCorrelation, pair_correlation};
use super::profile::{HeightBin, height_profile, means};
use super::voronoi::changes;
use super::{AllAndBulk, Packing, SnapshotError};

/// How far pairs are counted for g(r), in d_p: twice as far as a packing without order has peaks.
const FARTHEST_PAIR: f64 = 8.0;

/// How far values of D_min are compared, in d_p: beyond the paper's Fig. 12.
const FARTHEST_CORRELATION: f64 = 10.0;

/// Vicinities in d_p that tell how much [`VICINITY`] matters.
const OTHER_VICINITIES: [f64; 2] = [1.25, 2.0];

/// Displacements are kept in whole nanometers, 2e-6 of the paper's way of the rods between two snapshots.
const PER_METER: f64 = 1e9;

/// What one snapshot shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Moment {
    /// φ = ΣV_p/V, V the membrane's volume.
    pub volume_fraction: f64,
    /// ⟨φ_i⟩ of the Voronoi cells.
    pub local_volume_fraction: AllAndBulk<Option<f64>>,
    /// z under its names.
    pub coordination: Coordination,
    /// ⟨F⟩, ⟨F_n⟩, ⟨F_t⟩, the Coulomb fraction and P(F_n/⟨F_n⟩).
    pub force_network: AllAndBulk<ForceNetwork>,
    /// The paper's g and the textbooks' up to 8 d_p; `None` without grains.
    pub pair_correlation: Option<PairCorrelation>,
    /// Q6: below 0.05 where there is no order.
    pub bond_order: AllAndBulk<Option<BondOrder>>,
}

impl Moment {
    /// What `packing` shows, whose grains have the φ_i `fractions`.
    #[must_use]
    pub fn of(packing: &Packing<'_>, fractions: &[Option<f64>]) -> Self {
        Self {
            volume_fraction: packing.volume_fraction(),
            local_volume_fraction: means(packing, fractions),
            coordination: coordination(packing),
            force_network: force_network(packing),
            pair_correlation: pair_correlation(packing, FARTHEST_PAIR),
            bond_order: bond_order(packing),
        }
    }
}

/// Means of one value per grain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Means {
    /// Over all grains and over the bulk.
    #[serde(flatten)]
    pub whole: AllAndBulk<Option<f64>>,
    /// Over the grains nearer to the top face, and to the bottom face.
    #[serde(flatten)]
    pub halves: Halves<Option<f64>>,
}

impl Means {
    fn of(packing: &Packing<'_>, faces: Option<&Faces>, values: &[Option<f64>]) -> Self {
        Self {
            whole: means(packing, values),
            halves: faces.map_or_else(Halves::default, |faces| faces.halves(packing, values)),
        }
    }
}

/// ⟨D_min⟩ with another vicinity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OtherVicinity {
    /// \[d_p\].
    pub vicinity: f64,
    /// ⟨D_min⟩ \[m\].
    pub mean: AllAndBulk<Option<f64>>,
}

/// What two consecutive snapshots show together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// ⟨D_min⟩ \[m\], Eq. (5), neighbors nearer than 1.5 d_p.
    pub non_affine: Means,
    /// How many grains have no D_min.
    pub excluded: Excluded,
    /// ⟨D_min⟩ with neighbors nearer than 1.25 and 2.0 d_p.
    pub other_vicinities: Vec<OtherVicinity>,
    /// D_min over its mean, over the height, in bins of 1 d_p.
    pub height_profile: Vec<HeightBin>,
    /// C(r) of D_min up to 10 d_p, Eqs. (D1) and (D2).
    pub autocorrelation: Option<Autocorrelation>,
    /// ⟨Δφ_i⟩.
    pub volume_fraction_change: Means,
    /// The displacement toward (−) or away from (+) the center \[m\], Eq. (C1), averaged over the depth, in whole nanometers.
    pub displacement: Option<Field>,
    /// Where its x-component is zero, in slabs of 2 d_p.
    pub neutral_plane: Vec<NeutralPoint>,
}

/// A snapshot with the φ_i of its grains.
#[derive(Clone, Copy, Debug)]
pub struct Filled<'a> {
    /// The snapshot.
    pub packing: &'a Packing<'a>,
    /// φ_i.
    pub fractions: &'a [Option<f64>],
}

impl Change {
    /// What happened from one snapshot to the next, and the D_min of each grain \[m\]; profiles have `each_way` bins above and below the middle.
    ///
    /// # Errors
    /// If the snapshots are of different grains.
    pub fn between(
        before: Filled<'_>,
        after: Filled<'_>,
        each_way: usize,
    ) -> Result<(Self, Vec<Option<f64>>), SnapshotError> {
        let (old, new) = (before.packing, after.packing);
        let faces = Faces::of(new);
        let strays = non_affine(old, new, VICINITY)?;
        let mut other_vicinities = vec![];
        for vicinity in OTHER_VICINITIES {
            let mean = means(new, &non_affine(old, new, vicinity)?.values);
            other_vicinities.push(OtherVicinity { vicinity, mean });
        }
        let field = displacement_field(old, new)?;
        let changes = changes(before.fractions, after.fractions);
        let profile = |faces| height_profile(new, faces, &strays.values, each_way);
        let change = Self {
            non_affine: Means::of(new, faces.as_ref(), &strays.values),
            excluded: strays.excluded,
            other_vicinities,
            height_profile: faces.as_ref().map_or_else(Vec::new, profile),
            autocorrelation: autocorrelation(old, &strays.values, FARTHEST_CORRELATION),
            volume_fraction_change: Means::of(new, faces.as_ref(), &changes),
            neutral_plane: field
                .as_ref()
                .map_or_else(Vec::new, |field| neutral_plane(new, field)),
            displacement: field.map(|field| whole_nanometers(field.averaged_over_depth())),
        };
        Ok((change, strays.values))
    }
}

fn whole_nanometers(mut field: Field) -> Field {
    for value in field.values.iter_mut().flatten() {
        *value = value.map(|x| (x * PER_METER).round() / PER_METER);
    }
    field
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{Beam, bent, box_membrane};
    use super::super::voronoi::local_volume_fractions;
    use super::*;

    fn between(before: &Beam, after: &Beam) -> (Change, Vec<Option<f64>>) {
        let (before, after) = (before.packing(), after.packing());
        let fractions = [&before, &after].map(local_volume_fractions);
        let filled = |k: usize, packing| Filled {
            packing,
            fractions: &fractions[k],
        };
        Change::between(filled(0, &before), filled(1, &after), 4).expect("the same grains")
    }

    #[test]
    fn a_lattice_that_swells_gets_thinner_everywhere_alike_and_strays_nowhere() {
        let mut before = Beam::cubic_lattice([12, 6, 6], 1.0);
        let at = |i: usize, k: usize, n: usize| (i / [1, 12, 72][k]) % n;
        for i in 0..before.positions.len() {
            for (k, n) in [12, 6, 6].into_iter().enumerate() {
                if at(i, k, n) + 1 < n {
                    before.contacts.push(super::super::ContactForce {
                        i,
                        j: i + [1, 12, 72][k],
                        normal_force: 1.0,
                        tangential_force: 0.0,
                    });
                }
            }
        }
        let after = before.moved(|at| at.map(|x| 1.01 * x));
        let (change, strays) = between(&before, &after);
        assert!(strays.iter().flatten().all(|stray| *stray < 1e-12));
        // φ_i falls by 1 − 1/1.01³ of π/6 in either half.
        let expected = std::f64::consts::FRAC_PI_6 * (1.0 / (1.01 * 1.01 * 1.01) - 1.0);
        let found = change.volume_fraction_change;
        for value in [found.whole.all, found.halves.top, found.halves.bottom] {
            assert!((value.expect("grains") - expected).abs() < 1e-9);
        }
        // Everything moves away from the center.
        let field = change.displacement.expect("grains");
        assert_eq!(field.count[1], 1);
        assert!(field.values.iter().flatten().flatten().all(|x| *x >= 0.0));
    }

    #[test]
    fn an_empty_beam_has_moments_and_changes_without_numbers() {
        let beam = Beam::empty(box_membrane([0.0; 3], [9.0, 3.0, 3.0], [9, 3, 3]));
        let after = beam.moved(|at| bent(at, 9.0, 3.0, 0.1));
        let (change, strays) = between(&beam, &after);
        assert!(strays.is_empty() && change.displacement.is_none());
        assert_eq!(change.non_affine.whole.all, None);
        let moment = Moment::of(&beam.packing(), &[]);
        assert_eq!(moment.coordination.all, None);
        assert!(moment.volume_fraction.abs() < f64::MIN_POSITIVE);
    }
}
