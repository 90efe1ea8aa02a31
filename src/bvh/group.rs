//! Groups of rays.
use super::tree::root;
use super::walk::{Rows, descend};
use super::{Child, View};
use crate::blob::prims::Prims;
use crate::geom::Aabb;
use crate::geom::ray::Prepared;
use crate::num::index;
use crate::walk::group::{Heading, Slots, Tree};
use crate::walk::{Best, Meter, Stop};

/// The tree with its primitives and its box.
pub(crate) struct Boxes<'q, 'a> {
    pub view: &'q View<'a>,
    pub prims: &'q Prims<'a>,
    pub bounds: &'q Aabb,
}

impl<'a> Tree<'a> for Boxes<'_, 'a> {
    type Place = Child;

    #[inline(always)]
    fn root(&self) -> (Child, Aabb) {
        (root(self.view.nodes, self.prims.len), *self.bounds)
    }

    #[inline(always)]
    fn open(
        &self,
        at: Child,
        _: &Aabb,
        heading: &Heading,
        mut child: impl FnMut(Child, Aabb) -> Result<(), Stop>,
    ) -> Result<Option<Slots<'a>>, Stop> {
        if !at.is_node() {
            return Ok(Some(Slots::Run(at.number(), at.len())));
        }
        let node = self.view.nodes.get(index(at.number())).ok_or(Stop::Corrupt)?;
        let (a, b) = (node.bounds(0), node.bounds(1));
        let (first, second) = ((node.child[0], a), (node.child[1], b));
        let (first, second) = if heading.swaps(&a, &b) { (second, first) } else { (first, second) };
        child(second.0, second.1)?;
        child(first.0, first.1)?;
        Ok(None)
    }

    #[inline(always)]
    fn costs(&self, at: Child) -> bool {
        at.is_node()
    }

    #[inline(always)]
    fn alone<const ANY: bool>(
        &self,
        at: Child,
        _: &Aabb,
        ray: &Prepared,
        best: &mut Best,
        meter: &mut impl Meter,
    ) -> Result<bool, Stop> {
        descend::<ANY, _>(self.view.nodes, at, &Rows::new(ray), self.prims, ray, best, meter)
    }
}
