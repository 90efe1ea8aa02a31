//! Groups of rays in binary trees, whatever their nodes bound their children with.
use super::tree::{Branch, root};
use super::walk::{Rows, Test, descend};
use super::{Child, Node};
use crate::blob::prims::Prims;
use crate::geom::Aabb;
use crate::geom::ray::Prepared;
use crate::num::index;
use crate::walk::group::{Heading, Slots, Tree};
use crate::walk::{Best, Meter, Stop};

/// A node as groups see it.
pub(crate) trait Boxed: Branch + Sized {
    /// What one ray asks of such nodes.
    type Test: Test<Self>;

    /// That of a ray.
    fn test(ray: &Prepared) -> Self::Test;

    /// Boxes around what the children bound, where that of the node is `around`.
    fn boxes(&self, around: &Aabb) -> [Aabb; 2];
}

impl Boxed for Node {
    type Test = Rows;

    #[inline(always)]
    fn test(ray: &Prepared) -> Rows {
        Rows::new(ray)
    }

    #[inline(always)]
    fn boxes(&self, _: &Aabb) -> [Aabb; 2] {
        [self.bounds(0), self.bounds(1)]
    }
}

/// The tree with its primitives and its box.
pub(crate) struct Boxes<'q, 'a, N> {
    pub nodes: &'a [N],
    pub prims: &'q Prims<'a>,
    pub bounds: &'q Aabb,
}

impl<'a, N: Boxed> Tree<'a> for Boxes<'_, 'a, N> {
    type Place = Child;

    #[inline(always)]
    fn root(&self) -> (Child, Aabb) {
        (root(self.nodes, self.prims.len), *self.bounds)
    }

    #[inline(always)]
    fn open(
        &self,
        at: Child,
        bounds: &Aabb,
        heading: &Heading,
        mut child: impl FnMut(Child, Aabb) -> Result<(), Stop>,
    ) -> Result<Option<Slots<'a>>, Stop> {
        if !at.is_node() {
            return Ok(Some(Slots::Run(at.number(), at.len())));
        }
        let node = self.nodes.get(index(at.number())).ok_or(Stop::Corrupt)?;
        let ([a, b], [first, second]) = (node.boxes(bounds), node.children());
        let (first, second) = ((first, a), (second, b));
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
        descend::<ANY, _>(self.nodes, at, &N::test(ray), self.prims, ray, best, meter)
    }
}
