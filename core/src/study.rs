//! Studies: what a cheaper setting costs in accuracy, from its results and the reference's on the same packings; pure.

use crate::parameter::Quantity;

/// What a study says of the cost of a setting.
pub const COSTS: &[Quantity] = &[
    Quantity::new(
        "core_seconds",
        ("t", "s"),
        "Core-seconds of everything after the packing, for one packing.",
    ),
    Quantity::new(
        "relative_cost",
        ("t/t_ref", ""),
        "Core-seconds over those of the reference.",
    ),
    Quantity::new(
        "preparation_core_seconds",
        ("t_prep", "s"),
        "Core-seconds of making one packing, which settings share unless they change it.",
    ),
];

/// A result by which settings are judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Judged {
    /// The name in results.
    pub name: &'static str,
    /// Whether a deviation is a share of the reference's value.
    pub relative: bool,
}

impl Judged {
    /// How far `value` is from the reference's; `None` where a share would be one of nothing.
    #[must_use]
    pub fn deviation(self, value: f64, reference: f64) -> Option<f64> {
        if self.relative {
            (reference != 0.0).then(|| (value - reference) / reference.abs())
        } else {
            Some(value - reference)
        }
    }
}

/// How far a setting is from the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// The mean over packings.
    pub mean: f64,
    /// The standard error of the mean; `None` of one packing.
    pub sem: Option<f64>,
    /// What the deviation of a further packing stays below, either way, with a probability of 90 % at least; `None` of one packing.
    pub bound: Option<f64>,
}

impl Deviation {
    /// From the deviation in each packing; `None` without any.
    ///
    /// The bound is |m| + t s √(1 + 1/n), with mean m, standard deviation s and the 95 % quantile t of Student's
    /// distribution with n − 1 degrees of freedom: the farther end of the prediction interval of normal deviations.
    #[must_use]
    pub fn of(deviations: &[f64]) -> Option<Self> {
        let n = deviations.len() as f64;
        if deviations.is_empty() {
            return None;
        }
        let mean = deviations.iter().sum::<f64>() / n;
        let squares: f64 = deviations.iter().map(|d| (d - mean) * (d - mean)).sum();
        let spread = (deviations.len() > 1).then(|| (squares / (n - 1.0)).sqrt());
        let further = student_95(deviations.len() - 1) * (1.0 + 1.0 / n).sqrt();
        Some(Self {
            mean,
            sem: spread.map(|s| s / n.sqrt()),
            bound: spread.map(|s| mean.abs() + further * s),
        })
    }

    /// How large it may be: the bound, or what is known of one packing.
    #[must_use]
    pub fn size(&self) -> f64 {
        self.bound.unwrap_or_else(|| self.mean.abs())
    }
}

/// The 95 % quantile of Student's distribution; infinite without a degree of freedom, and from 31 on that of 30,
/// which is 3 % too large at most.
fn student_95(degrees: usize) -> f64 {
    const QUANTILES: [f64; 30] = [
        6.314, 2.920, 2.353, 2.132, 2.015, 1.943, 1.895, 1.860, 1.833, 1.812, 1.796, 1.782, 1.771,
        1.761, 1.753, 1.746, 1.740, 1.734, 1.729, 1.725, 1.721, 1.717, 1.714, 1.711, 1.708, 1.706,
        1.703, 1.701, 1.699, 1.697,
    ];
    match degrees {
        0 => f64::INFINITY,
        degrees => QUANTILES[degrees.min(QUANTILES.len()) - 1],
    }
}

/// What a setting costs and how far it is off.
#[derive(Clone, Debug, PartialEq)]
pub struct Trade {
    /// Core-seconds, or anything that is the better the less it is.
    pub cost: f64,
    /// How large the error of each result may be; the same results in every setting.
    pub errors: Vec<f64>,
}

impl Trade {
    /// Whether it is at least as good as `other` in everything, and better in something.
    fn beats(&self, other: &Self) -> bool {
        let pairs = || {
            std::iter::once((&self.cost, &other.cost)).chain(self.errors.iter().zip(&other.errors))
        };
        pairs().all(|(own, of_other)| own <= of_other)
            && pairs().any(|(own, of_other)| own < of_other)
    }
}

/// Which settings are on the Pareto front: those that no other beats.
#[must_use]
pub fn front(settings: &[Trade]) -> Vec<bool> {
    let beaten = |one: &Trade| settings.iter().any(|other| other.beats(one));
    settings.iter().map(|one| !beaten(one)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, uniform3};

    /// The probability of Student's distribution beyond `t`, by its density and Simpson's rule.
    fn beyond(t: f64, degrees: f64) -> f64 {
        let density = |x: f64| {
            let shape = libm::lgamma(0.5 * (degrees + 1.0)) - libm::lgamma(0.5 * degrees);
            let power = -0.5 * (degrees + 1.0) * libm::log1p(x * x / degrees);
            libm::exp(shape + power) / (degrees * std::f64::consts::PI).sqrt()
        };
        let (steps, width) = (20_000, t / 20_000.0);
        let inner: f64 = (1..steps)
            .map(|k| density(f64::from(k) * width) * if k % 2 == 1 { 4.0 } else { 2.0 })
            .sum();
        0.5 - (density(0.0) + inner + density(t)) * width / 3.0
    }

    #[test]
    fn quantiles_leave_a_twentieth_beyond_them() {
        for degrees in 1..=30 {
            let share = beyond(student_95(degrees), degrees as f64);
            // Three digits after the point move the share by the density there times 0.0005, below 0.0001.
            assert!((share - 0.05).abs() < 1e-4, "{degrees}: {share}");
        }
    }

    #[test]
    fn two_packings_have_an_error_and_one_has_none() {
        let two = Deviation::of(&[0.01, 0.03]).expect("two packings");
        let spread = 2.0_f64.sqrt() * 0.01;
        assert!((two.mean - 0.02).abs() < 1e-15);
        assert!((two.sem.expect("two") - 0.01).abs() < 1e-15);
        let bound = 0.02 + 6.314 * spread * 1.5_f64.sqrt();
        assert!((two.bound.expect("two") - bound).abs() < 1e-12);
        let one = Deviation::of(&[-0.01]).expect("a packing");
        assert_eq!((one.sem, one.bound), (None, None));
        assert!((one.size() - 0.01).abs() < 1e-15);
        assert_eq!(Deviation::of(&[]), None);
    }

    #[test]
    fn nine_of_ten_further_packings_stay_below_the_bound() {
        // 4 known packings and a further one, normal deviations about a mean that is small beside their spread.
        let mut normal = normals();
        let trials = 4000;
        let kept = (0..trials)
            .filter(|_| {
                let known: Vec<f64> = (0..4).map(|_| normal()).collect();
                let deviation = Deviation::of(&known).expect("four");
                normal().abs() <= deviation.size()
            })
            .count();
        // 90 % with a mean of its own, and more where |m| is added though the true mean is zero.
        let share = kept as f64 / f64::from(trials);
        assert!((0.89..0.97).contains(&share), "{share}");
    }

    /// Numbers of mean 0 and variance 1, nearly normal: sums of twelve uniform ones.
    fn normals() -> impl FnMut() -> f64 {
        let mut counter = 0;
        move || {
            counter += 4;
            let threes = (0..4).map(|k| uniform3(7, Purpose::GasVelocity, counter + k));
            threes.flatten().sum::<f64>() - 6.0
        }
    }

    #[test]
    fn front_holds_what_nothing_beats() {
        let trade = |cost: f64, errors: [f64; 2]| Trade {
            cost,
            errors: errors.to_vec(),
        };
        let settings = [
            trade(10.0, [0.0, 0.0]),
            trade(5.0, [0.1, 0.2]),
            // Dearer and worse than the one before.
            trade(6.0, [0.1, 0.3]),
            // Worse in one thing, better in another.
            trade(6.0, [0.05, 0.3]),
            trade(1.0, [0.5, 0.5]),
        ];
        assert_eq!(front(&settings), [true, true, false, true, true]);
        // Equal settings do not beat each other.
        assert_eq!(
            front(&[settings[1].clone(), settings[1].clone()]),
            [true, true]
        );
    }
}
