//! Primitives against the rays of a group: each is loaded once.
//!
//! A triangle is tested against eight rays at a time: on each lane the steps are those of [`Triangle::crossing`], in the same
//! order, so the answers have the same bits. A lane for which `f32` is not enough goes to the test of one ray.
use super::bundle::{Bundle, row};
use super::{AT_ONCE, CHUNKS, RAYS, Slots, State, each, low_byte};
use crate::blob::prims::Prims;
use crate::geom::Triangle;
use crate::geom::hit::Crossing;
use crate::geom::ray::{Axis, Prepared, blurs};
use crate::geom::triangle::{LEAST_DET, MOST_CANCELLED, MOST_DET};
use crate::num::{count, index};
use crate::walk::lanes::Lanes;
use crate::walk::leaf::crossing;
use crate::walk::{Best, Meter, Stop, Tally};

/// What a triangle test found, by lanes.
pub(super) struct Found {
    /// Lanes that hit.
    pub(super) good: u32,
    /// Lanes that are to be tested alone.
    pub(super) odd: u32,
    pub(super) t: [f32; AT_ONCE],
    pub(super) u: [f32; AT_ONCE],
    pub(super) v: [f32; AT_ONCE],
}

impl Found {
    pub(super) const NOTHING: Self = Self { good: 0, odd: 0, t: [0.0; AT_ONCE], u: [0.0; AT_ONCE], v: [0.0; AT_ONCE] };
}

/// So many rays of a chunk are tested together where there are no lanes.
const WORTH: u32 = 2;

/// A corner of a triangle in the frames of eight rays.
#[derive(Clone, Copy)]
struct Sheared<L> {
    x: L,
    y: L,
    z: L,
}

impl<L: Lanes<8>> Sheared<L> {
    /// The sum of its distances from the two axes of the plane.
    #[inline(always)]
    fn reach(self) -> L {
        self.x.abs() + self.y.abs()
    }

    /// The two products of the edge function.
    #[inline(always)]
    fn products(self, to: Self) -> (L, L) {
        (self.x * to.y, self.y * to.x)
    }
}

impl Bundle {
    /// A corner in the frames of a chunk's rays.
    #[inline(always)]
    fn corner<L: Lanes<8>>(&self, chunk: usize, kz: Axis, v: &[f32; 3]) -> Sheared<L> {
        let (kx, ky) = kz.others();
        let z = L::splat(v[kz.at()]) - row(&self.turned[2], chunk);
        let x = L::splat(v[kx.at()]) - row(&self.turned[0], chunk) - row::<L>(&self.shear[0], chunk) * z;
        let y = L::splat(v[ky.at()]) - row(&self.turned[1], chunk) - row::<L>(&self.shear[1], chunk) * z;
        Sheared { x, y, z }
    }

    /// The rays of a chunk whose bits are on, all steepest along one axis, against a triangle.
    #[inline(always)]
    fn test<L: Lanes<8>>(&self, chunk: usize, lanes: u32, kz: Axis, triangle: &Triangle) -> Found {
        let [a, b, c] = &triangle.v;
        let (a, b, c) = (self.corner::<L>(chunk, kz, a), self.corner(chunk, kz, b), self.corner(chunk, kz, c));
        let (pa, pb, pc) = (b.products(c), c.products(a), a.products(b));
        let (wa, wb, wc) = (pa.0 - pa.1, pb.0 - pb.1, pc.0 - pc.1);
        let (low, high) = (wa.least(wb).least(wc), wa.most(wb).most(wc));
        let zero = L::splat(0.0);
        let doubt = row::<L>(&self.doubt, chunk);
        let padded = (row(&self.near_origin[0], chunk), row(&self.far_origin[0], chunk));
        // As in `block::one`.
        let blur = blurs::<8, L>(padded.0, padded.1, doubt) * ((a.reach() + b.reach()) + c.reach());
        let doubt = blur.least(doubt);
        let under = zero - doubt;
        let maybe = lanes & !(low.lt(under) & doubt.lt(high));
        if maybe == 0 {
            return Found::NOTHING;
        }
        let det = wa + wb + wc;
        let depth = wa * a.z + wb * b.z + wc * c.z;
        let sizes = ((pa.0.abs() + pa.1.abs()) + (pb.0.abs() + pb.1.abs())) + (pc.0.abs() + pc.1.abs());
        let infinite = L::splat(f32::INFINITY);
        let clear = (doubt.lt(low) | high.lt(under))
            & L::splat(LEAST_DET).lt(det.abs())
            & det.abs().lt(L::splat(MOST_DET))
            & depth.abs().lt(infinite)
            & sizes.le(det.abs() * L::splat(MOST_CANCELLED));
        let (near, far) = self.slab::<L>(chunk, &triangle.bounds());
        let t = depth / det * row(&self.inv_kz, chunk);
        let t = far.least(near.most(t)) + zero;
        let good = maybe
            & clear
            & near.le(far)
            & row::<L>(&self.t_min, chunk).le(t)
            & t.le(row(&self.t, chunk))
            & t.abs().lt(infinite);
        Found { good, odd: maybe & !clear, t: t.store(), u: (wb / det).store(), v: (wc / det).store() }
    }
}

impl State {
    /// Some rays against a leaf. Returns those that are done: with `ANY`, that have hit.
    #[inline(always)]
    pub(super) fn leaf<const ANY: bool, L: Lanes<8>>(
        &mut self,
        prims: &Prims<'_>,
        slots: Slots<'_>,
        rays: u64,
        meter: &mut Tally,
    ) -> Result<u64, Stop> {
        let len = match slots {
            Slots::Run(_, len) => len,
            Slots::List(slots) => count(slots.len()),
        };
        if !meter.prims(len) {
            return Err(Stop::Fuel);
        }
        let mut done = 0;
        if !prims.refs.is_empty() {
            let (first, len, list): (_, _, &[u32]) = match slots {
                Slots::Run(first, len) => (first, len, &[]),
                Slots::List(list) => (0, 0, list),
            };
            for slot in list.iter().copied().chain(first..first.saturating_add(len)) {
                done |= self.mixed::<ANY>(prims, slot, rays & !done)?;
            }
            return Ok(done);
        }
        match slots {
            Slots::Run(first, len) => {
                let run = prims.triangles.get(index(first)..).and_then(|t| t.get(..index(len))).ok_or(Stop::Corrupt)?;
                for (slot, triangle) in (first..).zip(run) {
                    done |= self.triangle::<ANY, L>(prims, slot, triangle, rays & !done);
                }
            }
            Slots::List(slots) => {
                for &slot in slots {
                    let triangle = prims.triangles.get(index(slot)).ok_or(Stop::Corrupt)?;
                    done |= self.triangle::<ANY, L>(prims, slot, triangle, rays & !done);
                }
            }
        }
        Ok(done)
    }

    /// A primitive of any kind, where other kinds stand among the triangles.
    #[inline(never)]
    fn mixed<const ANY: bool>(&mut self, prims: &Prims<'_>, slot: u32, rays: u64) -> Result<u64, Stop> {
        let mut done = 0;
        for i in each(rays) {
            let ray = self.bundle.ray(i);
            if let Some(found) = crossing(prims, slot, &ray, self.best[i % RAYS].t)? {
                self.offer(i / AT_ONCE, i % AT_ONCE, found, prims.id(slot));
                done |= u64::from(ANY) << i;
            }
        }
        Ok(done)
    }

    #[inline(always)]
    fn triangle<const ANY: bool, L: Lanes<8>>(
        &mut self,
        prims: &Prims<'_>,
        slot: u32,
        triangle: &Triangle,
        rays: u64,
    ) -> u64 {
        let mut done = 0;
        for kz in Axis::ALL {
            let rays = rays & self.bundle.steepest[kz.at()];
            if rays == 0 {
                continue;
            }
            for chunk in 0..CHUNKS {
                let lanes = low_byte(rays >> (chunk * AT_ONCE));
                if lanes == 0 {
                    continue;
                }
                let found = match () {
                    () if L::AT_ONCE => self.bundle.test::<L>(chunk, lanes, kz, triangle),
                    // In loops those are not worth all eight.
                    () if lanes.count_ones() < WORTH => Found { odd: lanes, ..Found::NOTHING },
                    () => self.bundle.test_in_loops(chunk, lanes, kz, triangle),
                };
                for lane in each(u64::from(found.good)) {
                    let (t, u, v) = (found.t[lane % AT_ONCE], found.u[lane % AT_ONCE], found.v[lane % AT_ONCE]);
                    self.offer(chunk, lane, Crossing { t, u, v, enters: true }, prims.id(slot));
                }
                let mut hit = found.good;
                for lane in each(u64::from(found.odd)) {
                    let i = chunk * AT_ONCE + lane;
                    let Some(&best) = self.best.get(i) else { continue };
                    if let Some(crossing) = again(triangle, self.bundle.ray(i), best) {
                        self.offer(chunk, lane, crossing, prims.id(slot));
                        hit |= 1 << lane;
                    }
                }
                if ANY {
                    done |= u64::from(hit) << (chunk * AT_ONCE);
                }
            }
        }
        done
    }

    #[inline(always)]
    fn offer(&mut self, chunk: usize, lane: usize, crossing: Crossing, prim: u32) {
        if let Some(best) = self.best.get_mut(chunk * AT_ONCE + lane) {
            best.offer(crossing, prim);
            self.bundle.set_t(chunk * AT_ONCE + lane, best.t);
        }
    }
}

/// The one-ray test of a lane.
#[cold]
#[inline(never)]
fn again(triangle: &Triangle, ray: Prepared, best: Best) -> Option<Crossing> {
    triangle.crossing(&ray, best.t)
}
