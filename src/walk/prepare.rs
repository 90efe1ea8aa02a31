//! A ray prepared in lanes, and turned away early.
//!
//! The steps on each axis are those of [`Prepared::new`], so the result has the same bits. What only primitives need comes
//! after the scene's own box: a ray that misses that costs little.
use super::lanes::{Four, Lanes};
use crate::geom::Ray;
use crate::geom::place::Place;
use crate::geom::ray::{Axis, LARGE, ORIGIN_PAD, PAD, Prepared, SMALL, doubt};
use crate::geom::vec::{Vec3, least, most};

/// A ray as two rows and a bit more, made where the caller has its numbers at hand. A walk is called out of line, so its ray
/// goes through memory; what was written number by number can not be read four at a time before it has arrived there, and
/// a ray that was made just now would wait for that: 15 ns.
#[derive(Clone, Copy, Debug)]
pub struct Given {
    /// The origin, and whatever.
    origin: Four,
    /// The direction, and the least `t`: beside the greatest it would be read with that at once.
    dir: Four,
    t_max: f32,
}

impl Given {
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        // The fourth number of a row is whatever lies there: one load takes four.
        let row = |[x, y, z]: Vec3, next: f32| <Four as Lanes<4>>::load(&[x, y, z, next]);
        Self { origin: row(ray.origin, ray.dir[0]), dir: row(ray.dir, ray.t_min), t_max: ray.t_max }
    }

    /// Whether no distance to a plane is NaN, not even to those of an empty box, and none that counts is negative or underflows;
    /// nor is the greatest 0, of whatever sign. What makes no sense is not quick.
    #[inline(always)]
    pub fn is_quick(&self, place: &Place<'_>) -> bool {
        let splat = <Four as Lanes<4>>::splat;
        let ([.., t_min], size) = (self.dir.store(), self.dir.abs());
        let fine = self.origin.abs().lt(splat(place.far)) & splat(SMALL).le(size) & size.le(splat(LARGE));
        fine & 7 == 7 && t_min >= 0.0 && self.t_max > 0.0 && t_min <= self.t_max
    }

    /// Whether the direction is one of those that [`Entered::new`] leaves to [`Prepared::new`].
    #[inline(always)]
    pub fn is_tiny(&self) -> bool {
        let small = <Four as Lanes<4>>::splat(SMALL);
        self.dir.abs().lt(small) & 7 == 7
    }

    /// The ray again.
    #[inline(always)]
    pub fn ray(&self) -> Ray {
        let ([x, y, z, _], [dx, dy, dz, t_min]) = (self.origin.store(), self.dir.store());
        Ray { origin: [x, y, z], dir: [dx, dy, dz], t_min, t_max: self.t_max }
    }
}

/// A ray that meets the scene's box: what is known of it then, three numbers and a fourth of no meaning.
#[derive(Clone, Copy)]
pub struct Entered<L> {
    dir: L,
    inv: L,
    origin: L,
    near_origin: L,
    far_origin: L,
    t_min: f32,
    t_max: f32,
    doubt: f32,
}

/// The same as [`Prepared::new`], but also `None` for a ray that misses the scene's box.
#[inline(always)]
pub fn prepare<L: Lanes<4>>(ray: &Given, place: &Place<'_>) -> Option<Prepared> {
    match Entered::<L>::new(ray, place) {
        Some(entered) => Some(entered.prepared()),
        None if ray.is_tiny() => tiny(*ray, place),
        None => None,
    }
}

impl<L: Lanes<4>> Entered<L> {
    /// `None` for a ray that makes no sense, that misses the scene's box, or that [is tiny](Given::is_tiny).
    #[inline(always)]
    pub fn new(ray: &Given, place: &Place<'_>) -> Option<Self> {
        let ([.., t_min], infinite) = (ray.dir.store(), L::splat(f32::INFINITY));
        let (origin, dir) = (L::load(&ray.origin.store()).abs(), L::load(&ray.dir.store()).abs());
        let finite = origin.lt(infinite) & dir.lt(infinite) & 7 == 7;
        if !finite || !(t_min <= ray.t_max) || ray.is_tiny() {
            return None;
        }
        Self::fine(ray, place)
    }

    /// The same of a ray that [is quick](Given::is_quick), or is known to make sense and not to be tiny.
    #[inline(always)]
    pub fn fine(ray: &Given, place: &Place<'_>) -> Option<Self> {
        // The fourth number of a row is whatever lies there: one load takes four.
        let row = |[x, y, z]: Vec3, next: f32| L::load(&[x, y, z, next]);
        let ([.., t_min], t_max) = (ray.dir.store(), ray.t_max);
        let (given, dir) = (L::load(&ray.origin.store()), L::load(&ray.dir.store()) + L::splat(0.0));
        let inv = L::splat(1.0) / dir;
        let (bounds, local) = (place.bounds, place.local);
        let origin = given - row(local, 0.0);
        let (min, max) = (row(bounds.min, bounds.max[0]), row(bounds.max, 0.0));
        let [x, y, z, _] = (max - origin).abs().most((min - origin).abs()).store();
        let extent = most(z, most(y, x)) * PAD;
        let pad = L::splat(extent) + (origin.abs() * L::splat(ORIGIN_PAD) + L::splat(f32::MIN_POSITIVE));
        let pad = pad.signed_as(dir);
        let (near_origin, far_origin) = (origin + pad, origin - pad);
        // The nearer plane gives the lesser product, whichever the sign; but where both are NaN.
        let (a, b) = ((min - near_origin) * inv, (max - near_origin) * inv);
        let [nx, ny, nz, _] = a.least(b).store();
        let (a, b) = ((min - far_origin) * inv, (max - far_origin) * inv);
        let [fx, fy, fz, _] = a.most(b).store();
        let near = most(nz, most(ny, most(nx, t_min)));
        let far = least(fz, least(fy, least(fx, t_max)));
        let doubt = doubt(extent, place.coarse);
        (near <= far).then_some(Self { dir, inv, origin, near_origin, far_origin, t_min, t_max, doubt })
    }

    /// The ray prepared.
    #[inline(always)]
    pub fn prepared(self) -> Prepared {
        // Rows of four, written whole: what is read of them by a number that is not constant comes from one store.
        let (dirs, invs, origins) = (self.dir.store(), self.inv.store(), self.origin.store());
        let [dx, dy, dz, _] = dirs;
        let [sx, sy, sz] = [dx.abs(), dy.abs(), dz.abs()];
        let kz = if sy > sx { Axis::Y } else { Axis::X };
        let kz = if sz > most(sy, sx) { Axis::Z } else { kz };
        let (kx, ky) = kz.others();
        let inv_kz = invs[kz.at()];
        Prepared {
            origin: three(self.origin),
            near_origin: three(self.near_origin),
            far_origin: three(self.far_origin),
            inv: three(self.inv),
            negative: [dx < 0.0, dy < 0.0, dz < 0.0],
            kz,
            kx,
            ky,
            turned: [[origins[kx.at()], origins[ky.at()], origins[kz.at()]]; _],
            inv_kz,
            shear: [dirs[kx.at()] * inv_kz, dirs[ky.at()] * inv_kz],
            dir: three(self.dir),
            doubt: self.doubt,
            t_min: self.t_min,
            t_max: self.t_max,
            unit: 1.0,
        }
    }
}

/// The path of tiny directions.
#[cold]
#[inline(never)]
fn tiny(ray: Given, place: &Place<'_>) -> Option<Prepared> {
    Prepared::new(&ray.ray(), place)
}

#[inline(always)]
fn three<L: Lanes<4>>(all: L) -> Vec3 {
    let [x, y, z, _] = all.store();
    [x, y, z]
}
