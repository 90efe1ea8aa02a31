//! The walk: that of [`crate::bvh`], with spheres.
//!
//! # Why no hit is passed over
//! The contract ([`crate::geom`], rule 3) ties an accepted hit to the padded slab interval of the primitive's own box,
//! in `f32`. A sphere test has no rounding in common with it, so it is grown by a margin that covers both. Let
//! `u = 2^-24`, `E` the distance of rule 4, `M` the largest size of `near_origin - origin`: a pad as it came out, at
//! least `32 u E`. Lengths are in scene units, `d` is the direction over its largest component, `D` the same without
//! rounding, and a hit at `t` lies at `tau = t * dir[kz]`, a real number, of the line `o + tau D`. Constants are those
//! of first order; the rest is some `u` of them.
//!
//! 1. *How far a hit may lie from its box.* Each axis of the slab test says that `first <= near_origin + tau D`, but
//!    for three roundings, and the like for `last`: so the point lies within `M + 3 u (E + M) < 1.1 M` of the box on
//!    each axis, and within `1.91 M` of it. Where the product of that test underflows, the error is `2^-150` of `t`,
//!    and so `2^-150 |dir[kz]|` an axis. Where `1 / dir` overflows on an axis, the sign of the difference is all that
//!    counts, which is exact, and the line moves by less than `2^-28 E` on it. A sphere contains the box (rule 50,
//!    right to `2^-51`), so the point is within its radius and this distance of its centre.
//! 2. *The direction.* `d` is off by `2u` on two axes, and `tau` at most `E + M`: `2.9 u E`.
//! 3. *The centre from the origin* is rounded on each axis: `1.8 u E`. (Centres lie in the bounds.)
//! 4. *The nearest point*, `s = (oc . d) / (d . d)`: sum of products `5.2 u E` (three roundings each, and Cauchy and
//!    Schwarz), denominator, its inverse and the product `8.7 u E`. An error of `s` makes `oc - s d` longer by as much.
//! 5. *That vector*, rounded: `3.5 u E`. Its scaled length against the scaled radius, where the two are about equal and
//!    so neither is beyond `|oc|`: `8.7 u E`.
//! 6. *The interval* `s -+ (h + margin)`, times `1 / dir[kz]`, where `h` is half the chord of the grown sphere: no less
//!    than that of the sphere grown by steps 1 to 5 alone, but for the rounding of the root, of its argument and of two
//!    products, `7 u E`. Steps 2 to 4; the sum and the difference `8.7 u E`, and `5.2 u E` for the rounding of the
//!    inverse. The last product is monotone, and the `t` that it is compared with is an `f32`: its own rounding, to a
//!    denormal or to infinity too, loses nothing.
//!
//! A radius is at most `3.5 E`, since centre and boxes lie in the bounds; a blob may have a greater one, but every
//! comparison is monotone in it. Steps 1 to 5 add up to `1.91 M + 31 u E`, and 1 to 4 and 6 to `1.91 M + 40 u E`: less
//! than `3.2 M`. The margin is `4 M` and `2^-147 |dir[kz]|`. The lengths of step 5 are compared in units of `2^19 M`,
//! which is no less than `E`: no square overflows, and the margin's own is `2^-34`, so none that matters underflows.
//! Beyond coordinates of 5e36 and directions of `2^126` the margin is infinite, and everything is visited. So it is
//! where a NaN turns up: every comparison is written so.
use super::{Node, View};
use crate::blob::prims::Prims;
use crate::bvh::tree::root;
use crate::bvh::walk::{Test, descend};
use crate::geom::ray::Prepared;
use crate::geom::root::sqrt;
use crate::geom::vec::{Vec3, add_scaled, dot, least, most, scale, size, sub};
use crate::walk::{Best, Meter, Stop};

/// The margin in units of the pad.
const MARGIN: f32 = 4.0;
/// Unit of lengths, in units of the pad: no less than the distance to the far side of the scene.
const UNIT: f32 = 524_288.0; // 2^19
/// Pads beyond this are those of scenes too large for products to stay finite.
const MOST_PAD: f32 = 10_141_204_801_825_835_211_973_625_643_008.0; // 2^103
/// Margin for a `t` that underflows, in units of the direction's largest component.
const UNDERFLOW: f32 = 4.0 * f32::from_bits(1); // 2^-147

/// What the sphere tests of a walk read of the ray.
pub(crate) struct Line {
    origin: Vec3,
    /// The direction over its largest component.
    dir: Vec3,
    /// What turns a distance along `dir` into `t`: positive.
    to_t: f32,
    /// `1 / (dir . dir)`: at most 1.
    inv_square: f32,
    /// What spheres are grown by.
    margin: f32,
    /// `1 / unit` of lengths.
    inv_unit: f32,
    /// Unit of lengths.
    unit: f32,
}

impl Line {
    #[inline(always)]
    pub(super) fn new(ray: &Prepared) -> Self {
        let (dir, to_t) = ray.scaled_dir();
        // Turned so that distances grow with `t`.
        let (dir, to_t) = if to_t < 0.0 { (scale(dir, -1.0), -to_t) } else { (dir, to_t) };
        let pad = size(sub(ray.near_origin, ray.origin));
        let unit = pad * UNIT;
        let fair = pad < MOST_PAD && to_t >= f32::MIN_POSITIVE;
        let margin = if fair { pad * MARGIN + UNDERFLOW / to_t } else { f32::INFINITY };
        Self { origin: ray.origin, dir, to_t, inv_square: 1.0 / dot(dir, dir), margin, inv_unit: 1.0 / unit, unit }
    }
}

impl Test<Node> for Line {
    #[inline(always)]
    fn interval<const C: usize>(&self, node: &Node, ray: &Prepared, t_max: f32) -> (f32, f32) {
        let [x, y, z] = &node.centers;
        let from = sub([x[C], y[C], z[C]], self.origin);
        let middle = dot(from, self.dir) * self.inv_square;
        let nearest = scale(add_scaled(from, -middle, self.dir), self.inv_unit);
        let radius = node.radii[C] + self.margin;
        let reach = radius * self.inv_unit;
        let rest = reach * reach - dot(nearest, nearest);
        let missed = rest < 0.0;
        let half = sqrt(rest * self.inv_square) * self.unit + self.margin;
        let (near, far) = ((middle - half) * self.to_t, (middle + half) * self.to_t);
        // A NaN leaves the ray's own interval.
        (most(near, ray.t_min), if missed { f32::NEG_INFINITY } else { least(far, t_max) })
    }
}

impl View<'_> {
    /// Finds the closest hit, or with `ANY` whether there is one. Returns whether the walk ended at a hit.
    ///
    /// # Errors
    /// [`Stop`] if the meter runs out or the bytes contradict themselves.
    // Out of line everywhere: a query has one function for all structures, whose stack would be that of the deepest.
    #[inline(never)]
    pub fn walk<const ANY: bool>(
        &self,
        prims: &Prims<'_>,
        ray: &Prepared,
        best: &mut Best,
        meter: &mut impl Meter,
    ) -> Result<bool, Stop> {
        descend::<ANY, _>(self.nodes, root(self.nodes, prims.len), &Line::new(ray), prims, ray, best, meter)
    }
}
