//! Groups of rays: a sphere's box stands for it, cut to the box above it.
//!
//! What a child bounds is inside of its sphere and inside of all that are above it (rule 50), so it is inside of the boxes
//! of those, which are taken one step larger than they are rounded. So rule 3 of [`crate::geom`] says that no hit is lost.
use super::Node;
use super::walk::Line;
use crate::bvh::group::Boxed;
use crate::geom::Aabb;
use crate::geom::ray::Prepared;
use crate::geom::vec::{least3, most3};

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

impl Boxed for Node {
    type Test = Line;

    #[inline(always)]
    fn test(ray: &Prepared) -> Line {
        Line::new(ray)
    }

    #[inline(always)]
    fn boxes(&self, around: &Aabb) -> [Aabb; 2] {
        [within(self, 0, around), within(self, 1, around)]
    }
}
