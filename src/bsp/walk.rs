//! The walk: front to back, the side that the ray comes from first.
//!
//! A node has the interval of `t` in which the ray is inside its box, padded as the slab test pads it. The plane ends
//! it for the nearer side at its farther distance and begins it for the other at its nearer one, so both intervals are
//! those of the slab test on the two boxes (Sung and Shirley, "Ray Tracing with the BSP Tree", Graphics Gems III, 1992;
//! Havran's case analysis of 2000 becomes needless, because the pad decides all ties). A side is visited if its
//! interval is not empty. A hit beyond its leaf is kept as the best so far; a side that begins beyond the best is
//! dropped, one that begins at it is not, because a primitive there may have the lesser number.
use super::{LEAF, View};
use crate::blob::MAX_STACK;
use crate::blob::prims::Prims;
use crate::geom::ray::{Axis, Prepared};
use crate::geom::vec::{least, most};
use crate::num::index;
use crate::walk::{Best, Mailbox, Meter, Stop, test_listed};

/// What a walk reads of the ray for a plane of one axis.
#[derive(Clone, Copy)]
struct Row {
    near_origin: f32,
    far_origin: f32,
    inv: f32,
    /// Which child comes first.
    first: u32,
}

impl Row {
    #[inline(always)]
    const fn new(ray: &Prepared, axis: Axis) -> Self {
        let k = axis.at();
        let first = if ray.negative[k] { 1 } else { 0 };
        Self { near_origin: ray.near_origin[k], far_origin: ray.far_origin[k], inv: ray.inv[k], first }
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
        mailbox: &mut impl Mailbox,
    ) -> Result<bool, Stop> {
        let (near, far) = ray.slab(self.bounds);
        let (t0, t1) = (most(ray.t_min, near), least(best.t, far));
        if !(t0 <= t1) {
            return Ok(false);
        }
        from::<ANY>(self, prims, (0, t0, t1), ray, best, meter, mailbox)
    }
}

/// The walk from a node on, given the interval of its box.
#[inline(always)]
pub(super) fn from<const ANY: bool>(
    view: &View<'_>,
    prims: &Prims<'_>,
    (mut at, mut t0, mut t1): (u32, f32, f32),
    ray: &Prepared,
    best: &mut Best,
    meter: &mut impl Meter,
    mailbox: &mut impl Mailbox,
) -> Result<bool, Stop> {
    // Four rows, so that two bits of a word are a good index; the last is never read.
    let z = Row::new(ray, Axis::Z);
    let rows = [Row::new(ray, Axis::X), Row::new(ray, Axis::Y), z, z];
    let mut stack = heapless::Vec::<(u32, f32, f32), { index(MAX_STACK) }>::new();
    loop {
        let leaf = loop {
            if !meter.node() {
                return Err(Stop::Fuel);
            }
            let node = *view.nodes.get(index(at)).ok_or(Stop::Corrupt)?;
            meter.at(|| view.bounds_of(at));
            let axis = node.word & LEAF;
            if axis == LEAF {
                break node;
            }
            let (row, plane) = (rows[index(axis)], f32::from_bits(node.place));
            // Prepared::near and far.
            let near = (plane - row.near_origin) * row.inv;
            let far = (plane - row.far_origin) * row.inv;
            let (end, begin) = (least(far, t1), most(near, t0));
            let child = node.number();
            let (first, second) = (child.wrapping_add(row.first), child.wrapping_add(row.first ^ 1));
            if t0 <= end {
                if begin <= t1 {
                    stack.push((second, begin, t1)).map_err(|_| Stop::Corrupt)?;
                }
                (at, t1) = (first, end);
            } else {
                // The near distance is not greater than the far one: this side is not empty.
                (at, t0) = (second, begin);
            }
        };
        let list = view.list(leaf).ok_or(Stop::Corrupt)?;
        if !list.is_empty() && test_listed::<ANY>(prims, list, ray, best, meter, mailbox)? {
            return Ok(true);
        }
        // Go on with the latest waiting side that is not beyond the best hit.
        loop {
            match stack.pop() {
                Some((waiting, begin, end)) if begin <= best.t => {
                    (at, t0, t1) = (waiting, begin, least(best.t, end));
                    break;
                }
                Some(_) => {}
                None => return Ok(false),
            }
        }
    }
}
