//! Coordination number: how many neighbors press on a grain, under its several names.

use serde::{Deserialize, Serialize};

use super::{Packing, ratio};

/// z \[contacts per grain\]; `None` where there is no grain to average over.
///
/// The paper does not say which it means; `all` is compared with its Fig. 3.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coordination {
    /// z = 2 N_c/N: contacts between grains, over all grains.
    pub all: Option<f64>,
    /// z_bulk: the mean over the bulk, contacts with other grains included.
    pub bulk: Option<f64>,
    /// z_nr: of what is left when rattlers are removed, repeatedly until there is none.
    pub without_rattlers: Option<f64>,
    /// The number of grains so removed.
    pub rattlers: usize,
    /// Their share of all grains.
    pub rattler_fraction: Option<f64>,
    /// (2 N_c + N_m)/N: with the contacts of grains and membrane.
    pub with_membrane: Option<f64>,
}

/// Counts the contacts with F_n > 0.
#[must_use]
pub fn coordination(packing: &Packing<'_>) -> Coordination {
    let counts = packing.contact_counts();
    let ends: usize = counts.iter().sum();
    let bulk: Vec<usize> = counts
        .iter()
        .zip(packing.bulk())
        .filter_map(|(&count, &bulk)| bulk.then_some(count))
        .collect();
    let with_membrane = ends + packing.snapshot().membrane_contacts.len();
    let (rattlers, left) = without_rattlers(packing, &counts);
    Coordination {
        all: ratio(ends as f64, counts.len()),
        bulk: ratio(bulk.iter().sum::<usize>() as f64, bulk.len()),
        without_rattlers: ratio(left as f64, counts.len() - rattlers),
        rattlers,
        rattler_fraction: ratio(rattlers as f64, counts.len()),
        with_membrane: ratio(with_membrane as f64, counts.len()),
    }
}

/// The number of rattlers, and of contact ends between the others.
///
/// A rattler has fewer than 2 contacts with grains where they rub, fewer than 4 where μ = 0: too few to hold it.
fn without_rattlers(packing: &Packing<'_>, counts: &[usize]) -> (usize, usize) {
    let least = if packing.snapshot().friction_coefficient > 0.0 {
        2
    } else {
        4
    };
    let mut neighbors = vec![vec![]; counts.len()];
    for contact in packing.pressing() {
        neighbors[contact.i].push(contact.j);
        neighbors[contact.j].push(contact.i);
    }
    let mut left = counts.to_vec();
    let mut removed: Vec<bool> = left.iter().map(|&count| count < least).collect();
    let mut next: Vec<usize> = (0..left.len()).filter(|&i| removed[i]).collect();
    while let Some(i) = next.pop() {
        for &j in &neighbors[i] {
            left[j] -= 1;
            if !removed[j] && left[j] < least {
                removed[j] = true;
                next.push(j);
            }
        }
    }
    let kept = left.iter().zip(&removed).filter(|(_, removed)| !**removed);
    let rattlers = removed.iter().filter(|removed| **removed).count();
    (rattlers, kept.map(|(&count, _)| count).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::structure::ContactForce;
    use crate::beam::structure::fixture::{Beam, box_membrane, indices};

    fn touch(i: usize, j: usize) -> ContactForce {
        ContactForce {
            i,
            j,
            normal_force: 1.0,
            tangential_force: 0.0,
        }
    }

    /// A cubic lattice of 7³ grains, each touching those beside it, the outer ones the membrane.
    fn lattice() -> Beam {
        let n = 7;
        let mut beam = Beam::cubic_lattice([n; 3], 1.0);
        for (i, at) in indices([n; 3]).enumerate() {
            for (axis, step) in [1, n, n * n].into_iter().enumerate() {
                if at[axis] + 1 < n {
                    beam.contacts.push(touch(i, i + step));
                }
            }
            let faces = at.iter().filter(|&&k| k == 0 || k + 1 == n).count();
            beam.membrane_contacts.extend(std::iter::repeat_n(i, faces));
        }
        beam
    }

    #[test]
    fn a_cubic_lattice_has_6_neighbors_in_the_bulk_and_fewer_at_the_membrane() {
        let found = coordination(&lattice().packing());
        // 3 × 7² × 6 contacts between 7³ grains, 6 × 7² with the membrane.
        assert_eq!(found.all, Some(2.0 * 882.0 / 343.0));
        assert_eq!(found.bulk, Some(6.0));
        assert_eq!(found.with_membrane, Some(6.0));
        assert_eq!((found.without_rattlers, found.rattlers), (found.all, 0));
    }

    #[test]
    fn a_contact_without_force_does_not_count() {
        let mut beam = lattice();
        beam.contacts[0].normal_force = 0.0;
        let found = coordination(&beam.packing());
        assert_eq!(found.all, Some(2.0 * 881.0 / 343.0));
    }

    #[test]
    fn rattlers_go_one_after_the_other() {
        // A ring of five with a tail of three: the tail goes from its end, the ring stays.
        let mut beam = Beam::of(
            box_membrane([0.0; 3], [9.0; 3], [2; 3]),
            (0..8).map(|k| [f64::from(k) + 0.5, 4.0, 4.0]),
            0.5,
        );
        let ring = [(0, 1), (1, 2), (2, 3), (3, 4), (4, 0)];
        let tail = [(4, 5), (5, 6), (6, 7)];
        let contacts = ring.iter().chain(&tail).map(|&(i, j)| touch(i, j));
        beam.contacts = contacts.collect();
        let found = coordination(&beam.packing());
        assert_eq!(found.all, Some(2.0));
        assert_eq!((found.without_rattlers, found.rattlers), (Some(2.0), 3));
        // Without friction two contacts hold nothing, and the ring goes too.
        beam.friction_coefficient = 0.0;
        let found = coordination(&beam.packing());
        assert_eq!((found.without_rattlers, found.rattlers), (None, 8));
    }

    #[test]
    fn without_grains_there_is_no_coordination_and_one_alone_has_none() {
        let mesh = || box_membrane([0.0; 3], [9.0; 3], [2; 3]);
        let none = coordination(&Beam::empty(mesh()).packing());
        assert_eq!(
            (none.all, none.bulk, none.with_membrane),
            (None, None, None)
        );
        let one = coordination(&Beam::of(mesh(), [[4.5; 3]], 0.5).packing());
        assert_eq!((one.all, one.bulk), (Some(0.0), Some(0.0)));
        assert_eq!((one.without_rattlers, one.rattlers), (None, 1));
        assert_eq!(
            (one.rattler_fraction, none.rattler_fraction),
            (Some(1.0), None)
        );
    }
}
