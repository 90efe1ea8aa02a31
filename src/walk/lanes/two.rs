//! Twice as many lanes: two halves.
use super::{Lanes, Work};
use core::ops::{Add, Div, Mul, Sub};

/// Sixteen lanes as two times eight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Two<L>(L, L);

/// An operator on both halves.
macro_rules! halves {
    ($trait:ident, $name:ident) => {
        impl<L: Lanes<8>> $trait for Two<L> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(self.0.$name(other.0), self.1.$name(other.1))
            }
        }
    };
}

halves!(Add, add);
halves!(Sub, sub);
halves!(Mul, mul);
halves!(Div, div);

impl<L: Lanes<8>> Lanes<16> for Two<L> {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self(L::splat(x), L::splat(x))
    }

    #[inline(always)]
    fn load(row: &[f32; 16]) -> Self {
        let ([a, b], _) = row.as_chunks::<8>() else { return Self::splat(0.0) };
        Self(L::load(a), L::load(b))
    }

    #[inline(always)]
    fn store(self) -> [f32; 16] {
        let mut row = [0.0; 16];
        if let ([a, b], _) = row.as_chunks_mut::<8>() {
            (*a, *b) = (self.0.store(), self.1.store());
        }
        row
    }

    #[inline(always)]
    fn call<W: Work>(work: W) -> W::Output {
        L::call(work)
    }

    #[inline(always)]
    fn negative(self) -> Self {
        Self(self.0.negative(), self.1.negative())
    }

    #[inline(always)]
    fn exchanged(self, other: Self, mask: Self) -> (Self, Self) {
        let ((a, c), (b, d)) = (self.0.exchanged(other.0, mask.0), self.1.exchanged(other.1, mask.1));
        (Self(a, b), Self(c, d))
    }

    #[inline(always)]
    fn columns([a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p]: [&[f32; 8]; 16]) -> [Self; 8] {
        let (low, high) = (L::columns([a, b, c, d, e, f, g, h]), L::columns([i, j, k, l, m, n, o, p]));
        let mut all = [Self(low[0], high[0]); 8];
        for k in 0..8 {
            all[k] = Self(low[k], high[k]);
        }
        all
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1.abs())
    }

    #[inline(always)]
    fn signed_as(self, other: Self) -> Self {
        Self(self.0.signed_as(other.0), self.1.signed_as(other.1))
    }

    #[inline(always)]
    fn least(self, other: Self) -> Self {
        Self(self.0.least(other.0), self.1.least(other.1))
    }

    #[inline(always)]
    fn most(self, other: Self) -> Self {
        Self(self.0.most(other.0), self.1.most(other.1))
    }

    #[inline(always)]
    fn lt(self, other: Self) -> u32 {
        self.0.lt(other.0) | self.1.lt(other.1) << 8
    }

    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        self.0.le(other.0) | self.1.le(other.1) << 8
    }

    #[inline(always)]
    fn choose(lanes: u32, yes: Self, no: Self) -> Self {
        Self(L::choose(lanes, yes.0, no.0), L::choose(lanes >> 8, yes.1, no.1))
    }

    #[inline(always)]
    fn greatest(self) -> f32 {
        self.0.most(self.1).greatest()
    }

    #[inline(always)]
    fn smallest(self) -> f32 {
        self.0.least(self.1).smallest()
    }
}
