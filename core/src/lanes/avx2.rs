//! Lanes in AVX2 registers.
//!
//! Everything here is `#[inline(always)]` and reached only through [`enter`].

#[allow(
    clippy::wildcard_imports,
    reason = "a family of instructions; the lint does not fire in tests"
)]
use core::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Kernel, Lane, Mask, Row};

/// Runs `kernel` compiled for these instructions.
pub(super) fn enter<R: Row, T: Kernel<R>>(kernel: T) -> T::Output {
    #[target_feature(enable = "avx2,fma")]
    fn inside<R: Row, T: Kernel<R>>(kernel: T) -> T::Output {
        kernel.run::<R::Avx2>()
    }
    #[expect(
        unsafe_code,
        reason = "`VectorWidth` holds this width only after the machine was seen to have it"
    )]
    unsafe {
        inside::<R, T>(kernel)
    }
}

/// Asks for the cache lines of `row` ahead of their use.
#[inline(always)]
pub(super) fn prefetch<T>(row: &T) {
    const LINE: usize = 64;
    let start = std::ptr::from_ref(row).cast::<i8>();
    for line in 0..std::mem::size_of::<T>().div_ceil(LINE) {
        #[expect(
            unsafe_code,
            reason = "a prefetch reads nothing; every x86-64 processor has it"
        )]
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(start.add(LINE * line));
        }
    }
}

/// One truth value per replica: all bits of its number set, or none.
#[derive(Clone, Copy)]
pub struct Wide<V, const N: usize>([V; N]);

macro_rules! mask {
    ($vector:ty, $n:literal, $per:literal, $movemask:ident, $and:ident) => {
        #[expect(unsafe_code, reason = "only reached through `enter`")]
        impl Mask for Wide<$vector, $n> {
            #[inline(always)]
            fn bits(self) -> u32 {
                let parts = self.0.iter().enumerate();
                parts.fold(0, |bits, (n, &part)| {
                    bits | (unsafe { $movemask(part) } as u32) << ($per * n)
                })
            }

            #[inline(always)]
            fn and(self, other: Self) -> Self {
                Self(std::array::from_fn(|n| unsafe {
                    $and(self.0[n], other.0[n])
                }))
            }
        }
    };
}

mask!(__m256d, 2, 4, _mm256_movemask_pd, _mm256_and_pd);
mask!(__m256, 1, 8, _mm256_movemask_ps, _mm256_and_ps);
mask!(__m256, 2, 8, _mm256_movemask_ps, _mm256_and_ps);

macro_rules! op {
    ($trait:ident, $method:ident, $name:ident, $intrinsic:ident) => {
        impl $trait for $name {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                #[expect(unsafe_code, reason = "only reached through `enter`")]
                Self(std::array::from_fn(|n| unsafe {
                    $intrinsic(self.0[n], other.0[n])
                }))
            }
        }
    };
}

macro_rules! avx2 {
    (
        $(#[$doc:meta])*
        $name:ident, $scalar:ty, $k:literal, $vector:ty, $n:literal, $part:literal,
        $add:ident $sub:ident $mul:ident $div:ident $set1:ident $load:ident $store:ident $fmadd:ident $fnmadd:ident
        $sqrt:ident $max:ident $cmp:ident $blend:ident $and:ident
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub struct $name([$vector; $n]);

        op!(Add, add, $name, $add);
        op!(Sub, sub, $name, $sub);
        op!(Mul, mul, $name, $mul);
        op!(Div, div, $name, $div);

        impl Neg for $name {
            type Output = Self;

            #[inline(always)]
            fn neg(self) -> Self {
                // −0 − x would lose the sign of zero; a product with −1 does not.
                self * Self::splat(-1.0)
            }
        }

        #[expect(unsafe_code, reason = "only reached through `enter`; rows are aligned to a whole vector")]
        impl Lane for $name {
            type Scalar = $scalar;
            type Row = super::portable::$name;
            type Mask = Wide<$vector, $n>;
            const K: usize = $k;

            #[inline(always)]
            fn splat(value: $scalar) -> Self {
                Self([unsafe { $set1(value) }; $n])
            }

            #[inline(always)]
            fn load(row: &Self::Row) -> Self {
                Self(std::array::from_fn(|n| unsafe { $load(row.0.as_ptr().add($part * n)) }))
            }

            #[inline(always)]
            fn store(self, row: &mut Self::Row) {
                for n in 0..$n {
                    unsafe { $store(row.0.as_mut_ptr().add($part * n), self.0[n]) }
                }
            }

            #[inline(always)]
            fn mul_add(self, factor: Self, addend: Self) -> Self {
                Self(std::array::from_fn(|n| unsafe { $fmadd(self.0[n], factor.0[n], addend.0[n]) }))
            }

            #[inline(always)]
            fn neg_mul_add(self, factor: Self, addend: Self) -> Self {
                Self(std::array::from_fn(|n| unsafe { $fnmadd(self.0[n], factor.0[n], addend.0[n]) }))
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(std::array::from_fn(|n| unsafe { $sqrt(self.0[n]) }))
            }

            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self(std::array::from_fn(|n| unsafe { $max(self.0[n], other.0[n]) }))
            }

            #[inline(always)]
            fn lt(self, other: Self) -> Self::Mask {
                Wide(std::array::from_fn(|n| unsafe { $cmp::<_CMP_LT_OQ>(self.0[n], other.0[n]) }))
            }

            #[inline(always)]
            fn le(self, other: Self) -> Self::Mask {
                Wide(std::array::from_fn(|n| unsafe { $cmp::<_CMP_LE_OQ>(self.0[n], other.0[n]) }))
            }

            #[inline(always)]
            fn select(self, mask: Self::Mask, other: Self) -> Self {
                Self(std::array::from_fn(|n| unsafe { $blend(other.0[n], self.0[n], mask.0[n]) }))
            }

            #[inline(always)]
            fn keep(self, mask: Self::Mask) -> Self {
                Self(std::array::from_fn(|n| unsafe { $and(self.0[n], mask.0[n]) }))
            }
        }
    };
}

avx2! {
    /// Eight replicas in double precision.
    F64x8, f64, 8, __m256d, 2, 4,
    _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd _mm256_set1_pd _mm256_load_pd _mm256_store_pd _mm256_fmadd_pd
    _mm256_fnmadd_pd _mm256_sqrt_pd _mm256_max_pd _mm256_cmp_pd _mm256_blendv_pd _mm256_and_pd
}

avx2! {
    /// Eight replicas in single precision.
    F32x8, f32, 8, __m256, 1, 8,
    _mm256_add_ps _mm256_sub_ps _mm256_mul_ps _mm256_div_ps _mm256_set1_ps _mm256_load_ps _mm256_store_ps _mm256_fmadd_ps
    _mm256_fnmadd_ps _mm256_sqrt_ps _mm256_max_ps _mm256_cmp_ps _mm256_blendv_ps _mm256_and_ps
}

avx2! {
    /// Sixteen replicas in single precision.
    F32x16, f32, 16, __m256, 2, 8,
    _mm256_add_ps _mm256_sub_ps _mm256_mul_ps _mm256_div_ps _mm256_set1_ps _mm256_load_ps _mm256_store_ps _mm256_fmadd_ps
    _mm256_fnmadd_ps _mm256_sqrt_ps _mm256_max_ps _mm256_cmp_ps _mm256_blendv_ps _mm256_and_ps
}
