//! Lanes without instructions of their own: one number after another.
use super::{Lanes, Work};
use crate::geom::vec;
use core::ops::{Add, Div, Mul, Sub};

/// A row of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row<const N: usize>(pub [f32; N]);

/// Does the work with rows.
// Out of line as for the others, so that a query's stack is that of one of them.
#[inline(never)]
pub(super) fn run<W: Work>(work: W) -> W::Output {
    work.run::<Row<8>, Row<4>>()
}

impl<const N: usize> Row<N> {
    // Plain loops over numbers of lanes: compilers unroll them, and make what vectors they can of them.
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let mut row = [0.0; N];
        for i in 0..N {
            row[i] = f(self.0[i], other.0[i]);
        }
        Self(row)
    }

    #[inline(always)]
    fn bits(self, other: Self, f: impl Fn(f32, f32) -> bool) -> u32 {
        let mut bits = 0;
        for i in 0..N {
            bits |= u32::from(f(self.0[i], other.0[i])) << i;
        }
        bits
    }
}

impl<const N: usize> Lanes<N> for Row<N> {
    const AT_ONCE: bool = false;

    #[inline(always)]
    fn call<W: Work>(work: W) -> W::Output {
        run(work)
    }

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; N])
    }

    #[inline(always)]
    fn load(row: &[f32; N]) -> Self {
        Self(*row)
    }

    #[inline(always)]
    fn store(self) -> [f32; N] {
        self.0
    }

    #[inline(always)]
    fn negative(self) -> Self {
        Self(self.0.map(|x| f32::from_bits(if x.is_sign_negative() { u32::MAX } else { 0 })))
    }

    #[inline(always)]
    fn exchanged(self, other: Self, mask: Self) -> (Self, Self) {
        let (mut a, mut b) = (self, other);
        for i in 0..N {
            if mask.0[i].to_bits() != 0 {
                core::mem::swap(&mut a.0[i], &mut b.0[i]);
            }
        }
        (a, b)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }

    #[inline(always)]
    fn signed_as(self, other: Self) -> Self {
        self.zip(other, f32::copysign)
    }

    #[inline(always)]
    fn least(self, other: Self) -> Self {
        self.zip(other, vec::least)
    }

    #[inline(always)]
    fn most(self, other: Self) -> Self {
        self.zip(other, vec::most)
    }

    #[inline(always)]
    fn lt(self, other: Self) -> u32 {
        self.bits(other, |a, b| a < b)
    }

    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        self.bits(other, |a, b| a <= b)
    }
}

/// An operator.
macro_rules! operator {
    ($trait:ident, $name:ident) => {
        impl<const N: usize> $trait for Row<N> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                self.zip(other, $trait::$name)
            }
        }
    };
}

operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);
