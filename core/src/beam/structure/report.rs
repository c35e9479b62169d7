//! The artifact `structure`: the inside of a beam along its bending.

use serde::Serialize;

use super::along::{Change, Means, Moment};
use super::profile::{StressBin, by_stress};

/// A place of the stress–strain curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Place {
    /// Since the rods set out \[s\].
    pub time: f64,
    /// Way of the rods, down \[m\].
    pub rod_travel: f64,
    /// ε, nominal.
    pub strain: f64,
    /// σ, nominal \[Pa\].
    pub stress: f64,
}

/// Something found at a place, the fields of both side by side.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct At<T> {
    /// Where.
    #[serde(flatten)]
    pub place: Place,
    /// What.
    #[serde(flatten)]
    pub found: T,
}

/// Averages over intervals of σ of 25 kPa, as in the paper's figures; each curve names its places.
///
/// Whatever lies in an interval counts, also where the rods of a cycle went up.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ByStress {
    /// φ.
    pub volume_fraction: Vec<StressBin>,
    /// ⟨F⟩, ⟨F_n⟩, ⟨F_t⟩ of all contacts \[N\].
    pub mean_force: Vec<StressBin>,
    /// The Coulomb fraction of all contacts.
    pub coulomb_fraction: Vec<StressBin>,
    /// ⟨D_min⟩ \[m\] of all grains, of the bulk, of the top half, of the bottom half.
    pub non_affine: Vec<StressBin>,
    /// ⟨Δφ_i⟩ of all grains, of the bulk, of the top half, of the bottom half.
    pub volume_fraction_change: Vec<StressBin>,
    /// D_min over its mean, at the heights of the profile.
    pub height_profile: Vec<StressBin>,
    /// C(r) of D_min as printed, at the distances of the autocorrelation.
    pub autocorrelation: Vec<StressBin>,
    /// The same of the connected version.
    pub connected_autocorrelation: Vec<StressBin>,
}

impl ByStress {
    fn of(snapshots: &[At<Moment>], changes: &[At<Change>]) -> Self {
        let means = |means: &Means| {
            let (whole, halves) = (&means.whole, &means.halves);
            vec![whole.all, whole.bulk, halves.top, halves.bottom]
        };
        let forces = |moment: &Moment| {
            let all = &moment.force_network.all;
            let [mean, normal, tangential] = [
                all.mean_force,
                all.mean_normal_force,
                all.mean_tangential_force,
            ];
            vec![mean, normal, tangential]
        };
        let correlation = |connected: bool| {
            move |change: &Change| {
                let found = change.autocorrelation.as_ref();
                found.map_or_else(Vec::new, |found| {
                    let curve = if connected {
                        &found.connected
                    } else {
                        &found.printed
                    };
                    curve.clone()
                })
            }
        };
        Self {
            volume_fraction: averaged(snapshots, |moment| vec![Some(moment.volume_fraction)]),
            mean_force: averaged(snapshots, forces),
            coulomb_fraction: averaged(snapshots, |moment| {
                vec![moment.force_network.all.coulomb_fraction]
            }),
            non_affine: averaged(changes, |change| means(&change.non_affine)),
            volume_fraction_change: averaged(changes, |change| {
                means(&change.volume_fraction_change)
            }),
            height_profile: averaged(changes, |change| {
                change.height_profile.iter().map(|bin| bin.value).collect()
            }),
            autocorrelation: averaged(changes, correlation(false)),
            connected_autocorrelation: averaged(changes, correlation(true)),
        }
    }
}

fn averaged<T>(all: &[At<T>], curve: impl Fn(&T) -> Vec<Option<f64>>) -> Vec<StressBin> {
    let curves: Vec<_> = all
        .iter()
        .map(|at| (at.place.stress, curve(&at.found)))
        .collect();
    by_stress(&curves)
}

/// Everything, in the order of time; SI units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// d_p \[m\]; `None` without grains.
    pub mean_diameter: Option<f64>,
    /// Way of the rods from one snapshot to the next \[m\].
    pub snapshot_travel: f64,
    /// The snapshots, the first when the rods touch.
    pub snapshots: Vec<At<Moment>>,
    /// The change from each snapshot to the next, at the mean place of both: one less than there are snapshots.
    pub changes: Vec<At<Change>>,
    /// Both averaged.
    pub by_stress: ByStress,
}

impl Report {
    /// The report of snapshots, each with its place, and of the changes between them.
    ///
    /// # Panics
    /// If there is not one snapshot more than there are changes, or none of both.
    #[must_use]
    pub fn new(
        (mean_diameter, snapshot_travel): (Option<f64>, f64),
        snapshots: Vec<At<Moment>>,
        changes: Vec<Change>,
    ) -> Self {
        let pairs = snapshots.windows(2);
        assert_eq!(pairs.len(), changes.len(), "a change between each two");
        let changes: Vec<At<Change>> = pairs
            .zip(changes)
            .map(|(pair, found)| {
                let [from, to] = [pair[0].place, pair[1].place];
                let middle = |of: fn(&Place) -> f64| 0.5 * (of(&from) + of(&to));
                let place = Place {
                    time: middle(|at| at.time),
                    rod_travel: middle(|at| at.rod_travel),
                    strain: middle(|at| at.strain),
                    stress: middle(|at| at.stress),
                };
                At { place, found }
            })
            .collect();
        Self {
            mean_diameter,
            snapshot_travel,
            by_stress: ByStress::of(&snapshots, &changes),
            snapshots,
            changes,
        }
    }
}
