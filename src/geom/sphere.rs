//! Spheres.
//!
//! The test works in units of the radius from the point of the ray nearest to the centre, which keeps the discriminant
//! free of the cancellation of the textbook formula (Haines, Guenther, Akenine-Moeller, "Precision Improvements for
//! Ray/Sphere Intersection", Ray Tracing Gems, chapter 7, 2019) and of overflow at any scale.
use super::aabb::Aabb;
use super::ray::Prepared;
use super::root::sqrt;
use super::vec::{add_scaled, dot, in_units, sub};
use bytemuck::{Pod, Zeroable};

/// A sphere: the surface only, crossed up to twice by a ray.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Sphere {
    /// Centre, in scene units.
    pub center: [f32; 3],
    /// Radius, in scene units; 0 or more. A sphere of radius 0 is never hit, nor need one be by a ray that starts
    /// farther than 1e38 radii away.
    pub radius: f32,
}

impl Sphere {
    /// The sphere's bounding box.
    #[inline]
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        let r = [self.radius; 3];
        Aabb { min: sub(self.center, r), max: add_scaled(self.center, 1.0, r) }
    }

    /// The nearest crossing in `[t_min, t_max]`.
    #[inline]
    #[must_use]
    pub fn crossing(&self, ray: &Prepared, t_max: f32) -> Option<f32> {
        let own = ray.slab(&self.bounds());
        if !ray.could_admit(own, t_max) {
            return None;
        }
        let (dir, to_t) = ray.scaled_dir();
        let [from] = in_units([sub(ray.origin, self.center)], self.radius);
        let a = dot(dir, dir);
        let middle = -dot(from, dir) / a;
        let nearest = add_scaled(from, middle, dir);
        let rest = 1.0 - dot(nearest, nearest);
        // Also false for the NaN of a radius of 0.
        if !(rest >= 0.0) {
            return None;
        }
        let half = sqrt(rest / a);
        // In units of the radius and of the scaled direction; a negative `to_t` swaps the two ends.
        let (one, two) = (((middle - half) * self.radius) * to_t, ((middle + half) * self.radius) * to_t);
        let (first, last) = if one < two { (one, two) } else { (two, one) };
        ray.admit(first, own, t_max).or_else(|| ray.admit(last, own, t_max))
    }
}
