//! 64-bit Arm: four lanes of NEON, which every such machine has. (32-bit Arm's makes denormal numbers 0: not used.)
//!
//! # Safety
//! A call of an intrinsic is sound where the machine has the instruction, and every machine of this architecture has
//! these.
use super::pair::{Half, Pair};
use super::{Lanes, Work};
use core::arch::aarch64::{
    float32x4_t, int32x4_t, uint32x4_t, vabsq_f32, vaddq_f32, vaddvq_u32, vandq_u32, vbslq_f32, vcgtq_f32, vcleq_f32,
    vcleq_s32, vcltq_f32, vdivq_f32, vdupq_n_f32, vdupq_n_u32, vld1q_f32, vld1q_u32, vmaxq_s32, vminq_s32, vmulq_f32,
    vorrq_u32, vreinterpretq_f32_s32, vreinterpretq_f32_u32, vreinterpretq_s32_f32, vreinterpretq_u32_f32, vshrq_n_s32,
    vst1q_f32, vsubq_f32,
};
use core::ops::{Add, Div, Mul, Sub};

/// Does the work with eight lanes as two times four.
#[inline(never)]
pub(super) fn neon<W: Work>(work: W) -> W::Output {
    work.run::<Pair<Neon>, Neon>()
}

/// Four lanes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Neon(float32x4_t);

/// The bits of lanes by number.
const BITS: [[u32; 4]; 2] = [[1, 2, 4, 8], [16, 32, 64, 128]];

/// One bit a lane, of the four and of the four above them, where the comparisons say yes.
#[inline(always)]
fn bits([low, high]: [uint32x4_t; 2]) -> u32 {
    // SAFETY: every machine has it; the loads take as many numbers as their rows have.
    unsafe {
        let (low, high) = (vandq_u32(low, vld1q_u32(BITS[0].as_ptr())), vandq_u32(high, vld1q_u32(BITS[1].as_ptr())));
        vaddvq_u32(vorrq_u32(low, high))
    }
}

/// The bits as whole numbers.
#[inline(always)]
fn whole(of: Neon) -> int32x4_t {
    // SAFETY: every machine has it.
    unsafe { vreinterpretq_s32_f32(of.0) }
}

impl Half for Neon {
    // One sum across for both.
    #[inline(always)]
    fn lt_both([a, b]: [Self; 2], [c, d]: [Self; 2]) -> u32 {
        // SAFETY: every machine has it.
        bits(unsafe { [vcltq_f32(a.0, c.0), vcltq_f32(b.0, d.0)] })
    }

    #[inline(always)]
    fn le_both([a, b]: [Self; 2], [c, d]: [Self; 2]) -> u32 {
        // SAFETY: every machine has it.
        bits(unsafe { [vcleq_f32(a.0, c.0), vcleq_f32(b.0, d.0)] })
    }

    #[inline(always)]
    fn quick_le_both([a, b]: [Self; 2], [c, d]: [Self; 2]) -> u32 {
        // SAFETY: every machine has it.
        bits(unsafe { [vcleq_s32(whole(a), whole(c)), vcleq_s32(whole(b), whole(d))] })
    }
}

impl Lanes<4> for Neon {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: every machine has it.
        Self(unsafe { vdupq_n_f32(x) })
    }

    #[inline(always)]
    fn load(row: &[f32; 4]) -> Self {
        // SAFETY: every machine has it; it reads as many numbers as the row has, and needs no alignment.
        Self(unsafe { vld1q_f32(row.as_ptr()) })
    }

    #[inline(always)]
    fn store(self) -> [f32; 4] {
        let mut row = [0.0; 4];
        // SAFETY: every machine has it; it writes as many numbers as the row has, and needs no alignment.
        unsafe { vst1q_f32(row.as_mut_ptr(), self.0) };
        row
    }

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: every machine has it.
        Self(unsafe { vabsq_f32(self.0) })
    }

    #[inline(always)]
    fn signed_as(self, other: Self) -> Self {
        // SAFETY: every machine has it.
        unsafe {
            let (own, other) = (vreinterpretq_u32_f32(self.0), vreinterpretq_u32_f32(other.0));
            Self(vreinterpretq_f32_u32(vorrq_u32(own, vandq_u32(other, vdupq_n_u32(1 << 31)))))
        }
    }

    // A comparison and a choice: FMIN and FMAX would give NaN where one operand is, and order the zeros.
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        // SAFETY: every machine has it.
        Self(unsafe { vbslq_f32(vcltq_f32(self.0, other.0), self.0, other.0) })
    }

    #[inline(always)]
    fn most(self, other: Self) -> Self {
        // SAFETY: every machine has it.
        Self(unsafe { vbslq_f32(vcgtq_f32(self.0, other.0), self.0, other.0) })
    }

    #[inline(always)]
    fn lt(self, other: Self) -> u32 {
        // SAFETY: every machine has it.
        bits(unsafe { [vcltq_f32(self.0, other.0), vdupq_n_u32(0)] })
    }

    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        // SAFETY: every machine has it.
        bits(unsafe { [vcleq_f32(self.0, other.0), vdupq_n_u32(0)] })
    }

    #[inline(always)]
    fn negative(self) -> Self {
        // SAFETY: every machine has it.
        Self(unsafe { vreinterpretq_f32_s32(vshrq_n_s32::<31>(whole(self))) })
    }

    #[inline(always)]
    fn exchanged(self, other: Self, mask: Self) -> (Self, Self) {
        // SAFETY: every machine has it.
        unsafe {
            let mask = vreinterpretq_u32_f32(mask.0);
            (Self(vbslq_f32(mask, other.0, self.0)), Self(vbslq_f32(mask, self.0, other.0)))
        }
    }

    const QUICK: bool = true;

    // As whole numbers: see `x86`. Here that spares the choice.
    #[inline(always)]
    fn quick_most(self, other: Self) -> Self {
        // SAFETY: every machine has it.
        Self(unsafe { vreinterpretq_f32_s32(vmaxq_s32(whole(self), whole(other))) })
    }

    #[inline(always)]
    fn quick_least(self, other: Self) -> Self {
        // SAFETY: every machine has it.
        Self(unsafe { vreinterpretq_f32_s32(vminq_s32(whole(self), whole(other))) })
    }

    #[inline(always)]
    fn quick_le(self, other: Self) -> u32 {
        // SAFETY: every machine has it.
        bits(unsafe { [vcleq_s32(whole(self), whole(other)), vdupq_n_u32(0)] })
    }

    #[inline(always)]
    fn call<W: Work>(work: W) -> W::Output {
        neon(work)
    }

    #[inline(always)]
    fn prefetch_at(at: *const u8, bytes: usize) {
        for line in (0..bytes).step_by(64) {
            // SAFETY: a prefetch reads nothing that a program can see.
            unsafe {
                core::arch::asm!(
                    "prfm pldl1keep, [{at}]",
                    at = in(reg) at.wrapping_add(line),
                    options(nostack, preserves_flags, readonly)
                );
            }
        }
    }
}

/// An operator.
macro_rules! operator {
    ($trait:ident, $name:ident, $intrinsic:ident) => {
        impl $trait for Neon {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: every machine has it.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    };
}

operator!(Add, add, vaddq_f32);
operator!(Sub, sub, vsubq_f32);
operator!(Mul, mul, vmulq_f32);
operator!(Div, div, vdivq_f32);
