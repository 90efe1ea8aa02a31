//! Better places for subtrees.
//!
//! A top-down split decides once and sends large primitives to one side with the small ones around their centres.
//! Bittner, Hapala and Havran, "Fast Insertion-Based Optimization of Bounding Volume Hierarchies", CGF 32(1), 2013:
//! take a subtree out, and put it where it adds least to the total area of boxes. Its old place is always a candidate,
//! so the total never grows.
//!
//! Places are searched from the root, depth first, and passed over where even an empty box could not win; the
//! old place's cost is the bound to begin with. Nothing is allocated: parents stand in the nodes' reserved words.
use super::Place;
use crate::build::sah::area;
use crate::bvh::{Child, Node};
use crate::geom::Aabb;
use crate::geom::vec::{size, sub};
use crate::num::{count, floor, index, weight};

/// Takes the `share` of subtrees below the root's children that have the largest boxes out and puts them back, so many
/// times or until nothing moves.
pub fn improve(nodes: &mut [Node], bounds: &Aabb, rounds: u32, share: f32) {
    // Areas in units of the scene, so that they neither overflow nor vanish.
    let unit = 1.0 / size(sub(bounds.max, bounds.min));
    let mut tree = Links { nodes, unit };
    for _ in 0..rounds {
        let least = largest(tree.nodes, unit, share);
        let mut moved = false;
        for node in 1..count(tree.nodes.len()) {
            for side in 0..2 {
                let place = Place::new(node, side);
                if area(&tree.bounds(place), unit) >= least {
                    moved |= tree.reinsert(place);
                }
            }
        }
        if !moved {
            return;
        }
    }
}

/// An area that no more than a share of all boxes have, or a larger one.
fn largest(nodes: &[Node], unit: f32, share: f32) -> f32 {
    /// The exponent, and three bits more: no box has more than the scene's half area, 3.
    const SHIFT: u32 = 20;
    const SIZES: usize = index(3f32.to_bits() >> SHIFT) + 1;
    if share >= 1.0 {
        return 0.0;
    }
    let mut sizes = [0u32; SIZES];
    for node in nodes {
        for side in 0..2 {
            if let Some(size) = sizes.get_mut(index(area(&node.bounds(side), unit).to_bits() >> SHIFT)) {
                *size += 1;
            }
        }
    }
    let most = floor(weight(2 * nodes.len()) * share);
    let mut larger = 0u32;
    let mut size = count(SIZES);
    for &more in sizes.iter().rev() {
        larger = larger.saturating_add(more);
        if larger > most {
            break;
        }
        size -= 1;
    }
    f32::from_bits(size << SHIFT)
}

/// Nodes whose first reserved word is their own place.
pub(super) struct Links<'n> {
    pub(super) nodes: &'n mut [Node],
    pub(super) unit: f32,
}

impl Links<'_> {
    pub(super) fn bounds(&self, place: Place) -> Aabb {
        self.nodes.get(place.node()).map_or(Aabb::EMPTY, |n| n.bounds(place.side()))
    }

    pub(super) fn child(&self, place: Place) -> Child {
        self.nodes.get(place.node()).map_or(Child::NONE, |n| n.child[place.side()])
    }

    /// The place of a node.
    pub(super) fn place(&self, node: usize) -> Place {
        self.nodes.get(node).map_or(Place::ROOT, |n| Place(n.reserved[0]))
    }

    /// Puts a child into a place, and tells it.
    fn set(&mut self, place: Place, child: Child, bounds: &Aabb) {
        if let Some(node) = self.nodes.get_mut(place.node()) {
            node.child[place.side()] = child;
            node.set_bounds(place.side(), bounds);
        }
        if let Some(node) = self.nodes.get_mut(index(child.number())).filter(|_| child.is_node()) {
            node.reserved[0] = place.0;
        }
    }

    /// Makes the boxes above a node fit it again.
    fn refit(&mut self, mut node: usize) {
        loop {
            let place = self.place(node);
            if place == Place::ROOT {
                return;
            }
            let (left, right) = (Place::new(count(node), 0), Place::new(count(node), 1));
            let bounds = self.bounds(left).join(&self.bounds(right));
            if let Some(parent) = self.nodes.get_mut(place.node()) {
                parent.set_bounds(place.side(), &bounds);
            }
            node = place.node();
        }
    }

    /// Takes out the subtree at a place, and puts it where it costs least. Returns whether that is another place.
    fn reinsert(&mut self, place: Place) -> bool {
        self.carry(place, |tree, bounds, old| {
            let target = tree.best_place(bounds, old);
            (target, target != old)
        })
    }

    /// Takes out the subtree at a place, and puts it where `choose` says, which sees the tree without it, its box, and
    /// its old place. What else `choose` says is returned; of the root's children that is nothing.
    pub(super) fn carry<T: Default>(&mut self, place: Place, choose: impl Fn(&Self, &Aabb, Place) -> (Place, T)) -> T {
        let node = place.node();
        let above = self.place(node);
        if above == Place::ROOT {
            return T::default();
        }
        let (moved, bounds) = (self.child(place), self.bounds(place));
        let (sibling, sibling_bounds) = (self.child(place.sibling()), self.bounds(place.sibling()));
        // Its sibling takes the node's place, and the node is free.
        self.set(above, sibling, &sibling_bounds);
        self.refit(above.node());
        let (target, said) = choose(self, &bounds, above);
        // The free node takes the target's place, over what was there and the subtree.
        let (other, other_bounds) = (self.child(target), self.bounds(target));
        self.set(target, Child::node(count(node)), &other_bounds.join(&bounds));
        self.set(Place::new(count(node), 0), other, &other_bounds);
        self.set(Place::new(count(node), 1), moved, &bounds);
        self.refit(target.node());
        said
    }

    /// What the boxes above a place would grow by, were `bounds` put there, and its own with `bounds` in it.
    pub(super) fn cost(&self, bounds: &Aabb, place: Place) -> f32 {
        let mut cost = area(&self.bounds(place).join(bounds), self.unit);
        let mut above = self.place(place.node());
        while above != Place::ROOT {
            let there = self.bounds(above);
            cost += area(&there.join(bounds), self.unit) - area(&there, self.unit);
            above = self.place(above.node());
        }
        cost
    }

    /// The place of least cost; `old` if no other is better.
    fn best_place(&self, bounds: &Aabb, old: Place) -> Place {
        let (mut best, mut least) = (old, self.cost(bounds, old));
        let own = area(bounds, self.unit);
        let mut todo = heapless::Vec::<(u32, f32), 128>::new();
        // The root's own box holds everything already and does not grow.
        let mut next = Some((0, 0.0));
        while let Some((node, grown)) = next.take().or_else(|| todo.pop()) {
            for side in 0..2 {
                let place = Place::new(node, side);
                let there = self.bounds(place);
                let joined = area(&there.join(bounds), self.unit);
                if grown + joined < least {
                    (best, least) = (place, grown + joined);
                }
                let (child, grown) = (self.child(place), grown + (joined - area(&there, self.unit)));
                // Below, at least its own area is added. (A full stack, of a very deep tree, only narrows the search.)
                if child.is_node() && grown + own < least {
                    let _ = todo.push((child.number(), grown));
                }
            }
            while todo.last().is_some_and(|&(_, grown)| grown + own >= least) {
                todo.pop();
            }
        }
        best
    }
}
