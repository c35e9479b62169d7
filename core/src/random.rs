//! Random numbers keyed by seed, purpose and counter, with no state to carry or to lose.

/// What random numbers are drawn for; each purpose is a stream of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Velocities of the gas of grains.
    GasVelocity,
    /// Orientations of the gas of grains.
    GasOrientation,
    /// Radii of the beam's grains.
    GrainRadius,
    /// Where the beam's grains are tried to be put.
    GrainPlace,
    /// Initial weights of a classifier.
    ClassifierWeight,
    /// Noise in what a classifier learns from.
    ClassifierNoise,
    /// In which order a classifier learns.
    ClassifierOrder,
}

impl Purpose {
    fn name(self) -> &'static str {
        match self {
            Self::GasVelocity => "gas velocity",
            Self::GasOrientation => "gas orientation",
            Self::GrainRadius => "grain radius",
            Self::GrainPlace => "grain place",
            Self::ClassifierWeight => "classifier weight",
            Self::ClassifierNoise => "classifier noise",
            Self::ClassifierOrder => "classifier order",
        }
    }
}

fn keyed(seed: u64, purpose: Purpose, counter: u64) -> blake3::Hasher {
    let mut hasher = blake3::Hasher::new();
    hasher
        .update(&seed.to_le_bytes())
        .update(&counter.to_le_bytes())
        .update(purpose.name().as_bytes());
    hasher
}

/// Three numbers, uniform in [0, 1), for `counter` in the stream of `seed` and `purpose`.
///
/// The top 53 bits of BLAKE3's output, so the same on every machine.
#[must_use]
pub fn uniform3(seed: u64, purpose: Purpose, counter: u64) -> [f64; 3] {
    let bytes = keyed(seed, purpose, counter).finalize();
    std::array::from_fn(|k| {
        let mut word = [0; 8];
        word.copy_from_slice(&bytes.as_bytes()[8 * k..8 * k + 8]);
        (u64::from_le_bytes(word) >> 11) as f64 * 2f64.powi(-53)
    })
}

/// A unit quaternion `[w, x, y, z]`, uniform over all rotations (Shoemake's method).
#[must_use]
pub fn rotation(seed: u64, purpose: Purpose, counter: u64) -> [f64; 4] {
    let [a, b, c] = uniform3(seed, purpose, counter);
    let turn = 2.0 * std::f64::consts::PI;
    let (near, far) = ((1.0 - a).sqrt(), a.sqrt());
    [
        near * libm::sin(turn * b),
        near * libm::cos(turn * b),
        far * libm::sin(turn * c),
        far * libm::cos(turn * c),
    ]
}

/// As many words of a stream as are asked for, one after the other.
struct Words {
    output: blake3::OutputReader,
    block: [u8; 64],
    used: usize,
}

impl Words {
    fn new(seed: u64, purpose: Purpose, counter: u64) -> Self {
        Self {
            output: keyed(seed, purpose, counter).finalize_xof(),
            block: [0; 64],
            used: 64,
        }
    }

    fn next(&mut self) -> u32 {
        if self.used == self.block.len() {
            self.output.fill(&mut self.block);
            self.used = 0;
        }
        let mut word = [0; 4];
        word.copy_from_slice(&self.block[self.used..self.used + 4]);
        self.used += 4;
        u32::from_le_bytes(word)
    }

    /// Uniform in [0, 1), with 24 bits.
    fn uniform(&mut self) -> f32 {
        (self.next() >> 8) as f32 * 2f32.powi(-24)
    }
}

/// Fills `numbers` with independent normal numbers of mean 0 and variance 1 (Box and Muller 1958).
pub fn normals(seed: u64, purpose: Purpose, counter: u64, numbers: &mut [f32]) {
    let mut words = Words::new(seed, purpose, counter);
    for pair in numbers.chunks_mut(2) {
        let (a, b) = (1.0 - words.uniform(), words.uniform());
        let radius = (-2.0 * libm::logf(a)).sqrt();
        let (sine, cosine) = libm::sincosf(std::f32::consts::TAU * b);
        for (number, part) in pair.iter_mut().zip([cosine, sine]) {
            *number = radius * part;
        }
    }
}

/// Fills `numbers` with independent ones, uniform from −`bound` to `bound`.
pub fn symmetric(seed: u64, purpose: Purpose, counter: u64, bound: f32, numbers: &mut [f32]) {
    let mut words = Words::new(seed, purpose, counter);
    for number in numbers {
        *number = bound * (2.0 * words.uniform() - 1.0);
    }
}

/// Brings `items`, at most 2³² of them, into an order of which all are as likely but for 1 in 2³² (Fisher and Yates).
pub fn shuffle<T>(seed: u64, purpose: Purpose, counter: u64, items: &mut [T]) {
    let mut words = Words::new(seed, purpose, counter);
    for last in (1..items.len()).rev() {
        let pick = (u64::from(words.next()) * (last as u64 + 1)) >> 32;
        items.swap(last, pick as usize);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_pinned() {
        let [a, b, c] = uniform3(1, Purpose::GasVelocity, 0);
        assert_eq!(
            [a.to_bits(), b.to_bits(), c.to_bits()],
            uniform3(1, Purpose::GasVelocity, 0).map(f64::to_bits)
        );
        let bits = |seed, purpose| uniform3(seed, purpose, 0).map(f64::to_bits);
        assert_ne!(
            bits(1, Purpose::GasVelocity),
            bits(1, Purpose::GasOrientation)
        );
        assert_ne!(bits(1, Purpose::GasVelocity), bits(2, Purpose::GasVelocity));
    }

    #[test]
    fn numbers_are_uniform() {
        // Mean of 30,000 uniform numbers: standard error 0.00167; five of them.
        let mut sum = 0.0;
        for n in 0..10_000 {
            let numbers = uniform3(7, Purpose::GasVelocity, n);
            assert!(numbers.iter().all(|x| (0.0..1.0).contains(x)));
            sum += numbers.iter().sum::<f64>();
        }
        assert!((sum / 30_000.0 - 0.5).abs() < 5.0 * 0.00167);
    }

    #[test]
    fn normal_numbers_have_the_moments_of_a_normal_distribution() {
        let mut numbers = vec![0.0; 100_001];
        normals(5, Purpose::ClassifierNoise, 3, &mut numbers);
        let moment = |power| {
            let sum: f64 = numbers.iter().map(|&x| f64::from(x).powi(power)).sum();
            sum / numbers.len() as f64
        };
        // Standard errors are √(variance of x^k/n), with variances 1, 2, 15 and 96: five of them.
        for (power, expected, variance) in
            [(1, 0.0, 1.0), (2, 1.0, 2.0), (3, 0.0, 15.0), (4, 3.0, 96.0)]
        {
            let error = 5.0 * (variance / numbers.len() as f64).sqrt();
            let found = moment(power);
            assert!((found - expected).abs() < error, "{power}: {found}");
        }
        let mut again = [0.0; 10];
        normals(5, Purpose::ClassifierNoise, 3, &mut again);
        assert_eq!(
            again.map(f32::to_bits),
            std::array::from_fn(|k| numbers[k].to_bits()),
            "one stream"
        );
    }

    #[test]
    fn an_order_holds_every_item_once_and_each_is_anywhere_as_often() {
        // How often item 0 comes to each of 8 places in 8,000 orders: 1,000 ± √(8000·7/64) = 30; five of them.
        let mut places = [0_u32; 8];
        for counter in 0..8_000 {
            let mut items: Vec<usize> = (0..8).collect();
            shuffle(1, Purpose::ClassifierOrder, counter, &mut items);
            places[items
                .iter()
                .position(|&item| item == 0)
                .expect("every item")] += 1;
            items.sort_unstable();
            assert_eq!(items, (0..8).collect::<Vec<_>>());
        }
        assert!(places.iter().all(|&n| n.abs_diff(1000) < 150), "{places:?}");
    }

    #[test]
    fn symmetric_numbers_fill_their_range() {
        let mut numbers = vec![0.0; 10_000];
        symmetric(2, Purpose::ClassifierWeight, 0, 0.5, &mut numbers);
        assert!(numbers.iter().all(|x| (-0.5..0.5).contains(x)));
        let mean: f32 = numbers.iter().sum::<f32>() / 1e4;
        // The standard error of the mean is 0.5/√3/100: five of them.
        assert!(mean.abs() < 5.0 * 0.0029, "{mean}");
    }

    #[test]
    fn rotations_have_unit_length() {
        for n in 0..100 {
            let q = rotation(3, Purpose::GasOrientation, n);
            assert!((q.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-14);
        }
    }
}
