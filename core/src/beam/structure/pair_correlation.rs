//! Pair correlation: how often grains stand at a distance r from each other.
//!
//! Twice: as the paper prints it, and as textbooks define it, free of the beam's shape.

use serde::{Deserialize, Serialize};

use super::cells::PointGrid;
use super::{AllAndBulk, Packing};

mod reachable;

use reachable::Reachable;

/// Width of the bins in d_p.
pub const BIN: f64 = 0.02;

/// Both functions over the same distances.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairCorrelation {
    /// r \[m\], the middle of each bin.
    pub distances: Vec<f64>,
    /// ⟨n_i(r)/(4π (r/r_mean)²)⟩, Eq. (1), r_mean = ⟨R⟩; n_i counts the other grains j whose surface cuts the sphere of radius r around i: |r_ij − r| < R_j.
    ///
    /// Its plateau is (3φ/2π)(r_mean/R)², 0.30 for φ = 0.62, less where the membrane is near; `None` without grains.
    pub paper: AllAndBulk<Option<Vec<f64>>>,
    /// g(r) = dN/(4πr² dr n) between grains of the bulk, of each shell only what lies in the bulk; its plateau is 1.
    ///
    /// `None` where no shell reaches into the bulk.
    pub normalized: Vec<Option<f64>>,
}

impl PairCorrelation {
    /// The largest g(r) beyond `distance` \[m\]; an amorphous packing has none above 1.15 beyond 4 d_p.
    #[must_use]
    pub fn highest_beyond(&self, distance: f64) -> Option<f64> {
        let all = self.distances.iter().zip(&self.normalized);
        let beyond = all.filter(|(r, _)| **r > distance);
        beyond.filter_map(|(_, g)| *g).reduce(f64::max)
    }
}

/// Both functions up to `farthest` d_p; `None` without grains.
#[must_use]
pub fn pair_correlation(packing: &Packing<'_>, farthest: f64) -> Option<PairCorrelation> {
    let diameter = packing.mean_diameter()?;
    let width = BIN * diameter;
    let bins = (farthest / BIN).round() as usize;
    let counts = count(packing, width, bins);
    let reachable = Reachable::around(packing, farthest * diameter);
    let distances: Vec<f64> = (0..bins).map(|k| width * (k as f64 + 0.5)).collect();
    let normalized = distances.iter().zip(&counts.pairs);
    Some(PairCorrelation {
        paper: AllAndBulk {
            all: counts.surfaces.all.averaged(&distances, 0.5 * diameter),
            bulk: counts.surfaces.bulk.averaged(&distances, 0.5 * diameter),
        },
        normalized: normalized
            .map(|(&r, &pairs)| {
                let expected = reachable.expected_pairs(r - 0.5 * width, r + 0.5 * width)?;
                Some(pairs as f64 / expected)
            })
            .collect(),
        distances,
    })
}

/// What is counted in one pass over all pairs.
struct Counts {
    /// Ordered pairs of bulk grains by the bin of their distance.
    pairs: Vec<usize>,
    surfaces: AllAndBulk<Surfaces>,
}

/// How many surfaces cut the sphere of each radius, summed over some grains.
#[derive(Default)]
struct Surfaces {
    /// What the count of a bin is more than that of the one before.
    steps: Vec<i64>,
    /// The number of grains.
    grains: usize,
}

impl Surfaces {
    /// A surface that cuts the spheres of radii strictly between `from` and `to`, in bins.
    fn add(&mut self, from: f64, to: f64) {
        // The middle of bin k is at k + 1/2; conversion sends what is negative to 0.
        let first = (from - 0.5 + 1.0).floor() as usize;
        let end = (to - 0.5).ceil().max(0.0) as usize;
        if first < end && first < self.steps.len() {
            self.steps[first] += 1;
            if end < self.steps.len() {
                self.steps[end] -= 1;
            }
        }
    }

    fn averaged(&self, distances: &[f64], mean_radius: f64) -> Option<Vec<f64>> {
        let mut count = 0;
        let value = |(&r, step): (&f64, &i64)| {
            count += step;
            let sphere = 4.0 * std::f64::consts::PI * (r / mean_radius) * (r / mean_radius);
            count as f64 / (self.grains as f64 * sphere)
        };
        (self.grains > 0).then(|| distances.iter().zip(&self.steps).map(value).collect())
    }
}

fn count(packing: &Packing<'_>, width: f64, bins: usize) -> Counts {
    let (positions, radii) = (packing.snapshot().positions, packing.snapshot().radii);
    let bulk = packing.bulk();
    let surfaces = |grains| Surfaces {
        steps: vec![0; bins],
        grains,
    };
    let mut counts = Counts {
        pairs: vec![0; bins],
        surfaces: AllAndBulk {
            all: surfaces(positions.len()),
            bulk: surfaces(bulk.iter().filter(|bulk| **bulk).count()),
        },
    };
    let largest = radii.iter().copied().fold(0.0, f64::max);
    let reach = width * bins as f64 + largest;
    let grid = PointGrid::new(positions, 100.0 * width);
    for (i, &position) in positions.iter().enumerate() {
        grid.visit(position, reach, |j, _, square| {
            if i == j {
                return;
            }
            let (distance, radius) = (square.sqrt() / width, radii[j] / width);
            let (from, to) = (distance - radius, distance + radius);
            counts.surfaces.all.add(from, to);
            if bulk[i] {
                counts.surfaces.bulk.add(from, to);
                if bulk[j] && (distance as usize) < bins {
                    counts.pairs[distance as usize] += 1;
                }
            }
        });
    }
    counts
}

#[cfg(test)]
mod tests;
