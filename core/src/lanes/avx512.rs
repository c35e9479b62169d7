//! Lanes in AVX-512 registers.
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
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    fn inside<R: Row, T: Kernel<R>>(kernel: T) -> T::Output {
        kernel.run::<R::Avx512>()
    }
    #[expect(
        unsafe_code,
        reason = "`VectorWidth` holds this width only after the machine was seen to have it"
    )]
    unsafe {
        inside::<R, T>(kernel)
    }
}

/// One truth value per replica, in a mask register.
#[derive(Clone, Copy)]
pub struct Bits<M>(M);

impl Mask for Bits<__mmask8> {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl Mask for Bits<__mmask16> {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

macro_rules! op {
    ($(#[$doc:meta])* $trait:ident, $method:ident, $name:ident, $intrinsic:ident) => {
        impl $trait for $name {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                #[expect(unsafe_code, reason = "only reached through `enter`")]
                unsafe {
                    Self($intrinsic(self.0, other.0))
                }
            }
        }
    };
}

macro_rules! avx512 {
    (
        $(#[$doc:meta])*
        $name:ident, $scalar:ty, $k:literal, $vector:ty, $mask:ty,
        $add:ident $sub:ident $mul:ident $div:ident $set1:ident $load:ident $store:ident $fmadd:ident $fnmadd:ident
        $sqrt:ident $max:ident $cmp:ident $blend:ident $maskz:ident
        $($records:item)*
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub struct $name($vector);

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
            type Mask = Bits<$mask>;
            const K: usize = $k;

            #[inline(always)]
            fn splat(value: $scalar) -> Self {
                unsafe { Self($set1(value)) }
            }

            #[inline(always)]
            fn load(row: &Self::Row) -> Self {
                unsafe { Self($load(row.0.as_ptr())) }
            }

            #[inline(always)]
            fn store(self, row: &mut Self::Row) {
                unsafe { $store(row.0.as_mut_ptr(), self.0) }
            }

            #[inline(always)]
            fn mul_add(self, factor: Self, addend: Self) -> Self {
                unsafe { Self($fmadd(self.0, factor.0, addend.0)) }
            }

            #[inline(always)]
            fn neg_mul_add(self, factor: Self, addend: Self) -> Self {
                unsafe { Self($fnmadd(self.0, factor.0, addend.0)) }
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                unsafe { Self($sqrt(self.0)) }
            }

            #[inline(always)]
            fn max(self, other: Self) -> Self {
                unsafe { Self($max(self.0, other.0)) }
            }

            #[inline(always)]
            fn lt(self, other: Self) -> Self::Mask {
                unsafe { Bits($cmp::<_CMP_LT_OQ>(self.0, other.0)) }
            }

            #[inline(always)]
            fn le(self, other: Self) -> Self::Mask {
                unsafe { Bits($cmp::<_CMP_LE_OQ>(self.0, other.0)) }
            }

            #[inline(always)]
            fn select(self, mask: Self::Mask, other: Self) -> Self {
                unsafe { Self($blend(mask.0, other.0, self.0)) }
            }

            #[inline(always)]
            fn keep(self, mask: Self::Mask) -> Self {
                unsafe { Self($maskz(mask.0, self.0)) }
            }

            $($records)*
        }
    };
}

/// Two records in one register.
#[inline(always)]
fn both(low: &[f64; 4], high: &[f64; 4]) -> __m512d {
    #[expect(unsafe_code, reason = "only reached through `enter`")]
    unsafe {
        let low = _mm512_castpd256_pd512(_mm256_loadu_pd(low.as_ptr()));
        _mm512_insertf64x4::<1>(low, _mm256_loadu_pd(high.as_ptr()))
    }
}

/// The lower halves of two registers, or the upper ones.
#[inline(always)]
fn half(upper: usize, first: __m512d, second: __m512d) -> __m512d {
    #[expect(unsafe_code, reason = "only reached through `enter`")]
    unsafe {
        if upper == 0 {
            _mm512_shuffle_f64x2::<0x44>(first, second)
        } else {
            _mm512_shuffle_f64x2::<0xEE>(first, second)
        }
    }
}

/// Transposes the lower 4 × 4 halves and the upper ones.
#[inline(always)]
fn transposed([a, b, c, d]: [__m512d; 4]) -> [__m512d; 4] {
    #[expect(unsafe_code, reason = "only reached through `enter`")]
    unsafe {
        let (ab_even, cd_even) = (_mm512_unpacklo_pd(a, b), _mm512_unpacklo_pd(c, d));
        let (ab_odd, cd_odd) = (_mm512_unpackhi_pd(a, b), _mm512_unpackhi_pd(c, d));
        let low = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
        let high = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
        [
            _mm512_permutex2var_pd(ab_even, low, cd_even),
            _mm512_permutex2var_pd(ab_odd, low, cd_odd),
            _mm512_permutex2var_pd(ab_even, high, cd_even),
            _mm512_permutex2var_pd(ab_odd, high, cd_odd),
        ]
    }
}

/// Picks eight of sixteen numbers: those of `second` count from eight on.
#[inline(always)]
fn pick(first: __m512d, which: [i64; 8], second: __m512d) -> __m512d {
    let [a, b, c, d, e, f, g, h] = which;
    #[expect(unsafe_code, reason = "only reached through `enter`")]
    unsafe {
        _mm512_permutex2var_pd(first, _mm512_setr_epi64(a, b, c, d, e, f, g, h), second)
    }
}

avx512! {
    /// Eight replicas in double precision.
    F64x8, f64, 8, __m512d, __mmask8,
    _mm512_add_pd _mm512_sub_pd _mm512_mul_pd _mm512_div_pd _mm512_set1_pd _mm512_load_pd _mm512_store_pd _mm512_fmadd_pd
    _mm512_fnmadd_pd _mm512_sqrt_pd _mm512_max_pd _mm512_cmp_pd_mask _mm512_mask_blend_pd _mm512_maskz_mov_pd

    #[inline(always)]
    fn gather<'a>(record: impl Fn(usize) -> &'a [f64; 4]) -> [Self; 4] {
        let [a, b, c, d] = transposed([
            both(record(0), record(4)),
            both(record(1), record(5)),
            both(record(2), record(6)),
            both(record(3), record(7)),
        ]);
        [Self(a), Self(b), Self(c), Self(d)]
    }

    #[inline(always)]
    fn transposed([a, b, c, d, e, f, g, h]: [Self; 8]) -> [Self; 8] {
        let low = transposed([a.0, b.0, c.0, d.0]);
        let high = transposed([e.0, f.0, g.0, h.0]);
        std::array::from_fn(|n| Self(half(n / 4, low[n % 4], high[n % 4])))
    }

    #[inline(always)]
    fn of_triples(triples: &[[f64; 3]; 8]) -> [Self; 3] {
        let numbers = triples.as_flattened();
        let part = |n: usize| unsafe { _mm512_loadu_pd(numbers[8 * n..8 * n + 8].as_ptr()) };
        let (a, b, c) = (part(0), part(1), part(2));
        let x = pick(pick(a, [0, 3, 6, 9, 12, 15, 0, 0], b), [0, 1, 2, 3, 4, 5, 10, 13], c);
        let y = pick(pick(a, [1, 4, 7, 10, 13, 0, 0, 0], b), [0, 1, 2, 3, 4, 8, 11, 14], c);
        let z = pick(pick(a, [2, 5, 8, 11, 14, 0, 0, 0], b), [0, 1, 2, 3, 4, 9, 12, 15], c);
        [Self(x), Self(y), Self(z)]
    }

    #[inline(always)]
    fn triples([x, y, z]: [Self; 3]) -> [[f64; 3]; 8] {
        let (x, y, z) = (x.0, y.0, z.0);
        let parts = [
            pick(pick(x, [0, 8, 0, 1, 9, 0, 2, 10], y), [0, 1, 8, 3, 4, 9, 6, 7], z),
            pick(pick(x, [0, 3, 11, 0, 4, 12, 0, 5], y), [10, 1, 2, 11, 4, 5, 12, 7], z),
            pick(pick(x, [13, 0, 6, 14, 0, 7, 15, 0], y), [0, 13, 2, 3, 14, 5, 6, 15], z),
        ];
        let mut triples = [[0.0; 3]; 8];
        let numbers = triples.as_flattened_mut();
        for (n, part) in parts.into_iter().enumerate() {
            unsafe { _mm512_storeu_pd(numbers[8 * n..8 * n + 8].as_mut_ptr(), part) }
        }
        triples
    }
}

avx512! {
    /// Sixteen replicas in single precision.
    F32x16, f32, 16, __m512, __mmask16,
    _mm512_add_ps _mm512_sub_ps _mm512_mul_ps _mm512_div_ps _mm512_set1_ps _mm512_load_ps _mm512_store_ps _mm512_fmadd_ps
    _mm512_fnmadd_ps _mm512_sqrt_ps _mm512_max_ps _mm512_cmp_ps_mask _mm512_mask_blend_ps _mm512_maskz_mov_ps
}
