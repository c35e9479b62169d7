//! Lanes: K replicas side by side, the number type that every kernel is written in.
//!
//! A [`Row`] is K numbers in memory; a [`Lane`] is the same K numbers in registers.
//! Kernels are generic over `Lane`; [`dispatch`] runs one with the widest vectors that the machine has.
//! Every path gives the same bits: operations are IEEE 754 and element-wise, and a product-sum is fused exactly where the
//! source says [`Lane::mul_add`] or [`Lane::neg_mul_add`].

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod portable;

pub use portable::{F32x8, F32x16, F64x1, F64x8};

/// f32 or f64.
pub trait Scalar: Copy + Debug + Default + PartialOrd + Send + Sync + 'static {
    /// Whether what thousands of small additions lose would be noticed.
    const COARSE: bool;
    /// The distance from 1 to the next number.
    const EPSILON: f64;

    /// Rounds to this type.
    fn from_f64(value: f64) -> Self;
    /// Widens, exactly.
    fn to_f64(self) -> f64;
}

impl Scalar for f64 {
    const COARSE: bool = false;
    const EPSILON: f64 = f64::EPSILON;

    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
}

impl Scalar for f32 {
    const COARSE: bool = true;
    const EPSILON: f64 = f32::EPSILON as f64;

    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        value as Self
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}

/// `sum + part`, where `part` is by far the smaller, rounded so that a thousand equal parts add up.
///
/// Rounding to the nearest errs by the same share of a last digit whenever equal parts are added, so that errors grow with their
/// number: displacements of 0.1 R that grow for 45,000 steps end off by 10⁻⁴ R, which is all of a small signal.
/// Here `dither` last digits of the sum are added first, −½ … ½, other at every step: the sum is rounded up as often as the
/// equidistributed sequence [`dither`] says, and errors stay about one last digit.
/// That digit is found by going to the next number: sum + 0.50005 ulp is rounded away from zero.
#[inline(always)]
pub fn grown<L: Lane>(sum: L, part: L, dither: L) -> L {
    let digit = sum.mul_add(L::constant(0.50005 * f64::from(f32::EPSILON)), sum) - sum;
    sum + digit.mul_add(dither, part)
}

/// What step `step` adds before it rounds: multiples of the golden section modulo one, which fill the interval most evenly,
/// less a half.
#[must_use]
pub fn dither(step: u64) -> f64 {
    // 2^64 over the golden number; the first is not the end of the interval.
    let part = (step + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (part >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

/// K numbers in memory, one per replica, aligned for whole-vector loads.
pub trait Row: Lane<Row = Self> + Default + Debug + Send + Sync + 'static {
    /// The same numbers in AVX2 registers.
    type Avx2: Lane<Row = Self, Scalar = Self::Scalar>;
    /// The same numbers in AVX-512 registers.
    type Avx512: Lane<Row = Self, Scalar = Self::Scalar>;

    /// The K numbers.
    fn lanes(&self) -> &[Self::Scalar];

    /// The K numbers, to be changed.
    fn lanes_mut(&mut self) -> &mut [Self::Scalar];
}

/// Which of K replicas.
pub trait Mask: Copy {
    /// One bit per replica, the first lowest.
    fn bits(self) -> u32;

    /// Whether any replica is meant.
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }

    /// The replicas that both name.
    #[must_use]
    fn and(self, other: Self) -> Self;
}

/// K numbers in registers.
pub trait Lane:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Send
    + Sync
{
    /// The type of one number.
    type Scalar: Scalar;
    /// The same numbers in memory.
    type Row: Row<Scalar = Self::Scalar>;
    /// One truth value per replica.
    type Mask: Mask;
    /// The number of replicas.
    const K: usize;

    /// The same number in every replica.
    fn splat(value: Self::Scalar) -> Self;

    /// Reads K numbers.
    fn load(row: &Self::Row) -> Self;

    /// Writes K numbers.
    fn store(self, row: &mut Self::Row);

    /// `self * factor + addend`, rounded once.
    #[must_use]
    fn mul_add(self, factor: Self, addend: Self) -> Self;

    /// `addend - self * factor`, rounded once.
    #[must_use]
    fn neg_mul_add(self, factor: Self, addend: Self) -> Self;

    /// The correctly rounded square root.
    #[must_use]
    fn sqrt(self) -> Self;

    /// `self` where it is greater than `other`, else `other` (also where either is NaN).
    #[must_use]
    fn max(self, other: Self) -> Self;

    /// Where `self < other`; nowhere that either is NaN.
    fn lt(self, other: Self) -> Self::Mask;

    /// Where `self <= other`; nowhere that either is NaN.
    fn le(self, other: Self) -> Self::Mask;

    /// `self` where `mask`, else `other`.
    #[must_use]
    fn select(self, mask: Self::Mask, other: Self) -> Self;

    /// `self` where `mask`, else +0.
    #[must_use]
    fn keep(self, mask: Self::Mask) -> Self;

    /// K records of four numbers as four vectors: number `n` of record `e` becomes lane `e` of vector `n`.
    #[inline(always)]
    #[must_use]
    fn gather<'a>(record: impl Fn(usize) -> &'a [Self::Scalar; 4]) -> [Self; 4]
    where
        Self::Scalar: 'a,
    {
        let mut rows = [Self::Row::default(); 4];
        for e in 0..Self::K {
            for (row, &number) in rows.iter_mut().zip(record(e)) {
                row.lanes_mut()[e] = number;
            }
        }
        rows.each_ref().map(Self::load)
    }

    /// Eight vectors of eight, turned about: lane `e` of vector `n` becomes lane `n` of vector `e`. Only for K = 8.
    #[inline(always)]
    #[must_use]
    fn transposed(vectors: [Self; 8]) -> [Self; 8] {
        let mut rows = [Self::Row::default(); 8];
        for (n, vector) in vectors.into_iter().enumerate() {
            let mut row = Self::Row::default();
            vector.store(&mut row);
            for (to, &number) in rows.iter_mut().zip(row.lanes()) {
                to.lanes_mut()[n] = number;
            }
        }
        rows.each_ref().map(Self::load)
    }

    /// Eight triples, one behind the other, as three vectors: number `n` of triple `e` becomes lane `e` of vector `n`.
    /// Only for K = 8.
    #[inline(always)]
    #[must_use]
    fn of_triples(triples: &[[Self::Scalar; 3]; 8]) -> [Self; 3] {
        let mut rows = [Self::Row::default(); 3];
        for (e, triple) in triples.iter().enumerate() {
            for (row, &number) in rows.iter_mut().zip(triple) {
                row.lanes_mut()[e] = number;
            }
        }
        rows.each_ref().map(Self::load)
    }

    /// The triples of which [`of_triples`](Self::of_triples) makes these vectors.
    #[inline(always)]
    #[must_use]
    fn triples(vectors: [Self; 3]) -> [[Self::Scalar; 3]; 8] {
        let mut triples = [[Self::Scalar::default(); 3]; 8];
        for (n, vector) in vectors.into_iter().enumerate() {
            let mut row = Self::Row::default();
            vector.store(&mut row);
            for (triple, &number) in triples.iter_mut().zip(row.lanes()) {
                triple[n] = number;
            }
        }
        triples
    }

    /// A constant of the physics in every replica.
    #[inline(always)]
    #[must_use]
    fn constant(value: f64) -> Self {
        Self::splat(Self::Scalar::from_f64(value))
    }
}

/// Work that is written once for all lane types of one row type.
///
/// `run` and all that it calls must be `#[inline(always)]`, so that it is compiled with the caller's vector instructions.
pub trait Kernel<R: Row> {
    /// What it returns.
    type Output;

    /// Does the work with the lane type `L`.
    fn run<L: Lane<Row = R, Scalar = R::Scalar>>(self) -> Self::Output;
}

/// The vector instructions to use: never more than the machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VectorWidth(Width);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Width {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl VectorWidth {
    /// No vector instructions beyond what the program was compiled for.
    pub const PORTABLE: Self = Self(Width::Portable);

    /// Every width that this machine has, narrowest first.
    #[must_use]
    pub fn available() -> Vec<Self> {
        #[cfg_attr(
            not(target_arch = "x86_64"),
            expect(unused_mut, reason = "only x86-64 has more than one")
        )]
        let mut widths = vec![Self::PORTABLE];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                widths.push(Self(Width::Avx2));
                if is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vl")
                {
                    widths.push(Self(Width::Avx512));
                }
            }
        }
        widths
    }

    /// The widest that this machine has.
    #[must_use]
    pub fn widest() -> Self {
        *Self::available().last().unwrap_or(&Self::PORTABLE)
    }

    /// `portable`, `avx2` or `avx512`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.0 {
            Width::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Width::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Width::Avx512 => "avx512",
        }
    }
}

/// Asks for the memory of `row` ahead of its use; changes nothing but the time it takes.
#[inline(always)]
pub fn prefetch<T>(row: &T) {
    #[cfg(target_arch = "x86_64")]
    avx2::prefetch(row);
    #[cfg(not(target_arch = "x86_64"))]
    let _ = row;
}

/// Runs `kernel` with the lane type of `width`.
#[inline]
pub fn dispatch<R: Row, T: Kernel<R>>(width: VectorWidth, kernel: T) -> T::Output {
    match width.0 {
        Width::Portable => kernel.run::<R>(),
        #[cfg(target_arch = "x86_64")]
        Width::Avx2 => avx2::enter::<R, T>(kernel),
        #[cfg(target_arch = "x86_64")]
        Width::Avx512 => avx512::enter::<R, T>(kernel),
    }
}

#[cfg(test)]
mod tests;
