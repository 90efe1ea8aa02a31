//! Axis-aligned boxes, as bounds and as primitives.
use super::ray::Prepared;
use super::vec::{Vec3, finite, least3, most, most3};
use bytemuck::{Pod, Zeroable};

/// An axis-aligned box: the points between `min` and `max`, both included.
///
/// As a primitive it is hollow: a ray from inside meets the wall it leaves by.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Aabb {
    /// Least corner.
    pub min: [f32; 3],
    /// Greatest corner.
    pub max: [f32; 3],
}

impl Aabb {
    /// The box of nothing: it holds no point, and any box joined with it stays as it is.
    pub const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    /// The least box around two.
    #[inline(always)]
    #[must_use]
    pub fn join(&self, other: &Self) -> Self {
        Self { min: least3(other.min, self.min), max: most3(other.max, self.max) }
    }

    /// The least box around this and a point.
    #[inline(always)]
    #[must_use]
    pub fn with(&self, p: Vec3) -> Self {
        Self { min: least3(p, self.min), max: most3(p, self.max) }
    }

    /// Whether `other` lies inside; `false` if either has a NaN.
    #[inline]
    #[must_use]
    pub fn contains(&self, other: &Self) -> bool {
        let inside = |k: usize| self.min[k] <= other.min[k] && other.max[k] <= self.max[k];
        inside(0) && inside(1) && inside(2)
    }

    /// Whether all numbers are finite and `min <= max`.
    #[inline]
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let ordered = |k: usize| self.min[k] <= self.max[k];
        finite(self.min) && finite(self.max) && ordered(0) && ordered(1) && ordered(2)
    }

    /// The nearest wall crossed in `[t_min, t_max]`. The walls are met where the exact slabs, without the pad, say.
    #[inline]
    #[must_use]
    pub fn crossing(&self, ray: &Prepared, t_max: f32) -> Option<f32> {
        let own = ray.slab(self);
        let (mut near, mut far) = (f32::NEG_INFINITY, f32::INFINITY);
        let mut axis = |k: usize| {
            let (first, last) = if ray.negative[k] { (self.max[k], self.min[k]) } else { (self.min[k], self.max[k]) };
            let (first, last) = ((first - ray.origin[k]), (last - ray.origin[k]));
            // In the plane of a wall 0 x infinity is NaN, and the wall is no bound.
            near = most(first * ray.inv[k], near);
            far = super::vec::least(last * ray.inv[k], far);
        };
        axis(0);
        axis(1);
        axis(2);
        if !(near <= far) {
            return None;
        }
        ray.admit(near, own, t_max).or_else(|| ray.admit(far, own, t_max))
    }
}
