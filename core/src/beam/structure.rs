//! What the inside of the beam does: contacts, forces, distances, motion and density of its grains.
//!
//! Source: the paper, Sec. III and Appendices C and D.
//! All of it takes a [`Packing`], a checked snapshot in SI units: x along the beam, y along its depth, z along its height; the rods press toward −z.
//! d_p is the mean grain diameter, and the *bulk* are the grains farther than 2 d_p from the membrane.
//! A third of the grains touch the membrane and bias every average, so averages are given over all grains and over the bulk.
//!
//! What has no data is `None`: a packing without grains is a packing, and no number here is ever NaN.

use serde::{Deserialize, Serialize};
use thiserror::Error;

mod cells;
pub mod membrane;

pub mod coordination;
pub mod force_network;

pub mod bond_order;
pub mod pair_correlation;

pub mod faces;

pub mod displacement;
pub mod neutral_plane;

pub mod autocorrelation;
pub mod non_affine;
mod symmetric;

mod polyhedron;
pub mod voronoi;

pub mod profile;

pub mod along;
pub mod report;

#[cfg(test)]
mod fixture;

use membrane::Membrane;

/// Grains farther than this from the membrane, in d_p, are the bulk.
const BULK_DEPTH: f64 = 2.0;

/// The force between two grains that touch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactForce {
    /// One of the grains.
    pub i: usize,
    /// The other.
    pub j: usize,
    /// F_n \[N\]; a contact without it does not count.
    pub normal_force: f64,
    /// F_t ≥ 0 \[N\]: the magnitude.
    pub tangential_force: f64,
}

/// Everything that the analyses look at, at one moment.
#[derive(Clone, Copy, Debug)]
pub struct Snapshot<'a> {
    /// Centers of the grains \[m\].
    pub positions: &'a [[f64; 3]],
    /// R of each grain \[m\].
    pub radii: &'a [f64],
    /// μ between grains.
    pub friction_coefficient: f64,
    /// Contacts of grains, each once.
    pub contacts: &'a [ContactForce],
    /// The grain of each contact with the membrane.
    pub membrane_contacts: &'a [usize],
    /// Positions of the membrane's vertices \[m\].
    pub vertices: &'a [[f64; 3]],
    /// The membrane's triangles: closed, and all turned outward or all inward.
    pub triangles: &'a [[usize; 3]],
}

/// Why a snapshot cannot be analyzed.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum SnapshotError {
    /// Lists of grains differ in length.
    #[error("{positions} positions but {radii} radii: each grain has one of both")]
    Lengths {
        /// Of the positions.
        positions: usize,
        /// Of the radii.
        radii: usize,
    },
    /// A number that is not finite.
    #[error("{what} {index} is not finite")]
    NotFinite {
        /// Of what list.
        what: &'static str,
        /// Where in it.
        index: usize,
    },
    /// A radius that is zero or less.
    #[error("grain {grain} has the radius {radius} m; it must be above 0")]
    Radius {
        /// The grain.
        grain: usize,
        /// Its radius \[m\].
        radius: f64,
    },
    /// A contact of a grain that does not exist, or with itself.
    #[error("contact {contact} is not between two of the {grains} grains")]
    Contact {
        /// The contact.
        contact: usize,
        /// How many grains there are.
        grains: usize,
    },
    /// A contact of the membrane with a grain that does not exist.
    #[error("contact {contact} of the membrane is with none of the {grains} grains")]
    MembraneContact {
        /// The contact.
        contact: usize,
        /// How many grains there are.
        grains: usize,
    },
    /// A triangle with a vertex that does not exist.
    #[error("triangle {triangle} names a vertex beyond the {vertices} there are")]
    Vertex {
        /// The triangle.
        triangle: usize,
        /// How many vertices there are.
        vertices: usize,
    },
    /// An edge of the membrane that its neighbor does not run through the other way.
    #[error("the membrane is open, or not oriented alike, between the vertices {from} and {to}")]
    OpenMembrane {
        /// One end of the edge.
        from: usize,
        /// The other.
        to: usize,
    },
    /// Two snapshots of different grains.
    #[error("{before} grains before but {after} after: both must be of the same")]
    Grains {
        /// In the first snapshot.
        before: usize,
        /// In the second.
        after: usize,
    },
    /// A membrane around nothing.
    #[error("the membrane encloses no volume")]
    NoVolume,
}

/// The same quantity of all grains and of the bulk alone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AllAndBulk<T> {
    /// Of all grains.
    pub all: T,
    /// Of the grains farther than 2 d_p from the membrane.
    pub bulk: T,
}

/// A snapshot that is fit for analysis, with what all analyses ask for.
#[derive(Clone, Debug)]
pub struct Packing<'a> {
    snapshot: Snapshot<'a>,
    membrane: Membrane<'a>,
    /// d_p \[m\]; `None` without grains.
    mean_diameter: Option<f64>,
    bulk: Vec<bool>,
}

impl<'a> Packing<'a> {
    /// Checks `snapshot` and tells the bulk from the rest.
    pub fn new(snapshot: Snapshot<'a>) -> Result<Self, SnapshotError> {
        check_grains(&snapshot)?;
        check_contacts(&snapshot)?;
        let membrane = Membrane::new(snapshot.vertices, snapshot.triangles)?;
        let mean_diameter = mean(snapshot.radii.iter().map(|radius| 2.0 * radius));
        let depth = BULK_DEPTH * mean_diameter.unwrap_or(0.0);
        let is_bulk = |&point: &[f64; 3]| membrane.holds(point, depth);
        let bulk = snapshot.positions.iter().map(is_bulk).collect();
        Ok(Self {
            snapshot,
            membrane,
            mean_diameter,
            bulk,
        })
    }

    /// What it was made of.
    #[must_use]
    pub fn snapshot(&self) -> &Snapshot<'a> {
        &self.snapshot
    }

    /// The membrane around the grains.
    #[must_use]
    pub fn membrane(&self) -> &Membrane<'a> {
        &self.membrane
    }

    /// d_p \[m\], the mean diameter of all grains; `None` without grains.
    #[must_use]
    pub fn mean_diameter(&self) -> Option<f64> {
        self.mean_diameter
    }

    /// Whether each grain is farther than 2 d_p from the membrane, inside of it.
    #[must_use]
    pub fn bulk(&self) -> &[bool] {
        &self.bulk
    }

    /// φ = ΣV_p/V: the volume of the grains over that of the membrane.
    ///
    /// Overlaps count twice, as in the paper: soft grains reach more than 0.75.
    #[must_use]
    pub fn volume_fraction(&self) -> f64 {
        let grains = self.snapshot.radii.iter();
        grains.map(|&radius| ball_volume(radius)).sum::<f64>() / self.membrane.volume()
    }

    /// The contacts that press, F_n > 0.
    fn pressing(&self) -> impl Iterator<Item = &'a ContactForce> {
        let contacts = self.snapshot.contacts.iter();
        contacts.filter(|contact| contact.normal_force > 0.0)
    }

    /// How many grains press on each grain.
    #[must_use]
    pub fn contact_counts(&self) -> Vec<usize> {
        let mut counts = vec![0; self.snapshot.positions.len()];
        for contact in self.pressing() {
            counts[contact.i] += 1;
            counts[contact.j] += 1;
        }
        counts
    }
}

fn check_grains(snapshot: &Snapshot<'_>) -> Result<(), SnapshotError> {
    let (positions, radii) = (snapshot.positions, snapshot.radii);
    if positions.len() != radii.len() {
        return Err(SnapshotError::Lengths {
            positions: positions.len(),
            radii: radii.len(),
        });
    }
    for (what, points) in [("position", positions), ("vertex", snapshot.vertices)] {
        let wild = |point: &[f64; 3]| !point.iter().all(|x| x.is_finite());
        if let Some(index) = points.iter().position(wild) {
            return Err(SnapshotError::NotFinite { what, index });
        }
    }
    let wrong = |radius: &f64| !(radius.is_finite() && *radius > 0.0);
    match radii.iter().position(wrong) {
        None => Ok(()),
        Some(grain) => Err(SnapshotError::Radius {
            grain,
            radius: radii[grain],
        }),
    }
}

fn check_contacts(snapshot: &Snapshot<'_>) -> Result<(), SnapshotError> {
    let grains = snapshot.positions.len();
    for (contact, force) in snapshot.contacts.iter().enumerate() {
        if force.i >= grains || force.j >= grains || force.i == force.j {
            return Err(SnapshotError::Contact { contact, grains });
        }
        if !(force.normal_force.is_finite() && force.tangential_force.is_finite()) {
            return Err(SnapshotError::NotFinite {
                what: "force of contact",
                index: contact,
            });
        }
    }
    let unknown = |&grain: &usize| grain >= grains;
    match snapshot.membrane_contacts.iter().position(unknown) {
        None => Ok(()),
        Some(contact) => Err(SnapshotError::MembraneContact { contact, grains }),
    }
}

/// The mean; `None` of nothing.
fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0usize);
    for value in values {
        sum += value;
        count += 1;
    }
    ratio(sum, count)
}

/// `sum`/`count`; `None` if there is nothing to divide by.
fn ratio(sum: f64, count: usize) -> Option<f64> {
    (count > 0).then(|| sum / count as f64)
}

/// (4/3)π R³.
fn ball_volume(radius: f64) -> f64 {
    4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius
}

#[cfg(test)]
mod tests {
    use super::*;
    use fixture::{Beam, box_membrane};

    #[test]
    fn a_cube_of_cubic_cells_has_the_volume_fraction_pi_over_6() {
        let beam = Beam::cubic_lattice([4, 5, 6], 1.0);
        let packing = beam.packing();
        let expected = std::f64::consts::FRAC_PI_6;
        assert!((packing.volume_fraction() - expected).abs() < 1e-12);
        assert_eq!(packing.mean_diameter(), Some(1.0));
    }

    #[test]
    fn the_bulk_is_farther_than_two_diameters_from_the_membrane() {
        // Centers at 0.5, 1.5, … from each face: of 7 in a row, those at 2.5, 3.5 and 4.5.
        let beam = Beam::cubic_lattice([7, 7, 7], 1.0);
        let bulk = beam.packing().bulk().iter().filter(|bulk| **bulk).count();
        assert_eq!(bulk, 27);
    }

    #[test]
    fn a_grain_that_escaped_is_not_bulk() {
        let mut beam = Beam::cubic_lattice([7, 7, 7], 1.0);
        beam.positions[171] = [30.0, 3.0, 3.0];
        assert!(!beam.packing().bulk()[171]);
    }

    #[test]
    fn an_empty_beam_is_a_packing_of_volume_fraction_zero() {
        let beam = Beam::empty(box_membrane([0.0; 3], [3.0; 3], [2; 3]));
        let packing = beam.packing();
        assert!(packing.volume_fraction().abs() < f64::MIN_POSITIVE);
        assert_eq!(packing.mean_diameter(), None);
    }

    #[test]
    fn a_snapshot_that_cannot_be_is_refused() {
        let sound = Beam::cubic_lattice([2, 2, 2], 1.0);
        let refused = |change: &dyn Fn(&mut Beam)| {
            let mut beam = sound.clone();
            change(&mut beam);
            Packing::new(beam.snapshot()).expect_err("it is wrong")
        };
        let contact = |i, j, normal_force| ContactForce {
            i,
            j,
            normal_force,
            tangential_force: 0.0,
        };
        let at = |contact| SnapshotError::Contact { contact, grains: 8 };
        assert_eq!(
            refused(&|beam| beam.radii.truncate(7)),
            SnapshotError::Lengths {
                positions: 8,
                radii: 7
            }
        );
        let what = "position";
        assert_eq!(
            refused(&|beam| beam.positions[3][1] = f64::NAN),
            SnapshotError::NotFinite { what, index: 3 }
        );
        assert_eq!(
            refused(&|beam| beam.radii[2] = 0.0),
            SnapshotError::Radius {
                grain: 2,
                radius: 0.0
            }
        );
        assert_eq!(
            refused(&|beam| beam.contacts.push(contact(0, 8, 1.0))),
            at(0)
        );
        assert_eq!(
            refused(&|beam| beam.contacts.push(contact(1, 1, 1.0))),
            at(0)
        );
        assert_eq!(
            refused(&|beam| beam.membrane_contacts.push(9)),
            SnapshotError::MembraneContact {
                contact: 0,
                grains: 8
            }
        );
        assert!(matches!(
            refused(&|beam| beam.contacts.push(contact(0, 1, f64::NAN))),
            SnapshotError::NotFinite { .. }
        ));
    }
}
