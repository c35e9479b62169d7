//! Eigenvalues and inverse of a symmetric 3 × 3 matrix.

use crate::math::plain::{add, dot, scale, sub};

/// Three rows.
pub(super) type Matrix = [[f64; 3]; 3];

/// Rotations that suffice: each sweep of three at least squares what is beside the diagonal.
const SWEEPS: usize = 10;

/// Eigenvalues λ_k, in no particular order, and the unit vectors v_k that belong to them (Jacobi's rotations).
#[derive(Clone, Copy, Debug)]
pub(super) struct Eigen {
    pub(super) values: [f64; 3],
    /// Row k is v_k.
    vectors: Matrix,
}

impl Eigen {
    pub(super) fn of(mut matrix: Matrix) -> Self {
        let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for _ in 0..SWEEPS {
            for (p, q) in [(0, 1), (0, 2), (1, 2)] {
                rotate(&mut matrix, &mut vectors, p, q);
            }
        }
        Self {
            values: std::array::from_fn(|k| matrix[k][k]),
            vectors,
        }
    }

    /// λ_max/λ_min in magnitude; infinite if the matrix is singular, and NaN of the zero matrix.
    pub(super) fn condition_number(&self) -> f64 {
        let sizes = self.values.map(f64::abs);
        let [least, most] = [f64::min, f64::max].map(|pick| sizes.into_iter().reduce(pick));
        most.unwrap_or(0.0) / least.unwrap_or(0.0)
    }

    /// Σ_k v_k v_kᵀ/λ_k.
    pub(super) fn inverse(&self) -> Matrix {
        let v = &self.vectors;
        let entry = |i: usize, j: usize| (0..3).map(|k| v[k][i] * v[k][j] / self.values[k]).sum();
        std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
    }
}

/// Turns rows and columns p and q so that their common entry vanishes.
fn rotate(matrix: &mut Matrix, vectors: &mut Matrix, p: usize, q: usize) {
    let beside = matrix[p][q];
    if beside == 0.0 {
        return;
    }
    let ratio = (matrix[q][q] - matrix[p][p]) / (2.0 * beside);
    let tangent = ratio.signum() / (ratio.abs() + f64::sqrt(ratio * ratio + 1.0));
    let cosine = 1.0 / f64::sqrt(tangent * tangent + 1.0);
    let sine = tangent * cosine;
    for row in matrix.iter_mut() {
        (row[p], row[q]) = (
            cosine * row[p] - sine * row[q],
            sine * row[p] + cosine * row[q],
        );
    }
    for rows in [matrix, vectors] {
        let (of_p, of_q) = (rows[p], rows[q]);
        rows[p] = sub(scale(of_p, cosine), scale(of_q, sine));
        rows[q] = add(scale(of_p, sine), scale(of_q, cosine));
    }
}

/// a bᵀ.
pub(super) fn outer(a: [f64; 3], b: [f64; 3]) -> Matrix {
    a.map(|a| b.map(|b| a * b))
}

/// `a + b`.
pub(super) fn sum(a: Matrix, b: Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] + b[i][j]))
}

/// `a b`.
pub(super) fn product(a: Matrix, b: Matrix) -> Matrix {
    let entry = |i: usize, j: usize| (0..3).map(|k| a[i][k] * b[k][j]).sum();
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}

/// `a x`.
pub(super) fn apply(a: Matrix, x: [f64; 3]) -> [f64; 3] {
    a.map(|row| dot(row, x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, uniform3};

    fn random(seed: u64) -> Matrix {
        let vectors = (0..4).map(|n| uniform3(seed, Purpose::GasVelocity, n).map(|x| x - 0.5));
        vectors.fold([[0.0; 3]; 3], |matrix, vector| {
            sum(matrix, outer(vector, vector))
        })
    }

    #[test]
    fn the_inverse_times_the_matrix_is_one() {
        for seed in 0..100 {
            let matrix = random(seed);
            let eigen = Eigen::of(matrix);
            let one = product(eigen.inverse(), matrix);
            for (i, row) in one.iter().enumerate() {
                for (j, entry) in row.iter().enumerate() {
                    let expected = f64::from(u8::from(i == j));
                    assert!((entry - expected).abs() < 1e-14 * eigen.condition_number());
                }
            }
        }
    }

    #[test]
    fn eigenvalues_have_the_trace_and_determinant_of_the_matrix() {
        for seed in 0..100 {
            let m = random(seed);
            let [a, b, c] = Eigen::of(m).values;
            let determinant = dot(m[0], crate::math::plain::cross(m[1], m[2]));
            assert!((a + b + c - m[0][0] - m[1][1] - m[2][2]).abs() < 1e-14);
            assert!((a * b * c - determinant).abs() < 1e-14);
        }
    }

    #[test]
    fn a_flat_neighborhood_has_no_finite_condition_number_worth_having() {
        let flat = sum(
            outer([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
            outer([0.3, 2.0, 0.0], [0.3, 2.0, 0.0]),
        );
        assert!(Eigen::of(flat).condition_number() > 1e15);
    }
}
