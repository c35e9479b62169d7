//! Smoothing and differentiating a curve: steps 1 and 2 of the rule for Y_b.

use crate::beam::curve::Point;

/// Strain between two points of the uniform grid.
pub(super) const SPACING: f64 = 1e-4;

/// Strains beyond this are of no beam and would only fill memory.
const LARGEST_STRAIN: f64 = 1.0;

/// The points whose strain exceeds every strain before them.
pub(super) fn rising(points: &[Point]) -> Vec<Point> {
    let mut largest = f64::NEG_INFINITY;
    let mut rising = vec![];
    for &point in points {
        if point.strain > largest && point.strain.abs() <= LARGEST_STRAIN {
            largest = point.strain;
            rising.push(point);
        }
    }
    rising
}

/// Rising points, interpolated linearly at the first strain and every [`SPACING`] after it.
pub(super) fn resample(points: &[Point]) -> Vec<Point> {
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return vec![];
    };
    // A grid point must not be lost to the rounding of the quotient.
    let steps = ((last.strain - first.strain) / SPACING + 1e-6).floor() as usize;
    let mut right = 1;
    let mut grid = vec![*first];
    for k in 1..=steps {
        let strain = first.strain + SPACING * k as f64;
        while right + 1 < points.len() && points[right].strain < strain {
            right += 1;
        }
        let (a, b) = (points[right - 1], points[right]);
        let part = (strain - a.strain) / (b.strain - a.strain);
        let stress = a.stress + part * (b.stress - a.stress);
        grid.push(Point { strain, stress });
    }
    grid
}

/// Density of white noise \[Pa²\] in σ: its variance times the strain between two samples, one grid step at least.
///
/// Each sample is compared with the line through its neighbors (Gasser, Sroka and Jennen-Steinmetz, Biometrika 73, 625 (1986)).
/// Noise that neighbors share, such as ringing, is not seen.
pub(super) fn noise_density(points: &[Point]) -> f64 {
    let mut sum = 0.0;
    for triple in points.windows(3) {
        let [a, b, c] = [triple[0], triple[1], triple[2]];
        let part = (b.strain - a.strain) / (c.strain - a.strain);
        let residual = b.stress - (1.0 - part) * a.stress - part * c.stress;
        sum += residual * residual / (1.0 + part * part + (1.0 - part) * (1.0 - part));
    }
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return 0.0;
    };
    let triples = points.len().saturating_sub(2).max(1) as f64;
    let spacing = (last.strain - first.strain) / (points.len() as f64 - 1.0).max(1.0);
    sum / triples * spacing.max(SPACING)
}

/// A normalized Gaussian of `width`, from its middle outward to four widths.
pub(super) fn gaussian(width: f64) -> Vec<f64> {
    let radius = (4.0 * width / SPACING).round() as usize;
    let mut kernel: Vec<f64> = (0..=radius)
        .map(|k| {
            let x = SPACING * k as f64 / width;
            libm::exp(-0.5 * x * x)
        })
        .collect();
    let total = kernel[0] + 2.0 * kernel[1..].iter().sum::<f64>();
    for weight in &mut kernel {
        *weight /= total;
    }
    kernel
}

/// `values` convolved with a symmetric `kernel` that is shorter than they are, mirrored at the end points.
pub(super) fn smooth(values: &[f64], kernel: &[f64]) -> Vec<f64> {
    let last = values.len() - 1;
    let mirrored = |place: usize| {
        values[if place > last {
            2 * last - place
        } else {
            place
        }]
    };
    (0..values.len())
        .map(|k| {
            let pairs = kernel.iter().enumerate().skip(1);
            pairs.fold(kernel[0] * values[k], |sum, (shift, weight)| {
                sum + weight * (values[k.abs_diff(shift)] + mirrored(k + shift))
            })
        })
        .collect()
}

/// dy/dx by central differences, one-sided at the ends.
pub(super) fn central_differences(y: &[f64], x: &[f64]) -> Vec<f64> {
    let last = y.len() - 1;
    (0..y.len())
        .map(|k| {
            let (a, b) = (k.saturating_sub(1), (k + 1).min(last));
            (y[b] - y[a]) / (x[b] - x[a])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::noise::gaussian as noise;

    fn point(strain: f64, stress: f64) -> Point {
        Point { strain, stress }
    }

    #[test]
    fn reversals_and_repeated_strains_are_dropped() {
        let points = [0.0, 1e-3, 5e-4, 1e-3, 2e-3, 1.5e-3, 3e-3, 7.0].map(|x| point(x, 1.0));
        let strains: Vec<f64> = rising(&points).iter().map(|point| point.strain).collect();
        assert_eq!(strains, [0.0, 1e-3, 2e-3, 3e-3]);
    }

    #[test]
    fn a_straight_line_is_resampled_exactly_on_10_to_the_minus_4() {
        let points = [0.0, 1.7e-4, 9e-4, 1e-3, 2.35e-3].map(|x| point(x, 3e6 * x + 5.0));
        let grid = resample(&points);
        assert_eq!(grid.len(), 24);
        for (k, at) in grid.iter().enumerate() {
            assert!((at.strain - 1e-4 * k as f64).abs() < 1e-15);
            assert!((at.stress - 3e6 * at.strain - 5.0).abs() < 1e-8);
        }
        assert!(resample(&[]).is_empty());
        assert_eq!(resample(&points[..1]).len(), 1);
    }

    #[test]
    fn smoothing_keeps_constants_everywhere_and_straight_lines_inside() {
        let kernel = gaussian(1e-3);
        let values: Vec<f64> = (0..200).map(f64::from).collect();
        let smoothed = smooth(&values, &kernel);
        for k in 40..160 {
            assert!((smoothed[k] - values[k]).abs() < 1e-11);
        }
        assert!(
            smooth(&[7.0; 200], &kernel)
                .iter()
                .all(|value| (value - 7.0).abs() < 1e-13)
        );
    }

    #[test]
    fn smoothing_a_spike_gives_the_gaussian_and_its_mirror_image() {
        let mut spike = [0.0; 200];
        spike[3] = 1.0;
        let smoothed = smooth(&spike, &gaussian(1e-3));
        // Density 1/(√(2π) w) times the spacing, from the spike and from its image at −3.
        let density = |k: f64| 0.1 * 0.398_942_280_4 * libm::exp(-0.5 * 0.01 * k * k);
        assert!((smoothed[8] - density(5.0) - density(11.0)).abs() < 1e-5);
    }

    #[test]
    fn central_differences_of_a_parabola_are_exact_inside() {
        let x: Vec<f64> = (0..10).map(|k| 0.1 * f64::from(k)).collect();
        let y: Vec<f64> = x.iter().map(|x| x * x).collect();
        let slope = central_differences(&y, &x);
        for k in 1..9 {
            assert!((slope[k] - 2.0 * x[k]).abs() < 1e-14);
        }
    }

    #[test]
    fn the_density_of_noise_is_variance_times_spacing_on_a_bent_curve() {
        for spacing in [2e-4, 1e-4] {
            let points: Vec<Point> = (0..4000u32)
                .map(|k| {
                    let x = spacing * f64::from(k);
                    point(x, 5e6 * x * (1.0 - x) + 2e3 * noise(1, k.into()))
                })
                .collect();
            // The relative error of a variance from 4000 residuals that overlap is below 5 %.
            assert!((noise_density(&points) / (4e6 * spacing) - 1.0).abs() < 0.1);
        }
        assert!(noise_density(&[]).abs() < f64::MIN_POSITIVE);
        assert!(noise_density(&[point(0.0, 1.0)]).abs() < f64::MIN_POSITIVE);
    }
}
