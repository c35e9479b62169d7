use super::*;

/// Applies every operation to rows that hold signed zeros, infinities, NaN and ordinary numbers.
struct Everything<'a, R: Row> {
    a: &'a R,
    b: &'a R,
    c: &'a R,
}

impl<R: Row> Kernel<R> for Everything<'_, R> {
    type Output = Vec<R>;

    #[inline(always)]
    fn run<L: Lane<Row = R, Scalar = R::Scalar>>(self) -> Vec<R> {
        let (a, b, c) = (L::load(self.a), L::load(self.b), L::load(self.c));
        let less = a.lt(b);
        let both = less.and(c.lt(b));
        let results = [
            a + b,
            a - b,
            a * b,
            a / b,
            -a,
            a.mul_add(b, c),
            a.neg_mul_add(b, c),
            a.sqrt(),
            a.max(b),
            a.select(less, b),
            a.select(a.le(b), c),
            a.select(a.le(a), c),
            c.keep(both),
            L::constant(0.1),
            grown(a, b, c),
            if less.any() { a } else { b },
        ];
        results
            .into_iter()
            .map(|result| {
                let mut row = R::default();
                result.store(&mut row);
                row
            })
            .collect()
    }
}

fn rows<R: Row>(shift: usize) -> R {
    const NUMBERS: [f64; 9] = [
        0.0,
        -0.0,
        1.0,
        -1.5,
        1e-20,
        3e7,
        f64::INFINITY,
        f64::NAN,
        std::f64::consts::PI,
    ];
    let mut row = R::default();
    for (k, lane) in row.lanes_mut().iter_mut().enumerate() {
        *lane = R::Scalar::from_f64(NUMBERS[(k * (shift + 1) + shift) % NUMBERS.len()]);
    }
    row
}

/// Bits as text, every NaN alike: its sign and payload are the maker's choice.
fn bits<R: Row>(rows: &[R]) -> Vec<String> {
    let text = |x: f64| {
        if x.is_nan() {
            "NaN".to_owned()
        } else {
            format!("{:016x}", x.to_bits())
        }
    };
    rows.iter()
        .flat_map(|row| row.lanes().iter().map(|lane| text(lane.to_f64())))
        .collect()
}

fn all_widths_agree<R: Row>() {
    for shift in 0..9 {
        let (a, b, c) = (rows::<R>(shift), rows::<R>(shift + 3), rows::<R>(shift + 5));
        let expected = bits(&dispatch(
            VectorWidth::PORTABLE,
            Everything {
                a: &a,
                b: &b,
                c: &c,
            },
        ));
        for width in VectorWidth::available() {
            let found = bits(&dispatch(
                width,
                Everything {
                    a: &a,
                    b: &b,
                    c: &c,
                },
            ));
            assert_eq!(
                found,
                expected,
                "{} {}",
                width.name(),
                std::any::type_name::<R>()
            );
        }
    }
}

#[test]
fn every_width_gives_the_same_bits() {
    all_widths_agree::<F64x1>();
    all_widths_agree::<F64x8>();
    all_widths_agree::<F32x8>();
    all_widths_agree::<F32x16>();
}

#[test]
fn rows_are_aligned_to_whole_vectors() {
    assert_eq!(std::mem::align_of::<F64x8>(), 64);
    assert_eq!(std::mem::size_of::<F32x16>(), 64);
    assert_eq!(std::mem::size_of::<F64x1>(), 8);
}

/// Gathers K records of four numbers.
struct Gathered<'a, R: Row> {
    records: &'a [[R::Scalar; 4]],
}

impl<R: Row> Kernel<R> for Gathered<'_, R> {
    type Output = Vec<R>;

    #[inline(always)]
    fn run<L: Lane<Row = R, Scalar = R::Scalar>>(self) -> Self::Output {
        stored(L::gather(|e| &self.records[e]))
    }
}

/// Turns eight vectors of eight about.
struct Transposed<'a>(&'a [F64x8; 8]);

impl Kernel<F64x8> for Transposed<'_> {
    type Output = Vec<F64x8>;

    #[inline(always)]
    fn run<L: Lane<Row = F64x8, Scalar = f64>>(self) -> Self::Output {
        stored(L::transposed(self.0.each_ref().map(L::load)))
    }
}

#[inline(always)]
fn stored<L: Lane, const N: usize>(vectors: [L; N]) -> Vec<L::Row> {
    let mut rows = vec![L::Row::default(); N];
    for (row, vector) in rows.iter_mut().zip(vectors) {
        vector.store(row);
    }
    rows
}

fn records_become_lanes<R: Row>() {
    let number = |e: usize, n: usize| R::Scalar::from_f64((10 * e + n) as f64);
    let records: Vec<_> = (0..R::K)
        .map(|e| [0, 1, 2, 3].map(|n| number(e, n)))
        .collect();
    for width in VectorWidth::available() {
        let rows = dispatch::<R, _>(width, Gathered { records: &records });
        for (n, row) in rows.iter().enumerate() {
            let expected: Vec<_> = (0..R::K).map(|e| number(e, n)).collect();
            assert_eq!(row.lanes(), expected, "{} {n}", width.name());
        }
    }
}

#[test]
fn record_e_is_gathered_into_lane_e() {
    records_become_lanes::<F64x1>();
    records_become_lanes::<F64x8>();
    records_become_lanes::<F32x16>();
}

#[test]
fn lane_e_of_vector_n_is_turned_into_lane_n_of_vector_e() {
    let matrix: [F64x8; 8] =
        std::array::from_fn(|n| F64x8(std::array::from_fn(|e| (10 * n + e) as f64)));
    for width in VectorWidth::available() {
        for (e, row) in dispatch(width, Transposed(&matrix)).iter().enumerate() {
            let expected: Vec<_> = matrix.iter().map(|row| row.0[e]).collect();
            assert_eq!(row.lanes(), expected, "{} {e}", width.name());
        }
    }
}

#[test]
fn thousands_of_small_parts_add_up_in_single_precision() {
    // The golden section's sequence misses the share of an interval by at most some log(n)/n: of n roundings up or down by one
    // last digit ε, all but a few are right. Rounding to the nearest is wrong by up to n ε/2.
    for (start, total) in [(0.0, 0.1f64), (0.07, 0.013), (-0.3, 0.1), (0.5, -0.11)] {
        for steps in [1_000u64, 20_000, 100_000] {
            let part = F32x8([(total / steps as f64) as f32; 8]);
            let mut sum = F32x8([start as f32; 8]);
            for step in 0..steps {
                sum = grown(sum, part, F32x8([dither(step) as f32; 8]));
            }
            let exact = f64::from(start as f32) + steps as f64 * f64::from(part.0[0]);
            let digit = f64::from(f32::EPSILON) * 0.5f64.max(exact.abs());
            let off = (f64::from(sum.0[0]) - exact).abs();
            assert!(
                off < 5.0 * digit,
                "{start} {total} {steps}: off by {} digits",
                off / digit
            );
        }
    }
}

#[test]
fn rounding_fills_its_interval_evenly() {
    let n = 10_000;
    let mut all: Vec<f64> = (0..n).map(dither).collect();
    all.sort_by(f64::total_cmp);
    for (k, value) in all.into_iter().enumerate() {
        assert!((value + 0.5 - k as f64 / n as f64).abs() < 1e-3);
    }
}
