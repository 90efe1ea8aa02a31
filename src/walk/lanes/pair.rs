//! Eight lanes as two times four, where four are as many as the machine has.
use super::{Lanes, Work};
use core::ops::{Add, Div, Mul, Sub};

/// Four lanes that can be half of eight.
pub(super) trait Half: Lanes<4> {
    /// [`Lanes::lt`] of eight, given as halves.
    #[inline(always)]
    fn lt_both(own: [Self; 2], other: [Self; 2]) -> u32 {
        own[0].lt(other[0]) | own[1].lt(other[1]) << 4
    }

    /// [`Lanes::le`] of eight, given as halves.
    #[inline(always)]
    fn le_both(own: [Self; 2], other: [Self; 2]) -> u32 {
        own[0].le(other[0]) | own[1].le(other[1]) << 4
    }

    /// [`Lanes::quick_le`] of eight, given as halves.
    #[inline(always)]
    fn quick_le_both(own: [Self; 2], other: [Self; 2]) -> u32 {
        own[0].quick_le(other[0]) | own[1].quick_le(other[1]) << 4
    }
}

/// The lower four lanes and the upper four.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair<H>([H; 2]);

impl<H: Half> Pair<H> {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(H, H) -> H) -> Self {
        Self([f(self.0[0], other.0[0]), f(self.0[1], other.0[1])])
    }
}

impl<H: Half> Lanes<8> for Pair<H> {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([H::splat(x); 2])
    }

    #[inline(always)]
    fn load(&[a, b, c, d, e, f, g, h]: &[f32; 8]) -> Self {
        Self([H::load(&[a, b, c, d]), H::load(&[e, f, g, h])])
    }

    #[inline(always)]
    fn store(self) -> [f32; 8] {
        let [[a, b, c, d], [e, f, g, h]] = [self.0[0].store(), self.0[1].store()];
        [a, b, c, d, e, f, g, h]
    }

    #[inline(always)]
    fn columns([a, b, c, d, e, f, g, h]: [&[f32; 8]; 8]) -> [Self; 8] {
        let (low, high) = (H::columns([a, b, c, d]), H::columns([e, f, g, h]));
        let mut all = [Self([low[0], high[0]]); 8];
        for k in 0..8 {
            all[k] = Self([low[k], high[k]]);
        }
        all
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(H::abs))
    }

    #[inline(always)]
    fn signed_as(self, other: Self) -> Self {
        self.zip(other, H::signed_as)
    }

    #[inline(always)]
    fn least(self, other: Self) -> Self {
        self.zip(other, H::least)
    }

    #[inline(always)]
    fn most(self, other: Self) -> Self {
        self.zip(other, H::most)
    }

    #[inline(always)]
    fn lt(self, other: Self) -> u32 {
        H::lt_both(self.0, other.0)
    }

    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        H::le_both(self.0, other.0)
    }

    #[inline(always)]
    fn negative(self) -> Self {
        Self(self.0.map(H::negative))
    }

    #[inline(always)]
    fn exchanged(self, other: Self, mask: Self) -> (Self, Self) {
        let [(a, c), (b, d)] = [self.0[0].exchanged(other.0[0], mask.0[0]), self.0[1].exchanged(other.0[1], mask.0[1])];
        (Self([a, b]), Self([c, d]))
    }

    const QUICK: bool = H::QUICK;

    #[inline(always)]
    fn choose(lanes: u32, yes: Self, no: Self) -> Self {
        let ([a, b], [c, d]) = (yes.0, no.0);
        Self([H::choose(lanes, a, c), H::choose(lanes >> 4, b, d)])
    }

    #[inline(always)]
    fn greatest(self) -> f32 {
        let [a, b] = self.0;
        a.most(b).greatest()
    }

    #[inline(always)]
    fn smallest(self) -> f32 {
        let [a, b] = self.0;
        a.least(b).smallest()
    }

    #[inline(always)]
    fn quick_most(self, other: Self) -> Self {
        self.zip(other, H::quick_most)
    }

    #[inline(always)]
    fn quick_least(self, other: Self) -> Self {
        self.zip(other, H::quick_least)
    }

    #[inline(always)]
    fn quick_le(self, other: Self) -> u32 {
        H::quick_le_both(self.0, other.0)
    }

    #[inline(always)]
    fn call<W: Work>(work: W) -> W::Output {
        H::call(work)
    }

    #[inline(always)]
    fn prefetch_at(at: *const u8, bytes: usize) {
        H::prefetch_at(at, bytes);
    }
}

/// An operator on both halves.
macro_rules! operator {
    ($trait:ident, $name:ident) => {
        impl<H: Half> $trait for Pair<H> {
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
