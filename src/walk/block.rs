//! A run of blocks against a ray: four triangles at a time.
//!
//! On each lane the steps are those of [`Triangle::crossing`](crate::geom::Triangle::crossing), in the same order, so the answers
//! have the same bits. A lane for which `f32` is not enough goes to the one-triangle test.
use super::aim::{Aim, Source};
use super::lanes::{self, Lanes};
use super::{Best, Meter, Stop};
use crate::blob::block::Block;
use crate::geom::hit::Crossing;
use crate::geom::ray::{Axis, blur};
use crate::geom::triangle::{LEAST_DET, MOST_CANCELLED, MOST_DET};
use crate::num::index;

/// A corner of four triangles in the ray's frame.
#[derive(Clone, Copy)]
struct Sheared<L> {
    x: L,
    y: L,
    z: L,
}

impl<L: Lanes<4>> Sheared<L> {
    #[inline(always)]
    fn new(corner: &[[f32; 4]; 3], [kx, ky, kz]: [Axis; 3], ray: impl Aim) -> Self {
        let (turned, shear) = (ray.turned(), ray.shear());
        let z = L::load(&corner[kz.at()]) - L::splat(turned[2]);
        let x = L::load(&corner[kx.at()]) - L::splat(turned[0]) - L::splat(shear[0]) * z;
        let y = L::load(&corner[ky.at()]) - L::splat(turned[1]) - L::splat(shear[1]) * z;
        Self { x, y, z }
    }

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

/// Tests the `len` triangles of the blocks from number `first`. Returns whether the walk is over: with `ANY`, at the first hit.
///
/// # Errors
/// [`Stop::Fuel`] if the meter does not allow `len` tests, [`Stop::Corrupt`] if the blocks do not exist.
#[inline(always)]
pub fn test<const ANY: bool, L: Lanes<4>>(
    blocks: &[Block],
    (first, len): (u32, u32),
    ray: impl Aim,
    best: &mut Best,
    meter: &mut impl Meter,
) -> Result<bool, Stop> {
    if !meter.prims(len) {
        return Err(Stop::Fuel);
    }
    let mut blocks = blocks.get(index(first)..).unwrap_or(&[]).iter();
    let mut left = len;
    loop {
        let block = blocks.next().ok_or(Stop::Corrupt)?;
        let lanes = if left < 4 { (1 << left) - 1 } else { 15 };
        let over = if lanes::HERE {
            one::<ANY, L>(block, lanes, ray, best)
        } else {
            each::<ANY>(block, left.min(4), ray, best)
        };
        if over {
            return Ok(true);
        }
        if left <= 4 {
            return Ok(false);
        }
        left -= 4;
    }
}

/// Tests the triangles in those lanes of a block whose bits are on.
#[inline(always)]
fn one<const ANY: bool, L: Lanes<4>>(block: &Block, lanes: u32, ray: impl Aim, best: &mut Best) -> bool {
    let [a, b, c] = &block.corners;
    let axes = ray.axes();
    let corner = |of| Sheared::<L>::new(of, axes, ray);
    let (a, b, c) = (corner(a), corner(b), corner(c));
    let (pa, pb, pc) = (b.products(c), c.products(a), a.products(b));
    let (wa, wb, wc) = (pa.0 - pa.1, pb.0 - pb.1, pc.0 - pc.1);
    let (low, high) = (wa.least(wb).least(wc), wa.most(wb).most(wc));
    let zero = L::splat(0.0);
    // Both bounds of `geom::triangle` at once, the lesser for each lane: which one tells is as good as random where triangles
    // are of all sizes.
    let blur = blur(ray.near_origin()[0], ray.far_origin()[0], ray.doubt());
    let blur = L::splat(blur) * ((a.reach() + b.reach()) + c.reach());
    let doubt = blur.least(L::splat(ray.doubt()));
    let under = zero - doubt;
    let maybe = lanes & !(low.lt(under) & doubt.lt(high));
    if maybe == 0 {
        return false;
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
    let mut found = false;
    let mut odd = maybe & !clear;
    while odd != 0 {
        // By value both ways: a ray and a best hit that nobody points to can stay in registers.
        let (hit, after) = again(block, index(odd.trailing_zeros()), ray.source(), *best);
        found |= hit;
        *best = after;
        odd &= odd - 1;
    }
    if ANY && found {
        return true;
    }
    let (near, far) = slab::<L>(block, ray);
    let t = depth / det * L::splat(ray.inv_kz());
    let t = far.least(near.most(t)) + zero;
    let mut good = maybe
        & clear
        & near.le(far)
        & L::splat(ray.t_min()).le(t)
        & t.le(L::splat(best.t))
        & t.abs().lt(L::splat(f32::INFINITY));
    if good == 0 {
        return false;
    }
    if ANY {
        // Which and where is not asked.
        best.offer(Crossing { t: best.t, u: 0.0, v: 0.0, enters: true }, 0);
        return true;
    }
    let (t, u, v) = (t.store(), (wb / det).store(), (wc / det).store());
    while good != 0 {
        let lane = index(good.trailing_zeros()) % 4;
        good &= good - 1;
        if t[lane] <= best.t {
            best.offer(Crossing { t: t[lane], u: u[lane], v: v[lane], enters: true }, block.ids[lane]);
        }
    }
    false
}

/// Tests the first `len` triangles of a block, one after another.
#[inline(always)]
fn each<const ANY: bool>(block: &Block, len: u32, ray: impl Aim, best: &mut Best) -> bool {
    for lane in 0..index(len) {
        if let Some(crossing) = ray.meets(&block.triangle(lane), best.t) {
            best.offer(crossing, block.ids[lane % 4]);
            if ANY {
                return true;
            }
        }
    }
    false
}

/// The slab test of the triangles' own boxes.
#[inline(always)]
fn slab<L: Lanes<4>>(block: &Block, ray: impl Aim) -> (L, L) {
    let [a, b, c] = &block.corners;
    let (mut near, mut far) = (L::splat(f32::NEG_INFINITY), L::splat(f32::INFINITY));
    let (near_origin, far_origin, inv) = (ray.near_origin(), ray.far_origin(), ray.inv());
    let mut axis = |k: usize| {
        let (a, b, c) = (L::load(&a[k]), L::load(&b[k]), L::load(&c[k]));
        let (min, max) = (c.least(b.least(a)), c.most(b.most(a)));
        let inv = L::splat(inv[k]);
        // Not branched on: which way rays go is as good as random.
        let (first, last) = min.exchanged(max, inv.negative());
        near = ((first - L::splat(near_origin[k])) * inv).most(near);
        far = ((last - L::splat(far_origin[k])) * inv).least(far);
    };
    axis(0);
    axis(1);
    axis(2);
    (near, far)
}

/// The rest of the one-triangle test of a lane. Returns whether it hit, and the best hit then.
#[cold]
#[inline(never)]
fn again(block: &Block, lane: usize, ray: impl Source, mut best: Best) -> (bool, Best) {
    let crossing = ray.prepared().and_then(|ray| block.triangle(lane).crossing_closely(&ray, best.t));
    if let Some(crossing) = crossing {
        best.offer(crossing, block.ids[lane % 4]);
    }
    (crossing.is_some(), best)
}
