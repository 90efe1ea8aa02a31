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
        let area = |kid: &Kid| area(&kid.bounds, self.unit);
        for end in 1..kids.len() {
            for at in (1..=end).rev() {
                match kids.get_mut(at - 1..=at) {
                    Some([before, kid]) if area(before) < area(kid) => core::mem::swap(before, kid),
                    _ => break,
                }
            }
        }
        kids
    }
}

/// What a walk meets, in its order.
#[allow(clippy::large_enum_variant)] // it lives for one step of an iterator
enum Met {
    Node(Node, u32),
    Leaf(Kid),
}

impl<'n> Tree<'n> {
    /// To find the deepest stack, if it is not known, takes a walk over all nodes.
    pub(super) fn new(refs: &'n [Ref], known: Known<'n>, stack: Option<u32>) -> Self {
        let all = count(refs.len());
        let mut tree = Self { refs, known, len: 0, blocks: all.div_ceil(known.lanes), stack: 0 };
        let root = known.forests.first().filter(|f| !known.nodes.is_empty() && f.how(1) == 0);
        if let Some(root) = root {
            (tree.len, tree.blocks) = (root.nodes, root.blocks);
            let deepest = |most: u32, met| if let Met::Node(_, n) = met { most.max(n) } else { most };
            tree.stack = stack.unwrap_or_else(|| tree.met().fold(0, deepest));
        }
        tree
    }

    /// Every node with the entries that a walk's stack may have there, and every leaf; in walk order. Where that is more
    /// than any walk may need, the rest is left out.
    fn met(self) -> impl Iterator<Item = Met> {
        let mut todo = heapless::Vec::<(Kid, u32), { index(STACK) + WIDTH }>::new();
        let root = Kid { at: Child::node(0), bounds: Aabb::EMPTY, leaf: None };
        let mut next = (self.len > 0).then_some((root, 0));
        let (mut number, mut block) = (0, 0);
        core::iter::from_fn(move || {
            let (kid, below) = next.take().or_else(|| todo.pop())?;
            if let Some(prims) = kid.leaf {
                block += prims.div_ceil(self.known.lanes);
                return Some(Met::Leaf(kid));
            }
            let binary = self.known.nodes.get(index(kid.at.number()))?;
            let kids = self.known.kids(binary, self.known.forest(kid.at)?.left());
            let (mut child_number, mut child_block) = (number + 1, block);
            number += 1;
            let stack = below + count(kids.len());
            let mut node = Node::<WIDTH>::EMPTY;
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
                if stack <= STACK {
                    let _ = todo.push((*kid, stack - 1));
                }
            }
            Some(Met::Node(node, stack))
        })
    }

    /// The section of the nodes, and the bytes of each.
    #[must_use]
    pub const fn section(&self) -> (Section, usize) {
        section(self.known.width)
    }

    /// The nodes in walk order, as they are to stand in a blob.
    pub fn nodes<const W: usize>(self) -> impl Iterator<Item = [[u32; W]; 8]> {
        self.met()
            .filter_map(|met| if let Met::Node(node, _) = met { Some(node.narrowed::<W>().words()) } else { None })
    }

    /// The references in the order of leaves.
    pub fn refs(self) -> impl Iterator<Item = &'n Ref> {
        self.leaves().flat_map(move |(_, run, at)| runs(self.refs, self.known.nodes, run, at))
    }

    /// The blocks; `triangle` gives a primitive by its number.
    pub fn blocks(self, triangle: impl Fn(u32) -> Triangle) -> impl Iterator<Item = Block> {
        let mut refs = self.refs();
        self.leaves()
            .flat_map(|(prims, _, _)| {
                (0..prims.div_ceil(block::LANES)).map(move |i| (prims - i * block::LANES).min(block::LANES))
            })
            .map(move |len| {
                let mut block = Block::EMPTY;
                for (lane, r) in refs.by_ref().take(index(len)).enumerate() {
                    block.set(lane, &triangle(r.prim), r.prim);
                }
                block
            })
    }

    /// The leaves: number of primitives, and the run of references or the subtree that has them.
    fn leaves(self) -> impl Iterator<Item = (u32, &'n [Ref], Option<Child>)> {
        // With no wide node, everything is one leaf.
        let whole = if self.known.nodes.is_empty() {
            (count(self.refs.len()), self.refs, None)
        } else {
            (count(self.refs.len()), &[][..], Some(Child::node(0)))
        };
        let whole = (self.len == 0 && !self.refs.is_empty()).then_some(whole);
        let leaf = |met| if let Met::Leaf(kid) = met { Some((kid.leaf?, &[][..], Some(kid.at))) } else { None };
        whole.into_iter().chain(self.met().filter_map(leaf))
    }
}
