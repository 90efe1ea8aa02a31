//! Rays, and what is computed once per ray.
use super::aabb::Aabb;
use super::place::Place;
use super::vec::{Vec3, add_scaled, least, most, scale, size, sub};
use crate::walk::lanes::{self, Lanes};
use bytemuck::{Pod, Zeroable};

/// A ray: the points `origin + t dir` for `t` in `[t_min, t_max]`, both ends included.
///
/// `dir` need not be normalised; `t` is in units of it. Any bit pattern is a legal value: a ray that makes no sense
/// (NaN or infinity in `origin` or `dir`, zero `dir`, `t_min > t_max`, NaN in either) meets nothing.
///
/// ```
/// use flashray::Ray;
/// let ray = Ray::new([0.0, 0.0, 5.0], [0.0, 0.0, -1.0]);
/// assert_eq!((ray.t_min, ray.t_max), (0.0, f32::INFINITY));
/// ```
///
/// Its eight numbers stand in memory in the order of the fields, so that a buffer of numbers can be read as rays:
///
/// ```
/// use flashray::Ray;
/// let numbers = [0.0, 0.0, 5.0, 0.0, 0.0, -1.0, 0.0, f32::INFINITY];
/// assert_eq!(bytemuck::cast_slice::<f32, Ray>(&numbers), [Ray::new([0.0, 0.0, 5.0], [0.0, 0.0, -1.0])]);
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Ray {
    /// Start, in scene units.
    pub origin: [f32; 3],
    /// Direction; its length is the unit of `t`.
    pub dir: [f32; 3],
    /// Least `t` that counts.
    pub t_min: f32,
    /// Greatest `t` that counts; may be infinite.
    pub t_max: f32,
}

impl Ray {
    /// Of `N` rays the numbers of the fields, each in a row: the origin's, the direction's, `t_min` and `t_max`.
    #[inline(always)]
    pub(crate) fn columns<const N: usize, L: Lanes<N>>(rays: [&Self; N]) -> ([L; 3], [L; 3], L, L) {
        let mut rows = [&[0.0; 8]; N];
        for i in 0..N {
            rows[i] = bytemuck::cast_ref(rays[i]);
        }
        let [a, b, c, d, e, f, t_min, t_max] = L::columns(rows);
        ([a, b, c], [d, e, f], t_min, t_max)
    }

    /// A ray from `origin` along `dir` with `t` from 0 to infinity.
    pub fn new(origin: impl Into<[f32; 3]>, dir: impl Into<[f32; 3]>) -> Self {
        Self { origin: origin.into(), dir: dir.into(), t_min: 0.0, t_max: f32::INFINITY }
    }

    /// The same ray with another interval.
    ///
    /// ```
    /// use flashray::Ray;
    /// let ray = Ray::new([0.0; 3], [1.0, 0.0, 0.0]).within(0.5, 2.0);
    /// assert_eq!(ray.t_max, 2.0);
    /// ```
    #[must_use]
    pub const fn within(mut self, t_min: f32, t_max: f32) -> Self {
        self.t_min = t_min;
        self.t_max = t_max;
        self
    }
}

/// A coordinate axis. An enum rather than a number, so that `array[axis as usize]` needs no bounds check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Axis {
    /// The first coordinate.
    X,
    /// The second coordinate.
    Y,
    /// The third coordinate.
    Z,
}

impl Axis {
    /// All three.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// Its place in a three-component array.
    #[inline(always)]
    #[must_use]
    #[allow(clippy::as_conversions)] // an enum's own number
    pub const fn at(self) -> usize {
        self as usize
    }

    /// The two axes after this one, in cyclic order.
    #[inline(always)]
    #[must_use]
    pub const fn others(self) -> (Self, Self) {
        match self {
            Self::X => (Self::Y, Self::Z),
            Self::Y => (Self::Z, Self::X),
            Self::Z => (Self::X, Self::Y),
        }
    }
}

/// Pad of the slab test as a share of the distance to the far side of the scene: 32 half-ulps. See
/// [`super`], rules 4 and 6.
pub(crate) const PAD: f32 = 32.0 / 16_777_216.0;
/// Share of the origin's own size, so that the pad survives the rounding of `origin + pad`: 2 half-ulps.
pub(crate) const ORIGIN_PAD: f32 = 2.0 / 16_777_216.0;

/// Directions of which no component reaches this are tiny.
pub(crate) const SMALL: f32 = 1.0 / 1_267_650_600_228_229_401_496_703_205_376.0; // 2^-100
/// Directions of which a component exceeds this are large: distances that count may underflow, to 0 or `-0.0`. The least pad
/// is `2^-126`, and over this it is `2^-146`, of which three bits are left.
pub(crate) const LARGE: f32 = 1_048_576.0; // 2^20
/// What a tiny direction is multiplied by, so that its inverse does not overflow.
const SCALE: f32 = 18_446_744_073_709_551_616.0; // 2^64

/// How often [`Prepared`] has its origin turned.
const TURNED: usize = if lanes::HERE { 1 } else { 0 };

/// A ray that makes sense, with what every test of it shares.
#[derive(Clone, Copy, Debug)]
pub struct Prepared {
    /// Origin, relative to the scene's local origin.
    pub(crate) origin: Vec3,
    /// The origin as the nearer plane of each axis sees it: moved by the pad so that the plane looks nearer.
    pub(crate) near_origin: Vec3,
    /// The origin as the farther plane of each axis sees it: moved by the pad so that the plane looks farther.
    pub(crate) far_origin: Vec3,
    /// `1 / dir`; infinite where `dir` is 0.
    pub(crate) inv: Vec3,
    /// Whether `dir` is negative, so that a box's greatest plane comes first.
    pub(crate) negative: [bool; 3],
    /// The axis on which `dir` is largest, and the two after it.
    pub(crate) kz: Axis,
    pub(crate) kx: Axis,
    pub(crate) ky: Axis,
    /// `origin` on `kx`, `ky` and `kz`, once or not at all. A value of its own, like the next: an index that is not constant
    /// would keep all of this in memory. Small machines have no registers to keep it in, and are faster without.
    pub(crate) turned: [Vec3; TURNED],
    /// `inv` on `kz`.
    pub(crate) inv_kz: f32,
    /// `dir` on `kx` and `ky` over `dir` on `kz`: at most 1 in size.
    pub(crate) shear: [f32; 2],
    /// The direction, for the rare test that needs more bits than `shear` has.
    pub(crate) dir: Vec3,
    /// What an edge function in f32 may be wrong by at most, for any triangle that counts: see [`super::triangle`].
    pub(crate) doubt: f32,
    /// Least `t` that counts.
    pub(crate) t_min: f32,
    /// Greatest `t` that counts.
    pub(crate) t_max: f32,
    /// What a `t` found is to be multiplied by: 1, or [`SCALE`] for a tiny direction.
    pub(crate) unit: f32,
}

impl Prepared {
    /// Prepares `ray` against a scene.
    ///
    /// `None` if the ray makes no sense, and then it meets nothing.
    #[inline(always)]
    #[must_use]
    pub fn new(ray: &Ray, place: &Place<'_>) -> Option<Self> {
        // Adding 0.0 turns -0.0 into 0.0, so that the two can not part ways below.
        let dir = [ray.dir[0] + 0.0, ray.dir[1] + 0.0, ray.dir[2] + 0.0];
        let sizes = [dir[0].abs(), dir[1].abs(), dir[2].abs()];
        let largest = most(sizes[2], most(sizes[1], sizes[0]));
        // Behind a branch: a factor of 1, selected and multiplied, would delay every ray's inverse.
        let (dir, (t_min, t_max), unit) = if largest < SMALL {
            (scale(dir, SCALE), shrunk(ray.t_min, ray.t_max), SCALE)
        } else {
            (dir, (ray.t_min, ray.t_max), 1.0)
        };
        if !all_finite(ray.origin, dir) || largest == 0.0 || !(t_min <= t_max) {
            return None;
        }
        // Selected, not branched on, here and below: the signs and the order of components are as good as random.
        let kz = if sizes[1] > sizes[0] { Axis::Y } else { Axis::X };
        let kz = if sizes[2] > most(sizes[1], sizes[0]) { Axis::Z } else { kz };
        let (kx, ky) = kz.others();
        let (origin, bounds) = (sub(ray.origin, place.local), place.bounds);
        let inv = [1.0 / dir[0], 1.0 / dir[1], 1.0 / dir[2]];
        let extent = most(size(sub(bounds.min, origin)), size(sub(bounds.max, origin))) * PAD;
        // A plane looks nearer from an origin moved along the ray, and farther from one moved against it.
        let pad = |k: usize| (extent + (origin[k].abs() * ORIGIN_PAD + f32::MIN_POSITIVE)).copysign(dir[k]);
        let pad = [pad(0), pad(1), pad(2)];
        Some(Self {
            origin,
            near_origin: [origin[0] + pad[0], origin[1] + pad[1], origin[2] + pad[2]],
            far_origin: [origin[0] - pad[0], origin[1] - pad[1], origin[2] - pad[2]],
            inv,
            negative: [dir[0] < 0.0, dir[1] < 0.0, dir[2] < 0.0],
            kz,
            kx,
            ky,
            turned: [[origin[kx.at()], origin[ky.at()], origin[kz.at()]]; TURNED],
            inv_kz: inv[kz.at()],
            shear: [dir[kx.at()] * inv[kz.at()], dir[ky.at()] * inv[kz.at()]],
            dir,
            doubt: doubt(extent, place.coarse),
            t_min,
            t_max,
            unit,
        })
    }

    /// The origin on `kx`, `ky` and `kz`.
    #[inline(always)]
    pub(crate) fn turned(&self) -> Vec3 {
        let o = &self.origin;
        self.turned.first().copied().unwrap_or([o[self.kx.at()], o[self.ky.at()], o[self.kz.at()]])
    }

    /// *The* slab test: the padded interval of `t` in which the whole line is inside the box; empty if the first
    /// number is greater than the second.
    ///
    /// Every step is monotone, so a box inside another has its interval inside the other's. Where `dir` is 0 on an
    /// axis the products are infinite, or NaN if the origin lies in a padded plane; a NaN constrains nothing.
    #[inline(always)]
    #[must_use]
    pub fn slab(&self, bounds: &Aabb) -> (f32, f32) {
        let (mut near, mut far) = (f32::NEG_INFINITY, f32::INFINITY);
        let mut axis = |k: usize, min: f32, max: f32| {
            let (first, last) = if self.negative[k] { (max, min) } else { (min, max) };
            near = most(self.near(k, first), near);
            far = least(self.far(k, last), far);
        };
        axis(0, bounds.min[0], bounds.max[0]);
        axis(1, bounds.min[1], bounds.max[1]);
        axis(2, bounds.min[2], bounds.max[2]);
        (near, far)
    }

    /// The padded distance to the plane of axis `k` that the ray meets first.
    #[inline(always)]
    pub(crate) fn near(&self, k: usize, plane: f32) -> f32 {
        (plane - self.near_origin[k]) * self.inv[k]
    }

    /// The padded distance to the plane of axis `k` that the ray meets last.
    #[inline(always)]
    pub(crate) fn far(&self, k: usize, plane: f32) -> f32 {
        (plane - self.far_origin[k]) * self.inv[k]
    }

    /// Whether [`Self::admit`] could take any `t` with this interval of a primitive's box: where not, the rest of its
    /// test can be left out.
    #[inline(always)]
    pub(crate) fn could_admit(&self, (near, far): (f32, f32), t_max: f32) -> bool {
        near <= far && far >= self.t_min && near <= t_max
    }

    /// Clamps a primitive's `t` into its box's interval and asks whether it counts, up to `t_max`.
    ///
    /// `None` too where `t` is NaN or infinite: such a distance has no place in the answer.
    #[inline(always)]
    pub(crate) fn admit(&self, t: f32, (near, far): (f32, f32), t_max: f32) -> Option<f32> {
        let t = if t < near { near } else { t };
        let t = if t > far { far } else { t } + 0.0;
        (near <= far && t >= self.t_min && t <= t_max && t.is_finite()).then_some(t)
    }

    /// Least `t` that counts, in the units that walks count in: those of the ray, but for tiny directions.
    #[inline(always)]
    #[must_use]
    pub const fn t_min(&self) -> f32 {
        self.t_min
    }

    /// The point at distance `t`, about.
    #[inline(always)]
    pub(crate) fn point(&self, t: f32) -> Vec3 {
        let (dir, to_t) = self.scaled_dir();
        add_scaled(self.origin, t / to_t, dir)
    }

    /// `dir` over its largest component (1 on that axis), and what turns a distance in units of it into `t`.
    #[inline(always)]
    pub(crate) fn scaled_dir(&self) -> (Vec3, f32) {
        let mut d = [1.0; 3];
        d[self.kx.at()] = self.shear[0];
        d[self.ky.at()] = self.shear[1];
        (d, self.inv_kz)
    }
}

/// What of the scene's extent, times [`PAD`], adds to what is [coarse](super::place::coarse) in it.
const FARTHER: f32 = 6.0;

/// [`Prepared::doubt`] of a ray that is padded by `extent`.
#[inline(always)]
pub(crate) fn doubt(extent: f32, coarse: f32) -> f32 {
    extent * (coarse + extent * FARTHER)
}

/// The same of many rays.
#[inline(always)]
pub(crate) fn doubts<const N: usize, L: Lanes<N>>(extent: L, coarse: f32) -> L {
    extent * (L::splat(coarse) + extent * L::splat(FARTHER))
}

/// What an edge function in f32 may be wrong by, over the sum of its triangle's coordinates in the sheared plane; from the
/// padded origins on any axis. NaN where the doubt is infinite.
#[inline(always)]
pub(crate) fn blur(near_origin: f32, far_origin: f32, doubt: f32) -> f32 {
    (near_origin - far_origin).abs() * 0.25 + doubt * 0.0
}

/// The same of many rays.
#[inline(always)]
pub(crate) fn blurs<const N: usize, L: Lanes<N>>(near_origin: L, far_origin: L, doubt: L) -> L {
    (near_origin - far_origin).abs() * L::splat(0.25) + doubt * L::splat(0.0)
}

/// Whether no component is NaN or infinite: their products with 0 would not be 0, nor their sum.
#[inline(always)]
fn all_finite(a: Vec3, b: Vec3) -> bool {
    (a[0] * 0.0 + a[1] * 0.0) + (a[2] * 0.0 + b[0] * 0.0) + (b[1] * 0.0 + b[2] * 0.0) == 0.0
}

/// The interval of a ray whose direction is multiplied by [`SCALE`].
///
/// Scaling a `t` back is exact, because the interval is first cut to where that is finite. The interval itself may
/// underflow: its ends then round inwards, and it may become empty.
#[cold]
#[inline(never)]
fn shrunk(t_min: f32, t_max: f32) -> (f32, f32) {
    if !(t_min <= t_max) {
        return (f32::NAN, f32::NAN);
    }
    let (t_min, t_max) = (most(t_min, f32::MIN), least(t_max, f32::MAX));
    let (low, high) = (t_min / SCALE, t_max / SCALE);
    let low = if low * SCALE < t_min { low.next_up() } else { low };
    let high = if high * SCALE > t_max { high.next_down() } else { high };
    (low, high)
}
