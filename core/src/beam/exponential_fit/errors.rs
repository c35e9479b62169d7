//! Standard errors of the three parameters, from the curvature of the sum of squares.

use super::{Datum, Profile};

/// Standard errors of Y⁰, Y^∞ and a, and the condition number of the scaled JᵀJ; `None` if it is singular.
///
/// Cov = s² (JᵀJ)⁻¹ with s² = Σ r²/(n − 3); J is the derivative of the model by the parameters.
pub(super) fn parameter_errors(data: &[Datum], profile: &Profile) -> Option<([f64; 3], f64)> {
    let rows: Vec<[f64; 3]> = data
        .iter()
        .map(|datum| derivatives(datum.friction, profile))
        .collect();
    let products = |i: usize, j: usize| rows.iter().map(|row| row[i] * row[j]).sum::<f64>();
    let lengths: [f64; 3] = std::array::from_fn(|i| products(i, i).sqrt());
    let scaled: [[f64; 3]; 3] = std::array::from_fn(|i| {
        std::array::from_fn(|j| products(i, j) / (lengths[i] * lengths[j]))
    });
    let inverse = inverse(&scaled)?;
    let variance = profile.squared_residuals / (data.len() as f64 - 3.0);
    let errors = std::array::from_fn(|i| (variance * inverse[i][i]).sqrt() / lengths[i]);
    Some((errors, norm(&scaled) * norm(&inverse)))
}

/// ∂Y_b/∂(Y⁰, Y^∞, a) at `friction`.
fn derivatives(friction: f64, profile: &Profile) -> [f64; 3] {
    let left = libm::exp(-profile.rate * friction);
    let rise = profile.infinite_friction - profile.zero_friction;
    [left, 1.0 - left, rise * friction * left]
}

/// Inverse of a symmetric matrix with a unit diagonal; `None` unless it is positive definite beyond rounding.
fn inverse(m: &[[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let cofactors = [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])];
    let determinant: f64 = (0..3).map(|k| m[0][k] * cofactors[0][k]).sum();
    let regular = determinant > 1e-14 && (0..3).all(|k| cofactors[k][k] > 0.0);
    regular.then(|| cofactors.map(|row| row.map(|value| value / determinant)))
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        a[i] * b[j] - a[j] * b[i]
    })
}

/// The largest sum of magnitudes of a column.
fn norm(m: &[[f64; 3]; 3]) -> f64 {
    let column = |j: usize| m.iter().map(|row| row[j].abs()).sum::<f64>();
    (0..3).map(column).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_times_its_inverse_is_one() {
        let m = [[1.0, 0.3, -0.5], [0.3, 1.0, 0.2], [-0.5, 0.2, 1.0]];
        let inverse = inverse(&m).expect("positive definite");
        for (i, row) in m.iter().enumerate() {
            for j in 0..3 {
                let product: f64 = row.iter().zip(inverse).map(|(a, b)| a * b[j]).sum();
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((product - expected).abs() < 1e-14);
            }
        }
        // Determinant 0.56: the first column of the inverse is (0.96, −0.40, 0.56)/0.56.
        assert!((norm(&m) - 1.8).abs() < 1e-15);
        assert!((norm(&inverse) - 1.92 / 0.56).abs() < 1e-14);
    }

    #[test]
    fn dependent_columns_have_no_inverse() {
        assert_eq!(
            inverse(&[[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
            None
        );
        assert_eq!(inverse(&[[1.0, f64::NAN, 0.0], [0.0; 3], [0.0; 3]]), None);
    }
}
