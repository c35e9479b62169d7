//! Spatial autocorrelation of D_min: over what distance grains stray alike, Eqs. (D1) and (D2).

use serde::{Deserialize, Serialize};

use super::cells::PointGrid;
use super::{Packing, mean, ratio};

/// Δr in d_p; distances are multiples of it, so neighboring windows overlap by half.
const WINDOW: f64 = 0.25;

/// C(r) in both versions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Autocorrelation {
    /// r \[m\]: 0, Δr, 2Δr, … with Δr = 0.25 d_p.
    pub distances: Vec<f64>,
    /// C(r) = ⟨(1/M_i) Σ_j D_i D_j⟩_i/d_p², |r_ij| ∈ r ± Δr; C(0) = ⟨D²⟩/d_p². `None` where no two grains are so far apart.
    ///
    /// Printed with d_p instead of d_p²; C/C(0) is the same.
    /// Its mean is not subtracted: C/C(0) tends to ⟨D⟩²/⟨D²⟩, and stays above 0.8 where D varies by less than half its mean.
    pub printed: Vec<Option<f64>>,
    /// (⟨D_i D_j⟩ − ⟨D⟩²)/(⟨D²⟩ − ⟨D⟩²), of the same average; 1 at r = 0. `None` also where all D are equal.
    pub connected: Vec<Option<f64>>,
    /// Where the connected version falls to 1/e \[m\], interpolated between its values; `None` if it never does.
    pub decay_length: Option<f64>,
}

/// Of the `values` known, up to `farthest` d_p; `None` if there are none.
#[must_use]
pub fn autocorrelation(
    packing: &Packing<'_>,
    values: &[Option<f64>],
    farthest: f64,
) -> Option<Autocorrelation> {
    let diameter = packing.mean_diameter()?;
    let known: Vec<f64> = values.iter().flatten().copied().collect();
    let mean_square = mean(known.iter().map(|value| value * value))?;
    let places = packing.snapshot().positions.iter().zip(values);
    let places: Vec<[f64; 3]> = places
        .filter_map(|(at, value)| value.map(|_| *at))
        .collect();
    let width = WINDOW * diameter;
    let last = (farthest / WINDOW).round() as usize;
    let mut products = products(&places, &known, width, last);
    products[0] = Some(mean_square);
    let distances: Vec<f64> = (0..=last).map(|k| width * k as f64).collect();
    let connected = connected(&products, &known)?;
    let printed = products
        .iter()
        .map(|product| Some((*product)? / (diameter * diameter)));
    Some(Autocorrelation {
        printed: printed.collect(),
        decay_length: decay_length(&distances, &connected),
        distances,
        connected,
    })
}

/// What `products` of values are more than the square of their mean, relative to their variance.
fn connected(products: &[Option<f64>], values: &[f64]) -> Option<Vec<Option<f64>>> {
    let mean_value = mean(values.iter().copied())?;
    let deviations = values.iter().map(|value| value - mean_value);
    let variance = mean(deviations.map(|deviation| deviation * deviation))?;
    // Below this, values vary by no more than their rounding.
    let varies = variance > 1e-24 * mean_value * mean_value;
    let excess = |product: f64| (product - mean_value * mean_value) / variance;
    let products = products.iter();
    Some(
        products
            .map(|product| product.filter(|_| varies).map(excess))
            .collect(),
    )
}

/// ⟨(1/M_i) Σ_j D_i D_j⟩ over the grains that have others in r ± Δr, for r = k Δr up to k = `last`.
fn products(places: &[[f64; 3]], values: &[f64], width: f64, last: usize) -> Vec<Option<f64>> {
    let grid = PointGrid::new(places, 4.0 * width);
    let mut sums = vec![(0.0, 0usize); last + 1];
    // Values and number of the grains from k Δr to (k + 1) Δr away: two of them make a window.
    let mut rings = vec![(0.0, 0usize); last + 1];
    for (i, &place) in places.iter().enumerate() {
        rings.fill((0.0, 0));
        grid.visit(place, width * (last + 1) as f64, |j, _, square| {
            let ring = (square.sqrt() / width) as usize;
            if i != j && ring <= last {
                rings[ring].0 += values[j];
                rings[ring].1 += 1;
            }
        });
        for k in 1..=last {
            let (inner, outer) = (rings[k - 1], rings[k]);
            if let Some(mean) = ratio(inner.0 + outer.0, inner.1 + outer.1) {
                sums[k].0 += values[i] * mean;
                sums[k].1 += 1;
            }
        }
    }
    sums.iter().map(|&(sum, count)| ratio(sum, count)).collect()
}

/// Where what is known first falls to 1/e.
fn decay_length(distances: &[f64], connected: &[Option<f64>]) -> Option<f64> {
    let level = libm::exp(-1.0);
    let points = distances.iter().zip(connected);
    let mut points = points.filter_map(|(&r, value)| Some((r, (*value)?)));
    let mut last = points.next()?;
    for next in points {
        if next.1 <= level {
            let share = (last.1 - level) / (last.1 - next.1);
            return Some(last.0 + share * (next.0 - last.0));
        }
        last = next;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::structure::fixture::{Beam, box_membrane};
    use crate::math::plain::{norm, sub};
    use crate::random::{Purpose, uniform3};

    fn beam() -> Beam {
        let positions = (0..8000).map(|n| uniform3(1, Purpose::GasVelocity, n).map(|x| 20.0 * x));
        Beam::of(box_membrane([0.0; 3], [20.0; 3], [10; 3]), positions, 0.5)
    }

    fn of(beam: &Beam, value: impl Fn(usize) -> Option<f64>) -> Autocorrelation {
        let values: Vec<_> = (0..beam.positions.len()).map(value).collect();
        autocorrelation(&beam.packing(), &values, 8.0).expect("values")
    }

    fn number(i: usize) -> f64 {
        uniform3(2, Purpose::GasOrientation, i as u64)[0]
    }

    #[test]
    fn values_without_order_have_only_the_square_of_their_mean_in_common() {
        // Uniform in 0 … 1: ⟨D⟩²/⟨D²⟩ = 3/4, as if they were alike.
        let beam = beam();
        let found = of(&beam, |i| Some(number(i)));
        let at_zero = found.printed[0].expect("C(0)");
        for k in 4..found.distances.len() {
            let printed = found.printed[k].expect("pairs") / at_zero;
            let connected = found.connected[k].expect("pairs");
            // 8000 grains: mean and variance within 1 % each.
            assert!(
                (printed - 0.75).abs() < 0.02 && connected.abs() < 0.03,
                "{printed} {connected}"
            );
        }
        assert!(found.decay_length.expect("it falls at once") < 1.0);
    }

    #[test]
    fn equal_values_correlate_at_all_distances() {
        let found = of(&beam(), |_| Some(0.3));
        assert!(
            found
                .printed
                .iter()
                .flatten()
                .all(|c| (c - 0.09).abs() < 1e-12)
        );
        assert!(found.connected.iter().all(Option::is_none));
        assert_eq!(found.decay_length, None);
    }

    #[test]
    fn each_value_is_the_average_that_is_printed() {
        // (D1) and (D2) word by word.
        let beam = Beam {
            positions: beam().positions[..300].to_vec(),
            radii: vec![0.5; 300],
            ..beam()
        };
        let found = of(&beam, |i| Some(number(i)));
        for (k, &r) in found.distances.iter().enumerate().skip(1) {
            let of_grain = |i: usize| {
                let far = |j: &usize| {
                    let distance = norm(sub(beam.positions[*j], beam.positions[i]));
                    *j != i && distance >= r - 0.25 && distance < r + 0.25
                };
                mean((0..300).filter(far).map(|j| number(i) * number(j)))
            };
            let expected = mean((0..300).filter_map(of_grain));
            let off = found.printed[k].unwrap_or(0.0) - expected.unwrap_or(0.0);
            assert!(off.abs() < 1e-12 && found.printed[k].is_some() == expected.is_some());
        }
    }

    #[test]
    fn the_decay_length_is_where_the_connected_version_falls_to_1_over_e() {
        // An exponential of decay length 2, with a value missing before: straight lines of 0.25 are off by 0.25²/8·2.
        let distances: Vec<f64> = (0..20).map(|k| 0.25 * f64::from(k)).collect();
        let value = |(k, r): (usize, &f64)| (k != 1).then(|| libm::exp(-r / 2.0));
        let connected: Vec<_> = distances.iter().enumerate().map(value).collect();
        let found = decay_length(&distances, &connected).expect("it falls");
        assert!((found - 2.0).abs() < 0.01);
        assert_eq!(decay_length(&distances[..5], &connected[..5]), None);
        assert_eq!(decay_length(&[], &[]), None);
    }

    #[test]
    fn grains_without_a_value_do_not_count() {
        let beam = beam();
        let all = of(&beam, |i| (i % 2 == 0).then(|| number(i)));
        let half = Beam {
            positions: beam.positions.iter().step_by(2).copied().collect(),
            radii: beam.radii.iter().step_by(2).copied().collect(),
            ..beam.clone()
        };
        let alone = of(&half, |i| Some(number(2 * i)));
        for (a, b) in all.printed.iter().zip(&alone.printed) {
            assert!((a.unwrap_or(0.0) - b.unwrap_or(0.0)).abs() < 1e-12);
        }
    }

    #[test]
    fn one_value_or_none_has_a_defined_answer() {
        let beam = beam();
        let values = vec![None; 8000];
        assert_eq!(autocorrelation(&beam.packing(), &values, 8.0), None);
        let one = of(&beam, |i| (i == 5).then_some(2.0));
        assert_eq!(one.printed[0], Some(4.0));
        assert!(
            one.printed[1..]
                .iter()
                .chain(&one.connected)
                .all(Option::is_none)
        );
    }
}
