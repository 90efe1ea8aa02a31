//! Where a scene is, and how coarse: what rays are prepared against.
use super::aabb::Aabb;
use super::vec::{Vec3, most, sub};
use crate::walk::lanes;

/// Half an ulp of 1.
const U: f32 = 1.0 / 16_777_216.0;
/// In scenes smaller than this edge functions may underflow.
const TOO_SMALL: f32 = 1.0 / 549_755_813_888.0; // 2^-39

/// Where no coordinate and no origin of a ray exceeds this, relative to the scene and to its local origin, differences of them
/// are numbers, and so are the pads of rays.
const FAR: f32 = 85_070_591_730_234_615_865_843_651_857_942_052_864.0; // 2^126

/// A scene's box, its local origin, and what its triangles add to the doubt about an edge function.
#[derive(Clone, Copy, Debug)]
pub struct Place<'p> {
    pub(crate) bounds: &'p Aabb,
    pub(crate) local: Vec3,
    pub(crate) longest: f32,
    pub(crate) coarse: f32,
    /// Rays whose origin is nearer than this on every axis have finite pads; 0 in a scene that itself is so far, and where
    /// there are no lanes: there nobody asks.
    pub(crate) far: f32,
}

impl<'p> Place<'p> {
    /// A scene that lies in `bounds`, whose coordinates are relative to `local`; `longest` is the longest side of its
    /// triangles' boxes, or 0 where that is not known.
    #[must_use]
    pub fn new(bounds: &'p Aabb, local: Vec3, longest: f32) -> Self {
        let all = [bounds.min, bounds.max, local];
        let far = if lanes::HERE && all.as_flattened().iter().all(|x| x.abs() <= FAR) { FAR } else { 0.0 };
        Self { bounds, local, longest, coarse: coarse(bounds, longest), far }
    }
}

/// The longest side of a box.
#[inline]
#[must_use]
pub fn longest_side(of: &Aabb) -> f32 {
    let [x, y, z] = sub(of.max, of.min);
    most(z, most(y, x))
}

/// What [`Prepared::doubt`](super::ray::Prepared) takes of a scene: see [`super::triangle`]. Infinite for a scene so small that
/// products may underflow.
pub(crate) fn coarse(bounds: &Aabb, longest: f32) -> f32 {
    let size = longest_side(bounds);
    if !(size >= TOO_SMALL) {
        return f32::INFINITY;
    }
    let far = |k: usize| most(bounds.max[k].abs(), bounds.min[k].abs());
    let far = most(far(2), most(far(1), far(0)));
    let longest = if longest > 0.0 { longest } else { size };
    longest * 4.25 + far * (16.0 * U)
}
