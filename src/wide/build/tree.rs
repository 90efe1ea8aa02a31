//! The wide tree, in the order in which it is written.
use super::forests::Known;
use super::{Node, STACK, WIDTH, section};
use crate::blob::Section;
use crate::blob::block::{self, Block};
use crate::build::Ref;
use crate::build::sah::area;
use crate::bvh::build::order::runs;
use crate::bvh::{self, Child};
use crate::geom::{Aabb, Triangle};
use crate::num::{count, index};

/// A child of a wide node to be.
#[derive(Clone, Copy, Debug)]
struct Kid {
    /// Its subtree of the binary tree.
    at: Child,
    bounds: Aabb,
    /// Primitives, if it becomes a leaf.
    leaf: Option<u32>,
}

type Kids = heapless::Vec<Kid, WIDTH>;

/// A tree whose shape is known.
#[derive(Clone, Copy, Debug)]
pub struct Tree<'n> {
    refs: &'n [Ref],
    known: Known<'n>,
    /// Number of wide nodes.
    pub len: u32,
    /// Number of blocks; of primitives, where there are none.
    pub blocks: u32,
    /// Deepest stack of a walk.
    pub stack: u32,
}

impl Known<'_> {
    /// The children of a wide node.
    fn kids(&self, node: &bvh::Node, left: usize) -> Kids {
        let mut kids = Kids::new();
        let [a, b] = node.child;
        // Each entry takes at least one of the roots.
        let mut todo = heapless::Vec::<(Child, Aabb, usize), WIDTH>::new();
        let _ = todo.push((b, node.bounds(1), self.width - left));
        let _ = todo.push((a, node.bounds(0), left));
        while let Some((at, bounds, roots)) = todo.pop() {
            let (Some(forest), Some(node)) = (self.forest(at), self.nodes.get(index(at.number()))) else {
                let _ = kids.push(Kid { at, bounds, leaf: Some(at.len()) });
                continue;
            };
            match (roots, forest.how(roots)) {
                (1, how) => {
                    let _ = kids.push(Kid { at, bounds, leaf: (how == 1).then_some(forest.prims) });
                }
                (_, 0) => {
                    let _ = todo.push((at, bounds, roots - 1));
                }
                (_, left) => {
                    let _ = todo.push((node.child[1], node.bounds(1), roots - left));
                    let _ = todo.push((node.child[0], node.bounds(0), left));
                }
            }
        }
        // The largest first: any-hit walks look there first, and most rays meet it.
        let mut order = [(0.0, 0); WIDTH];
        for (i, (place, kid)) in order.iter_mut().zip(&kids).enumerate() {
            *place = (area(&kid.bounds, self.unit), i);
        }
        for end in 1..kids.len() {
            let mut at = end;
            while at > 0 && order[(at - 1) % WIDTH].0 < order[at % WIDTH].0 {
                order.swap((at - 1) % WIDTH, at % WIDTH);
                at -= 1;
            }
        }
        order.iter().filter_map(|&(_, i)| kids.get(i)).copied().take(kids.len()).collect()
    }
}

/// What a walk meets, in its order.
#[allow(clippy::large_enum_variant)] // it lives for one step of an iterator
enum Met<const W: usize> {
    Node(Node<W>),
    Leaf(Kid),
}

impl<'n> Tree<'n> {
    /// `stack`: the most entries of a walk's.
    pub(super) fn new(refs: &'n [Ref], known: Known<'n>, stack: u32) -> Self {
        let mut tree = Self { refs, known, len: 0, blocks: count(refs.len()).div_ceil(known.lanes), stack: 0 };
        let root = known.forests.first().filter(|f| !known.nodes.is_empty() && f.how(1) == 0);
        if let Some(root) = root {
            (tree.len, tree.blocks, tree.stack) = (root.nodes, root.blocks, stack);
        }
        tree
    }

    /// Every node and every leaf, in walk order.
    fn met<const W: usize>(self) -> impl Iterator<Item = Met<W>> {
        let mut todo = heapless::Vec::<Kid, { index(STACK) + WIDTH }>::new();
        let root = Kid { at: Child::node(0), bounds: Aabb::EMPTY, leaf: None };
        let mut next = (self.len > 0).then_some(root);
        let (mut number, mut block) = (0, 0);
        core::iter::from_fn(move || {
            let kid = next.take().or_else(|| todo.pop())?;
            if let Some(prims) = kid.leaf {
                block += prims.div_ceil(self.known.lanes);
                return Some(Met::Leaf(kid));
            }
            let binary = self.known.nodes.get(index(kid.at.number()))?;
            let kids = self.known.kids(binary, self.known.forest(kid.at)?.left());
            let (mut child_number, mut child_block) = (number + 1, block);
            number += 1;
            let mut node = Node::<W>::EMPTY;
            for (lane, kid) in kids.iter().enumerate() {
                let forest = self.known.forest(kid.at);
                let child = if let Some(prims) = kid.leaf {
                    Child::leaf(child_block, prims)
                } else {
                    Child::node(child_number)
                };
                match (kid.leaf, forest) {
                    (None, Some(f)) => (child_number, child_block) = (child_number + f.nodes, child_block + f.blocks),
                    (leaf, _) => child_block += leaf.unwrap_or(0).div_ceil(self.known.lanes),
                }
                node.set(lane, child, &kid.bounds);
            }
            for kid in kids.iter().rev() {
                // There is room for as many as the stack of any walk.
                let _ = todo.push(*kid);
            }
            Some(Met::Node(node))
        })
    }

    /// The section of the nodes, and the bytes of each.
    #[must_use]
    pub const fn section(&self) -> (Section, usize) {
        section(self.known.width)
    }

    /// Writes the nodes in walk order, as they are to stand in a blob, and the blocks, if there are any; `triangle` gives
    /// a primitive by its number.
    pub fn write(self, nodes: &mut [u8], blocks: &mut [u8], triangle: impl Fn(u32) -> Triangle) {
        match self.known.width {
            4 => self.write_as::<4>(nodes, blocks, triangle),
            _ => self.write_as::<WIDTH>(nodes, blocks, triangle),
        }
    }

    /// The same with nodes of a width that the compiler knows.
    fn write_as<const W: usize>(self, nodes: &mut [u8], blocks: &mut [u8], triangle: impl Fn(u32) -> Triangle) {
        let mut nodes = nodes.chunks_exact_mut(size_of::<Node<W>>());
        let mut blocks = blocks.chunks_exact_mut(size_of::<Block>());
        let mut put = |refs: &mut dyn Iterator<Item = &Ref>, prims: u32| {
            for first in (0..prims).step_by(index(block::LANES)) {
                let Some(place) = blocks.next() else { return };
                let mut block = Block::EMPTY;
                for lane in 0..(prims - first).min(block::LANES) {
                    let Some(r) = refs.next() else { break };
                    block.set(index(lane), &triangle(r.prim), r.prim);
                }
                place.copy_from_slice(bytemuck::bytes_of(&block));
            }
        };
        if self.len == 0 {
            put(&mut self.refs(), count(self.refs.len()));
        }
        for met in self.met::<W>() {
            match met {
                Met::Node(node) => {
                    if let Some(place) = nodes.next() {
                        place.copy_from_slice(bytemuck::bytes_of(&node.words()));
                    }
                }
                Met::Leaf(kid) => {
                    put(&mut runs(self.refs, self.known.nodes, &[], Some(kid.at)), kid.leaf.unwrap_or(0));
                }
            }
        }
    }

    /// The references in the order of leaves.
    pub fn refs(self) -> impl Iterator<Item = &'n Ref> {
        self.leaves().flat_map(move |(run, at)| runs(self.refs, self.known.nodes, run, at))
    }

    /// The leaves: the run of references or the subtree that has them.
    fn leaves(self) -> impl Iterator<Item = (&'n [Ref], Option<Child>)> {
        // With no wide node, everything is one leaf.
        let whole = if self.known.nodes.is_empty() { (self.refs, None) } else { (&[][..], Some(Child::node(0))) };
        let whole = (self.len == 0 && !self.refs.is_empty()).then_some(whole);
        let leaf = |met| if let Met::Leaf(kid) = met { Some((&[][..], Some(kid.at))) } else { None };
        whole.into_iter().chain(self.met::<WIDTH>().filter_map(leaf))
    }
}
