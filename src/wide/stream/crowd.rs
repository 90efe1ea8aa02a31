//! Rays of a stream side by side: prepared eight at a time, then read one at a time.
//!
//! On each lane the steps are those of [`Entered`](crate::walk::prepare::Entered), in the same order, so that the numbers
//! have the same bits.
use super::RAYS;
use crate::bvh::Face;
use crate::bvh::walk::Rows;
use crate::geom::hit::Crossing;
use crate::geom::place::Place;
use crate::geom::ray::{Axis, LARGE, ORIGIN_PAD, PAD, Prepared, SMALL, doubts};
use crate::geom::vec::Vec3;
use crate::geom::{Aabb, Ray, Triangle};
use crate::walk::Best;
use crate::walk::aim::{Aim, Source};
use crate::walk::lanes::Lanes;
use crate::wide::slabs::Slab;

/// Rays that are prepared at once.
pub(super) const AT_ONCE: usize = 8;

/// A number of each ray.
type Each = [[f32; AT_ONCE]; RAYS / AT_ONCE];

/// Up to 64 rays.
#[cfg_attr(target_arch = "x86_64", repr(align(32)))]
pub(crate) struct Rays {
    origin: [Each; 3],
    near_origin: [Each; 3],
    far_origin: [Each; 3],
    /// With twice the pad, for the quick box test.
    farther: [Each; 3],
    inv: [Each; 3],
    /// The origin on the axes of the shear.
    turned: [Each; 3],
    shear: [Each; 2],
    dir: [Each; 3],
    doubt: Each,
    inv_kz: Each,
    t_min: Each,
    t_max: Each,
    /// A bit for each axis on which a direction is negative.
    negative: [[u8; AT_ONCE]; RAYS / AT_ONCE],
    rows: [Rows; RAYS],
    /// The number of the axis on which a direction is largest.
    kz: [[u8; AT_ONCE]; RAYS / AT_ONCE],
}

/// Which of eight rays are what.
#[derive(Clone, Copy)]
pub(super) struct Told {
    /// Those that [`Entered`](crate::walk::prepare::Entered) would call quick, or turn away at the scene's box.
    pub quick: u32,
    /// Those of them that meet the scene's box.
    pub enter: u32,
}

/// A number of a ray.
#[inline(always)]
fn of(row: &Each, i: usize) -> f32 {
    row.as_flattened()[i % RAYS]
}

/// The rows of planes for each combination of signs.
const ROWS: [Rows; 8] = {
    let mut all = [Rows::of([false; 3]); 8];
    let mut i = 0;
    while i < 8 {
        all[i] = Rows::of([i & 1 != 0, i & 2 != 0, i & 4 != 0]);
        i += 1;
    }
    all
};

/// `kx`, `ky` and `kz` for each number of `kz`.
static AXES: [[Axis; 3]; 4] = {
    let mut all = [[Axis::X; 3]; 4];
    let mut i = 0;
    while i < 4 {
        let kz = Axis::ALL[if i < 3 { i } else { 2 }];
        let (kx, ky) = kz.others();
        all[i] = [kx, ky, kz];
        i += 1;
    }
    all
};

/// Bits as bytes of 0 and 1, the lowest first.
#[inline(always)]
fn bytes(bits: u32) -> u64 {
    let bits = u64::from(bits);
    // Each bit meets its own byte: seven copies of the bits, each seven places on.
    let low = (bits & 127).wrapping_mul(0x0002_0408_1020_4081) & 0x0101_0101_0101_0101;
    low | (bits >> 7 & 1) << 56
}

/// On each lane, the number on the axis that is `A` after the largest: that is y, or z, in these lanes, else x.
#[inline(always)]
fn pick<L: Lanes<8>, const A: usize>(of: &[L; 3], y: u32, z: u32) -> L {
    L::choose(z, of[(A + 2) % 3], L::choose(y, of[(A + 1) % 3], of[A % 3]))
}

/// Three of them.
#[inline(always)]
fn three(rows: &[Each; 3], i: usize) -> Vec3 {
    [of(&rows[0], i), of(&rows[1], i), of(&rows[2], i)]
}

impl Rays {
    /// All zeros, as all of a [`Crowd`](super::Crowd).
    pub(crate) const EMPTY: Self = {
        let zero = [[0.0; AT_ONCE]; RAYS / AT_ONCE];
        Self {
            origin: [zero; 3],
            near_origin: [zero; 3],
            far_origin: [zero; 3],
            farther: [zero; 3],
            inv: [zero; 3],
            turned: [zero; 3],
            shear: [zero; 2],
            dir: [zero; 3],
            doubt: zero,
            inv_kz: zero,
            t_min: zero,
            t_max: zero,
            negative: [[0; AT_ONCE]; RAYS / AT_ONCE],
            rows: [Rows { near: [Face::MinX; 3], far: [Face::MinX; 3] }; RAYS],
            kz: [[0; AT_ONCE]; RAYS / AT_ONCE],
        }
    };

    /// Prepares eight rays, the `c`-th eight.
    #[inline(always)]
    pub(super) fn set<L: Lanes<8>>(
        &mut self,
        c: usize,
        rays: &[Ray; AT_ONCE],
        best: &mut [Best; RAYS],
        place: &Place<'_>,
    ) -> Told {
        let c = c % (RAYS / AT_ONCE);
        let mut each = [&rays[0]; AT_ONCE];
        for i in 0..AT_ONCE {
            each[i] = &rays[i];
        }
        let (given, dir, t_min, t_max) = Ray::columns::<AT_ONCE, L>(each);
        (self.t_min[c], self.t_max[c]) = (t_min.store(), t_max.store());
        let (zero, too_far) = (L::splat(0.0), L::splat(place.far));
        let dir = [dir[0] + zero, dir[1] + zero, dir[2] + zero];
        let size = [dir[0].abs(), dir[1].abs(), dir[2].abs()];
        let mut quick = t_min.le(t_max) & zero.le(t_min) & zero.lt(t_max);
        for k in 0..3 {
            quick &= given[k].abs().lt(too_far) & L::splat(SMALL).le(size[k]) & size[k].le(L::splat(LARGE));
        }
        let (Aabb { min, max }, local) = (place.bounds, place.local);
        let origin = [given[0] - L::splat(local[0]), given[1] - L::splat(local[1]), given[2] - L::splat(local[2])];
        let mut extent = zero;
        for k in 0..3 {
            let reach = (L::splat(max[k]) - origin[k]).abs().most((L::splat(min[k]) - origin[k]).abs());
            extent = reach.most(extent);
        }
        let extent = extent * L::splat(PAD);
        let (mut near, mut far) = (t_min, t_max);
        let mut inv = [zero; 3];
        for k in 0..3 {
            let pad = extent + (origin[k].abs() * L::splat(ORIGIN_PAD) + L::splat(f32::MIN_POSITIVE));
            let pad = pad.signed_as(dir[k]);
            inv[k] = L::splat(1.0) / dir[k];
            let (near_origin, far_origin) = (origin[k] + pad, origin[k] - pad);
            let (a, b) = ((L::splat(min[k]) - near_origin) * inv[k], (L::splat(max[k]) - near_origin) * inv[k]);
            near = a.least(b).most(near);
            let (a, b) = ((L::splat(min[k]) - far_origin) * inv[k], (L::splat(max[k]) - far_origin) * inv[k]);
            far = a.most(b).least(far);
            self.origin[k][c] = origin[k].store();
            self.near_origin[k][c] = near_origin.store();
            self.far_origin[k][c] = far_origin.store();
            self.farther[k][c] = (far_origin + (far_origin - origin[k])).store();
            self.inv[k][c] = inv[k].store();
            self.dir[k][c] = dir[k].store();
        }
        self.doubt[c] = doubts(extent, place.coarse).store();
        let negative = [bytes(dir[0].lt(zero)), bytes(dir[1].lt(zero)), bytes(dir[2].lt(zero))];
        self.negative[c] = (negative[0] | negative[1] << 1 | negative[2] << 2).to_le_bytes();
        for (rows, &signs) in self.rows[c * AT_ONCE..].iter_mut().zip(&self.negative[c]) {
            *rows = ROWS[usize::from(signs) % 8];
        }
        self.turn::<L>(c, &origin, &dir, &inv, (size[0].lt(size[1]), size[1].most(size[0]).lt(size[2])));
        for (i, best) in best[c * AT_ONCE..].iter_mut().take(AT_ONCE).enumerate() {
            *best = Best::new(self.t_max[c][i]);
        }
        Told { quick, enter: quick & near.le(far) }
    }

    /// What depends on the axis on which a direction is largest: on y, or on z, else on x.
    #[inline(always)]
    fn turn<L: Lanes<8>>(&mut self, c: usize, origin: &[L; 3], dir: &[L; 3], inv: &[L; 3], (y, z): (u32, u32)) {
        let c = c % (RAYS / AT_ONCE);
        let inv_kz = pick::<L, 0>(inv, y, z);
        self.inv_kz[c] = inv_kz.store();
        self.turned[0][c] = pick::<L, 1>(origin, y, z).store();
        self.turned[1][c] = pick::<L, 2>(origin, y, z).store();
        self.turned[2][c] = pick::<L, 0>(origin, y, z).store();
        self.shear[0][c] = (pick::<L, 1>(dir, y, z) * inv_kz).store();
        self.shear[1][c] = (pick::<L, 2>(dir, y, z) * inv_kz).store();
        let (y, z) = (bytes(y & !z), bytes(z));
        self.kz[c] = (y | z << 1).to_le_bytes();
    }

    /// On which axes a direction is negative.
    #[inline(always)]
    fn signs(&self, i: usize) -> [bool; 3] {
        let all = self.negative.as_flattened()[i % RAYS];
        [all & 1 != 0, all & 2 != 0, all & 4 != 0]
    }

    /// For the box test.
    #[inline(always)]
    pub(super) fn slab(&self, i: usize) -> Slab {
        Slab {
            near_origin: three(&self.near_origin, i),
            far_origin: three(&self.farther, i),
            inv: three(&self.inv, i),
            t_min: of(&self.t_min, i),
            rows: self.rows[i % RAYS],
        }
    }
}

/// A ray of a crowd.
#[derive(Clone, Copy)]
pub(super) struct One<'c> {
    pub rays: &'c Rays,
    pub i: usize,
}

impl Aim for One<'_> {
    type Source = Self;
    #[inline(always)]
    fn axes(self) -> [Axis; 3] {
        AXES[usize::from(self.rays.kz.as_flattened()[self.i % RAYS]) % 4]
    }
    #[inline(always)]
    fn turned(self) -> Vec3 {
        three(&self.rays.turned, self.i)
    }
    #[inline(always)]
    fn shear(self) -> [f32; 2] {
        [of(&self.rays.shear[0], self.i), of(&self.rays.shear[1], self.i)]
    }
    #[inline(always)]
    fn doubt(self) -> f32 {
        of(&self.rays.doubt, self.i)
    }
    #[inline(always)]
    fn near_origin(self) -> Vec3 {
        three(&self.rays.near_origin, self.i)
    }
    #[inline(always)]
    fn far_origin(self) -> Vec3 {
        three(&self.rays.far_origin, self.i)
    }
    #[inline(always)]
    fn inv(self) -> Vec3 {
        three(&self.rays.inv, self.i)
    }
    #[inline(always)]
    fn inv_kz(self) -> f32 {
        of(&self.rays.inv_kz, self.i)
    }
    #[inline(always)]
    fn t_min(self) -> f32 {
        of(&self.rays.t_min, self.i)
    }
    #[inline(always)]
    fn source(self) -> Self {
        self
    }
    #[inline(always)]
    fn meets(self, triangle: &Triangle, t_max: f32) -> Option<Crossing> {
        triangle.crossing(&self.whole(), t_max)
    }
}

impl Source for One<'_> {
    #[inline(always)]
    fn prepared(self) -> Option<Prepared> {
        Some(self.whole())
    }
}

impl One<'_> {
    #[cold]
    #[inline(never)]
    fn whole(self) -> Prepared {
        let [kx, ky, kz] = self.axes();
        Prepared {
            origin: three(&self.rays.origin, self.i),
            near_origin: self.near_origin(),
            far_origin: self.far_origin(),
            inv: self.inv(),
            negative: self.rays.signs(self.i),
            kz,
            kx,
            ky,
            turned: [self.turned(); _],
            inv_kz: self.inv_kz(),
            shear: self.shear(),
            dir: three(&self.rays.dir, self.i),
            doubt: self.doubt(),
            t_min: self.t_min(),
            t_max: of(&self.rays.t_max, self.i),
            unit: 1.0,
        }
    }
}
