//! Groups of rays: a sphere's box stands for it, cut to the box above it.
//!
//! What a child bounds is inside of its sphere and inside of all that are above it (rule 50), so it is inside of the boxes
//! of those, which are taken one step larger than they are rounded. So rule 3 of [`crate::geom`] says that no hit is lost.
use super::walk::Line;
use super::{Node, View};
use crate::blob::prims::Prims;
use crate::bvh::Child;
use crate::bvh::tree::root;
use crate::bvh::walk::descend;
use crate::geom::Aabb;
use crate::geom::ray::Prepared;
use crate::geom::vec::{least3, most3};
use crate::num::index;
use crate::walk::group::{Heading, Slots, Tree};
use crate::walk::{Best, Meter, Stop};

/// The tree with its primitives and its box.
pub(crate) struct Spheres<'q, 'a> {
    pub view: &'q View<'a>,
    pub prims: &'q Prims<'a>,
    pub bounds: &'q Aabb,
}

/// The box of a child's sphere, as far as it is in that of the node.
#[inline(always)]
fn within(node: &Node, side: usize, around: &Aabb) -> Aabb {
    let sphere = node.sphere(side);
    let (c, r) = (sphere.center, sphere.radius);
    let below = |k: usize| (c[k] - r).next_down();
    let above = |k: usize| (c[k] + r).next_up();
    Aabb {
        min: most3([below(0), below(1), below(2)], around.min),
        max: least3([above(0), above(1), above(2)], around.max),
    }
}

impl<'a> Tree<'a> for Spheres<'_, 'a> {
    type Place = Child;

    #[inline(always)]
    fn root(&self) -> (Child, Aabb) {
        (root(self.view.nodes, self.prims.len), *self.bounds)
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
        let node = self.view.nodes.get(index(at.number())).ok_or(Stop::Corrupt)?;
        let (a, b) = (within(node, 0, bounds), within(node, 1, bounds));
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
        descend::<ANY, _>(self.view.nodes, at, &Line::new(ray), self.prims, ray, best, meter)
    }
}
