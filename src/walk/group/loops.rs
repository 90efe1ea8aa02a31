//! What [`Bundle`] does in lanes, in plain loops: for machines where compilers make vectors of loops, and the library has no
//! instructions.
//!
//! Each is out of line, goes from memory to memory, takes all that a ray needs in one turn of the loop, and gives bytes for
//! answers: of that compilers make vectors. Of rows of eight numbers inlined into a walk they unrolled each operation by
//! itself, and put the numbers together one by one. The steps are those of the lanes, in the same order.
use super::bundle::Bundle;
use super::leaf::Found;
use super::{AT_ONCE, CHUNKS};
use crate::geom::place::Place;
use crate::geom::ray::{Axis, ORIGIN_PAD, PAD, SMALL, blur, doubt};
use crate::geom::triangle::{LEAST_DET, MOST_CANCELLED, MOST_DET};
use crate::geom::vec::{Vec3, least, most};
use crate::geom::{Aabb, Ray, Triangle};

/// A number of no ray.
const NONE: [f32; AT_ONCE] = [0.0; AT_ONCE];

/// What the edge functions of a triangle say of eight rays.
struct Edges {
    weights: [[f32; AT_ONCE]; 3],
    depth: [f32; AT_ONCE],
    sizes: [f32; AT_ONCE],
    /// The sums of its coordinates in the plane.
    reach: [f32; AT_ONCE],
}

impl Bundle {
    /// [`Bundle::set`].
    #[inline(never)]
    pub(super) fn set_in_loops(&mut self, chunk: usize, rays: [&Ray; AT_ONCE], live: u32, place: &Place<'_>) -> u32 {
        let (bounds, local) = (place.bounds, place.local);
        let (chunk, no) = (chunk % CHUNKS, [0; AT_ONCE]);
        let (mut given, mut dir) = ([[0.0; AT_ONCE]; 3], [[0.0; AT_ONCE]; 3]);
        for (i, ray) in rays.into_iter().enumerate() {
            let i = i % AT_ONCE;
            for k in 0..3 {
                (given[k][i], dir[k][i]) = (ray.origin[k], ray.dir[k] + 0.0);
            }
            (self.t_min[chunk][i], self.t[chunk][i]) = (ray.t_min, ray.t_max);
        }
        let (mut good, mut second, mut third, mut negative) = (no, no, no, [no; 3]);
        for i in 0..AT_ONCE {
            let (from, d) = ([given[0][i], given[1][i], given[2][i]], [dir[0][i], dir[1][i], dir[2][i]]);
            let sizes = d.map(f32::abs);
            let o = [from[0] - local[0], from[1] - local[1], from[2] - local[2]];
            let inv = d.map(|d| 1.0 / d);
            let reach = |k: usize| most((bounds.max[k] - o[k]).abs(), (bounds.min[k] - o[k]).abs());
            let extent = most(reach(2), most(reach(1), reach(0))) * PAD;
            self.doubt[chunk][i] = doubt(extent, place.coarse);
            let mut is_good = u8::from(self.t_min[chunk][i] <= self.t[chunk][i]);
            is_good &= u8::from(SMALL <= most(sizes[2], most(sizes[1], sizes[0])));
            for k in 0..3 {
                is_good &= u8::from(from[k].abs() < f32::INFINITY) & u8::from(sizes[k] < f32::INFINITY);
                let pad = (extent + (o[k].abs() * ORIGIN_PAD + f32::MIN_POSITIVE)).copysign(d[k]);
                let sign = 1.0f32.copysign(d[k]);
                self.near_origin[k][chunk][i] = (o[k] + pad) * sign;
                self.far_origin[k][chunk][i] = (o[k] - pad) * sign;
                self.inv[k][chunk][i] = inv[k] * sign;
                self.sign[k][chunk][i] = sign;
                self.dir[k][chunk][i] = d[k];
                negative[k][i] = u8::from(d[k] < 0.0);
            }
            let (is_third, is_second) = (most(sizes[1], sizes[0]) < sizes[2], sizes[0] < sizes[1]);
            let pick = |x: f32, y: f32, z: f32| {
                if is_third {
                    z
                } else if is_second {
                    y
                } else {
                    x
                }
            };
            self.turned[0][chunk][i] = pick(o[1], o[2], o[0]);
            self.turned[1][chunk][i] = pick(o[2], o[0], o[1]);
            self.turned[2][chunk][i] = pick(o[0], o[1], o[2]);
            let inv_kz = pick(inv[0], inv[1], inv[2]);
            self.inv_kz[chunk][i] = inv_kz;
            self.shear[0][chunk][i] = pick(d[1], d[2], d[0]) * inv_kz;
            self.shear[1][chunk][i] = pick(d[2], d[0], d[1]) * inv_kz;
            (good[i], second[i], third[i]) = (is_good, u8::from(is_second), u8::from(is_third));
        }
        let good = packed(good) & live;
        let third = packed(third) & good;
        let second = packed(second) & good & !third;
        self.note(chunk, good, negative.map(packed), [good & !second & !third, second, third]);
        good
    }

    /// [`Bundle::cut`], where the signs of all are alike.
    #[inline(never)]
    pub(super) fn cut_in_loops(&self, chunk: usize, (first, last): &(Vec3, Vec3)) -> u32 {
        let (chunk, mut met) = (chunk % CHUNKS, [0; AT_ONCE]);
        for i in 0..AT_ONCE {
            let (mut near, mut far) = (self.t_min[chunk][i], self.t[chunk][i]);
            for k in 0..3 {
                let inv = self.inv[k][chunk][i];
                near = most((first[k] - self.near_origin[k][chunk][i]) * inv, near);
                far = least((last[k] - self.far_origin[k][chunk][i]) * inv, far);
            }
            met[i] = u8::from(near <= far);
        }
        packed(met)
    }

    /// The same where they differ.
    #[inline(never)]
    pub(super) fn cut_mixed(&self, chunk: usize, b: &Aabb) -> u32 {
        let (chunk, mut met) = (chunk % CHUNKS, [0; AT_ONCE]);
        for i in 0..AT_ONCE {
            let (mut near, mut far) = (self.t_min[chunk][i], self.t[chunk][i]);
            for k in 0..3 {
                let (sign, inv) = (self.sign[k][chunk][i], self.inv[k][chunk][i]);
                let (min, max) = (b.min[k] * sign, b.max[k] * sign);
                near = most((least(min, max) - self.near_origin[k][chunk][i]) * inv, near);
                far = least((most(min, max) - self.far_origin[k][chunk][i]) * inv, far);
            }
            met[i] = u8::from(near <= far);
        }
        packed(met)
    }

    /// [`Bundle::test`].
    #[inline(always)]
    pub(super) fn test_in_loops(&self, chunk: usize, lanes: u32, kz: Axis, triangle: &Triangle) -> Found {
        let (mut found, mut edges) =
            (Found::NOTHING, Edges { weights: [NONE; 3], depth: NONE, sizes: NONE, reach: NONE });
        let maybe = lanes & self.edges(chunk, kz, triangle, &mut edges);
        if maybe != 0 {
            self.rest(chunk, &triangle.bounds(), &edges, &mut found);
            (found.good, found.odd) = (maybe & found.good & !found.odd, maybe & found.odd);
        }
        found
    }

    /// The edge functions. Returns for which rays they do not say at once that there is no hit.
    #[inline(never)]
    fn edges(&self, chunk: usize, kz: Axis, triangle: &Triangle, edges: &mut Edges) -> u32 {
        let ((kx, ky), chunk, mut maybe) = (kz.others(), chunk % CHUNKS, [0; AT_ONCE]);
        let [a, b, c] = triangle.v.map(|v| [v[kx.at()], v[ky.at()], v[kz.at()]]);
        for i in 0..AT_ONCE {
            let corner = |v: &Vec3| {
                let z = v[2] - self.turned[2][chunk][i];
                let (x, y) = (v[0] - self.turned[0][chunk][i], v[1] - self.turned[1][chunk][i]);
                [x - self.shear[0][chunk][i] * z, y - self.shear[1][chunk][i] * z, z]
            };
            let (a, b, c) = (corner(&a), corner(&b), corner(&c));
            let products = |a: Vec3, b: Vec3| (a[0] * b[1], a[1] * b[0]);
            let (pa, pb, pc) = (products(b, c), products(c, a), products(a, b));
            let (wa, wb, wc) = (pa.0 - pa.1, pb.0 - pb.1, pc.0 - pc.1);
            let (low, high) = (least(least(wa, wb), wc), most(most(wa, wb), wc));
            let doubt = self.doubt[chunk][i];
            maybe[i] = 1 ^ (u8::from(low < -doubt) & u8::from(high > doubt));
            let reach = |v: Vec3| v[0].abs() + v[1].abs();
            edges.reach[i] = (reach(a) + reach(b)) + reach(c);
            (edges.weights[0][i], edges.weights[1][i], edges.weights[2][i]) = (wa, wb, wc);
            edges.depth[i] = wa * a[2] + wb * b[2] + wc * c[2];
            edges.sizes[i] = ((pa.0.abs() + pa.1.abs()) + (pb.0.abs() + pb.1.abs())) + (pc.0.abs() + pc.1.abs());
        }
        packed(maybe)
    }

    /// What comes after them. Leaves to the caller which of the rays count.
    #[inline(never)]
    fn rest(&self, chunk: usize, b: &Aabb, edges: &Edges, found: &mut Found) {
        let (chunk, mut good, mut odd) = (chunk % CHUNKS, [0; AT_ONCE], [0; AT_ONCE]);
        for i in 0..AT_ONCE {
            let (wa, wb, wc, depth) = (edges.weights[0][i], edges.weights[1][i], edges.weights[2][i], edges.depth[i]);
            let (low, high) = (least(least(wa, wb), wc), most(most(wa, wb), wc));
            let det = wa + wb + wc;
            // Bytes, not conditions: those would become branches.
            let doubt = self.doubt[chunk][i];
            let (near, far) = (self.near_origin[0][chunk][i], self.far_origin[0][chunk][i]);
            let blur = blur(near, far, doubt) * edges.reach[i];
            let missed = u8::from(low < -blur) & u8::from(high > blur);
            let sure =
                (u8::from(low > doubt) | u8::from(high < -doubt)) | (u8::from(low > blur) | u8::from(high < -blur));
            let clear = sure
                & u8::from(det.abs() > LEAST_DET)
                & u8::from(det.abs() < MOST_DET)
                & u8::from(depth.abs() < f32::INFINITY)
                & u8::from(edges.sizes[i] <= det.abs() * MOST_CANCELLED);
            let (mut near, mut far) = (f32::NEG_INFINITY, f32::INFINITY);
            for k in 0..3 {
                let (sign, inv) = (self.sign[k][chunk][i], self.inv[k][chunk][i]);
                let (min, max) = (b.min[k] * sign, b.max[k] * sign);
                near = most((least(min, max) - self.near_origin[k][chunk][i]) * inv, near);
                far = least((most(min, max) - self.far_origin[k][chunk][i]) * inv, far);
            }
            let t = depth / det * self.inv_kz[chunk][i];
            let t = least(far, most(near, t)) + 0.0;
            good[i] = (missed ^ 1)
                & u8::from(near <= far)
                & u8::from(self.t_min[chunk][i] <= t)
                & u8::from(t <= self.t[chunk][i])
                & u8::from(t.abs() < f32::INFINITY);
            odd[i] = (clear | missed) ^ 1;
            (found.t[i], found.u[i], found.v[i]) = (t, wb / det, wc / det);
        }
        (found.good, found.odd) = (packed(good), packed(odd));
    }
}

/// The lowest bits of eight bytes that are 0 or 1.
#[inline(always)]
#[allow(clippy::as_conversions, clippy::cast_possible_truncation)] // what is left is below 256
const fn packed(row: [u8; AT_ONCE]) -> u32 {
    // Byte `i` comes to bit `56 + i` by its own factor, and no two come to one place.
    (u64::from_le_bytes(row).wrapping_mul(0x0102_0408_1020_4080) >> 56) as u32
}
