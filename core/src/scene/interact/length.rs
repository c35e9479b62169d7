//! How far apart two spheres of radius 1 are and how deep they touch, from |L|² − 4, without roots and divisions.
//!
//! A root and a division, one after the other, take as long as thirty product-sums, and all that a contact does waits for them.
//! Where spheres overlap by more than a fifth of R, rare but right as well, they are taken nonetheless.

use crate::lanes::{Lane, Mask};

/// |L|² − 4 down to which series are good: overlaps of 2 − √3.2 = 0.211 R.
const DEEPEST: f64 = -0.8;

/// 1/|L| by powers of |L|² − 4: off by 5.6e-6 at most.
const GUESS: [f64; 4] = [
    0.499_997_477_961_866_8,
    -0.062_600_309_976_984_13,
    0.011_110_970_740_118_62,
    -0.003_564_773_950_292_608,
];

/// 1/|L| by powers of |L|² − 4: off by 7.4e-10 at most, a hundredth of what single precision resolves.
const INVERSE: [f64; 7] = [
    0.500_000_000_332_986_6,
    -0.062_499_959_287_556_42,
    0.011_719_556_226_322_939,
    -0.002_435_477_546_281_542_3,
    0.000_554_513_373_721_972_8,
    -8.491_777_487_386_058e-5,
    5.566_092_897_496_872e-5,
];

/// 1/(|L| + 2) by powers of |L|² − 4: off by 8.8e-11 at most.
const INVERSE_OF_SUM: [f64; 7] = [
    0.250_000_000_019_181_3,
    -0.015_624_997_654_310_302,
    0.001_953_171_499_939_704,
    -0.000_304_833_128_280_086_2,
    5.459_229_965_831_678_5e-5,
    -7.955_853_726_078_175e-6,
    3.631_716_760_119_827e-6,
];

/// 1/|L| and p from |L|² − 4; where they do not touch, numbers without meaning.
#[inline(always)]
pub(super) fn inverse_length_and_overlap<L: Lane>(excess: L) -> (L, L) {
    let (inverse, overlap) = if size_of::<L::Scalar>() == size_of::<f32>() {
        let by_sum = series(&INVERSE_OF_SUM, excess);
        (series(&INVERSE, excess), -excess * by_sum)
    } else {
        refined(excess)
    };
    let deep = excess.lt(L::constant(DEEPEST));
    if !deep.any() {
        return (inverse, overlap);
    }
    let length = (excess + L::constant(4.0)).sqrt();
    let sum = length + L::constant(2.0);
    let both = L::constant(1.0) / (length * sum);
    (
        (both * sum).select(deep, inverse),
        (-excess * (both * length)).select(deep, overlap),
    )
}

/// The same in double precision: the guess y, bettered with h = 1 − |L|² y² to y (1 + h/2 + 3h²/8), and p = 2 − |L|² y.
///
/// The next term, 5h³/16, is 4.4e-16 at most, and so is what it adds to an overlap, in R.
#[inline(always)]
fn refined<L: Lane>(excess: L) -> (L, L) {
    let term = |n: usize| L::constant(GUESS[n]);
    let low = term(1).mul_add(excess, term(0));
    let high = term(3).mul_add(excess, term(2));
    let guess = high.mul_add(excess * excess, low);
    let square = excess + L::constant(4.0);
    let h = (square * guess).neg_mul_add(guess, L::constant(1.0));
    let better = h.mul_add(L::constant(0.375), L::constant(0.5)) * h;
    let inverse = better.mul_add(guess, guess);
    let overlap = square.neg_mul_add(inverse, L::constant(2.0));
    // Rounding may leave less than nothing of the shallowest.
    (inverse, overlap.max(L::constant(0.0)))
}

/// Σ c_n xⁿ, pairs first.
#[inline(always)]
fn series<L: Lane>(coefficients: &[f64; 7], x: L) -> L {
    let [c0, c1, c2, c3, c4, c5, c6] = coefficients.map(L::constant);
    let square = x * x;
    let low = c3.mul_add(x, c2).mul_add(square, c1.mul_add(x, c0));
    let high = c6.mul_add(square, c5.mul_add(x, c4));
    high.mul_add(square * square, low)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{F32x8, F64x1, Row};

    /// |L|² − 4 at overlaps from nothing to the whole of a sphere.
    fn excesses() -> impl Iterator<Item = f64> {
        (0..=2_000).map(|k| {
            let length = 2.0 - f64::from(k) / 1_000.0 * 0.95;
            length * length - 4.0
        })
    }

    #[test]
    fn double_precision_is_that_of_roots() {
        for excess in excesses() {
            let (inverse, overlap) = inverse_length_and_overlap(F64x1([excess]));
            let length = (excess + 4.0).sqrt();
            // 4.4e-16 of the series, and three roundings of each.
            assert!((inverse.0[0] * length - 1.0).abs() < 1.2e-15, "{excess}");
            let exact = -excess / (length + 2.0);
            assert!((overlap.0[0] - exact).abs() < 2.4e-15, "{excess}");
        }
    }

    #[test]
    fn single_precision_keeps_the_digits_of_an_overlap() {
        for excess in excesses() {
            let excess = excess as f32;
            let (inverse, overlap) = inverse_length_and_overlap(F32x8([excess; 8]));
            let length = (f64::from(excess) + 4.0).sqrt();
            let exact = -f64::from(excess) / (length + 2.0);
            // Four roundings of 6e-8.
            let off = f64::from(inverse.lanes()[0]) * length - 1.0;
            assert!(off.abs() < 2.4e-7, "{excess} {off}");
            let off = f64::from(overlap.lanes()[0]) - exact;
            assert!(off.abs() <= 2.4e-7 * exact, "{excess} {off}");
        }
    }

    #[test]
    fn spheres_that_hardly_touch_never_overlap_by_less_than_nothing() {
        for k in 0..1_000 {
            let excess = -f64::powi(2.0, -20 - k % 60) * (1.0 + f64::from(k) / 1_000.0);
            let (_, overlap) = inverse_length_and_overlap(F64x1([excess]));
            assert!(overlap.0[0] >= 0.0, "{excess}");
        }
    }
}
