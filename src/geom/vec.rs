//! Three-component arithmetic with one stated order of operations.
//!
//! Written out here, and not taken from a vector crate, because the order and rounding of these few sums is part of
//! the answers' bits: a dependency that reassociated a dot product would change them.

/// A point or direction.
pub type Vec3 = [f32; 3];

/// `a - b`.
#[inline(always)]
pub fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a + s b`.
#[inline(always)]
pub fn add_scaled(a: Vec3, s: f32, b: Vec3) -> Vec3 {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

/// `s a`.
#[inline(always)]
pub fn scale(a: Vec3, s: f32) -> Vec3 {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// What the in-between steps of tiny lengths are multiplied by.
const LARGER: f32 = 18_446_744_073_709_551_616.0; // 2^64

/// Each of `a` in units of `unit`, by its inverse.
///
/// That of a denormal number may overflow, so that all is then made larger first, by a power of two. Behind a branch,
/// because the others need not wait for a factor of 1.
#[inline(always)]
pub fn in_units<const N: usize>(a: [Vec3; N], unit: f32) -> [Vec3; N] {
    if unit < f32::MIN_POSITIVE {
        return in_tiny_units(a, unit);
    }
    let inverse = 1.0 / unit;
    a.map(|a| scale(a, inverse))
}

#[cold]
#[inline(never)]
fn in_tiny_units<const N: usize>(a: [Vec3; N], unit: f32) -> [Vec3; N] {
    let inverse = 1.0 / (unit * LARGER);
    a.map(|a| scale(scale(a, LARGER), inverse))
}

/// `a . b`, summed x, y, z.
#[inline(always)]
pub fn dot(a: Vec3, b: Vec3) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The lesser, `b` if they are unordered.
#[inline(always)]
pub fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The greater, `b` if they are unordered.
#[inline(always)]
pub fn most(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Componentwise [`least`].
#[inline(always)]
pub fn least3(a: Vec3, b: Vec3) -> Vec3 {
    [least(a[0], b[0]), least(a[1], b[1]), least(a[2], b[2])]
}

/// Componentwise [`most`].
#[inline(always)]
pub fn most3(a: Vec3, b: Vec3) -> Vec3 {
    [most(a[0], b[0]), most(a[1], b[1]), most(a[2], b[2])]
}

/// Whether no component is NaN or infinite.
#[inline(always)]
pub fn finite(a: Vec3) -> bool {
    a[0].is_finite() && a[1].is_finite() && a[2].is_finite()
}

/// The largest size among the components.
#[inline(always)]
pub fn size(a: Vec3) -> f32 {
    most(a[2].abs(), most(a[1].abs(), a[0].abs()))
}
