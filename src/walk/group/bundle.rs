//! The rays of a group as rows of eight numbers, and boxes against them.
//!
//! Where a direction is negative, the axis is mirrored: planes, origin and direction change their signs. That is exact, so
//! the distances are the same numbers, and every direction is positive: the least plane comes first.
mod boxes;

use super::{AT_ONCE, CHUNKS, RAYS, each};
use crate::geom::place::Place;
use crate::geom::ray::{Axis, ORIGIN_PAD, PAD, Prepared, SMALL, doubts};
use crate::geom::vec::{least, most};
use crate::geom::{Aabb, Ray};
use crate::walk::lanes::Lanes;
use boxes::Range;

/// A number of each ray.
pub(super) type Each = [[f32; AT_ONCE]; CHUNKS];
/// That number of no ray.
const NONE: Each = [[0.0; AT_ONCE]; CHUNKS];

/// The rays of a group.
pub(super) struct Bundle {
    /// As in [`Prepared`], mirrored.
    pub(super) near_origin: [Each; 3],
    pub(super) far_origin: [Each; 3],
    pub(super) inv: [Each; 3],
    /// 1, or -1 where an axis is mirrored.
    pub(super) sign: [Each; 3],
    /// As in [`Prepared`].
    pub(super) turned: [Each; 3],
    pub(super) shear: [Each; 2],
    pub(super) dir: [Each; 3],
    pub(super) doubt: Each,
    pub(super) inv_kz: Each,
    pub(super) t_min: Each,
    /// Distances to beat.
    pub(super) t: Each,
    /// Which rays are steepest along each axis.
    pub(super) steepest: [u64; 3],
    /// The signs that all rays of a chunk have, if they have the same.
    common: [Option<[bool; 3]>; CHUNKS],
    /// Whether a distance to beat has changed since the extremes were taken.
    is_nearer: bool,
    /// The extremes of the group, if the signs of all are alike.
    range: Option<Range>,
    /// Where the rays start.
    pub(super) origins: Aabb,
}

impl Bundle {
    pub(super) fn new() -> Self {
        let three = [NONE; 3];
        Self {
            near_origin: three,
            far_origin: three,
            inv: three,
            sign: three,
            turned: three,
            shear: [NONE; 2],
            dir: three,
            doubt: NONE,
            inv_kz: NONE,
            t_min: NONE,
            t: NONE,
            steepest: [0; 3],
            common: [None; CHUNKS],
            is_nearer: false,
            range: None,
            origins: Aabb::EMPTY,
        }
    }

    /// Prepares the rays of a chunk, in the steps of [`Prepared::new`]. Returns which of those in `live` make sense and have
    /// no tiny direction.
    #[inline(always)]
    pub(super) fn set<L: Lanes<8>>(
        &mut self,
        chunk: usize,
        rays: [&Ray; AT_ONCE],
        live: u32,
        place: &Place<'_>,
    ) -> u32 {
        let (chunk, bounds, local) = (chunk % CHUNKS, place.bounds, place.local);
        let (given, dir, t_min, t_max) = Ray::columns::<AT_ONCE, L>(rays);
        let zero = L::splat(0.0);
        let dir = [dir[0] + zero, dir[1] + zero, dir[2] + zero];
        let sizes = [dir[0].abs(), dir[1].abs(), dir[2].abs()];
        let mut good = live & t_min.le(t_max) & L::splat(SMALL).le(sizes[2].most(sizes[1].most(sizes[0])));
        let origin = [given[0] - L::splat(local[0]), given[1] - L::splat(local[1]), given[2] - L::splat(local[2])];
        let one = L::splat(1.0);
        let inv = [one / dir[0], one / dir[1], one / dir[2]];
        let reach = [reach(origin[0], bounds, 0), reach(origin[1], bounds, 1), reach(origin[2], bounds, 2)];
        let extent = reach[2].most(reach[1].most(reach[0])) * L::splat(PAD);
        for k in 0..3 {
            let infinite = L::splat(f32::INFINITY);
            good &= given[k].abs().lt(infinite) & sizes[k].lt(infinite);
            let pad =
                (extent + (origin[k].abs() * L::splat(ORIGIN_PAD) + L::splat(f32::MIN_POSITIVE))).signed_as(dir[k]);
            let sign = one.signed_as(dir[k]);
            self.near_origin[k][chunk] = ((origin[k] + pad) * sign).store();
            self.far_origin[k][chunk] = ((origin[k] - pad) * sign).store();
            self.inv[k][chunk] = (inv[k] * sign).store();
            self.sign[k][chunk] = sign.store();
            self.dir[k][chunk] = dir[k].store();
        }
        self.doubt[chunk] = doubts(extent, place.coarse).store();
        self.t_min[chunk] = t_min.store();
        self.t[chunk] = t_max.store();
        let third = sizes[1].most(sizes[0]).lt(sizes[2]) & good;
        let second = sizes[0].lt(sizes[1]) & good & !third;
        let negative = [dir[0].lt(zero), dir[1].lt(zero), dir[2].lt(zero)];
        self.note(chunk, good, negative, [good & !second & !third, second, third]);
        if third == good {
            self.turn(chunk, Axis::Z, &origin, &dir, &inv);
        } else if second == good {
            self.turn(chunk, Axis::Y, &origin, &dir, &inv);
        } else {
            self.turn(chunk, Axis::X, &origin, &dir, &inv);
            if second | third != 0 {
                self.turn_some(chunk, Axis::Y, second, &origin, &dir, &inv);
                self.turn_some(chunk, Axis::Z, third, &origin, &dir, &inv);
            }
        }
        good
    }

    /// What the rays of a chunk have in common: of the good ones those that go down along each axis, and those that are
    /// steepest along it.
    #[inline(always)]
    pub(super) fn note(&mut self, chunk: usize, good: u32, negative: [u32; 3], steepest: [u32; 3]) {
        let mut common = Some([false; 3]);
        for k in 0..3 {
            let negative = negative[k] & good;
            common = common.filter(|_| negative == 0 || negative == good);
            if let Some(signs) = &mut common {
                signs[k] = negative != 0;
            }
            self.steepest[k] |= u64::from(steepest[k]) << (chunk * AT_ONCE);
        }
        self.common[chunk % CHUNKS] = common;
    }

    /// What triangle tests read of a chunk whose rays are steepest along `kz`.
    #[inline(always)]
    fn turn<L: Lanes<8>>(&mut self, chunk: usize, kz: Axis, origin: &[L; 3], dir: &[L; 3], inv: &[L; 3]) {
        let (chunk, (kx, ky)) = (chunk % CHUNKS, kz.others());
        for (row, k) in self.turned.iter_mut().zip([kx, ky, kz]) {
            row[chunk] = origin[k.at()].store();
        }
        let inv_kz = inv[kz.at()];
        self.inv_kz[chunk] = inv_kz.store();
        self.shear[0][chunk] = (dir[kx.at()] * inv_kz).store();
        self.shear[1][chunk] = (dir[ky.at()] * inv_kz).store();
    }

    /// The same for some lanes.
    #[inline(always)]
    fn turn_some<L: Lanes<8>>(
        &mut self,
        chunk: usize,
        kz: Axis,
        lanes: u32,
        origin: &[L; 3],
        dir: &[L; 3],
        inv: &[L; 3],
    ) {
        let (chunk, (kx, ky)) = (chunk % CHUNKS, kz.others());
        let inv_kz = inv[kz.at()];
        let (x, y) = (dir[kx.at()] * inv_kz, dir[ky.at()] * inv_kz);
        let turned = [origin[kx.at()].store(), origin[ky.at()].store(), origin[kz.at()].store()];
        let rows = [turned[0], turned[1], turned[2], inv_kz.store(), x.store(), y.store()];
        for i in each(u64::from(lanes)) {
            let i = i % AT_ONCE;
            for k in 0..3 {
                self.turned[k][chunk][i] = rows[k][i];
            }
            self.inv_kz[chunk][i] = rows[3][i];
            self.shear[0][chunk][i] = rows[4][i];
            self.shear[1][chunk][i] = rows[5][i];
        }
    }

    /// Takes the extremes of the first `len` rays, if the signs of all are alike. Returns where the rays go, about.
    #[inline(always)]
    pub(super) fn survey<L: Lanes<8>>(&mut self, len: usize) -> [f32; 3] {
        let (common, chunks) = (self.common, len.div_ceil(AT_ONCE));
        let Some(Some(negative)) =
            common.first().copied().filter(|&first| common.iter().take(chunks).all(|&c| c == first))
        else {
            self.range = None;
            let sum = |k: usize| self.sign[k % 3].as_flattened().iter().take(len).fold(0.0, |sum, s| sum + s);
            return [sum(0), sum(1), sum(2)];
        };
        self.range = Some(Range {
            negative,
            near_origin: ends3::<L>(&self.near_origin, len),
            far_origin: ends3::<L>(&self.far_origin, len),
            inv: ends3::<L>(&self.inv, len),
            t_min: ends::<L>(&self.t_min, len),
            t: ends::<L>(&self.t, len),
        });
        let along = |k: usize| self.sign[k % 3][0][0] / self.inv[k % 3][0][0];
        [along(0), along(1), along(2)]
    }

    /// Takes the distances to beat of the first `len` rays anew into the extremes, if any has changed.
    #[inline(always)]
    pub(super) fn shrink<L: Lanes<8>>(&mut self, len: usize) {
        if let Some(range) = self.range.as_mut().filter(|_| self.is_nearer) {
            range.t = ends::<L>(&self.t, len);
            self.is_nearer = false;
        }
    }

    /// A nearer distance to beat.
    #[inline(always)]
    pub(super) fn set_t(&mut self, i: usize, t: f32) {
        self.t[i / AT_ONCE % CHUNKS][i % AT_ONCE] = t;
        self.is_nearer = true;
    }

    /// Whether the signs of all are alike.
    #[inline(always)]
    pub(super) fn is_alike(&self) -> bool {
        self.range.is_some()
    }

    /// A ray by itself.
    #[inline(always)]
    pub(super) fn ray(&self, i: usize) -> Prepared {
        let at = |each: &Each| each[i / AT_ONCE % CHUNKS][i % AT_ONCE];
        let three = |of: &[Each; 3]| [at(&of[0]), at(&of[1]), at(&of[2])];
        let (sign, near, far, inv) =
            (three(&self.sign), three(&self.near_origin), three(&self.far_origin), three(&self.inv));
        let kz = match () {
            () if self.steepest[2] >> i & 1 == 1 => Axis::Z,
            () if self.steepest[1] >> i & 1 == 1 => Axis::Y,
            () => Axis::X,
        };
        let (kx, ky) = kz.others();
        let turned = three(&self.turned);
        let [x, y, z] = turned;
        Prepared {
            origin: match kz {
                Axis::X => [z, x, y],
                Axis::Y => [y, z, x],
                Axis::Z => [x, y, z],
            },
            near_origin: [near[0] * sign[0], near[1] * sign[1], near[2] * sign[2]],
            far_origin: [far[0] * sign[0], far[1] * sign[1], far[2] * sign[2]],
            inv: [inv[0] * sign[0], inv[1] * sign[1], inv[2] * sign[2]],
            negative: sign.map(|s| s < 0.0),
            kz,
            kx,
            ky,
            turned: [turned; _],
            inv_kz: at(&self.inv_kz),
            shear: [at(&self.shear[0]), at(&self.shear[1])],
            dir: three(&self.dir),
            doubt: at(&self.doubt),
            t_min: at(&self.t_min),
            t_max: at(&self.t),
            unit: 1.0,
        }
    }
}

/// A number of each ray of a chunk. Functions, not closures, all of these: what is called out of line is not compiled
/// for the instruction set.
#[inline(always)]
pub(super) fn row<L: Lanes<8>>(each: &Each, chunk: usize) -> L {
    L::load(&each[chunk % CHUNKS])
}

/// How far it is to the far side of the scene along an axis.
#[inline(always)]
fn reach<L: Lanes<8>>(origin: L, bounds: &Aabb, k: usize) -> L {
    (L::splat(bounds.max[k % 3]) - origin).abs().most((L::splat(bounds.min[k % 3]) - origin).abs())
}

/// Least and greatest of the first `len` numbers, and perhaps of those that follow in the last chunk.
#[inline(always)]
fn ends<L: Lanes<8>>(each: &Each, len: usize) -> (f32, f32) {
    let chunks = len.div_ceil(AT_ONCE);
    if !L::AT_ONCE {
        // By lanes here too, so that no step waits for the one before.
        let (mut low, mut high) = ([f32::INFINITY; AT_ONCE], [f32::NEG_INFINITY; AT_ONCE]);
        for row in each.iter().take(chunks) {
            for ((low, high), &x) in low.iter_mut().zip(&mut high).zip(row) {
                (*low, *high) = (least(x, *low), most(x, *high));
            }
        }
        return (low.into_iter().fold(f32::INFINITY, least), high.into_iter().fold(f32::NEG_INFINITY, most));
    }
    let (mut low, mut high) = (L::splat(f32::INFINITY), L::splat(f32::NEG_INFINITY));
    for row in each.iter().take(chunks) {
        (low, high) = (L::load(row).least(low), L::load(row).most(high));
    }
    fold(low, high)
}

/// The same on each axis.
#[inline(always)]
fn ends3<L: Lanes<8>>(of: &[Each; 3], len: usize) -> [(f32, f32); 3] {
    [ends::<L>(&of[0], len), ends::<L>(&of[1], len), ends::<L>(&of[2], len)]
}

/// The least lane of one and the greatest of another.
#[inline(always)]
fn fold<L: Lanes<8>>(low: L, high: L) -> (f32, f32) {
    let ([a, b, c, d, e, f, g, h], high) = (low.store(), high.store());
    let low = least(least(least(a, b), least(c, d)), least(least(e, f), least(g, h)));
    let [a, b, c, d, e, f, g, h] = high;
    (low, most(most(most(a, b), most(c, d)), most(most(e, f), most(g, h))))
}

const _: () = assert!(RAYS == AT_ONCE * CHUNKS);
