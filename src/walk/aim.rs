//! What the test of a block reads of a ray.
use super::prepare::Given;
use crate::geom::Triangle;
use crate::geom::hit::Crossing;
use crate::geom::place::Place;
use crate::geom::ray::{Axis, Prepared};
use crate::geom::vec::Vec3;

/// What the test reads of a ray, wherever that stands.
pub trait Aim: Copy {
    /// `kx`, `ky` and `kz` of [`Prepared`].
    fn axes(self) -> [Axis; 3];
    /// `turned` of [`Prepared`].
    fn turned(self) -> Vec3;
    /// `shear` of [`Prepared`].
    fn shear(self) -> [f32; 2];
    /// `doubt` of [`Prepared`].
    fn doubt(self) -> f32;
    /// `near_origin` of [`Prepared`].
    fn near_origin(self) -> Vec3;
    /// `far_origin` of [`Prepared`].
    fn far_origin(self) -> Vec3;
    /// `inv` of [`Prepared`].
    fn inv(self) -> Vec3;
    /// `inv_kz` of [`Prepared`].
    fn inv_kz(self) -> f32;
    /// `t_min` of [`Prepared`].
    fn t_min(self) -> f32;
    /// Where all of it comes from.
    type Source: Source;
    /// Where all of it comes from. Seldom needed, and much of it for nothing else.
    fn source(self) -> Self::Source;
    /// The one-triangle test.
    fn meets(self, triangle: &Triangle, t_max: f32) -> Option<Crossing>;
}

/// What makes a ray whole again, out of line: what of a ray only that needs takes no registers in the meantime.
pub trait Source: Copy {
    /// The ray; always the same.
    fn prepared(self) -> Option<Prepared>;
}

impl Source for Prepared {
    #[inline(always)]
    fn prepared(self) -> Option<Prepared> {
        Some(self)
    }
}

impl Source for (&Given, &Place<'_>) {
    #[inline(always)]
    fn prepared(self) -> Option<Prepared> {
        Prepared::new(&self.0.ray(), self.1)
    }
}

/// What is known of a prepared ray besides: nothing, or what it was prepared from.
pub trait Known: Copy {
    /// Where all of the ray comes from.
    type Source: Source;
    /// Where all of the ray comes from.
    fn source(self, ray: &Prepared) -> Self::Source;
}

impl Known for () {
    type Source = Prepared;
    #[inline(always)]
    fn source(self, ray: &Prepared) -> Prepared {
        *ray
    }
}

impl Known for (&Given, &Place<'_>) {
    type Source = Self;
    #[inline(always)]
    fn source(self, _: &Prepared) -> Self {
        self
    }
}

impl<K: Known> Aim for (&Prepared, K) {
    type Source = K::Source;
    #[inline(always)]
    fn axes(self) -> [Axis; 3] {
        [self.0.kx, self.0.ky, self.0.kz]
    }
    #[inline(always)]
    fn turned(self) -> Vec3 {
        self.0.turned()
    }
    #[inline(always)]
    fn shear(self) -> [f32; 2] {
        self.0.shear
    }
    #[inline(always)]
    fn doubt(self) -> f32 {
        self.0.doubt
    }
    #[inline(always)]
    fn near_origin(self) -> Vec3 {
        self.0.near_origin
    }
    #[inline(always)]
    fn far_origin(self) -> Vec3 {
        self.0.far_origin
    }
    #[inline(always)]
    fn inv(self) -> Vec3 {
        self.0.inv
    }
    #[inline(always)]
    fn inv_kz(self) -> f32 {
        self.0.inv_kz
    }
    #[inline(always)]
    fn t_min(self) -> f32 {
        self.0.t_min
    }
    #[inline(always)]
    fn source(self) -> K::Source {
        self.1.source(self.0)
    }
    #[inline(always)]
    fn meets(self, triangle: &Triangle, t_max: f32) -> Option<Crossing> {
        triangle.crossing(self.0, t_max)
    }
}
