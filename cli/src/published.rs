//! The authors' published results, to be shown beside ours: from their data repository, CC0.

pub(crate) mod strengths;

/// The file as they published it, columns renamed.
const CSV: &str = include_str!("../../tests/data/waveform-memory-published.csv");

/// Mean and standard error of the mean; no error of a single value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mean {
    pub(crate) mean: f64,
    pub(crate) sem: Option<f64>,
}

impl Mean {
    fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        let sem = (values.len() > 1).then(|| (squares / (n - 1.0) / n).sqrt());
        Self { mean, sem }
    }
}

/// What was published for one friction coefficient and size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Published {
    /// Grains per pack.
    pub(crate) grains: u64,
    /// Packs.
    pub(crate) packs: usize,
    /// 𝒢·E·δ0 \[Pa\].
    pub(crate) gain_e_delta0: Mean,
    /// 𝓕.
    pub(crate) fidelity: Mean,
}

/// One line: friction, grains, 𝒢·E·δ0 \[Pa\], 𝓕.
type Line = (f64, u64, f64, f64);

/// Tetrahedra of overlap 0.6 at δ0 = 0.05 and γ0 = 10⁻³.
fn lines() -> impl Iterator<Item = Line> {
    CSV.lines().skip(1).filter_map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        let [
            shape,
            overlap,
            friction,
            grains,
            delta0,
            gamma0,
            gain,
            _,
            fidelity,
        ] = cells[..]
        else {
            return None;
        };
        if (shape, overlap, delta0, gamma0) != ("tetra", "0.6", "0.05", "0.001") {
            return None;
        }
        Some((
            friction.parse().ok()?,
            grains.parse().ok()?,
            gain.parse().ok()?,
            fidelity.parse().ok()?,
        ))
    })
}

/// The published packs of this friction coefficient: those of the same size if there are any, else the largest.
pub(crate) fn published(friction: f64, grains: u64) -> Option<Published> {
    let same: Vec<Line> = lines()
        .filter(|line| line.0.total_cmp(&friction).is_eq())
        .collect();
    let size = if same.iter().any(|line| line.1 == grains) {
        grains
    } else {
        same.iter().map(|line| line.1).max()?
    };
    let packs: Vec<Line> = same.into_iter().filter(|line| line.1 == size).collect();
    let gains: Vec<f64> = packs.iter().map(|line| line.2).collect();
    let fidelities: Vec<f64> = packs.iter().map(|line| line.3).collect();
    Some(Published {
        grains: size,
        packs: packs.len(),
        gain_e_delta0: Mean::of(&gains),
        fidelity: Mean::of(&fidelities),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_demo_finds_its_own_size_at_full_friction_and_the_papers_size_elsewhere() {
        let one = published(1.0, 1024).expect("published");
        assert_eq!((one.grains, one.packs), (1024, 5));
        // (149,240 + 148,980 + 120,940 + 152,390 + 135,880)/5, from the file by hand.
        assert!((one.gain_e_delta0.mean - 141_486.0).abs() < 1e-6);
        let weak = published(0.4, 1024).expect("published");
        assert_eq!((weak.grains, weak.packs), (10_240, 5));
        assert_eq!(published(0.123, 1024), None);
    }

    #[test]
    fn the_error_of_a_mean_is_that_of_textbooks() {
        let mean = Mean::of(&[1.0, 2.0, 3.0]);
        assert!((mean.sem.expect("three values") - 1.0 / 3f64.sqrt()).abs() < 1e-15);
        assert_eq!(Mean::of(&[1.0]).sem, None);
    }
}
