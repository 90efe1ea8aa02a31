//! Lanes: the same operation on several numbers at once.
//!
//! A walk that tests several boxes or triangles at a time is written once, over [`Lanes`], and compiled once for each
//! instruction set ([`Isa`]). Each operation is that of IEEE 754 on every lane, and none is fused with another, so all
//! instruction sets give the same bits.
//!
//! An [`Isa`] can only be had on a machine that has those instructions: it is what allows `Isa::run` to call code that
//! uses them. So nothing is asked per ray: a scene asks once, when it is loaded.

#[cfg(target_arch = "aarch64")]
#[allow(unsafe_code)]
mod arm;
// Rows are all that a machine without these has.
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64", all(target_arch = "wasm32", target_feature = "simd128")))]
mod pair;
mod row;
#[cfg(test)]
mod tests;
mod two;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod wasm;
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod x86;

pub use row::Row;
pub(crate) use two::Two;

use crate::geom::vec;
use core::fmt;
use core::ops::{Add, Div, Mul, Sub};

/// `N` numbers.
#[allow(clippy::return_self_not_must_use)] // they compute and do nothing else
pub trait Lanes<const N: usize>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Whether one instruction does all lanes. Where not, it is better to do only those that count.
    const AT_ONCE: bool = true;
    /// `N` times the same.
    fn splat(x: f32) -> Self;
    /// From a row.
    fn load(row: &[f32; N]) -> Self;
    /// To a row.
    fn store(self) -> [f32; N];
    /// The columns of rows.
    #[inline(always)]
    fn columns(rows: [&[f32; 8]; N]) -> [Self; 8] {
        let mut columns = [[0.0; N]; 8];
        for i in 0..N {
            for k in 0..8 {
                columns[k][i] = rows[i][k];
            }
        }
        let [a, b, c, d, e, f, g, h] = &columns;
        [
            Self::load(a),
            Self::load(b),
            Self::load(c),
            Self::load(d),
            Self::load(e),
            Self::load(f),
            Self::load(g),
            Self::load(h),
        ]
    }
    /// Without signs.
    fn abs(self) -> Self;
    /// With the signs of `other`; none may have one.
    fn signed_as(self, other: Self) -> Self;
    /// The lesser of each pair; `other`'s where they are unordered or equal.
    fn least(self, other: Self) -> Self;
    /// The greater of each pair; `other`'s where they are unordered or equal.
    fn most(self, other: Self) -> Self;
    /// Where `self < other`: one bit a lane, lane 0 the lowest.
    fn lt(self, other: Self) -> u32;
    /// Where `self <= other`.
    fn le(self, other: Self) -> u32;
    /// All bits of a lane on where its sign is minus, else none.
    fn negative(self) -> Self;
    /// The two, and exchanged where the bits of `mask` are on.
    fn exchanged(self, other: Self, mask: Self) -> (Self, Self);
    /// Whether the quick operations below differ from the others.
    const QUICK: bool = false;
    /// The greater of each pair, if not both have a minus sign and neither is NaN; else any that has. On some machines
    /// quicker than [`Lanes::most`]. All [`Lanes::quick_le`] and what its operands come from regards `-0.0` as negative.
    #[inline(always)]
    fn quick_most(self, other: Self) -> Self {
        self.most(other)
    }
    /// The lesser of each pair, if neither has a minus sign or is NaN; else any that has.
    #[inline(always)]
    fn quick_least(self, other: Self) -> Self {
        self.least(other)
    }
    /// Where `self <= other`, if `self` has no minus sign and neither is NaN. `-0.0` is less than `0.0` on some machines.
    #[inline(always)]
    fn quick_le(self, other: Self) -> u32 {
        self.le(other)
    }
    /// Does work out of line, with the same instructions. Where a rare or long part stands in a loop, the loop keeps
    /// its registers.
    fn call<W: Work>(work: W) -> W::Output;
    /// `yes` in the lanes whose bits are on, `no` in the others.
    #[inline(always)]
    fn choose(lanes: u32, yes: Self, no: Self) -> Self {
        let (yes, mut row) = (yes.store(), no.store());
        for i in 0..N {
            if lanes >> i & 1 == 1 {
                row[i] = yes[i];
            }
        }
        Self::load(&row)
    }
    /// The greatest of all lanes, none of which may be NaN.
    #[inline(always)]
    fn greatest(self) -> f32 {
        self.store().into_iter().fold(f32::NEG_INFINITY, vec::most)
    }
    /// The least of all lanes, none of which may be NaN.
    #[inline(always)]
    fn smallest(self) -> f32 {
        self.store().into_iter().fold(f32::INFINITY, vec::least)
    }
    /// Asks for memory ahead of its use, if the machine can.
    #[inline(always)]
    fn prefetch<T>(at: &T) {
        Self::prefetch_at(core::ptr::from_ref(at).cast(), size_of::<T>());
    }
    /// The same of some bytes, which need not be there: nothing is read.
    #[inline(always)]
    fn prefetch_at(_at: *const u8, _bytes: usize) {}
}

/// Four lanes that every machine of this architecture has.
#[cfg(target_arch = "x86_64")]
pub(crate) type Four = x86::Sse;
/// Four lanes that every machine of this architecture has.
#[cfg(not(target_arch = "x86_64"))]
pub(crate) type Four = Row<4>;

/// Work that is compiled for each instruction set.
pub trait Work {
    /// What comes of it.
    type Output;

    /// Does it with lanes of eight and of four. Must be inlined, and so must all in it that handles lanes: what is called
    /// out of line is compiled for any machine, and there each operation becomes a call. A closure is out of line as the
    /// compiler likes: functions that are always inlined are not.
    fn run<L8: Lanes<8>, L4: Lanes<4>>(self) -> Self::Output;
}

/// An instruction set that this machine has.
///
/// ```
/// use flashray::walk::Isa;
/// // Every machine has at least the one that needs nothing.
/// assert!(Isa::all().any(|isa| isa == Isa::SCALAR));
/// assert!(Isa::all().any(|isa| isa == Isa::best()));
/// ```
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Isa(Level);

/// In ascending order of speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    Scalar,
    #[cfg(target_arch = "aarch64")]
    Neon,
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    Simd128,
    #[cfg(target_arch = "x86_64")]
    Sse2,
    #[cfg(target_arch = "x86_64")]
    Sse41,
    #[cfg(target_arch = "x86_64")]
    Avx2,
}

/// Every level of this architecture with its name, the fastest last.
const LEVELS: &[(Level, &str)] = &[
    (Level::Scalar, "scalar"),
    #[cfg(target_arch = "aarch64")]
    (Level::Neon, "neon"),
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    (Level::Simd128, "simd128"),
    #[cfg(target_arch = "x86_64")]
    (Level::Sse2, "sse2"),
    #[cfg(target_arch = "x86_64")]
    (Level::Sse41, "sse4.1"),
    #[cfg(target_arch = "x86_64")]
    (Level::Avx2, "avx2"),
];

/// Whether this architecture has instructions for lanes at all. Where it has none, walks do one thing after another, and only
/// what counts: that is less code, and quicker.
pub(crate) const HERE: bool = LEVELS.len() > 1;

impl Level {
    /// Whether this machine has it: asked at run time with `std`, which remembers the answer, else what the build targets.
    fn is_here(self) -> bool {
        /// All of some features of x86-64.
        #[cfg(target_arch = "x86_64")]
        macro_rules! has {
            ($($feature:tt),*) => {{
                #[cfg(feature = "std")]
                let all = $(std::arch::is_x86_feature_detected!($feature))&&*;
                #[cfg(not(feature = "std"))]
                let all = $(cfg!(target_feature = $feature))&&*;
                all
            }};
        }
        match self {
            Self::Scalar => true,
            #[cfg(target_arch = "aarch64")]
            Self::Neon => true,
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Self::Simd128 => true,
            #[cfg(target_arch = "x86_64")]
            Self::Sse2 => true,
            #[cfg(target_arch = "x86_64")]
            Self::Sse41 => has!("sse4.1"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => has!("avx2"),
        }
    }
}

impl Isa {
    /// One number at a time: what every machine has.
    pub const SCALAR: Self = Self(Level::Scalar);

    /// All that this machine has.
    pub fn all() -> impl Iterator<Item = Self> {
        LEVELS.iter().map(|&(level, _)| level).filter(|level| level.is_here()).map(Self)
    }

    /// The fastest that this machine has.
    #[must_use]
    pub fn best() -> Self {
        Self::all().last().unwrap_or(Self::SCALAR)
    }

    /// Its name: `scalar`; `sse2`, `sse4.1`, `avx2`; `neon`; `simd128`.
    #[must_use]
    pub fn name(self) -> &'static str {
        LEVELS.iter().find(|(level, _)| *level == self.0).map_or("", |(_, name)| name)
    }

    /// Does the work with these instructions.
    #[inline(always)]
    pub(crate) fn run<W: Work>(self, work: W) -> W::Output {
        match self.0 {
            Level::Scalar => row::run(work),
            #[cfg(target_arch = "aarch64")]
            Level::Neon => arm::neon(work),
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Level::Simd128 => wasm::simd128(work),
            #[cfg(target_arch = "x86_64")]
            Level::Sse2 => x86::sse2(work),
            #[cfg(target_arch = "x86_64")]
            Level::Sse41 => x86::sse41(work),
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => x86::avx2(work),
        }
    }
}

impl fmt::Debug for Isa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
