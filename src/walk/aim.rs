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

/// A ray by itself, and what it was prepared from.
#[derive(Clone, Copy)]
pub(crate) struct Single<'r> {
    pub ray: &'r Prepared,
    pub given: &'r Given,
    pub place: &'r Place<'r>,
}

impl Source for (&Given, &Place<'_>) {
    #[inline(always)]
    fn prepared(self) -> Option<Prepared> {
        Prepared::new(&self.0.ray(), self.1)
    }
}

impl Aim for &Prepared {
    type Source = Prepared;
    #[inline(always)]
    fn axes(self) -> [Axis; 3] {
        [self.kx, self.ky, self.kz]
    }
    #[inline(always)]
    fn turned(self) -> Vec3 {
        self.turned()
    }
    #[inline(always)]
    fn shear(self) -> [f32; 2] {
        self.shear
    }
    #[inline(always)]
    fn doubt(self) -> f32 {
        self.doubt
    }
    #[inline(always)]
    fn near_origin(self) -> Vec3 {
        self.near_origin
    }
    #[inline(always)]
    fn far_origin(self) -> Vec3 {
        self.far_origin
    }
    #[inline(always)]
    fn inv(self) -> Vec3 {
        self.inv
    }
    #[inline(always)]
    fn inv_kz(self) -> f32 {
        self.inv_kz
    }
    #[inline(always)]
    fn t_min(self) -> f32 {
        self.t_min
    }
    #[inline(always)]
    fn source(self) -> Prepared {
        *self
    }
    #[inline(always)]
    fn meets(self, triangle: &Triangle, t_max: f32) -> Option<Crossing> {
        triangle.crossing(self, t_max)
    }
}

impl<'r> Aim for Single<'r> {
    type Source = (&'r Given, &'r Place<'r>);
    #[inline(always)]
    fn axes(self) -> [Axis; 3] {
        self.ray.axes()
    }
    #[inline(always)]
    fn turned(self) -> Vec3 {
        self.ray.turned()
    }
    #[inline(always)]
    fn shear(self) -> [f32; 2] {
        self.ray.shear
    }
    #[inline(always)]
    fn doubt(self) -> f32 {
        self.ray.doubt
    }
    #[inline(always)]
    fn near_origin(self) -> Vec3 {
        self.ray.near_origin
    }
    #[inline(always)]
    fn far_origin(self) -> Vec3 {
        self.ray.far_origin
    }
    #[inline(always)]
    fn inv(self) -> Vec3 {
        self.ray.inv
    }
    #[inline(always)]
    fn inv_kz(self) -> f32 {
        self.ray.inv_kz
    }
    #[inline(always)]
    fn t_min(self) -> f32 {
        self.ray.t_min
    }
    #[inline(always)]
    fn source(self) -> Self::Source {
        (self.given, self.place)
    }
    #[inline(always)]
    fn meets(self, triangle: &Triangle, t_max: f32) -> Option<Crossing> {
        triangle.crossing(self.ray, t_max)
    }
}
