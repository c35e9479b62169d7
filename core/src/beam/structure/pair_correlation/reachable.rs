//! How much of the shells around the bulk's grains lies in the bulk, so that g(r) forgets the beam's shape.
//!
//! Counted as pairs of a grain and a point, with points that fill the bulk evenly: of a bent beam no formula is known.

use crate::beam::structure::Packing;
use crate::beam::structure::cells::PointGrid;
use crate::beam::structure::{BULK_DEPTH, ball_volume};

/// Points for each grain: their counts then scatter less than those of grains.
const POINTS_PER_GRAIN: f64 = 4.0;

/// At least so many points, for beams of few grains.
const LEAST_POINTS: f64 = 20_000.0;

/// Width of the shells in d_p. The share that lies in the bulk falls slowly, and is interpolated between them.
const SHELL: f64 = 0.25;

/// Steps of the points along x, y, z: powers of 1/p, p⁴ = p + 1, whose multiples fill the unit cube evenly (M. Roberts's R3 sequence).
///
/// A lattice would not do: its planes may lie along the membrane's faces.
const STEPS: [f64; 3] = [
    0.819_172_513_396_164_4,
    0.671_043_606_703_789_3,
    0.549_700_477_901_970_4,
];

/// The bulk as the grains in it see it.
pub(super) struct Reachable {
    /// Width of the shells \[m\].
    width: f64,
    /// The part of each shell that lies in the bulk, averaged over the bulk's grains.
    shares: Vec<f64>,
    /// Ordered pairs of bulk grains per volume of a shell \[1/m³\].
    pair_density: f64,
}

impl Reachable {
    /// Of `packing`, for distances up to `farthest` \[m\].
    pub(super) fn around(packing: &Packing<'_>, farthest: f64) -> Self {
        let diameter = packing.mean_diameter().unwrap_or(0.0);
        let width = SHELL * diameter;
        let shells = (farthest / width).ceil() as usize + 1;
        let all = packing.snapshot().positions.iter().zip(packing.bulk());
        let grains: Vec<[f64; 3]> = all.filter(|(_, bulk)| **bulk).map(|all| *all.0).collect();
        let (points, density) = points(packing);
        let mut counts = vec![0usize; shells];
        let grid = PointGrid::new(&points, 2.0 * diameter);
        for &grain in &grains {
            grid.visit(grain, width * shells as f64, |_, _, square| {
                // Rounding may put the very last point one shell too far.
                let shell = (square.sqrt() / width) as usize;
                counts[shell.min(shells - 1)] += 1;
            });
        }
        let count = grains.len() as f64;
        let expected =
            |k: usize| density * count * shell_volume(k as f64 * width, (k + 1) as f64 * width);
        let share = |k: usize| {
            if counts[k] > 0 {
                counts[k] as f64 / expected(k)
            } else {
                0.0
            }
        };
        let volume = points.len() as f64 / density;
        let pairs = count * (count - 1.0);
        Self {
            width,
            shares: (0..shells).map(share).collect(),
            pair_density: if pairs > 0.0 && volume > 0.0 {
                pairs / volume
            } else {
                0.0
            },
        }
    }

    /// Ordered pairs of bulk grains from `from` to `to` \[m\] apart, were they anywhere in the bulk; `None` if there are none.
    pub(super) fn expected_pairs(&self, from: f64, to: f64) -> Option<f64> {
        let place = (0.5 * (from + to) / self.width - 0.5).max(0.0);
        let (k, part) = (place as usize, place.fract());
        let share = self.shares[k] * (1.0 - part) + self.shares.get(k + 1)? * part;
        let expected = self.pair_density * shell_volume(from, to) * share;
        (expected > 0.0).then_some(expected)
    }
}

/// Points of the bulk, and how many there are per volume \[1/m³\].
fn points(packing: &Packing<'_>) -> (Vec<[f64; 3]>, f64) {
    let membrane = packing.membrane();
    let [low, high] = membrane.bounds();
    let volume: f64 = (0..3).map(|k| high[k] - low[k]).product();
    let grains = packing.snapshot().positions.len() as f64;
    let in_membrane = (POINTS_PER_GRAIN * grains).max(LEAST_POINTS);
    let count = (in_membrane * volume / membrane.volume()).ceil();
    let depth = BULK_DEPTH * packing.mean_diameter().unwrap_or(0.0);
    let point = |n: usize| -> [f64; 3] {
        std::array::from_fn(|k| {
            let share = (0.5 + STEPS[k] * (n + 1) as f64).fract();
            low[k] + share * (high[k] - low[k])
        })
    };
    let points = (0..count as usize).map(point);
    let in_bulk = points.filter(|&point| membrane.holds(point, depth));
    (in_bulk.collect(), count / volume)
}

fn shell_volume(from: f64, to: f64) -> f64 {
    ball_volume(to) - ball_volume(from)
}
