//! The full check: one pass through the nodes in walk order.
use super::{Node, STACK, View, Wide, slots};
use crate::blob::prims::Prims;
use crate::blob::{BlobError, Rule};
use crate::bvh::{Child, MAX_LEAF};
use crate::geom::Aabb;
use crate::num::{count, index};

/// A node on the way down, the lane that is being looked at, and the entries that may wait below on the walk's stack.
#[derive(Clone, Copy)]
struct Step {
    node: u32,
    lane: usize,
    below: u32,
}

/// What has been met so far.
struct Pass<'c, 'a, const W: usize> {
    nodes: &'a [Node<W>],
    prims: &'c Prims<'a>,
    bounds: &'c Aabb,
    way: heapless::Vec<Step, { index(STACK) }>,
    next_node: u32,
    /// The block or slot that the next leaf starts at.
    next_leaf: u32,
    /// Primitives in leaves.
    listed: u32,
    deepest: u32,
}

impl<const W: usize> View<'_, W>
where
    Node<W>: Wide<W>,
{
    /// The full check, O(n), with a stack of its own: rules 7, 20 to 23 and 56.
    ///
    /// Returns the deepest stack of any walk.
    ///
    /// # Errors
    /// The first rule that is broken, and where.
    // Out of line: the stack of a caller that knows both widths would hold two ways to the root.
    #[inline(never)]
    pub fn check(&self, prims: &Prims<'_>, bounds: &Aabb) -> Result<u32, BlobError> {
        let way = heapless::Vec::new();
        let mut pass =
            Pass { nodes: self.nodes, prims, bounds, way, next_node: 0, next_leaf: 0, listed: 0, deepest: 0 };
        if !self.nodes.is_empty() {
            pass.enter(0, 0)?;
            pass.run()?;
        } else if prims.len <= MAX_LEAF {
            pass.leaf(Child::leaf(0, prims.len), 0)?;
        }
        let ends = |rule, found: u32, needed: u32| {
            if found == needed { Ok(()) } else { Err(broken::<W>(rule, found).found(found).needed(needed)) }
        };
        ends(Rule::NodeOrder, pass.next_node, count(self.nodes.len()))?;
        ends(Rule::LeafOrder, pass.listed, prims.len)?;
        let slots = if prims.blocks.is_empty() { pass.listed } else { count(prims.blocks.len()) };
        ends(Rule::LeafOrder, pass.next_leaf, slots)?;
        Ok(pass.deepest)
    }
}

impl<const W: usize> Pass<'_, '_, W>
where
    Node<W>: Wide<W>,
{
    /// Lane by lane, down into each child that is a node, and up again.
    fn run(&mut self) -> Result<(), BlobError> {
        while let Some(step) = self.way.pop() {
            let node = self.nodes.get(index(step.node)).ok_or(broken::<W>(Rule::NodeOrder, step.node))?;
            if step.lane >= node.len() {
                continue;
            }
            let child = node.child[step.lane % W];
            // There is room: one was taken off.
            let _ = self.way.push(Step { lane: step.lane.saturating_add(1), ..step });
            if child.is_node() {
                if child.number() != self.next_node {
                    return Err(broken::<W>(Rule::NodeOrder, step.node).found(child.number()).needed(self.next_node));
                }
                self.enter(child.number(), step.below.saturating_add(count(node.len())).saturating_sub(1))?;
            } else {
                self.leaf(child, step.node)?;
            }
        }
        Ok(())
    }

    /// The box of the child that is being looked at.
    fn own(&self) -> Aabb {
        let Some(step) = self.way.last() else { return *self.bounds };
        // The lane has been moved on already.
        self.nodes.get(index(step.node)).map_or(Aabb::EMPTY, |node| node.bounds(step.lane.wrapping_sub(1)))
    }

    /// A node: its children stand in the first lanes, with boxes inside its own; the other lanes are empty.
    fn enter(&mut self, number: u32, below: u32) -> Result<(), BlobError> {
        let node = self.nodes.get(index(number)).ok_or(broken::<W>(Rule::NodeOrder, number))?;
        let (own, len) = (self.own(), node.len());
        let stack = below.saturating_add(count(len));
        let inside = |lane: usize| node.bounds(lane).is_valid() && own.contains(&node.bounds(lane));
        let rest = Node::<W>::EMPTY;
        let empty = |lane: usize| node.child[lane % W] == Child::NONE && node.bounds(lane) == rest.bounds(lane);
        if len < 2 || !(len..W).all(empty) {
            return Err(broken::<W>(Rule::WideLanes, number));
        }
        if !(0..len).all(inside) {
            return Err(broken::<W>(Rule::NodeBounds, number));
        }
        if node.reserved != rest.reserved {
            return Err(broken::<W>(Rule::Reserved, number));
        }
        if stack > STACK || self.way.push(Step { node: number, lane: 0, below }).is_err() {
            return Err(broken::<W>(Rule::StackTrue, number).found(stack).needed(STACK));
        }
        self.next_node = self.next_node.saturating_add(1);
        self.deepest = self.deepest.max(stack);
        Ok(())
    }

    /// A leaf: it follows the one before, its primitives are there, and its box contains them.
    fn leaf(&mut self, leaf: Child, node: u32) -> Result<(), BlobError> {
        let (first, next) = slots(self.prims, leaf);
        let last = first.saturating_add(leaf.len());
        if leaf.number() != self.next_leaf || (first..last).any(|slot| self.prims.get(slot).is_none()) {
            return Err(broken::<W>(Rule::LeafOrder, node).found(leaf.number()).needed(self.next_leaf));
        }
        if !self.own().contains(&self.prims.bounds(first, leaf.len())) {
            return Err(broken::<W>(Rule::NodeBounds, node));
        }
        self.next_leaf = next;
        self.listed = self.listed.saturating_add(leaf.len());
        Ok(())
    }
}

const fn broken<const W: usize>(rule: Rule, node: u32) -> BlobError
where
    Node<W>: Wide<W>,
{
    BlobError::new(rule, <Node<W> as Wide<W>>::SECTION).at(node)
}
