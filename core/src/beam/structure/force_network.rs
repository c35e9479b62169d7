//! The force network: how large the forces between grains are, and how many are about to slide.

use serde::{Deserialize, Serialize};

use super::{AllAndBulk, ContactForce, Packing, mean, ratio};

/// A contact at this part of its Coulomb limit counts as sliding: "within 5 %" in the paper.
const NEAR_THE_LIMIT: f64 = 0.95;

/// Width of the histogram's bins in F_n/⟨F_n⟩.
pub const HISTOGRAM_BIN: f64 = 0.1;

/// The forces of a set of contacts; `None` without contacts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ForceNetwork {
    /// The number of contacts.
    pub contacts: usize,
    /// ⟨F⟩ \[N\], F = √(F_n² + F_t²).
    pub mean_force: Option<f64>,
    /// ⟨F_n⟩ \[N\].
    pub mean_normal_force: Option<f64>,
    /// ⟨F_t⟩ \[N\].
    pub mean_tangential_force: Option<f64>,
    /// Share of the contacts with F_t ≥ 0.95 μ F_n; `None` also where μ = 0.
    pub coulomb_fraction: Option<f64>,
    /// P(F_n/⟨F_n⟩), a density: bin k holds F_n/⟨F_n⟩ from 0.1 k to 0.1 (k + 1).
    pub normal_force_density: Vec<f64>,
}

/// The network of all contacts, and of those between two grains of the bulk.
#[must_use]
pub fn force_network(packing: &Packing<'_>) -> AllAndBulk<ForceNetwork> {
    let friction = packing.snapshot().friction_coefficient;
    let bulk = packing.bulk();
    let all: Vec<ContactForce> = packing.pressing().copied().collect();
    let inner = all
        .iter()
        .filter(|contact| bulk[contact.i] && bulk[contact.j]);
    AllAndBulk {
        bulk: network(&inner.copied().collect::<Vec<_>>(), friction),
        all: network(&all, friction),
    }
}

fn network(contacts: &[ContactForce], friction: f64) -> ForceNetwork {
    let over = |value: fn(&ContactForce) -> f64| mean(contacts.iter().map(value));
    let sliding = |contact: &&ContactForce| {
        contact.tangential_force >= NEAR_THE_LIMIT * friction * contact.normal_force
    };
    let mean_normal_force = over(|contact| contact.normal_force);
    let coulomb_fraction = if friction > 0.0 {
        ratio(
            contacts.iter().filter(sliding).count() as f64,
            contacts.len(),
        )
    } else {
        None
    };
    ForceNetwork {
        contacts: contacts.len(),
        mean_force: over(|contact| libm::hypot(contact.normal_force, contact.tangential_force)),
        mean_normal_force,
        mean_tangential_force: over(|contact| contact.tangential_force),
        coulomb_fraction,
        normal_force_density: mean_normal_force
            .map_or_else(Vec::new, |mean| density(contacts, mean)),
    }
}

/// The histogram, as long as its largest force asks for: F_n/⟨F_n⟩ is at most the number of contacts.
fn density(contacts: &[ContactForce], mean: f64) -> Vec<f64> {
    let mut counts: Vec<usize> = vec![];
    for contact in contacts {
        let bin = (contact.normal_force / mean / HISTOGRAM_BIN) as usize;
        if bin >= counts.len() {
            counts.resize(bin + 1, 0);
        }
        counts[bin] += 1;
    }
    let share = 1.0 / (contacts.len() as f64 * HISTOGRAM_BIN);
    counts.iter().map(|&count| count as f64 * share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::structure::fixture::Beam;

    /// Grains of a lattice of 7³; the first 27 pairs with the forces given, the last between two of the bulk.
    fn beam(forces: &[(f64, f64)], friction_coefficient: f64) -> Beam {
        let mut beam = Beam::cubic_lattice([7; 3], 1.0);
        beam.friction_coefficient = friction_coefficient;
        for (i, &(normal_force, tangential_force)) in forces.iter().enumerate() {
            // Grain 171 is the middle one, 172 beside it.
            let i = if i + 1 == forces.len() { 171 } else { i };
            beam.contacts.push(ContactForce {
                i,
                j: i + 1,
                normal_force,
                tangential_force,
            });
        }
        beam
    }

    #[test]
    fn means_are_of_the_contacts_that_press() {
        let found = force_network(&beam(&[(3.0, 4.0), (0.0, 0.0), (5.0, 12.0)], 9.0).packing());
        assert_eq!((found.all.contacts, found.bulk.contacts), (2, 1));
        assert_eq!(found.all.mean_force, Some(9.0));
        assert_eq!(found.all.mean_normal_force, Some(4.0));
        assert_eq!(found.all.mean_tangential_force, Some(8.0));
        assert_eq!(found.bulk.mean_force, Some(13.0));
    }

    #[test]
    fn within_5_percent_of_the_coulomb_limit_is_sliding() {
        let forces = [(1.0, 0.29), (1.0, 0.2851), (1.0, 0.2849), (1.0, 0.0)];
        let fraction = |friction| {
            let beam = beam(&forces, friction);
            force_network(&beam.packing()).all.coulomb_fraction
        };
        assert_eq!(fraction(0.3), Some(0.5));
        assert_eq!(fraction(0.0), None);
        assert_eq!(fraction(1e3), Some(0.0));
    }

    #[test]
    fn the_histogram_is_a_density_of_mean_1() {
        let forces: Vec<(f64, f64)> = (0..200)
            .map(|k| (0.01 + f64::from(k * k % 97), 0.0))
            .collect();
        let density = force_network(&beam(&forces, 0.3).packing())
            .all
            .normal_force_density;
        let integral: f64 = density.iter().map(|p| p * HISTOGRAM_BIN).sum();
        assert!((integral - 1.0).abs() < 1e-12);
        let middle = |k: usize| HISTOGRAM_BIN * (k as f64 + 0.5);
        let first: f64 = (0..density.len())
            .map(|k| density[k] * middle(k) * HISTOGRAM_BIN)
            .sum();
        // Each value is at most half a bin from the middle of its own.
        assert!((first - 1.0).abs() <= 0.5 * HISTOGRAM_BIN);
    }

    #[test]
    fn without_contacts_there_are_no_means() {
        let found = force_network(&beam(&[], 0.3).packing()).all;
        assert_eq!(
            (found.contacts, found.mean_force, found.coulomb_fraction),
            (0, None, None)
        );
        assert!(found.normal_force_density.is_empty());
    }
}
