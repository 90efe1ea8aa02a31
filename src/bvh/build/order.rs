//! From a tree whose nodes stand anywhere to nodes in walk order.
//!
//! One pass from the leaves up decides which subtrees become leaves: those whose primitives are few enough and cost
//! no more to test than the subtree costs to walk. It also counts what is below each node, so that nodes can then be
//! written one after the other, each child's number known before it is written.
use super::Place;
use crate::build::Ref;
use crate::build::sah::area;
use crate::bvh::{Child, Node};
use crate::geom::Aabb;
use crate::geom::vec::{size, sub};
use crate::num::{count, index, weight};

/// A finished tree: its nodes' reserved words hold the numbers of nodes (0 for one that is a leaf) and of primitives in
/// the subtree.
#[derive(Clone, Copy, Debug)]
pub struct Tree<'n> {
    refs: &'n [Ref],
    nodes: &'n [Node],
    /// Number of nodes in walk order.
    pub len: u32,
    /// Deepest stack of a walk.
    pub stack: u32,
}

/// The deepest stack that a walk of the nodes needs, if none becomes a leaf; more than any limit if it is too deep.
pub fn depth(nodes: &[Node]) -> u32 {
    let mut todo = heapless::Vec::<(u32, u32), 128>::new();
    let mut deepest = 0;
    let mut next = (!nodes.is_empty()).then_some((0, 1));
    while let Some((node, level)) = next.take().or_else(|| todo.pop()) {
        deepest = deepest.max(level);
        for child in nodes.get(index(node)).map_or([Child::NONE; 2], |n| n.child) {
            if child.is_node() && child != Child::NONE && todo.push((child.number(), level + 1)).is_err() {
                return u32::MAX;
            }
        }
    }
    deepest
}

impl<'n> Tree<'n> {
    /// Joins subtrees of up to `leaf` primitives into leaves where that costs less, and counts. Visiting a node costs
    /// as much as `node_cost` primitive tests.
    pub(super) fn new(refs: &'n mut [Ref], nodes: &'n mut [Node], bounds: &Aabb, leaf: u32, node_cost: f32) -> Self {
        let unit = 1.0 / size(sub(bounds.max, bounds.min));
        if !nodes.is_empty() {
            Join { refs, nodes, unit, leaf, node_cost }.run(bounds);
        }
        let mut tree = Self { refs, nodes, len: nodes.first().map_or(0, |n| n.reserved[0]), stack: 0 };
        tree.stack = tree.walk().map(|(_, _, level)| level).fold(0, u32::max);
        tree
    }

    /// A child's numbers of nodes and primitives.
    fn below(&self, child: Child) -> (u32, u32) {
        if !child.is_node() {
            return (0, child.len());
        }
        self.nodes.get(index(child.number())).map_or((0, 0), |n| (n.reserved[0], n.reserved[1]))
    }

    /// The nodes in walk order with the numbers that they have there, the numbers that they had before, and their
    /// levels; the root's is 1.
    pub(crate) fn walk(self) -> impl Iterator<Item = (Node, u32, u32)> {
        // A node, its number, its first slot, its level.
        let mut todo = heapless::Vec::<(u32, u32, u32, u32), 128>::new();
        let mut next = (self.len > 0).then_some((0, 0, 0, 1));
        core::iter::from_fn(move || {
            let (at, number, first, level) = next.take().or_else(|| todo.pop())?;
            let mut node = *self.nodes.get(index(at))?;
            let [left, right] = node.child;
            let (below_left, below_right) = (self.below(left), self.below(right));
            let mut child = |child: Child, (nodes, prims): (u32, u32), number: u32, first: u32| {
                if nodes == 0 {
                    return Child::leaf(first, prims);
                }
                // Twice as long as any tree is deep: it takes two entries a level at most.
                let _ = todo.push((child.number(), number, first, level + 1));
                Child::node(number)
            };
            let second = child(right, below_right, number + 1 + below_left.0, first + below_left.1);
            node.child = [child(left, below_left, number + 1, first), second];
            node.reserved = [0; 2];
            Some((node, at, level))
        })
    }

    /// The nodes in walk order.
    pub fn nodes(self) -> impl Iterator<Item = Node> {
        self.walk().map(|(node, _, _)| node)
    }

    /// The references in slot order.
    pub fn refs(self) -> impl Iterator<Item = &'n Ref> {
        // With no node, the whole run is one leaf.
        let run = if self.nodes.is_empty() { self.refs } else { &[] };
        runs(self.refs, self.nodes, run, (!self.nodes.is_empty()).then_some(Child::node(0)))
    }

    /// The references below a side of the node that had this number before.
    pub(crate) fn refs_below(self, node: u32, side: usize) -> impl Iterator<Item = &'n Ref> {
        runs(self.refs, self.nodes, &[], self.nodes.get(index(node)).map(|n| n.child[side & 1]))
    }
}

/// A run, and then the references below a child.
pub(crate) fn runs<'n>(
    refs: &'n [Ref],
    nodes: &'n [Node],
    mut run: &'n [Ref],
    mut next: Option<Child>,
) -> impl Iterator<Item = &'n Ref> {
    let mut todo = heapless::Vec::<Child, 128>::new();
    core::iter::from_fn(move || {
        loop {
            if let Some((first, rest)) = run.split_first() {
                run = rest;
                return Some(first);
            }
            let child = next.take().or_else(|| todo.pop())?;
            if child.is_node() {
                let [left, right] = nodes.get(index(child.number()))?.child;
                let _ = todo.push(right);
                next = Some(left);
            } else {
                run = refs.get(index(child.number())..index(child.number() + child.len()))?;
            }
        }
    })
}

/// Every node after those below it: down to the left, over to the right, and up, by the places in the nodes' first
/// reserved words.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Climb {
    /// The place of the node to go up from; none before the first step.
    from: Option<Place>,
}

impl Climb {
    pub(crate) const fn new() -> Self {
        Self { from: None }
    }

    /// The next node and its place; `None` after the root. What is below it, it may have changed, but not its place.
    pub(crate) fn next(&mut self, nodes: &[Node]) -> Option<(u32, Place)> {
        let inner = |place: Place| {
            let child = nodes.get(place.node())?.child[place.side()];
            child.is_node().then_some(child.number())
        };
        // From a left child over to the right one, if that is a node; else up.
        let mut at = match self.from {
            None => (!nodes.is_empty()).then_some((0, true)),
            Some(Place::ROOT) => None,
            Some(from) if from.side() == 0 => {
                Some(inner(from.sibling()).map_or((count(from.node()), false), |n| (n, true)))
            }
            Some(from) => Some((count(from.node()), false)),
        };
        while let Some((node, true)) = at {
            at = [0, 1]
                .into_iter()
                .find_map(|side| inner(Place::new(node, side)))
                .map(|n| (n, true))
                .or(Some((node, false)));
        }
        let (node, _) = at?;
        let place = Place(nodes.get(index(node))?.reserved[0]);
        self.from = Some(place);
        Some((node, place))
    }
}

/// The pass from the leaves up. What a subtree costs to walk stands in the scratch of the reference with its number.
struct Join<'j> {
    refs: &'j mut [Ref],
    nodes: &'j mut [Node],
    unit: f32,
    leaf: u32,
    node_cost: f32,
}

impl Join<'_> {
    fn run(&mut self, bounds: &Aabb) {
        let mut climb = Climb::new();
        while let Some((at, place)) = climb.next(self.nodes) {
            self.finish(at, place, bounds);
        }
    }

    /// Decides about a node whose children are finished.
    fn finish(&mut self, at: u32, place: Place, bounds: &Aabb) {
        let Some(&node) = self.nodes.get(index(at)) else { return };
        let own = self.nodes.get(place.node()).map_or(*bounds, |n| n.bounds(place.side()));
        let (mut below, mut prims, mut cost) = (1, 0, self.node_cost * area(&own, self.unit));
        for side in 0..2 {
            let child = node.child[side];
            let inner = self.nodes.get(index(child.number())).filter(|_| child.is_node());
            let (nodes, n) = inner.map_or((0, child.len()), |n| (n.reserved[0], n.reserved[1]));
            below += nodes;
            prims += n;
            cost += match inner {
                Some(_) => self.refs.get(index(child.number())).map_or(0.0, |r| r.scratch),
                None => weight(index(n)) * area(&node.bounds(side), self.unit),
            };
        }
        let whole = weight(index(prims)) * area(&own, self.unit);
        if prims <= self.leaf && whole <= cost {
            (below, cost) = (0, whole);
        }
        if let Some(node) = self.nodes.get_mut(index(at)) {
            node.reserved = [below, prims];
        }
        if let Some(r) = self.refs.get_mut(index(at)) {
            r.scratch = cost;
        }
    }
}
