//! Profiles over the beam's height, and averages over intervals of its stress: Figs 12 and 14 to 16.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::faces::Faces;
use super::{AllAndBulk, Packing, mean, ratio};

/// Width of the intervals of σ \[Pa\] that curves are averaged over.
pub const STRESS_BIN: f64 = 25e3;

/// The mean of what is known of each grain, of D_min or Δφ for two, over all grains and over the bulk.
#[must_use]
pub fn means(packing: &Packing<'_>, values: &[Option<f64>]) -> AllAndBulk<Option<f64>> {
    let bulk = values.iter().zip(packing.bulk());
    AllAndBulk {
        all: mean(values.iter().flatten().copied()),
        bulk: mean(bulk.filter_map(|(value, &bulk)| value.filter(|_| bulk))),
    }
}

/// One bin of a profile over the height.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeightBin {
    /// h' of its middle \[m\]: above the middle between the faces.
    pub height: f64,
    /// The mean over its grains, divided by the mean over all; `None` without grains.
    pub value: Option<f64>,
    /// The number of its grains that have a value.
    pub count: usize,
}

/// The profile of `values` ≥ 0, of D_min for one, in bins of 1 d_p: one around the middle, and `each_way` above and below it.
///
/// Grains beyond the last bin are left out, so that profiles of one beam have equal bins and can be averaged.
/// Empty without grains; the paper's "normalized" is taken as divided by the mean of all values of the same interval.
#[must_use]
pub fn height_profile(
    packing: &Packing<'_>,
    faces: &Faces,
    values: &[Option<f64>],
    each_way: usize,
) -> Vec<HeightBin> {
    let Some(diameter) = packing.mean_diameter() else {
        return vec![];
    };
    let mut sums = vec![(0.0, 0usize); 2 * each_way + 1];
    for (&position, value) in packing.snapshot().positions.iter().zip(values) {
        let place = faces.height(position) / diameter + each_way as f64 + 0.5;
        if let Some(value) = value
            && place >= 0.0
            && let Some(sum) = sums.get_mut(place as usize)
        {
            sum.0 += value;
            sum.1 += 1;
        }
    }
    let overall = mean(values.iter().flatten().copied()).filter(|mean| *mean > 0.0);
    let bin = |(k, &(sum, count)): (usize, &(f64, usize))| HeightBin {
        height: diameter * (k as f64 - each_way as f64),
        value: ratio(sum, count)
            .zip(overall)
            .map(|(mean, overall)| mean / overall),
        count,
    };
    sums.iter().enumerate().map(bin).collect()
}

/// The average of the curves whose σ lies in one interval.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StressBin {
    /// Where the interval of 25 kPa begins \[Pa\].
    pub from: f64,
    /// The number of curves in it.
    pub curves: usize,
    /// The mean at each place of the curves, over those that have a value there.
    pub mean: Vec<Option<f64>>,
}

/// Averages `curves`, each with its σ \[Pa\], in intervals of 25 kPa; intervals without curves are left out.
///
/// A single number is a curve of one place: so are made ⟨D_min⟩(σ), φ(σ) and ⟨F⟩(σ). A σ that is not finite has no interval.
#[must_use]
pub fn by_stress(curves: &[(f64, Vec<Option<f64>>)]) -> Vec<StressBin> {
    let mut bins = BTreeMap::<i64, Vec<&[Option<f64>]>>::new();
    for (stress, curve) in curves.iter().filter(|(stress, _)| stress.is_finite()) {
        let bin = (stress / STRESS_BIN).floor() as i64;
        bins.entry(bin).or_default().push(curve);
    }
    let averaged = |(bin, curves): (i64, Vec<&[Option<f64>]>)| {
        let places = curves.iter().map(|curve| curve.len()).max().unwrap_or(0);
        let at = |k: usize| mean(curves.iter().filter_map(|curve| *curve.get(k)?));
        StressBin {
            from: STRESS_BIN * bin as f64,
            curves: curves.len(),
            mean: (0..places).map(at).collect(),
        }
    };
    bins.into_iter().map(averaged).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::structure::fixture::Beam;

    #[test]
    fn a_profile_of_layers_is_the_layers_divided_by_their_mean() {
        // Layers at −2.5 … 2.5 d_p: bins around 0, ±1, ±2 hold their edges; heights of 7 layers are whole numbers.
        let beam = Beam::cubic_lattice([9, 5, 7], 2.0);
        let packing = beam.packing();
        let faces = Faces::of(&packing).expect("grains");
        let value = |at: &[f64; 3]| Some(faces.height(*at) / 2.0 + 5.0);
        let values: Vec<Option<f64>> = beam.positions.iter().map(value).collect();
        let found = height_profile(&packing, &faces, &values, 4);
        assert_eq!(found.len(), 9);
        for (k, bin) in found.iter().enumerate() {
            let layer = k as f64 - 4.0;
            assert!((bin.height - 2.0 * layer).abs() < 1e-12);
            let expected = (1..8).contains(&k).then_some(1.0 + layer / 5.0);
            assert_eq!(bin.count, if expected.is_some() { 45 } else { 0 });
            assert_eq!(bin.value.is_some(), expected.is_some());
            assert!((bin.value.unwrap_or(0.0) - expected.unwrap_or(0.0)).abs() < 1e-12);
        }
        // Of fewer bins the outer layers are left out, but not of the mean.
        let narrow = height_profile(&packing, &faces, &values, 1);
        assert!((narrow[2].value.expect("grains") - 1.2).abs() < 1e-12);
    }

    #[test]
    fn means_are_of_what_is_known() {
        // The middle one of 5³ grains is 2.5 from the membrane, all others at most 1.5.
        let beam = Beam::cubic_lattice([5; 3], 1.0);
        let mut values = vec![None; 125];
        (values[0], values[62]) = (Some(1.0), Some(3.0));
        let found = means(&beam.packing(), &values);
        assert_eq!((found.all, found.bulk), (Some(2.0), Some(3.0)));
        assert_eq!(means(&beam.packing(), &[None; 125]), AllAndBulk::default());
    }

    #[test]
    fn a_profile_of_nothing_or_of_zeros_has_no_values() {
        let beam = Beam::cubic_lattice([3; 3], 1.0);
        let packing = beam.packing();
        let faces = Faces::of(&packing).expect("grains");
        for value in [None, Some(0.0)] {
            let found = height_profile(&packing, &faces, &[value; 27], 2);
            assert!(found.iter().all(|bin| bin.value.is_none()));
        }
    }

    #[test]
    fn curves_are_averaged_over_intervals_of_25_kpa() {
        let curves = [
            (24_999.0, vec![Some(1.0), None]),
            (0.0, vec![Some(3.0), None, Some(7.0)]),
            (25_000.0, vec![Some(5.0)]),
            (180e3, vec![None]),
            (-1.0, vec![Some(2.0)]),
            (f64::NAN, vec![Some(9.0)]),
        ];
        let found = by_stress(&curves);
        let bin = |from, curves, mean: &[Option<f64>]| StressBin {
            from,
            curves,
            mean: mean.to_vec(),
        };
        let expected = [
            bin(-25e3, 1, &[Some(2.0)]),
            bin(0.0, 2, &[Some(2.0), None, Some(7.0)]),
            bin(25e3, 1, &[Some(5.0)]),
            bin(175e3, 1, &[None]),
        ];
        assert_eq!(found, expected);
        assert!(by_stress(&[]).is_empty());
    }
}
