//! Boxes against the rays of a group: the extremes of all at once, eight rays in lanes, or one.
use super::{Bundle, Each, row};
use crate::geom::Aabb;
use crate::geom::vec::{least, most};
use crate::num::index;
use crate::walk::group::{AT_ONCE, CHUNKS, low_byte};
use crate::walk::lanes::Lanes;

/// The extremes of a group whose signs are alike, mirrored.
#[derive(Clone, Copy)]
pub(super) struct Range {
    pub(super) negative: [bool; 3],
    /// Of the origins that nearer planes see.
    pub(super) near_origin: [(f32, f32); 3],
    pub(super) far_origin: [(f32, f32); 3],
    pub(super) inv: [(f32, f32); 3],
    pub(super) t_min: (f32, f32),
    /// Of the distances to beat.
    pub(super) t: (f32, f32),
}

/// Planes of a box on each axis: those that rays meet first, and those that they meet last; mirrored as the rays are.
type Ends = ([f32; 3], [f32; 3]);

/// What an interval says of a box.
enum Met {
    /// No ray meets it.
    None,
    /// Each may.
    All,
    /// Who knows.
    Some,
}

impl Bundle {
    /// Which of the rays may meet a box before their distances to beat: where the signs of all are alike, those from the
    /// first to the last of which do.
    #[inline(always)]
    pub(in crate::walk::group) fn may_meet<L: Lanes<8>>(&self, b: &Aabb, rays: u64) -> u64 {
        let Some(range) = &self.range else {
            let is_inside = |k: usize| b.min[k] <= self.origins.min[k] && self.origins.max[k] <= b.max[k];
            return if is_inside(0) && is_inside(1) && is_inside(2) { rays } else { self.met::<L>(b, rays) };
        };
        match range.met(b) {
            Met::None => return 0,
            Met::All => return rays,
            Met::Some => {}
        }
        let mut rays = rays;
        let ends = in_order(b, range.negative);
        let planes = Planes::<L>::new(&ends);
        while rays != 0 {
            let chunk = index(rays.trailing_zeros()) / AT_ONCE;
            let met = self.cut_by(chunk, &planes, &ends) & low_byte(rays >> (chunk * AT_ONCE));
            let below = u64::from(met) << (chunk * AT_ONCE);
            rays = rays & !(255 << (chunk * AT_ONCE)) | below;
            if met != 0 {
                break;
            }
        }
        rays
    }

    /// Which of the rays meet a box before their distances to beat.
    #[inline(always)]
    pub(in crate::walk::group) fn met<L: Lanes<8>>(&self, b: &Aabb, rays: u64) -> u64 {
        let mut met = 0;
        if let Some(range) = &self.range {
            let ends = in_order(b, range.negative);
            let planes = Planes::<L>::new(&ends);
            for chunk in 0..CHUNKS {
                if low_byte(rays >> (chunk * AT_ONCE)) != 0 {
                    met |= u64::from(self.cut_by(chunk, &planes, &ends)) << (chunk * AT_ONCE);
                }
            }
        } else {
            for chunk in 0..CHUNKS {
                if low_byte(rays >> (chunk * AT_ONCE)) != 0 {
                    let chunk_met = match self.common[chunk] {
                        _ if L::AT_ONCE => self.cut(chunk, &self.planes::<L>(chunk, b)),
                        Some(negative) => self.cut_in_loops(chunk, &in_order(b, negative)),
                        None => self.cut_mixed(chunk, b),
                    };
                    met |= u64::from(chunk_met) << (chunk * AT_ONCE);
                }
            }
        }
        met & rays
    }

    /// Which rays of a chunk meet a box, by its planes in lanes or one by one.
    #[inline(always)]
    fn cut_by<L: Lanes<8>>(&self, chunk: usize, planes: &Planes<L>, ends: &Ends) -> u32 {
        if L::AT_ONCE { self.cut(chunk, planes) } else { self.cut_in_loops(chunk, ends) }
    }

    /// Whether a ray meets a box whose planes are in its order: as [`Bundle::met`].
    #[inline(always)]
    fn meets(&self, i: usize, (first, last): &Ends) -> bool {
        let at = |each: &Each| each[i / AT_ONCE % CHUNKS][i % AT_ONCE];
        let (mut near, mut far) = (at(&self.t_min), at(&self.t));
        let mut axis = |k: usize| {
            let inv = at(&self.inv[k]);
            near = most((first[k] - at(&self.near_origin[k])) * inv, near);
            far = least((last[k] - at(&self.far_origin[k])) * inv, far);
        };
        axis(0);
        axis(1);
        axis(2);
        near <= far
    }

    /// Whether a ray meets a box.
    #[inline(always)]
    pub(in crate::walk::group) fn meets_box(&self, i: usize, b: &Aabb) -> bool {
        self.meets(i, &in_order(b, self.negative(i)))
    }

    /// The signs of a ray.
    #[inline(always)]
    fn negative(&self, i: usize) -> [bool; 3] {
        let is = |k: usize| self.sign[k % 3][i / AT_ONCE % CHUNKS][i % AT_ONCE] < 0.0;
        [is(0), is(1), is(2)]
    }

    /// The planes of a box as the rays of a chunk see them.
    #[inline(always)]
    fn planes<L: Lanes<8>>(&self, chunk: usize, b: &Aabb) -> Planes<L> {
        let chunk = chunk % CHUNKS;
        if let Some(negative) = self.common[chunk] {
            return Planes::new(&in_order(b, negative));
        }
        let zero = L::splat(0.0);
        let (mut first, mut last) = ([zero; 3], [zero; 3]);
        for k in 0..3 {
            let sign = L::load(&self.sign[k][chunk]);
            let (min, max) = (L::splat(b.min[k]) * sign, L::splat(b.max[k]) * sign);
            (first[k], last[k]) = (min.least(max), min.most(max));
        }
        Planes { first, last }
    }

    /// [`Prepared::slab`], cut to the ray's interval: the same steps in the same order. A NaN constrains nothing.
    #[inline(always)]
    fn cut<L: Lanes<8>>(&self, chunk: usize, planes: &Planes<L>) -> u32 {
        let (mut t0, mut t1) = (row::<L>(&self.t_min, chunk), row::<L>(&self.t, chunk));
        (t0, t1) = self.axis(chunk, 0, planes, t0, t1);
        (t0, t1) = self.axis(chunk, 1, planes, t0, t1);
        (t0, t1) = self.axis(chunk, 2, planes, t0, t1);
        t0.le(t1)
    }

    /// What one axis leaves of an interval.
    #[inline(always)]
    fn axis<L: Lanes<8>>(&self, chunk: usize, k: usize, planes: &Planes<L>, near: L, far: L) -> (L, L) {
        let (k, inv) = (k % 3, row::<L>(&self.inv[k % 3], chunk));
        (
            ((planes.first[k] - row(&self.near_origin[k], chunk)) * inv).most(near),
            ((planes.last[k] - row(&self.far_origin[k], chunk)) * inv).least(far),
        )
    }

    /// `Prepared::slab` of the rays of a chunk.
    #[inline(always)]
    pub(in crate::walk::group) fn slab<L: Lanes<8>>(&self, chunk: usize, b: &Aabb) -> (L, L) {
        let planes = self.planes::<L>(chunk, b);
        let (mut near, mut far) = (L::splat(f32::NEG_INFINITY), L::splat(f32::INFINITY));
        (near, far) = self.axis(chunk, 0, &planes, near, far);
        (near, far) = self.axis(chunk, 1, &planes, near, far);
        self.axis(chunk, 2, &planes, near, far)
    }
}

impl Range {
    /// What the extremes say of a box.
    #[inline(always)]
    fn met(&self, b: &Aabb) -> Met {
        // Least and greatest place at which any ray enters, and at which any leaves.
        let (mut near, mut far) = (self.t_min, self.t);
        let (first, last) = in_order(b, self.negative);
        let mut axis = |k: usize| {
            let (first, last) = (first[k], last[k]);
            if !(self.inv[k].1 <= f32::MAX) {
                // Along a plane: what is infinite or NaN is for the rays themselves to say.
                near.1 = f32::INFINITY;
                return;
            }
            let (low, high) = times((first - self.near_origin[k].1, first - self.near_origin[k].0), self.inv[k]);
            near = (most(low, near.0), most(high, near.1));
            let (low, high) = times((last - self.far_origin[k].1, last - self.far_origin[k].0), self.inv[k]);
            far = (least(low, far.0), least(high, far.1));
        };
        axis(0);
        axis(1);
        axis(2);
        match () {
            () if near.0 > far.1 => Met::None,
            () if near.1 <= far.0 => Met::All,
            () => Met::Some,
        }
    }
}

/// An interval times one that is positive. Each rounds monotonically, so it holds every product of two of their numbers.
#[inline(always)]
fn times((low, high): (f32, f32), (least_inv, most_inv): (f32, f32)) -> (f32, f32) {
    (low * if low < 0.0 { most_inv } else { least_inv }, high * if high < 0.0 { least_inv } else { most_inv })
}

/// The planes of a box that rays of these signs meet first, and those that they meet last; mirrored.
#[inline(always)]
fn in_order(b: &Aabb, negative: [bool; 3]) -> Ends {
    let (mut first, mut last) = (b.min, b.max);
    for k in 0..3 {
        if negative[k] {
            (first[k], last[k]) = (-b.max[k], -b.min[k]);
        }
    }
    (first, last)
}

/// Planes of a box in the order of the rays, mirrored as those are.
struct Planes<L> {
    first: [L; 3],
    last: [L; 3],
}

impl<L: Lanes<8>> Planes<L> {
    #[inline(always)]
    fn new((first, last): &Ends) -> Self {
        let zero = L::splat(0.0);
        let mut planes = Self { first: [zero; 3], last: [zero; 3] };
        for k in 0..3 {
            (planes.first[k], planes.last[k]) = (L::splat(first[k]), L::splat(last[k]));
        }
        planes
    }
}
