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
    pub(crate) fn of(values: &[f64]) -> Self {
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

/// One published pack.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pack {
    shape: String,
    /// 𝒪; 1 for spheres.
    pub(crate) overlap: f64,
    /// μ.
    pub(crate) friction: f64,
    /// N.
    pub(crate) grains: u64,
    /// δ0.
    pub(crate) delta0: f64,
    /// γ0.
    pub(crate) gamma0: f64,
    /// 𝒢·E·δ0 \[Pa\].
    pub(crate) gain_e_delta0: f64,
    /// 𝒢.
    pub(crate) gain: f64,
    /// 𝓕.
    pub(crate) fidelity: f64,
}

impl Pack {
    /// Whether its grains are tetrahedra of this overlap.
    pub(crate) fn is_tetrahedron(&self, overlap: f64) -> bool {
        self.shape == "tetra" && self.overlap.total_cmp(&overlap).is_eq()
    }
}

/// Every published pack.
pub(crate) fn packs() -> impl Iterator<Item = Pack> {
    CSV.lines().skip(1).filter_map(|line| {
        let mut cells = line.split(',');
        let shape = cells.next()?.to_owned();
        let mut number = || cells.next()?.parse().ok();
        Some(Pack {
            shape,
            overlap: number()?,
            friction: number()?,
            grains: number()? as u64,
            delta0: number()?,
            gamma0: number()?,
            gain_e_delta0: number()?,
            gain: number()?,
            fidelity: number()?,
        })
    })
}

/// Tetrahedra of overlap 0.6 at δ0 = 0.05 and γ0 = 10⁻³.
fn usual() -> impl Iterator<Item = Pack> {
    let same = |a: f64, b: f64| a.total_cmp(&b).is_eq();
    packs().filter(move |pack| {
        pack.is_tetrahedron(0.6) && same(pack.delta0, 0.05) && same(pack.gamma0, 1e-3)
    })
}

/// The published packs of this friction coefficient: those of the same size if there are any, else the largest.
pub(crate) fn published(friction: f64, grains: u64) -> Option<Published> {
    let same: Vec<Pack> = usual()
        .filter(|pack| pack.friction.total_cmp(&friction).is_eq())
        .collect();
    let size = if same.iter().any(|pack| pack.grains == grains) {
        grains
    } else {
        same.iter().map(|pack| pack.grains).max()?
    };
    let packs: Vec<Pack> = same
        .into_iter()
        .filter(|pack| pack.grains == size)
        .collect();
    let gains: Vec<f64> = packs.iter().map(|pack| pack.gain_e_delta0).collect();
    let fidelities: Vec<f64> = packs.iter().map(|pack| pack.fidelity).collect();
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
