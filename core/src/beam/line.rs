//! The straight line through points, by ordinary least squares.

/// y = slope·x + intercept with the least sum of squares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    pub(crate) slope: f64,
    pub(crate) intercept: f64,
    /// Σ (y − slope·x − intercept)².
    pub(crate) squared_residuals: f64,
    /// Σ (y − ȳ)².
    pub(crate) squared_deviations: f64,
    /// x̄.
    pub(crate) mean_x: f64,
    /// Σ (x − x̄)².
    pub(crate) x_spread: f64,
}

impl Line {
    /// The line through `points` (x, y); `None` unless two of them differ in x.
    pub(crate) fn through(points: impl Iterator<Item = (f64, f64)> + Clone) -> Option<Self> {
        let (mut count, mut sum_x, mut sum_y) = (0.0, 0.0, 0.0);
        for (x, y) in points.clone() {
            count += 1.0;
            sum_x += x;
            sum_y += y;
        }
        let (mean_x, mean_y) = (sum_x / count, sum_y / count);
        // Centered sums keep the digits that Σ x² − n x̄² would lose.
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for (x, y) in points.clone() {
            xx += (x - mean_x) * (x - mean_x);
            xy += (x - mean_x) * (y - mean_y);
            yy += (y - mean_y) * (y - mean_y);
        }
        if count < 2.0 || xx <= 0.0 {
            return None;
        }
        let slope = xy / xx;
        let intercept = mean_y - slope * mean_x;
        let residual = |(x, y)| y - mean_y - slope * (x - mean_x);
        Some(Self {
            slope,
            intercept,
            squared_residuals: points.map(residual).map(|r| r * r).sum(),
            squared_deviations: yy,
            mean_x,
            x_spread: xx,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_points_give_the_line_of_the_normal_equations() {
        // (0, 1), (1, 2), (2, 4): slope 3/2, intercept 5/6, residuals 1/6, −1/3, 1/6.
        let points = [(0.0, 1.0), (1.0, 2.0), (2.0, 4.0)];
        let line = Line::through(points.into_iter()).expect("three abscissas");
        assert!((line.slope - 1.5).abs() < 1e-15);
        assert!((line.intercept - 5.0 / 6.0).abs() < 1e-15);
        assert!((line.squared_residuals - 1.0 / 6.0).abs() < 1e-15);
        assert!((line.squared_deviations - 14.0 / 3.0).abs() < 1e-14);
    }

    #[test]
    fn a_single_abscissa_has_no_line() {
        assert_eq!(Line::through([(1.0, 2.0), (1.0, 3.0)].into_iter()), None);
        assert_eq!(Line::through(std::iter::empty()), None);
    }
}
