//! The triangle test: watertight, and each edge and vertex owned by exactly one side.
//!
//! Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013: move the ray's origin to 0, shear
//! so that its direction becomes the `kz` axis, and ask on which side of the triangle's three edges the origin of the
//! plane lies. A vertex's place in that plane depends on the ray and the vertex alone, so triangles that share a
//! vertex agree on it, and what follows is exact:
//!
//! - An edge function is a difference of two rounded products. Rounding is monotone, so a sign other than 0 is right.
//! - Where one is 0, or overflowed, all three are computed anew in f64, where products of f32 are exact. So they are
//!   where most of their bits cancelled, as in a triangle seen almost edge-on: the signs are right then, too, but the
//!   distance made from them would not be.
//! - Where one is 0 there too, the ray goes through the edge. It is then moved, in thought, by `(e, e^2)` for an `e`
//!   below every number (Edelsbrunner and Muecke, "Simulation of Simplicity", ACM TOG 9(1), 1990): the sign becomes
//!   that of the edge's own direction. The two triangles at an edge see it in opposite directions, so exactly one
//!   side owns it, and likewise around a vertex.
//!
//! A triangle that is degenerate in the plane, seen edge-on or with two equal corners, owns no point of it: its three
//! signs can not agree, because their sum is 0. One whose distinct corners lie on a line may become a sliver in the
//! plane, as thin as the rounding; builders collapse those, so that in a blob a triangle without area is never hit.
use super::aabb::Aabb;
use super::hit::Crossing;
use super::ray::Prepared;
use super::vec::{Vec3, least, most};
use crate::num::{narrow, wide};
use bytemuck::{Pod, Zeroable};

/// A triangle by its corners. Both sides count.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Triangle {
    /// The corners, in the caller's order.
    pub v: [[f32; 3]; 3],
}

/// The sum of the edge functions must lie between these for the f32 path: outside, a division could lose bits.
pub(crate) const LEAST_DET: f32 = 1.0 / MOST_DET;
pub(crate) const MOST_DET: f32 = 1_208_925_819_614_629_174_706_176.0; // 2^80
/// The products in the edge functions may be at most so many times their sum for the f32 path.
pub(crate) const MOST_CANCELLED: f32 = 512.0;

/// A vertex in the ray's frame: its place in the sheared plane, and its depth along `kz`.
#[derive(Clone, Copy)]
struct Sheared {
    x: f32,
    y: f32,
    z: f32,
}

impl Sheared {
    #[inline(always)]
    fn new(v: Vec3, ray: &Prepared) -> Self {
        let z = v[ray.kz.at()] - ray.turned()[2];
        let x = v[ray.kx.at()] - ray.turned()[0];
        let y = v[ray.ky.at()] - ray.turned()[1];
        Self { x: x - ray.shear[0] * z, y: y - ray.shear[1] * z, z }
    }

    /// Twice the signed area of the origin and the edge from `self` to `to`, and the size of what it was made from.
    #[inline(always)]
    fn edge(self, to: Self) -> (f32, f32) {
        let (p, q) = (self.x * to.y, self.y * to.x);
        (p - q, p.abs() + q.abs())
    }

    /// The same, exact in sign, with ties broken by the symbolic shift. The flag says that the value is negative;
    /// `None` for an edge of no length, which belongs to a degenerate triangle.
    fn exact_edge(self, to: Self) -> Option<(f64, bool)> {
        let e = wide(self.x) * wide(to.y) - wide(self.y) * wide(to.x);
        match () {
            () if e < 0.0 => Some((e, true)),
            () if e > 0.0 => Some((e, false)),
            // e == 0: the shift by (e, e^2) adds e (self.y - to.y) + e^2 (to.x - self.x).
            () if self.y != to.y => Some((0.0, self.y < to.y)),
            () if self.x != to.x => Some((0.0, to.x < self.x)),
            () => None,
        }
    }

    fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.z.is_finite()
    }
}

impl Triangle {
    /// The triangle's bounding box.
    #[inline(always)]
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        let [a, b, c] = self.v;
        Aabb { min: a, max: a }.with(b).with(c)
    }

    /// Where the ray crosses, if it does so in `[t_min, t_max]`.
    #[inline(always)]
    #[must_use]
    pub fn crossing(&self, ray: &Prepared, t_max: f32) -> Option<Crossing> {
        let a = Sheared::new(self.v[0], ray);
        let b = Sheared::new(self.v[1], ray);
        let c = Sheared::new(self.v[2], ray);
        // Weights of the three corners, up to their sum.
        let ((wa, sa), (wb, sb), (wc, sc)) = (b.edge(c), c.edge(a), a.edge(b));
        let low = least(least(wa, wb), wc);
        let high = most(most(wa, wb), wc);
        // Both are weights or NaN, and no NaN passes these tests: so even after an overflow some sign differs from
        // another.
        if low < 0.0 && high > 0.0 {
            return None;
        }
        let det = wa + wb + wc;
        let depth = wa * a.z + wb * b.z + wc * c.z;
        let ordinary = det.abs() > LEAST_DET && det.abs() < MOST_DET && depth.is_finite();
        // Few bits may be lost to cancellation, or `t` would lie off the triangle: `super`, rule 6.
        let steady = (sa + sb) + sc <= det.abs() * MOST_CANCELLED;
        let clear = (low > 0.0 || high < 0.0) && ordinary && steady;
        let (depth, u, v, clockwise) =
            if clear { (depth / det, wb / det, wc / det, det < 0.0) } else { exact_weights(a, b, c)? };
        let t = ray.admit(depth * ray.inv_kz, ray.slab(&self.bounds()), t_max)?;
        Some(Crossing { t, u, v, enters: clockwise != (ray.inv_kz < 0.0) })
    }
}

/// The rare path: depth along `kz`, the weights of the second and third corner, and whether the corners run clockwise
/// in the sheared plane, from f64 edge functions.
#[cold]
#[inline(never)]
fn exact_weights(a: Sheared, b: Sheared, c: Sheared) -> Option<(f32, f32, f32, bool)> {
    if !(a.is_finite() && b.is_finite() && c.is_finite()) {
        return None;
    }
    let ((wa, na), (wb, nb), (wc, nc)) = (b.exact_edge(c)?, c.exact_edge(a)?, a.exact_edge(b)?);
    if na != nb || nb != nc {
        return None;
    }
    // The signs agree, so not all three are 0, and the sum is not either.
    let det = wa + wb + wc;
    let (wa, wb, wc) = (wa / det, wb / det, wc / det);
    let depth = wa * wide(a.z) + wb * wide(b.z) + wc * wide(c.z);
    Some((narrow(depth), narrow(wb) + 0.0, narrow(wc) + 0.0, na))
}
