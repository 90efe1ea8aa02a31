//! WebAssembly: four lanes of `simd128`, where the module is built for it. A module with one such instruction loads
//! nowhere without them all, so there is nothing to ask at run time.
//!
//! The intrinsics are safe to call: a module that reaches this machine's compiler has passed its test.
use super::pair::{Half, Pair};
use super::{Lanes, Work};
use core::arch::wasm32::{
    f32x4, f32x4_abs, f32x4_add, f32x4_div, f32x4_extract_lane, f32x4_le, f32x4_lt, f32x4_mul, f32x4_pmax, f32x4_pmin,
    f32x4_splat, f32x4_sub, i32x4_bitmask, i32x4_le, i32x4_max, i32x4_min, i32x4_shr, v128, v128_and, v128_bitselect,
    v128_or,
};
use core::ops::{Add, Div, Mul, Sub};

/// Does the work with eight lanes as two times four.
#[inline(never)]
pub(super) fn simd128<W: Work>(work: W) -> W::Output {
    work.run::<Pair<Simd>, Simd>()
}

/// Four lanes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Simd(v128);

impl Half for Simd {}

impl Lanes<4> for Simd {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self(f32x4_splat(x))
    }

    #[inline(always)]
    fn load(&[a, b, c, d]: &[f32; 4]) -> Self {
        Self(f32x4(a, b, c, d))
    }

    #[inline(always)]
    fn store(self) -> [f32; 4] {
        let all = self.0;
        [
            f32x4_extract_lane::<0>(all),
            f32x4_extract_lane::<1>(all),
            f32x4_extract_lane::<2>(all),
            f32x4_extract_lane::<3>(all),
        ]
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(f32x4_abs(self.0))
    }

    #[inline(always)]
    fn signed_as(self, other: Self) -> Self {
        Self(v128_or(self.0, v128_and(other.0, f32x4_splat(-0.0))))
    }

    // `pmin` and `pmax` give their first operand where the two are unordered or equal; this gives the second.
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        Self(f32x4_pmin(other.0, self.0))
    }

    #[inline(always)]
    fn most(self, other: Self) -> Self {
        Self(f32x4_pmax(other.0, self.0))
    }

    #[inline(always)]
    fn lt(self, other: Self) -> u32 {
        u32::from(i32x4_bitmask(f32x4_lt(self.0, other.0)))
    }

    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        u32::from(i32x4_bitmask(f32x4_le(self.0, other.0)))
    }

    #[inline(always)]
    fn negative(self) -> Self {
        Self(i32x4_shr(self.0, 31))
    }

    #[inline(always)]
    fn exchanged(self, other: Self, mask: Self) -> (Self, Self) {
        let choose = |a: Self, b: Self| Self(v128_bitselect(a.0, b.0, mask.0));
        (choose(other, self), choose(self, other))
    }

    const QUICK: bool = true;

    // As whole numbers: see `x86`.
    #[inline(always)]
    fn quick_most(self, other: Self) -> Self {
        Self(i32x4_max(self.0, other.0))
    }

    #[inline(always)]
    fn quick_least(self, other: Self) -> Self {
        Self(i32x4_min(self.0, other.0))
    }

    #[inline(always)]
    fn quick_le(self, other: Self) -> u32 {
        u32::from(i32x4_bitmask(i32x4_le(self.0, other.0)))
    }

    #[inline(always)]
    fn call<W: Work>(work: W) -> W::Output {
        simd128(work)
    }
}

/// An operator.
macro_rules! operator {
    ($trait:ident, $name:ident, $intrinsic:ident) => {
        impl $trait for Simd {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self($intrinsic(self.0, other.0))
            }
        }
    };
}

operator!(Add, add, f32x4_add);
operator!(Sub, sub, f32x4_sub);
operator!(Mul, mul, f32x4_mul);
operator!(Div, div, f32x4_div);
