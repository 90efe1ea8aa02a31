//! Rays of one heading side by side: `N` of them against one box or one triangle.
//!
//! A number of all of them stands in one row, so that one instruction does the same step for each. On each lane the steps
//! are those of [`Prepared::new`] and [`Triangle::crossing`](crate::geom::Triangle::crossing), in the same order, so the
//! answers have the same bits. A lane for which `f32` is not enough goes to the one-triangle test.
mod range;

use super::NO_PRIM;
use super::heading::Heading;
use super::lanes::Lanes;
use crate::blob::block::Block;
use crate::geom::place::Place;
use crate::geom::ray::{Axis, ORIGIN_PAD, PAD, Prepared, blurs, doubts};
use crate::geom::triangle::{LEAST_DET, MOST_CANCELLED, MOST_DET};
use crate::geom::vec::Vec3;
use crate::geom::{Hit, Ray};
use crate::num::index;
pub(crate) use range::{Range, Ranges};

/// Rays from which a side of the scene is so far go alone: nothing of the others overflows.
const FAR: f32 = 1e37;

/// A number of each ray.
type Each<const N: usize> = [f32; N];

/// Rays of one heading, prepared, each with its best hit so far.
#[cfg_attr(target_arch = "x86_64", repr(align(32)))]
#[derive(Clone, Copy)]
pub(crate) struct Packet<const N: usize> {
    origin: [Each<N>; 3],
    near_origin: [Each<N>; 3],
    far_origin: [Each<N>; 3],
    inv: [Each<N>; 3],
    shear: [Each<N>; 2],
    dir: [Each<N>; 3],
    doubt: Each<N>,
    t_min: Each<N>,
    t: Each<N>,
    u: Each<N>,
    v: Each<N>,
    prim: [u32; N],
}

impl<const N: usize> Packet<N> {
    /// Nothing yet.
    pub(crate) const EMPTY: Self = {
        let (zero, none) = ([0.0; N], [f32::NEG_INFINITY; N]);
        Self {
            origin: [zero; 3],
            near_origin: [zero; 3],
            far_origin: [zero; 3],
            inv: [zero; 3],
            shear: [zero; 2],
            dir: [zero; 3],
            doubt: zero,
            t_min: zero,
            t: none,
            u: zero,
            v: zero,
            prim: [NO_PRIM; N],
        }
    };

    /// Takes rays. Those of lanes that are not `live` are not asked for, though they may stand there. Returns in which
    /// lanes the ray has the heading: the others are not prepared rightly.
    #[inline(always)]
    pub(crate) fn set<L: Lanes<N>>(&mut self, rays: &[Ray; N], live: u32, heading: Heading, place: &Place<'_>) -> u32 {
        let mut each = [&rays[0]; N];
        for i in 0..N {
            each[i] = &rays[i];
        }
        let (given, dir, t_min, t_max) = Ray::columns::<N, L>(each);
        let zero = L::splat(0.0);
        let dir = [dir[0] + zero, dir[1] + zero, dir[2] + zero];
        let good = heading.is::<N, L>(&dir) & t_min.le(t_max);

        let local = place.local;
        let origin = [given[0] - L::splat(local[0]), given[1] - L::splat(local[1]), given[2] - L::splat(local[2])];
        let one = L::splat(1.0);
        let inv = [one / dir[0], one / dir[1], one / dir[2]];
        let reach = |k: usize| {
            let (min, max) = (L::splat(place.bounds.min[k]), L::splat(place.bounds.max[k]));
            (max - origin[k]).abs().most((min - origin[k]).abs())
        };
        let extent = reach(2).most(reach(1).most(reach(0)));
        // Not so where an origin is NaN or infinite, either.
        let good = good & reach(0).lt(L::splat(FAR)) & reach(1).lt(L::splat(FAR)) & reach(2).lt(L::splat(FAR));
        let extent = extent * L::splat(PAD);
        for k in 0..3 {
            let pad =
                (extent + (origin[k].abs() * L::splat(ORIGIN_PAD) + L::splat(f32::MIN_POSITIVE))).signed_as(dir[k]);
            self.origin[k] = origin[k].store();
            self.near_origin[k] = (origin[k] + pad).store();
            self.far_origin[k] = (origin[k] - pad).store();
            self.inv[k] = inv[k].store();
            self.dir[k] = dir[k].store();
        }
        self.doubt = doubts(extent, place.coarse).store();
        let (kx, ky) = heading.kz.others();
        let inv_kz = inv[heading.kz.at()];
        self.shear = [(dir[kx.at()] * inv_kz).store(), (dir[ky.at()] * inv_kz).store()];
        self.t_min = t_min.store();
        self.t = L::choose(live, t_max, L::splat(f32::NEG_INFINITY)).store();
        self.prim = [NO_PRIM; N];
        good
    }

    /// Tests the triangle in a lane of a block. Returns the rays that hit.
    #[inline(always)]
    pub(crate) fn test<const ANY: bool, L: Lanes<N>>(
        &mut self,
        heading: Heading,
        block: &Block,
        lane: usize,
        boxes: &Boxes,
    ) -> u32 {
        let (kx, ky) = heading.kz.others();
        let lane = lane % 4;
        let corners = block.corners.each_ref().map(|v| [v[kx.at()][lane], v[ky.at()][lane], v[heading.kz.at()][lane]]);
        let row = |k: Axis| L::load(&self.origin[k.at()]);
        let origin = [row(kx), row(ky), row(heading.kz)];
        let shear = [L::load(&self.shear[0]), L::load(&self.shear[1])];
        let sheared = |v: Vec3| Sheared::<L>::new(v, &origin, &shear);
        let (a, b, c) = (sheared(corners[0]), sheared(corners[1]), sheared(corners[2]));
        let (pa, pb, pc) = (b.products::<N>(c), c.products::<N>(a), a.products::<N>(b));
        let (wa, wb, wc) = (pa.0 - pa.1, pb.0 - pb.1, pc.0 - pc.1);
        let (low, high) = (wa.least(wb).least(wc), wa.most(wb).most(wc));
        let zero = L::splat(0.0);
        let all = u32::MAX >> (32 - N);
        let doubt = L::load(&self.doubt);
        // As in `block::one`.
        let blur = blurs::<N, L>(L::load(&self.near_origin[0]), L::load(&self.far_origin[0]), doubt);
        let blur = blur * ((a.reach::<N>() + b.reach::<N>()) + c.reach::<N>());
        let doubt = blur.least(doubt);
        let under = zero - doubt;
        let maybe = all & !(low.lt(under) & doubt.lt(high));
        if maybe == 0 {
            return 0;
        }
        let det = wa + wb + wc;
        let depth = wa * a.z + wb * b.z + wc * c.z;
        let size = |p: (L, L)| p.0.abs() + p.1.abs();
        let sizes = (size(pa) + size(pb)) + size(pc);
        let clear = (doubt.lt(low) | high.lt(under))
            & L::splat(LEAST_DET).lt(det.abs())
            & det.abs().lt(L::splat(MOST_DET))
            & depth.abs().lt(L::splat(f32::INFINITY))
            & sizes.le(det.abs() * L::splat(MOST_CANCELLED));
        let mut odd = maybe & !clear;
        let mut hits = 0;
        while odd != 0 {
            hits |= self.again::<ANY>(heading, block, lane, index(odd.trailing_zeros()));
            odd &= odd - 1;
        }
        let (near, far) = self.slab::<L>(boxes, lane);
        let inv_kz = L::load(&self.inv[heading.kz.at()]);
        let t = depth / det * inv_kz;
        let t = far.least(near.most(t)) + zero;
        let best = L::load(&self.t);
        let good = maybe
            & clear
            & near.le(far)
            & L::load(&self.t_min).le(t)
            & t.le(best)
            & t.abs().lt(L::splat(f32::INFINITY));
        if good == 0 {
            return hits;
        }
        hits | self.take::<ANY, L>(good, t, (wb / det, wc / det), block.ids[lane % 4])
    }

    /// Takes the hits of some rays with a triangle, none of them beyond the best. Returns the rays.
    #[inline(always)]
    fn take<const ANY: bool, L: Lanes<N>>(&mut self, rays: u32, t: L, (u, v): (L, L), prim: u32) -> u32 {
        if ANY {
            // Nothing more is asked of them.
            self.t = L::choose(rays, L::splat(f32::NEG_INFINITY), L::load(&self.t)).store();
            self.each(rays, |_, place| *place = prim);
            return rays;
        }
        // At equal `t` the least number stays.
        let mut better = t.lt(L::load(&self.t)) & rays;
        self.each(rays & !better, |lane, place| better |= u32::from(prim < *place) << lane);
        self.t = L::choose(better, t, L::load(&self.t)).store();
        self.u = L::choose(better, u, L::load(&self.u)).store();
        self.v = L::choose(better, v, L::load(&self.v)).store();
        self.each(better, |_, place| *place = prim);
        better
    }

    /// For some rays the number of the primitive hit.
    #[inline(always)]
    fn each(&mut self, mut rays: u32, mut f: impl FnMut(usize, &mut u32)) {
        while rays != 0 {
            let lane = index(rays.trailing_zeros()) % N;
            rays &= rays - 1;
            f(lane, &mut self.prim[lane]);
        }
    }

    /// The slab test of a triangle's own box.
    #[inline(always)]
    fn slab<L: Lanes<N>>(&self, boxes: &Boxes, lane: usize) -> (L, L) {
        let (mut near, mut far) = (L::splat(f32::NEG_INFINITY), L::splat(f32::INFINITY));
        for k in 0..3 {
            let inv = L::load(&self.inv[k]);
            near = ((L::splat(boxes.first[k][lane % 4]) - L::load(&self.near_origin[k])) * inv).most(near);
            far = ((L::splat(boxes.last[k][lane % 4]) - L::load(&self.far_origin[k])) * inv).least(far);
        }
        (near, far)
    }

    /// The one-triangle test of a ray. Returns its bit if it hit.
    #[cold]
    #[inline(never)]
    fn again<const ANY: bool>(&mut self, heading: Heading, block: &Block, lane: usize, ray: usize) -> u32 {
        let i = ray % N;
        let row = |rows: &[Each<N>; 3]| [rows[0][i], rows[1][i], rows[2][i]];
        let (origin, inv) = (row(&self.origin), row(&self.inv));
        let (kx, ky) = heading.kz.others();
        let prepared = Prepared {
            origin,
            near_origin: row(&self.near_origin),
            far_origin: row(&self.far_origin),
            inv,
            negative: heading.negative,
            kz: heading.kz,
            kx,
            ky,
            turned: [[origin[kx.at()], origin[ky.at()], origin[heading.kz.at()]]; _],
            inv_kz: inv[heading.kz.at()],
            shear: [self.shear[0][i], self.shear[1][i]],
            dir: row(&self.dir),
            doubt: self.doubt[i],
            t_min: self.t_min[i],
            t_max: self.t[i],
            unit: 1.0,
        };
        let Some(found) = block.triangle(lane).crossing_closely(&prepared, self.t[i]) else {
            return 0;
        };
        let prim = block.ids[lane % 4];
        if ANY {
            (self.t[i], self.prim[i]) = (f32::NEG_INFINITY, prim);
        } else if found.t < self.t[i] || prim < self.prim[i] {
            (self.t[i], self.u[i], self.v[i], self.prim[i]) = (found.t, found.u, found.v, prim);
        }
        1 << i
    }

    /// The best hit of a ray.
    #[inline(always)]
    pub(crate) fn hit(&self, lane: usize) -> Option<Hit> {
        let i = lane % N;
        let (t, u, v, prim) = (self.t[i], self.u[i], self.v[i], self.prim[i]);
        (prim != NO_PRIM).then_some(Hit { t, u, v, prim })
    }

    /// Distance to beat, of the ray that has the most.
    #[inline(always)]
    pub(crate) fn farthest<L: Lanes<N>>(&self) -> f32 {
        L::load(&self.t).greatest()
    }

    /// Which rays look as far as this.
    #[inline(always)]
    pub(crate) fn reach<L: Lanes<N>>(&self, near: f32) -> u32 {
        L::splat(near).le(L::load(&self.t))
    }

    /// Which rays meet a box up to their distances to beat; `first` and `last` are its planes as their signs order them.
    #[inline(always)]
    pub(crate) fn meets<L: Lanes<N>>(&self, first: Vec3, last: Vec3) -> u32 {
        let (mut near, mut far) = (L::load(&self.t_min), L::load(&self.t));
        for k in 0..3 {
            let inv = L::load(&self.inv[k]);
            near = ((L::splat(first[k]) - L::load(&self.near_origin[k])) * inv).most(near);
            far = ((L::splat(last[k]) - L::load(&self.far_origin[k])) * inv).least(far);
        }
        near.le(far)
    }
}

/// The boxes of a block's triangles, as rays of a heading meet them.
pub(crate) struct Boxes {
    /// The planes that they meet first.
    pub(crate) first: [[f32; 4]; 3],
    /// And those that they meet last.
    pub(crate) last: [[f32; 4]; 3],
}

impl Boxes {
    #[inline(always)]
    pub(crate) fn new<L: Lanes<4>>(heading: Heading, block: &Block) -> Self {
        let (mut first, mut last) = ([[0.0; 4]; 3], [[0.0; 4]; 3]);
        let [a, b, c] = &block.corners;
        for k in 0..3 {
            let (a, b, c) = (L::load(&a[k]), L::load(&b[k]), L::load(&c[k]));
            let (min, max) = (c.least(b.least(a)).store(), c.most(b.most(a)).store());
            (first[k], last[k]) = if heading.negative[k] { (max, min) } else { (min, max) };
        }
        Self { first, last }
    }
}

/// A corner of a triangle in the frames of `N` rays.
#[derive(Clone, Copy)]
struct Sheared<L> {
    x: L,
    y: L,
    z: L,
}

impl<L> Sheared<L> {
    #[inline(always)]
    fn new<const N: usize>(v: Vec3, origin: &[L; 3], shear: &[L; 2]) -> Self
    where
        L: Lanes<N>,
    {
        let z = L::splat(v[2]) - origin[2];
        let x = L::splat(v[0]) - origin[0] - shear[0] * z;
        let y = L::splat(v[1]) - origin[1] - shear[1] * z;
        Self { x, y, z }
    }

    /// The sum of its distances from the two axes of the plane.
    #[inline(always)]
    fn reach<const N: usize>(self) -> L
    where
        L: Lanes<N>,
    {
        self.x.abs() + self.y.abs()
    }

    /// The two products of the edge function.
    #[inline(always)]
    fn products<const N: usize>(self, to: Self) -> (L, L)
    where
        L: Lanes<N>,
    {
        (self.x * to.y, self.y * to.x)
    }
}
