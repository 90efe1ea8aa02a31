//! Groups of rays: a node's box follows from the planes above it.
use super::walk::from;
use super::{LEAF, View};
use crate::blob::prims::Prims;
use crate::geom::Aabb;
use crate::geom::ray::Prepared;
use crate::geom::vec::{least, most};
use crate::num::index;
use crate::walk::group::{Heading, Slots, Tree};
use crate::walk::mailbox::NoMailbox;
use crate::walk::{Best, Meter, Stop};

/// The tree with its primitives.
pub(crate) struct Cells<'q, 'a> {
    pub view: &'q View<'a>,
    pub prims: &'q Prims<'a>,
}

impl<'a> Tree<'a> for Cells<'_, 'a> {
    /// A node's number.
    type Place = u32;

    #[inline(always)]
    fn root(&self) -> (u32, Aabb) {
        (0, *self.view.bounds)
    }

    #[inline(always)]
    fn open(
        &self,
        at: u32,
        bounds: &Aabb,
        heading: &Heading,
        mut child: impl FnMut(u32, Aabb) -> Result<(), Stop>,
    ) -> Result<Option<Slots<'a>>, Stop> {
        let node = *self.view.nodes.get(index(at)).ok_or(Stop::Corrupt)?;
        let Some(cut) = node.cut() else {
            debug_assert!(node.word & LEAF == LEAF, "what is not cut is a leaf");
            return Ok(Some(Slots::List(self.view.list(node).ok_or(Stop::Corrupt)?)));
        };
        let (mut below, mut above) = (*bounds, *bounds);
        (below.max[cut.axis.at()], above.min[cut.axis.at()]) = (cut.plane, cut.plane);
        let (first, second) = (node.number(), node.number().wrapping_add(1));
        if heading.is_negative(cut.axis.at()) {
            child(first, below)?;
            child(second, above)?;
        } else {
            child(second, above)?;
            child(first, below)?;
        }
        Ok(None)
    }

    #[inline(always)]
    fn alone<const ANY: bool>(
        &self,
        at: u32,
        bounds: &Aabb,
        ray: &Prepared,
        best: &mut Best,
        meter: &mut impl Meter,
    ) -> Result<bool, Stop> {
        let (near, far) = ray.slab(bounds);
        let t = (most(ray.t_min, near), least(best.t, far));
        if !(t.0 <= t.1) {
            return Ok(false);
        }
        from::<ANY>(self.view, self.prims, (at, t.0, t.1), ray, best, meter, &mut NoMailbox)
    }
}
