//! Every number cast of the crate, so that each has one place to be right.
//!
//! Indices in a blob are `u32`; slices want `usize`. Targets whose `usize` is narrower than 32 bits are refused below,
//! which makes [`index`] lossless. No index is ever trusted for memory safety: it goes through `get`.

#![allow(
    clippy::as_conversions,
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::cast_lossless,
    clippy::cast_sign_loss
)]

#[cfg(target_pointer_width = "16")]
compile_error!("flashray needs a usize of at least 32 bits");

/// A blob index as a slice index.
#[inline(always)]
#[must_use]
pub const fn index(i: u32) -> usize {
    i as usize
}

/// A length as a blob number; lengths past `u32::MAX` become `u32::MAX`, which every limit is below.
#[inline]
#[must_use]
pub const fn count(n: usize) -> u32 {
    if n > index(u32::MAX) { u32::MAX } else { n as u32 }
}

/// The lowest 8 bits.
#[inline(always)]
#[must_use]
pub const fn byte(n: usize) -> u8 {
    n as u8
}

/// A count as a weight in a cost formula; exact to 2^24 and rounded beyond.
#[cfg(feature = "build")]
#[inline]
#[must_use]
pub const fn weight(n: usize) -> f32 {
    n as f32
}

/// A small number as f32; exact to 2^24.
#[inline(always)]
#[must_use]
pub const fn float(n: u32) -> f32 {
    n as f32
}

/// The whole part of a number from 0; 0 for NaN, `u32::MAX` for what is larger.
#[inline(always)]
#[must_use]
pub const fn floor(x: f32) -> u32 {
    x as u32
}

/// An exact f32 as f64.
#[inline]
#[must_use]
pub const fn wide(x: f32) -> f64 {
    x as f64
}

/// The nearest f32.
#[inline]
#[must_use]
pub const fn narrow(x: f64) -> f32 {
    x as f32
}

/// Bytes of `n` entries of `size` bytes, if that fits in `u32`.
#[cfg(feature = "build")]
#[inline]
#[must_use]
pub const fn bytes_of(n: u32, size: u32) -> Option<u32> {
    n.checked_mul(size)
}
