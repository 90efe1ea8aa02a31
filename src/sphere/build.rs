//! The builder: the tree of boxes, its boxes replaced by spheres.
//!
//! A sphere's centre is that of the box around what is below it, its radius the distance to the farthest corner of the
//! box of a primitive below, rounded up. (To contain the spheres below, as a walk up from the leaves would have it,
//! takes larger ones.) Each node looks at all that is below it: O(n) for each level.
use super::{Node, farthest};
use crate::build::Ref;
use crate::bvh::build::Tree;
use crate::geom::root::sqrt;
use crate::geom::vec::Vec3;
use crate::geom::{Aabb, Sphere};
use crate::num::{narrow, wide};

/// The nodes of a tree with spheres, in walk order.
pub fn nodes(tree: Tree<'_>) -> impl Iterator<Item = Node> {
    tree.walk().map(move |(boxes, at, _)| {
        let sphere = |side: usize| around(&boxes.bounds(side), tree.refs_below(at, side));
        Node::new([sphere(0), sphere(1)], boxes.child)
    })
}

/// The sphere around what is in a box.
fn around<'r>(bounds: &Aabb, refs: impl Iterator<Item = &'r Ref>) -> Sphere {
    // In f64, where half of a denormal is exact: the centre is then never outside the box.
    let middle = |k: usize| narrow((wide(bounds.min[k]) + wide(bounds.max[k])) * 0.5);
    let center: Vec3 = [middle(0), middle(1), middle(2)];
    let square = refs.map(|r| farthest(center, &r.bounds)).fold(0.0, |a, b| if a > b { a } else { b });
    Sphere { center, radius: root_up(square) }
}

/// The least `f32` whose square, in f64, is not below `square`; infinite if it is beyond `f32`.
fn root_up(square: f64) -> f32 {
    // Half the exponent, so that the f32 root is one of a number near 1.
    let unit = f64::from_bits(((square.to_bits() >> 53) + 512) << 52);
    let mut root = narrow(wide(sqrt(narrow(square / (unit * unit)))) * unit);
    let enough = |r: f32| wide(r) * wide(r) >= square;
    while root > 0.0 && enough(root.next_down()) {
        root = root.next_down();
    }
    while !enough(root) {
        root = root.next_up();
    }
    root
}
