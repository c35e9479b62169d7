//! Lanes without vector instructions: arrays, and the layout of every row in memory.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Lane, Mask, Row};

/// One truth value per replica.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flags<const K: usize>([bool; K]);

impl<const K: usize> Mask for Flags<K> {
    #[inline(always)]
    fn bits(self) -> u32 {
        let bits = self.0.iter().enumerate();
        bits.fold(0, |bits, (k, &flag)| bits | u32::from(flag) << k)
    }

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] && other.0[k]))
    }
}

macro_rules! portable {
    ($(#[$doc:meta])* $name:ident, $scalar:ty, $k:literal, $align:literal, $avx2:ty, $avx512:ty) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        #[repr(C, align($align))]
        pub struct $name(pub [$scalar; $k]);

        impl $name {
            #[inline(always)]
            fn zip(self, other: Self, f: impl Fn($scalar, $scalar) -> $scalar) -> Self {
                Self(std::array::from_fn(|k| f(self.0[k], other.0[k])))
            }
        }

        impl Add for $name {
            type Output = Self;

            #[inline(always)]
            fn add(self, other: Self) -> Self {
                self.zip(other, |a, b| a + b)
            }
        }

        impl Sub for $name {
            type Output = Self;

            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                self.zip(other, |a, b| a - b)
            }
        }

        impl Mul for $name {
            type Output = Self;

            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                self.zip(other, |a, b| a * b)
            }
        }

        impl Div for $name {
            type Output = Self;

            #[inline(always)]
            fn div(self, other: Self) -> Self {
                self.zip(other, |a, b| a / b)
            }
        }

        impl Neg for $name {
            type Output = Self;

            #[inline(always)]
            fn neg(self) -> Self {
                Self(self.0.map(|a| -a))
            }
        }

        impl Lane for $name {
            type Scalar = $scalar;
            type Row = Self;
            type Mask = Flags<$k>;
            const K: usize = $k;

            #[inline(always)]
            fn splat(value: $scalar) -> Self {
                Self([value; $k])
            }

            #[inline(always)]
            fn load(row: &Self) -> Self {
                *row
            }

            #[inline(always)]
            fn store(self, row: &mut Self) {
                *row = self;
            }

            #[inline(always)]
            #[expect(clippy::disallowed_methods, reason = "the one place where a product-sum is fused")]
            fn mul_add(self, factor: Self, addend: Self) -> Self {
                Self(std::array::from_fn(|k| self.0[k].mul_add(factor.0[k], addend.0[k])))
            }

            #[inline(always)]
            #[expect(clippy::disallowed_methods, reason = "the one place where a product-sum is fused")]
            fn neg_mul_add(self, factor: Self, addend: Self) -> Self {
                Self(std::array::from_fn(|k| (-self.0[k]).mul_add(factor.0[k], addend.0[k])))
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(self.0.map(<$scalar>::sqrt))
            }

            #[inline(always)]
            fn max(self, other: Self) -> Self {
                self.zip(other, |a, b| if a > b { a } else { b })
            }

            #[inline(always)]
            fn lt(self, other: Self) -> Flags<$k> {
                Flags(std::array::from_fn(|k| self.0[k] < other.0[k]))
            }

            #[inline(always)]
            fn le(self, other: Self) -> Flags<$k> {
                Flags(std::array::from_fn(|k| self.0[k] <= other.0[k]))
            }

            #[inline(always)]
            fn select(self, mask: Flags<$k>, other: Self) -> Self {
                Self(std::array::from_fn(|k| if mask.0[k] { self.0[k] } else { other.0[k] }))
            }

            #[inline(always)]
            fn keep(self, mask: Flags<$k>) -> Self {
                self.select(mask, Self::splat(0.0))
            }
        }

        impl Row for $name {
            #[cfg(target_arch = "x86_64")]
            type Avx2 = $avx2;
            #[cfg(not(target_arch = "x86_64"))]
            type Avx2 = Self;
            #[cfg(target_arch = "x86_64")]
            type Avx512 = $avx512;
            #[cfg(not(target_arch = "x86_64"))]
            type Avx512 = Self;

            #[inline(always)]
            fn lanes(&self) -> &[$scalar] {
                &self.0
            }

            #[inline(always)]
            fn lanes_mut(&mut self) -> &mut [$scalar] {
                &mut self.0
            }
        }
    };
}

portable! {
    /// A lone run in double precision.
    F64x1, f64, 1, 8, F64x1, F64x1
}
portable! {
    /// Eight replicas in double precision.
    F64x8, f64, 8, 64, super::avx2::F64x8, super::avx512::F64x8
}
portable! {
    /// Eight replicas in single precision.
    F32x8, f32, 8, 32, super::avx2::F32x8, super::avx2::F32x8
}
portable! {
    /// Sixteen replicas in single precision.
    F32x16, f32, 16, 64, super::avx2::F32x16, super::avx512::F32x16
}

impl F64x8 {
    /// The first four numbers and the last four, as records of their own.
    #[inline(always)]
    #[must_use]
    pub fn halves(&self) -> [&[f64; 4]; 2] {
        let (halves, _) = self.0.as_chunks();
        [&halves[0], &halves[1]]
    }
}
