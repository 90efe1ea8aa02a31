//! What all walks share: the best hit so far, the budget, and the primitives of a leaf.
//!
//! A walk is one loop, with closest or any hit as a const parameter. It never relies on the full check for its safety:
//! every index goes through `get`, every push can be refused, and every step is paid from a [`Meter`]. Where one of
//! these fails the walk says [`Stop`].

pub(crate) mod aim;
pub mod block;
pub mod dda;
pub(crate) mod group;
pub(crate) mod heading;
pub mod lanes;
mod leaf;
pub mod mailbox;
mod meter;
pub(crate) mod packet;
pub(crate) mod prepare;

pub use crate::wide::STREAM_SCRATCH;
pub use group::SCRATCH as GROUP_SCRATCH;
pub use heading::PacketSize;
pub use lanes::Isa;
pub use leaf::{test, test_listed};
pub use mailbox::Mailbox;
pub use meter::{Fuel, Meter, Part, Steps, Tally};

use crate::geom::Hit;
use crate::geom::hit::Crossing;
use core::fmt;

/// Why a query ended without an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Stop {
    /// The caller's fuel ran out.
    Fuel,
    /// The bytes contradict themselves: they were not checked, or have changed since.
    Corrupt,
}

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Fuel => "the query ran out of fuel",
            Self::Corrupt => "the blob contradicts itself",
        })
    }
}

impl core::error::Error for Stop {}

/// Number of no primitive: blobs hold fewer than 2^28.
pub const NO_PRIM: u32 = u32::MAX;

/// The best hit so far; with no primitive yet, `t` is the ray's `t_max`.
#[derive(Clone, Copy, Debug)]
pub struct Best {
    /// Distance to beat.
    pub t: f32,
    u: f32,
    v: f32,
    prim: u32,
}

impl Best {
    /// All zeros, to be written over.
    pub const ZERO: Self = Self { t: 0.0, u: 0.0, v: 0.0, prim: 0 };

    /// Nothing yet, up to `t_max`.
    #[inline(always)]
    #[must_use]
    pub const fn new(t_max: f32) -> Self {
        Self { t: t_max, u: 0.0, v: 0.0, prim: NO_PRIM }
    }

    /// Takes a crossing with `t` not beyond the best: at equal `t` the least primitive number stays.
    #[inline(always)]
    pub fn offer(&mut self, c: Crossing, prim: u32) {
        if c.t < self.t || prim < self.prim {
            *self = Self { t: c.t, u: c.u, v: c.v, prim };
        }
    }

    /// The hit, if there is one.
    #[inline(always)]
    #[must_use]
    pub fn hit(&self) -> Option<Hit> {
        let Self { t, u, v, prim } = *self;
        (prim != NO_PRIM).then_some(Hit { t, u, v, prim })
    }
}
