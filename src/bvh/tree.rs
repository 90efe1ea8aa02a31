//! What binary trees in walk order have in common, whatever their nodes bound their children with.
use super::{Child, MAX_LEAF};
use crate::blob::{BlobError, MAX_STACK, Rule, Section};
use crate::geom::Aabb;
use crate::num::{count, index};
use crate::walk::Part;

/// An inner node of two children.
pub trait Branch {
    /// The section that holds such nodes.
    const SECTION: Section;

    /// The children.
    fn children(&self) -> [Child; 2];
    /// A box around what bounds child 0 or 1.
    fn bounds(&self, side: usize) -> Aabb;
}

/// The root: node 0, or one leaf of all primitives if there is no node.
#[inline(always)]
pub(crate) fn root<N>(nodes: &[N], prims: u32) -> Child {
    match nodes {
        [] if prims <= MAX_LEAF => Child::leaf(0, prims),
        _ => Child::node(0),
    }
}

/// Calls `each` with every inner node and every leaf, a node before what is below it.
pub(crate) fn parts<N: Branch>(nodes: &[N], prims: u32, bounds: &Aabb, each: &mut impl FnMut(Part)) {
    // Nodes that were not checked may go round in circles: no more are opened than there are.
    let mut left = nodes.len();
    let mut todo = heapless::Vec::<(Child, Aabb, u32), 128>::new();
    let mut next = (prims > 0).then_some((root(nodes, prims), *bounds, 0));
    while let Some((child, bounds, level)) = next.take().or_else(|| todo.pop()) {
        each(Part { bounds, level, listed: (!child.is_node()).then_some(child.len()) });
        let Some(node) = nodes.get(index(child.number())).filter(|_| child.is_node()) else { continue };
        let Some(fewer) = left.checked_sub(1) else { return };
        left = fewer;
        let [first, second] = node.children();
        // Twice as long as any tree is deep.
        let _ = todo.push((second, node.bounds(1), level.saturating_add(1)));
        next = Some((first, node.bounds(0), level.saturating_add(1)));
    }
}

/// A node and a side of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    pub(crate) node: u32,
    pub(crate) side: usize,
}

/// What a check has to prove beyond the order of nodes and leaves. The way to a place begins at the root and ends with
/// the node and side where the place is; it is empty for the root.
pub(crate) trait Proof {
    /// At a node, before what is below it.
    fn node(&self, number: u32, way: &[Step]) -> Result<(), BlobError>;
    /// At a leaf.
    fn leaf(&self, slots: (u32, u32), way: &[Step]) -> Result<(), BlobError>;
}

/// One pass through nodes in walk order, O(n): rules 20, 21 and what `proof` adds. Returns the deepest stack of any
/// walk.
///
/// A child that is a node must have the number that follows all nodes met before it, and a leaf must start at the slot
/// that follows all slots met before it. So no node has two parents, there is no cycle, and nothing is left out.
pub(crate) fn check<N: Branch>(nodes: &[N], prims: u32, proof: &impl Proof) -> Result<u32, BlobError> {
    let mut order = Order { nodes, prims, next_node: 1, next_slot: 0 };
    let mut deepest = 0;
    if !nodes.is_empty() {
        deepest = order.run(proof)?;
    } else if prims <= MAX_LEAF {
        (order.next_node, order.next_slot) = (0, prims);
    }
    let ends = |rule, found: u32, needed: u32| {
        let error = BlobError::new(rule, N::SECTION).at(found).found(found).needed(needed);
        if found == needed { Ok(()) } else { Err(error) }
    };
    ends(Rule::NodeOrder, order.next_node, count(nodes.len()))?;
    ends(Rule::LeafOrder, order.next_slot, prims)?;
    Ok(deepest)
}

struct Order<'a, N> {
    nodes: &'a [N],
    prims: u32,
    next_node: u32,
    next_slot: u32,
}

impl<N: Branch> Order<'_, N> {
    fn run(&mut self, proof: &impl Proof) -> Result<u32, BlobError> {
        let mut way = heapless::Vec::<Step, { index(MAX_STACK) }>::new();
        let (mut node, mut deepest) = (0, 0);
        loop {
            proof.node(node, &way)?;
            if way.push(Step { node, side: 0 }).is_err() {
                return Err(broken::<N>(Rule::StackTrue, node).found(MAX_STACK.saturating_add(1)).needed(MAX_STACK));
            }
            deepest = deepest.max(count(way.len()));
            // Leaves, up and over to the right, until there is a node to go down to.
            node = loop {
                let Some(&step) = way.last() else { return Ok(deepest) };
                let child = self.child(step)?;
                if child.is_node() {
                    break child.number();
                }
                proof.leaf((child.number(), child.len()), &way)?;
                while let Some(step) = way.pop() {
                    if step.side == 0 {
                        // There is room: one was taken off.
                        let _ = way.push(Step { side: 1, ..step });
                        break;
                    }
                }
            };
        }
    }

    /// The child at a place, in its turn.
    fn child(&mut self, step: Step) -> Result<Child, BlobError> {
        let node = self.nodes.get(index(step.node)).ok_or(broken::<N>(Rule::NodeOrder, step.node))?;
        let child = node.children()[step.side & 1];
        if child.is_node() {
            if child.number() != self.next_node || index(child.number()) >= self.nodes.len() {
                return Err(broken::<N>(Rule::NodeOrder, step.node).found(child.number()).needed(self.next_node));
            }
            self.next_node = self.next_node.saturating_add(1);
        } else {
            let left = self.prims.saturating_sub(self.next_slot);
            if child.number() != self.next_slot || child.len() > left {
                return Err(broken::<N>(Rule::LeafOrder, step.node).found(child.number()).needed(self.next_slot));
            }
            self.next_slot = self.next_slot.saturating_add(child.len());
        }
        Ok(child)
    }
}

/// A rule broken at a node.
pub(crate) const fn broken<N: Branch>(rule: Rule, node: u32) -> BlobError {
    BlobError::new(rule, N::SECTION).at(node)
}
