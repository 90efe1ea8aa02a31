//! x86-64: four lanes of SSE2, which every such machine has; the same with the extremes of whole numbers that came with
//! SSE4.1; and eight of AVX2. (AVX-512's masks take longer to reach a register than the sign bits of AVX2.)
//!
//! # Safety
//! A call of an intrinsic is sound where the machine has the instruction. What [`Sse`] asks for, every x86-64 has. Of
//! the other types values come from constructors that run in [`Isa::run`] for the level of that name alone.
//!
//! [`Isa::run`]: super::Isa::run
#[macro_use]
mod across;

use super::pair::{Half, Pair};
use super::{Lanes, Work};
use core::arch::x86_64::{
    __m128, __m256, _CMP_LE_OQ, _CMP_LT_OQ, _MM_HINT_T0, _mm_add_ps, _mm_and_ps, _mm_and_si128, _mm_andnot_ps,
    _mm_castps_si128, _mm_castsi128_ps, _mm_cmpeq_epi32, _mm_cmpgt_epi32, _mm_cmple_ps, _mm_cmplt_ps, _mm_cvtss_f32,
    _mm_div_ps, _mm_loadu_ps, _mm_max_epi32, _mm_max_ps, _mm_min_epi32, _mm_min_ps, _mm_movehl_ps, _mm_movemask_ps,
    _mm_mul_ps, _mm_or_ps, _mm_prefetch, _mm_set_epi32, _mm_set1_epi32, _mm_set1_ps, _mm_shuffle_ps, _mm_srai_epi32,
    _mm_storeu_ps, _mm_sub_ps, _mm_unpackhi_ps, _mm_unpacklo_ps, _mm_xor_ps, _mm256_add_ps, _mm256_and_ps,
    _mm256_and_si256, _mm256_andnot_ps, _mm256_blendv_ps, _mm256_castps_si256, _mm256_castps128_ps256,
    _mm256_castps256_ps128, _mm256_castsi256_ps, _mm256_cmp_ps, _mm256_cmpeq_epi32, _mm256_cmpgt_epi32, _mm256_div_ps,
    _mm256_extractf128_ps, _mm256_insertf128_ps, _mm256_loadu_ps, _mm256_max_epi32, _mm256_max_ps, _mm256_min_epi32,
    _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps, _mm256_or_ps, _mm256_set_epi32, _mm256_set1_epi32,
    _mm256_set1_ps, _mm256_shuffle_ps, _mm256_srai_epi32, _mm256_storeu_ps, _mm256_sub_ps, _mm256_unpackhi_ps,
    _mm256_unpacklo_ps, _mm256_xor_ps,
};
use core::ops::{Add, Div, Mul, Sub};

/// Does the work with eight lanes as two times four.
#[inline(never)]
pub(super) fn sse2<W: Work>(work: W) -> W::Output {
    work.run::<Pair<Sse>, Sse>()
}

/// Does the work with SSE4.1, eight lanes as two times four.
#[inline(always)]
pub(super) fn sse41<W: Work>(work: W) -> W::Output {
    #[target_feature(enable = "sse4.1")]
    #[inline(never)]
    fn inside<W: Work>(work: W) -> W::Output {
        work.run::<Pair<Sse41>, Sse41>()
    }
    // SAFETY: an `Isa` of this level is made only where the machine has SSE4.1.
    unsafe { inside(work) }
}

/// Does the work with AVX2.
#[inline(always)]
pub(super) fn avx2<W: Work>(work: W) -> W::Output {
    #[target_feature(enable = "avx2")]
    #[inline(never)]
    fn inside<W: Work>(work: W) -> W::Output {
        work.run::<Avx, Avx4>()
    }
    // SAFETY: an `Isa` of this level is made only where the machine has AVX2.
    unsafe { inside(work) }
}

/// Four lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sse(__m128);

/// Four lanes with extremes of whole numbers.
#[derive(Clone, Copy, Debug)]
struct Sse41(__m128);

/// Eight lanes.
#[derive(Clone, Copy, Debug)]
struct Avx(__m256);

/// Four of them.
#[derive(Clone, Copy, Debug)]
struct Avx4(__m128);

impl Half for Sse {}
impl Half for Sse41 {}

/// Asks for every line of a value.
#[inline(always)]
fn fetch(at: *const u8, bytes: usize) {
    for line in (0..bytes).step_by(64) {
        // SAFETY: a prefetch reads nothing, and every x86-64 has it.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(at.cast::<i8>().wrapping_add(line)) };
    }
}

/// An operator.
macro_rules! operator {
    ($type:ident, $trait:ident, $name:ident, $intrinsic:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: a value of the type is there only where the instruction is: see the module.
                unsafe { Self($intrinsic(self.0, other.0)) }
            }
        }
    };
}

/// All operators of a type.
macro_rules! operators {
    ($type:ident, $add:ident, $sub:ident, $mul:ident, $div:ident) => {
        operator!($type, Add, add, $add);
        operator!($type, Sub, sub, $sub);
        operator!($type, Mul, mul, $mul);
        operator!($type, Div, div, $div);
    };
}

operators!(Sse, _mm_add_ps, _mm_sub_ps, _mm_mul_ps, _mm_div_ps);
operators!(Sse41, _mm_add_ps, _mm_sub_ps, _mm_mul_ps, _mm_div_ps);
operators!(Avx4, _mm_add_ps, _mm_sub_ps, _mm_mul_ps, _mm_div_ps);
operators!(Avx, _mm256_add_ps, _mm256_sub_ps, _mm256_mul_ps, _mm256_div_ps);

/// The rest of an instruction set. MINPS and MAXPS have the order of operands that the trait states: they give the
/// second where the two are unordered or equal.
macro_rules! lanes {
    (
        $type:ident, $n:literal, $splat:ident, $load:ident, $store:ident, $min:ident, $max:ident,
        $and:ident, $andnot:ident, $or:ident, $xor:ident, $shift:path, $bits:ident, $number:ident, $run:ident, $lt:path, $le:path, $mask:expr, { $($more:tt)* }
    ) => {
        impl Lanes<$n> for $type {
            #[inline(always)]
            fn call<W: Work>(work: W) -> W::Output {
                $run(work)
            }

            #[inline(always)]
            fn splat(x: f32) -> Self {
                // SAFETY: called only where the instruction is: see the module.
                unsafe { Self($splat(x)) }
            }

            #[inline(always)]
            fn load(row: &[f32; $n]) -> Self {
                // SAFETY: as for `splat`; it reads as many numbers as the row has, and needs no alignment.
                unsafe { Self($load(row.as_ptr())) }
            }

            #[inline(always)]
            fn store(self) -> [f32; $n] {
                let mut row = [0.0; $n];
                // SAFETY: as for `splat`; it writes as many numbers as the row has, and needs no alignment.
                unsafe { $store(row.as_mut_ptr(), self.0) };
                row
            }

            #[inline(always)]
            fn negative(self) -> Self {
                // SAFETY: as for `splat`.
                unsafe { Self($number($shift($bits(self.0)))) }
            }

            #[inline(always)]
            fn exchanged(self, other: Self, mask: Self) -> (Self, Self) {
                // SAFETY: as for `splat`.
                unsafe {
                    let apart = $and($xor(self.0, other.0), mask.0);
                    (Self($xor(self.0, apart)), Self($xor(other.0, apart)))
                }
            }

            #[inline(always)]
            fn abs(self) -> Self {
                // SAFETY: as for `splat`; so for all that follow.
                unsafe { Self($andnot($splat(-0.0), self.0)) }
            }

            #[inline(always)]
            fn signed_as(self, other: Self) -> Self {
                // SAFETY: as for `splat`.
                unsafe { Self($or(self.0, $and(other.0, $splat(-0.0)))) }
            }

            #[inline(always)]
            fn least(self, other: Self) -> Self {
                // SAFETY: as for `splat`.
                unsafe { Self($min(self.0, other.0)) }
            }

            #[inline(always)]
            fn most(self, other: Self) -> Self {
                // SAFETY: as for `splat`.
                unsafe { Self($max(self.0, other.0)) }
            }

            #[inline(always)]
            fn lt(self, other: Self) -> u32 {
                // SAFETY: as for `splat`.
                unsafe { $mask($lt(self.0, other.0)) }
            }

            #[inline(always)]
            fn le(self, other: Self) -> u32 {
                // SAFETY: as for `splat`.
                unsafe { $mask($le(self.0, other.0)) }
            }

            #[inline(always)]
            fn prefetch_at(at: *const u8, bytes: usize) {
                fetch(at, bytes);
            }

            $($more)*
        }
    };
}

/// The quick operations. As whole numbers the bits of two numbers have the order of the numbers, unless both are
/// negative; and that takes one cycle where numbers take four.
macro_rules! quick {
    ($max:ident, $min:ident, $bits:ident, $number:ident, |$a:ident, $b:ident| $le:expr) => {
        const QUICK: bool = true;

        #[inline(always)]
        fn quick_most(self, other: Self) -> Self {
            // SAFETY: as for `splat`.
            unsafe { Self($number($max($bits(self.0), $bits(other.0)))) }
        }

        #[inline(always)]
        fn quick_least(self, other: Self) -> Self {
            // SAFETY: as for `splat`.
            unsafe { Self($number($min($bits(self.0), $bits(other.0)))) }
        }

        #[inline(always)]
        fn quick_le(self, other: Self) -> u32 {
            // SAFETY: as for `splat`.
            unsafe {
                let ($a, $b) = ($bits(self.0), $bits(other.0));
                $le
            }
        }
    };
}

/// All four lanes have alike.
macro_rules! four {
    ($type:ident, $($rest:tt)*) => {
        lanes!(
            $type, 4, _mm_set1_ps, _mm_loadu_ps, _mm_storeu_ps, _mm_min_ps, _mm_max_ps, _mm_and_ps, _mm_andnot_ps,
            _mm_or_ps, _mm_xor_ps, _mm_srai_epi32::<31>, _mm_castps_si128, _mm_castsi128_ps, $($rest)*
        );
    };
}

/// All eight lanes have alike.
macro_rules! eight {
    ($type:ident, $($rest:tt)*) => {
        lanes!(
            $type, 8, _mm256_set1_ps, _mm256_loadu_ps, _mm256_storeu_ps, _mm256_min_ps, _mm256_max_ps, _mm256_and_ps,
            _mm256_andnot_ps, _mm256_or_ps, _mm256_xor_ps, _mm256_srai_epi32::<31>, _mm256_castps_si256, _mm256_castsi256_ps, $($rest)*
        );
    };
}

/// The bits of a comparison of four.
macro_rules! signs {
    () => {
        |all| _mm_movemask_ps(all).cast_unsigned()
    };
}

/// The bits of a comparison of eight.
macro_rules! signs256 {
    () => {
        |all| _mm256_movemask_ps(all).cast_unsigned()
    };
}

four!(Sse, sse2, _mm_cmplt_ps, _mm_cmple_ps, signs!(), {
    across!();
});
four!(Sse41, sse41, _mm_cmplt_ps, _mm_cmple_ps, signs!(), {
    across!();
    quick!(_mm_max_epi32, _mm_min_epi32, _mm_castps_si128, _mm_castsi128_ps, |a, b| {
        !_mm_movemask_ps(_mm_castsi128_ps(_mm_cmpgt_epi32(a, b))).cast_unsigned() & 15
    });
});
four!(Avx4, avx2, _mm_cmplt_ps, _mm_cmple_ps, signs!(), {
    across!();
    quick!(_mm_max_epi32, _mm_min_epi32, _mm_castps_si128, _mm_castsi128_ps, |a, b| {
        !_mm_movemask_ps(_mm_castsi128_ps(_mm_cmpgt_epi32(a, b))).cast_unsigned() & 15
    });
});
eight!(Avx, avx2, _mm256_cmp_ps::<_CMP_LT_OQ>, _mm256_cmp_ps::<_CMP_LE_OQ>, signs256!(), {
    across256!();
    quick!(_mm256_max_epi32, _mm256_min_epi32, _mm256_castps_si256, _mm256_castsi256_ps, |a, b| {
        !_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpgt_epi32(a, b))).cast_unsigned() & 255
    });
});
