//! Cylinders and truncated cones.
//!
//! A point at height `s` along the axis (0 at the base, 1 at the top) is on the side if its distance from the axis is
//! `r0 + s (r1 - r0)`. For a point that moves with the ray this is a quadratic in `t`. It is solved in units of the
//! cone's size, from the ray's point nearest to the axis' middle, and once more from the parabola's vertex, so that
//! what remains to cancel is of the size of the radius and not of the distance.
use super::aabb::Aabb;
use super::ray::Prepared;
use super::root::sqrt;
use super::vec::{Vec3, add_scaled, dot, in_units, most, scale, size, sub};
use bytemuck::{Pod, Zeroable};

/// A round cylinder between two points.
///
/// It may be missed if it is shorter than `2^-63` of its radius, or farther from a ray's origin than 1e38 times its
/// size: numbers for that are too small or too large.
///
/// ```
/// use flashray::Cylinder;
/// let tube = Cylinder::open([0.0; 3], [0.0, 0.0, 1.0], 0.5);
/// assert_eq!(tube.caps, 0);
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Cylinder {
    /// Centre of the base circle.
    pub base: [f32; 3],
    /// Centre of the top circle.
    pub top: [f32; 3],
    /// Radius, 0 or more.
    pub radius: f32,
    /// 1 if the two end discs belong to the surface, 0 if it is an open tube.
    pub caps: u32,
}

/// A truncated cone between two circles; a pointed cone has one radius of 0.
///
/// It may be missed if it is shorter than `2^-63` of its greater radius, or farther from a ray's origin than 1e38 times
/// its size: numbers for that are too small or too large.
///
/// ```
/// use flashray::Cone;
/// let spike = Cone::capped([0.0; 3], [0.0, 0.0, 1.0], 0.5, 0.0);
/// assert_eq!((spike.base_radius, spike.caps), (0.5, 1));
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Cone {
    /// Centre of the base circle.
    pub base: [f32; 3],
    /// Centre of the top circle.
    pub top: [f32; 3],
    /// Radius at the base, 0 or more.
    pub base_radius: f32,
    /// Radius at the top, 0 or more.
    pub top_radius: f32,
    /// 1 if the two end discs belong to the surface, 0 if it is open.
    pub caps: u32,
}

impl Cylinder {
    /// A tube without end discs.
    #[must_use]
    pub const fn open(base: [f32; 3], top: [f32; 3], radius: f32) -> Self {
        Self { base, top, radius, caps: 0 }
    }

    /// A cylinder with both end discs.
    #[must_use]
    pub const fn capped(base: [f32; 3], top: [f32; 3], radius: f32) -> Self {
        Self { base, top, radius, caps: 1 }
    }

    /// The same surface as a cone with equal radii, which is how it is tested.
    #[inline]
    #[must_use]
    pub const fn as_cone(&self) -> Cone {
        let Self { base, top, radius, caps } = *self;
        Cone { base, top, base_radius: radius, top_radius: radius, caps }
    }
}

/// Below this share the quadratic term is too small for the parabola's vertex to be a good starting point.
const FLAT: f32 = 0.0625;
/// The box of a circle is computed in f32: this covers its roundings.
const OUTWARD: f32 = 1.000_001;

impl Cone {
    /// A truncated cone without end discs.
    #[must_use]
    pub const fn open(base: [f32; 3], top: [f32; 3], base_radius: f32, top_radius: f32) -> Self {
        Self { base, top, base_radius, top_radius, caps: 0 }
    }

    /// A truncated cone with both end discs.
    #[must_use]
    pub const fn capped(base: [f32; 3], top: [f32; 3], base_radius: f32, top_radius: f32) -> Self {
        Self { base, top, base_radius, top_radius, caps: 1 }
    }

    /// The cone's bounding box: that of its two end circles.
    #[inline]
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        let axis = sub(self.top, self.base);
        // In units of the axis, so that its square can not overflow or vanish.
        let unit = scale(axis, 1.0 / most(size(axis), f32::MIN_POSITIVE));
        let square = most(dot(unit, unit), f32::MIN_POSITIVE);
        // The sine of the angle between the axis and a coordinate axis, from the other two: 1 - cosine^2 would cancel.
        let reach = |i: usize, j: usize| sqrt((unit[i] * unit[i] + unit[j] * unit[j]) / square) * OUTWARD;
        let reach = [reach(1, 2), reach(2, 0), reach(0, 1)];
        let circle = |c: Vec3, r: f32| Aabb { min: add_scaled(c, -r, reach), max: add_scaled(c, r, reach) };
        circle(self.base, self.base_radius).join(&circle(self.top, self.top_radius))
    }

    /// The nearest crossing in `[t_min, t_max]`.
    #[inline]
    #[must_use]
    pub fn crossing(&self, ray: &Prepared, t_max: f32) -> Option<f32> {
        let own = ray.slab(&self.bounds());
        if !ray.could_admit(own, t_max) {
            return None;
        }
        let local = Local::new(self, ray)?;
        let mut best = None;
        let mut offer = |s: f32| {
            let limit = best.unwrap_or(t_max);
            best = ray.admit(local.to_t(s), own, limit).or(best);
        };
        for s in local.side() {
            if let Some(s) = s.filter(|&s| local.between_ends(s)) {
                offer(s);
            }
        }
        if self.caps != 0 {
            local.discs().into_iter().flatten().for_each(offer);
        }
        best
    }
}

/// A ray against a cone, in units of the cone's size; distances `s` start at the point nearest the axis' middle.
struct Local {
    /// Unit of length, distance of the starting point, and what turns both into `t`.
    unit: f32,
    start: f32,
    to_t: f32,
    /// Height along the axis at the start, and its change with `s`.
    height: [f32; 2],
    /// Vector from the axis at the start, and its change with `s`.
    away: [Vec3; 2],
    /// The side's radius at that height, and its change with `s`.
    radius: [f32; 2],
    /// Radii of the two ends.
    ends: [f32; 2],
}

impl Local {
    #[inline]
    fn new(cone: &Cone, ray: &Prepared) -> Option<Self> {
        let axis = sub(cone.top, cone.base);
        let unit = most(most(cone.base_radius, cone.top_radius), size(axis));
        let radii = [cone.base_radius, cone.top_radius, 0.0];
        let [axis, from, [base, top, _]] = in_units([axis, sub(ray.origin, cone.base), radii], unit);
        let ends = [base, top];
        let length2 = dot(axis, axis);
        let (dir, to_t) = ray.scaled_dir();
        let start = dot(add_scaled(from, -0.5, axis), dir) / -dot(dir, dir);
        let from = add_scaled(from, start, dir);
        let height = [dot(from, axis) / length2, dot(dir, axis) / length2];
        let away = [add_scaled(from, -height[0], axis), add_scaled(dir, -height[1], axis)];
        let taper = ends[1] - ends[0];
        let radius = [ends[0] + taper * height[0], taper * height[1]];
        (length2 > 0.0).then_some(Self { unit, start, to_t, height, away, radius, ends })
    }

    fn to_t(&self, s: f32) -> f32 {
        ((self.start + s) * self.unit) * self.to_t
    }

    fn between_ends(&self, s: f32) -> bool {
        let h = self.height[0] + self.height[1] * s;
        (0.0..=1.0).contains(&h)
    }

    /// The two crossings with the endless side.
    #[inline]
    fn side(&self) -> [Option<f32>; 2] {
        let [p, d] = self.away;
        let [r, dr] = self.radius;
        let a = dot(d, d) - dr * dr;
        let b = dot(p, d) - r * dr;
        if a.abs() > FLAT {
            // From the parabola's vertex, where the linear term is 0.
            let vertex = -b / a;
            let (p, r) = (add_scaled(p, vertex, d), r + vertex * dr);
            let square = (r * r - dot(p, p)) / a;
            let half = sqrt(square);
            return if square >= 0.0 { [Some(vertex - half), Some(vertex + half)] } else { [None, None] };
        }
        let c = dot(p, p) - r * r;
        let square = b * b - a * c;
        if !(square >= 0.0) {
            return [None, None];
        }
        let w = if b < 0.0 { sqrt(square) - b } else { -sqrt(square) - b };
        let divided = |x: f32, y: f32| (y != 0.0).then(|| x / y);
        [divided(w, a), divided(c, w)]
    }

    /// The crossings with the two end discs.
    #[inline]
    fn discs(&self) -> [Option<f32>; 2] {
        let disc = |h: f32, r: f32| {
            let s = (h - self.height[0]) / self.height[1];
            let p = add_scaled(self.away[0], s, self.away[1]);
            (dot(p, p) <= r * r).then_some(s)
        };
        [disc(0.0, self.ends[0]), disc(1.0, self.ends[1])]
    }
}
