//! The triangle test: watertight, and each edge and vertex owned by exactly one side.
//!
//! Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013: move the ray's origin to 0, shear
//! so that its direction becomes the `kz` axis, and ask on which side of the triangle's three edges the origin of the
//! plane lies. A vertex's place in that plane depends on the ray and the vertex alone, so triangles that share a
//! vertex agree on it. That place is computed in f32, and where that is not enough in f64, which decides:
//!
//! - In f64 a place is off by `2^-50` of the distance, and the sign of an edge function is then exact: where its rounded
//!   products are equal, what rounding took from them is compared (`lost`). So triangles that share an edge can not both
//!   lose a ray, nor both have it.
//! - Where one is 0, the ray goes through the edge. It is then moved, in thought, by `(e, e^2)` for an `e`
//!   below every number (Edelsbrunner and Muecke, "Simulation of Simplicity", ACM TOG 9(1), 1990): the sign becomes
//!   that of the edge's own direction. The two triangles at an edge see it in opposite directions, so exactly one
//!   side owns it, and likewise around a vertex.
//! - f32 is not asked for the distance either where most bits of the edge functions cancelled, as in a triangle seen
//!   almost edge-on: the signs may be right, but the distance made from them would not be.
//!
//! # What f32 may decide
//! With `u = 2^-24`; `E` the largest distance, per axis, from the origin to the far side of the scene's bounds; `M` the
//! largest coordinate of those in size; `l` the longest side of a triangle's box; and `R` the sum of the sizes of its six
//! coordinates in the plane:
//!
//! - A coordinate is off by less than `7u E` (`super`, rule 4), so the products of an edge function are off by
//!   `7u E R + 98u^2 E^2` together, and their roundings and that of the difference add `4u E R`, because a coordinate is at
//!   most `2E` in size. Products do not underflow: `E` is at least `2^-40`, or nothing is left to f32.
//! - A triangle counts only if the slab test of its own box passes: then a point of the ray is in that box, but for
//!   `40u E + 3.2u M` along each axis, by rule 4 and the roundings of that test. No corner is farther from that point than
//!   the box is long, so no coordinate is larger than twice both together, and `R` is at most `12 l + 522u E + 39u M`. Of a
//!   triangle that the ray goes through that is true anyway.
//! - So for any triangle that counts an edge function is off by less than
//!   `132u E l + 429u^2 E M + 5840u^2 E^2`, and the ray's `doubt` is no less: `32u E (4.25 l + 16u M + 6 * 32u E)`, for the
//!   longest `l` of the scene, which a blob's header has. If two functions are beyond it on different sides, the triangle is
//!   missed; if all are on one, the signs are right, or the box is missed.
//! - Where that leaves it open, as for small triangles in a scene that has large ones, a sign counts beyond `16u E R`. No edge
//!   function is larger than `R^2 / 4`, so `R` is at least `64u E` then, `98u^2 E^2` is below `1.6u E R`, and what rounding
//!   does to `R` is below the rest. Half the distance between the padded origins is no less than `32u E`.
//!
//! A triangle that is degenerate in the plane, seen edge-on or with two equal corners, owns no point of it: its three
//! signs can not agree, because their sum is 0. One whose distinct corners lie on a line may become a sliver in the
//! plane, as thin as the rounding of f64; builders collapse those, so that in a blob a triangle without area is never hit.
use super::aabb::Aabb;
use super::hit::Crossing;
use super::ray::{Prepared, blur};
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

    /// The sum of its distances from the two axes of the plane.
    #[inline(always)]
    fn reach(self) -> f32 {
        self.x.abs() + self.y.abs()
    }
}

/// A vertex in the ray's frame as f64 has it.
#[derive(Clone, Copy)]
struct Exact {
    x: f64,
    y: f64,
    z: f64,
}

impl Exact {
    /// Twice the signed area of the origin and the edge from `self` to `to`, and whether it is negative, exactly so, with
    /// ties broken by the symbolic shift; `None` for an edge of no length, which belongs to a degenerate triangle.
    #[inline(always)]
    fn edge(self, to: Self) -> Option<(f64, bool)> {
        let (p, q) = (self.x * to.y, self.y * to.x);
        // Rounding is monotone: products that differ when rounded differ in the same sense.
        let e = if p == q { lost(self.x, to.y) - lost(self.y, to.x) } else { p - q };
        match () {
            () if e < 0.0 => Some((e, true)),
            () if e > 0.0 => Some((e, false)),
            // 0: the shift by (e, e^2) adds e (self.y - to.y) + e^2 (to.x - self.x).
            () if self.y != to.y => Some((0.0, self.y < to.y)),
            () if self.x != to.x => Some((0.0, to.x < self.x)),
            () => None,
        }
    }
}

/// What rounding takes from a product, exactly: Dekker, "A floating-point technique for extending the available
/// precision", Numerische Mathematik 18, 1971.
#[cold]
#[inline(never)]
fn lost(a: f64, b: f64) -> f64 {
    let halves = |x: f64| {
        let c = x * 134_217_729.0; // 2^27 + 1
        let high = c - (c - x);
        (high, x - high)
    };
    let ((ah, al), (bh, bl)) = (halves(a), halves(b));
    ((ah * bh - a * b) + ah * bl + al * bh) + al * bl
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
        let edges = Edges::new(self, ray);
        if edges.differ_by(ray.doubt) {
            return None;
        }
        let sure = edges.agree_by(ray.doubt);
        let weights = if sure && edges.are_ordinary() { edges.weights() } else { decided(self, ray)? };
        self.admitted(weights, ray, t_max)
    }

    /// The same, for those who know already that the bound for every triangle leaves it open.
    #[inline(always)]
    pub(crate) fn crossing_closely(&self, ray: &Prepared, t_max: f32) -> Option<Crossing> {
        self.admitted(decided(self, ray)?, ray, t_max)
    }

    #[inline(always)]
    fn admitted(&self, weights: Weights, ray: &Prepared, t_max: f32) -> Option<Crossing> {
        let Weights { depth, u, v, clockwise } = weights;
        let t = ray.admit(depth * ray.inv_kz, ray.slab(&self.bounds()), t_max)?;
        Some(Crossing { t, u, v, enters: clockwise != (ray.inv_kz < 0.0) })
    }
}

/// What decides, but for the distance: depth along `kz`, the weights of the second and third corner, and whether the corners
/// run clockwise in the sheared plane.
#[derive(Clone, Copy)]
struct Weights {
    depth: f32,
    u: f32,
    v: f32,
    clockwise: bool,
}

/// The corners in the ray's frame and the edge functions, which are the weights of the corners, up to their sum.
struct Edges {
    corners: [Sheared; 3],
    weights: [f32; 3],
    /// The least and the greatest.
    low: f32,
    high: f32,
    /// The sum of the sizes of all products.
    sizes: f32,
}

impl Edges {
    #[inline(always)]
    fn new(triangle: &Triangle, ray: &Prepared) -> Self {
        let a = Sheared::new(triangle.v[0], ray);
        let b = Sheared::new(triangle.v[1], ray);
        let c = Sheared::new(triangle.v[2], ray);
        let ((wa, sa), (wb, sb), (wc, sc)) = (b.edge(c), c.edge(a), a.edge(b));
        // Both are weights or NaN, and no NaN passes the tests below: so even after an overflow some sign differs from
        // another.
        let low = least(least(wa, wb), wc);
        let high = most(most(wa, wb), wc);
        Self { corners: [a, b, c], weights: [wa, wb, wc], low, high, sizes: (sa + sb) + sc }
    }

    /// Whether two have different signs by more than this.
    #[inline(always)]
    fn differ_by(&self, doubt: f32) -> bool {
        self.low < -doubt && self.high > doubt
    }

    /// Whether all have one sign by more than this.
    #[inline(always)]
    fn agree_by(&self, doubt: f32) -> bool {
        self.low > doubt || self.high < -doubt
    }

    #[inline(always)]
    fn det(&self) -> f32 {
        let [wa, wb, wc] = self.weights;
        wa + wb + wc
    }

    #[inline(always)]
    fn depth(&self) -> f32 {
        let ([a, b, c], [wa, wb, wc]) = (self.corners, self.weights);
        wa * a.z + wb * b.z + wc * c.z
    }

    /// Whether f32 is enough for the distance: nothing overflows, and few bits are lost to cancellation, or `t` would lie off
    /// the triangle (`super`, rule 6).
    #[inline(always)]
    fn are_ordinary(&self) -> bool {
        let det = self.det().abs();
        det > LEAST_DET && det < MOST_DET && self.depth().is_finite() && self.sizes <= det * MOST_CANCELLED
    }

    #[inline(always)]
    fn weights(&self) -> Weights {
        let ([_, wb, wc], det) = (self.weights, self.det());
        Weights { depth: self.depth() / det, u: wb / det, v: wc / det, clockwise: det < 0.0 }
    }
}

/// The rare path, where what holds for every triangle leaves it open: with the bound of this one, and then exactly.
#[cold]
#[inline(never)]
fn decided(triangle: &Triangle, ray: &Prepared) -> Option<Weights> {
    let edges = Edges::new(triangle, ray);
    let [a, b, c] = edges.corners;
    let blur = blur(ray.near_origin[0], ray.far_origin[0], ray.doubt) * ((a.reach() + b.reach()) + c.reach());
    if edges.differ_by(blur) {
        return None;
    }
    let sure = edges.agree_by(ray.doubt) || edges.agree_by(blur);
    if sure && edges.are_ordinary() { Some(edges.weights()) } else { exact_weights(triangle, ray) }
}

/// From vertices in f64.
#[cold]
#[inline(never)]
fn exact_weights(triangle: &Triangle, ray: &Prepared) -> Option<Weights> {
    let turned = |v: Vec3| [wide(v[ray.kx.at()]), wide(v[ray.ky.at()]), wide(v[ray.kz.at()])];
    let ([dx, dy, dz], [ox, oy, oz]) = (turned(ray.dir), turned(ray.origin));
    let shear = [dx / dz, dy / dz];
    let corner = |v: Vec3| {
        let [x, y, z] = turned(v);
        let z = z - oz;
        Exact { x: x - ox - shear[0] * z, y: y - oy - shear[1] * z, z }
    };
    let [a, b, c] = triangle.v;
    let (a, b, c) = (corner(a), corner(b), corner(c));
    let ((wa, na), (wb, nb), (wc, nc)) = (b.edge(c)?, c.edge(a)?, a.edge(b)?);
    if na != nb || nb != nc {
        return None;
    }
    // The signs agree, so not all three are 0, and the sum is not either.
    let det = wa + wb + wc;
    let (wa, wb, wc) = (wa / det, wb / det, wc / det);
    let depth = wa * a.z + wb * b.z + wc * c.z;
    Some(Weights { depth: narrow(depth), u: narrow(wb) + 0.0, v: narrow(wc) + 0.0, clockwise: na })
}
