//! Lanczos' method: the top of the spectrum of a symmetric operator, from few applications of it.
//!
//! In the basis q1, q2, … of the Krylov space of a start, A is tridiagonal: A q_j = β_(j−1) q_(j−1) + α_j q_j + β_j q_(j+1).
//! The largest eigenvalue of that matrix is the largest Rayleigh quotient that any vector of the space has.
//! The basis is not made orthogonal again: rounding then repeats eigenvalues that are found already, and moves none of them.

/// Below this share of the largest entry, β is rounding: the space holds all that the start has components of.
const ROUNDING: f64 = 1e-13;

/// The unit vector of largest Rayleigh quotient under `apply` in the Krylov space of `start`, of `steps` dimensions at most.
///
/// `apply` adds A·x, its first argument, to its second.
pub(super) fn top_vector(
    start: &[f64],
    steps: usize,
    mut apply: impl FnMut(&[f64], &mut [f64]),
) -> Vec<f64> {
    let mut basis = vec![unit(start.to_vec())];
    let mut matrix = Tridiagonal {
        diagonal: vec![],
        beside: vec![],
    };
    let mut scale = 0.0_f64;
    loop {
        let last = basis.len() - 1;
        let mut image = vec![0.0; start.len()];
        apply(&basis[last], &mut image);
        if let Some(&beta) = matrix.beside.last() {
            subtract(&mut image, beta, &basis[last - 1]);
        }
        let alpha = dot(&image, &basis[last]);
        subtract(&mut image, alpha, &basis[last]);
        matrix.diagonal.push(alpha);
        let beta = dot(&image, &image).sqrt();
        scale = scale.max(alpha.abs()).max(beta);
        if basis.len() == steps || beta <= ROUNDING * scale {
            break;
        }
        matrix.beside.push(beta);
        basis.push(unit(image));
    }
    let mut top = vec![0.0; start.len()];
    for (share, vector) in matrix.top().iter().zip(&basis) {
        subtract(&mut top, -share, vector);
    }
    unit(top)
}

/// A symmetric tridiagonal matrix T: its diagonal, and what stands beside it.
struct Tridiagonal {
    diagonal: Vec<f64>,
    beside: Vec<f64>,
}

impl Tridiagonal {
    /// The entry of row `j` beside the diagonal, to its right; zero in the last.
    fn right(&self, j: usize) -> f64 {
        self.beside.get(j).copied().unwrap_or(0.0)
    }

    /// The pivots of σ − T, if all are positive: if σ is above every eigenvalue (Sturm).
    fn pivots(&self, sigma: f64) -> Option<Vec<f64>> {
        let mut pivots: Vec<f64> = vec![];
        for (j, alpha) in self.diagonal.iter().enumerate() {
            let before = pivots
                .last()
                .map_or(0.0, |pivot| self.right(j - 1) * self.right(j - 1) / pivot);
            let pivot = sigma - alpha - before;
            if pivot <= 0.0 {
                return None;
            }
            pivots.push(pivot);
        }
        Some(pivots)
    }

    /// The pivots just above the largest eigenvalue, which is bisected down to neighboring numbers.
    fn pivots_at_the_top(&self) -> Vec<f64> {
        let mut below = self.diagonal.iter().copied().fold(f64::MIN, f64::max);
        // Gershgorin's circles, with room for the rounding of the pivots.
        let widest = self.beside.iter().copied().fold(0.0, f64::max);
        let mut above = below + 2.0 * widest + 1e-12 * (below.abs() + widest) + f64::MIN_POSITIVE;
        let mut pivots = self.pivots(above);
        loop {
            let middle = 0.5 * (below + above);
            if middle <= below || middle >= above {
                break;
            }
            match self.pivots(middle) {
                Some(lower) => (above, pivots) = (middle, Some(lower)),
                None => below = middle,
            }
        }
        pivots.expect("the circles hold every eigenvalue")
    }

    /// The unit eigenvector of the largest eigenvalue θ1.
    ///
    /// Inverse iteration from a σ next to it needs no pivoting, and gains (σ − θ2)/(σ − θ1) each time: powers of ten.
    fn top(&self) -> Vec<f64> {
        let pivots = self.pivots_at_the_top();
        let mut vector = vec![0.0; pivots.len()];
        vector[0] = 1.0;
        for _ in 0..3 {
            for j in 1..vector.len() {
                vector[j] += self.right(j - 1) / pivots[j - 1] * vector[j - 1];
            }
            for j in (0..vector.len()).rev() {
                let after = vector.get(j + 1).map_or(0.0, |next| self.right(j) * next);
                vector[j] = (vector[j] + after) / pivots[j];
            }
            vector = unit(vector);
        }
        vector
    }
}

/// a·b.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// a −= factor · b.
pub(super) fn subtract(a: &mut [f64], factor: f64, b: &[f64]) {
    for (a, b) in a.iter_mut().zip(b) {
        *a -= factor * b;
    }
}

fn unit(mut vector: Vec<f64>) -> Vec<f64> {
    let length = dot(&vector, &vector).sqrt();
    for x in &mut vector {
        *x /= length;
    }
    vector
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adds A·x for a chain of n springs between fixed ends: eigenvalues 2 − 2 cos(π m/(n + 1)), m = 1 … n.
    fn chain(x: &[f64], image: &mut [f64]) {
        for i in 0..x.len() {
            let left = if i == 0 { 0.0 } else { x[i - 1] };
            let right = x.get(i + 1).copied().unwrap_or(0.0);
            image[i] += 2.0 * x[i] - left - right;
        }
    }

    fn quotient(x: &[f64]) -> f64 {
        let mut image = vec![0.0; x.len()];
        chain(x, &mut image);
        dot(x, &image)
    }

    fn top_of_chain(n: usize) -> f64 {
        2.0 + 2.0 * (std::f64::consts::PI / (n + 1) as f64).cos()
    }

    #[test]
    fn whole_space_holds_the_largest_eigenvalue() {
        for n in [1, 2, 3, 10, 40] {
            let start: Vec<f64> = (0..n).map(|i| (i * i % 7) as f64 - 2.5).collect();
            let found = quotient(&top_vector(&start, 60, chain));
            assert!(
                (found / top_of_chain(n) - 1.0).abs() < 1e-12,
                "{n}: {found}"
            );
        }
    }

    #[test]
    fn an_eigenvector_is_found_in_one_step() {
        let n = 9;
        let start: Vec<f64> = (1..=n)
            .map(|i| (f64::from(i) * f64::from(n) * std::f64::consts::PI / f64::from(n + 1)).sin())
            .collect();
        let mut applications = 0;
        let found = top_vector(&start, 40, |x, image| {
            applications += 1;
            chain(x, image);
        });
        assert!((quotient(&found) / top_of_chain(9) - 1.0).abs() < 1e-14);
        assert!(applications <= 2, "{applications}");
    }

    #[test]
    fn few_steps_stay_below_the_largest_eigenvalue_and_come_near() {
        let start: Vec<f64> = (0..500)
            .map(|i| f64::from(i * 7919 % 1009) / 1009.0 - 0.5)
            .collect();
        let found = quotient(&top_vector(&start, 40, chain));
        assert!(
            found < top_of_chain(500) && found > 0.99 * top_of_chain(500),
            "{found}"
        );
    }
}
