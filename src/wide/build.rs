//! The builder: the binary tree of [`crate::bvh`], collapsed.
//!
//! Which binary nodes become wide ones, and which subtrees leaves, is chosen for the least expected cost by dynamic
//! programming from the leaves up (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs", HPG 2017, section 3.1): for each subtree, the least cost of a forest of one to eight roots
//! that stands for it, each root a wide node or a leaf. A forest of one is a leaf, or a node over the best forest of
//! eight; a larger one is parted between the two children, or is one of fewer roots. A node costs the same wherever it
//! is; a leaf costs so much for each block of its triangles, because four are tested at a time. For nodes of four the same
//! is done with four for eight.
//!
//! Memory: that of the binary tree, and [`WORDS`] words for each of its nodes.
use super::{Node, STACK, WIDTH};
use crate::blob::block::{self, Block};
use crate::blob::{MAX_STACK, Section};
use crate::build::sah::area;
use crate::build::{BuildError, Config, Ref};
use crate::bvh::build::Leaves;
use crate::bvh::build::order::{Climb, runs};
use crate::bvh::{self, Child};
use crate::geom::vec::{size, sub};
use crate::geom::{Aabb, Triangle};
use crate::num::{count, index, weight};
use bytemuck::{Pod, Zeroable};

/// Words of memory for each node of the binary tree.
pub const WORDS: usize = size_of::<Forests>() / 4;

/// Cost of visiting a node.
pub const NODE_COST: f32 = 1.0;
/// Cost of testing a block of triangles, or one primitive where there are no blocks.
pub const BLOCK_COST: f32 = 0.6;

/// What is known about a binary node when all below it is.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Forests {
    /// How the best of up to one, two .. eight roots come about, three bits each. Of one root: 0 is a wide node, 1 a
    /// leaf. Of more: 0 is with a root less, else so many roots stand for the left child and the rest for the right one.
    /// Three bits more: how many of the children of a wide node here stand for the left child.
    how: u32,
    /// Primitives below.
    prims: u32,
    /// Wide nodes, if this is one.
    nodes: u32,
    /// Blocks below, if this is a wide node.
    blocks: u32,
}

impl Forests {
    const fn how(&self, roots: usize) -> usize {
        index(self.how >> ((roots - 1) % WIDTH * 3) & 7)
    }

    const fn left(&self) -> usize {
        index(self.how >> (WIDTH * 3) & 7)
    }
}

/// A forest of so many roots.
#[derive(Clone, Copy, Debug)]
struct Forest {
    /// Least cost, weighed with the areas of roots.
    cost: f32,
    /// Wide nodes.
    nodes: u32,
    blocks: u32,
}

/// The forests of up to one, two .. eight roots of a child. Only the node above asks for them: so they are no more than
/// a tree is deep at a time.
type Costs<const W: usize> = [Forest; W];

const fn of<const W: usize>(forests: &Costs<W>, roots: usize) -> Forest {
    forests[(roots - 1) % W]
}

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

/// A binary tree and what is known about its nodes.
#[derive(Clone, Copy, Debug)]
struct Known<'k> {
    nodes: &'k [bvh::Node],
    forests: &'k [Forests],
    /// Most children of a node.
    width: usize,
    /// Primitives of a block.
    lanes: u32,
    /// One over the scene's size: areas in units of it neither overflow nor vanish.
    unit: f32,
}

impl Known<'_> {
    fn forest(&self, at: Child) -> Option<&Forests> {
        self.forests.get(index(at.number())).filter(|_| at.is_node())
    }

    /// A leaf of so many primitives.
    fn leaf(&self, prims: u32, area: f32) -> Forest {
        let blocks = prims.div_ceil(self.lanes);
        Forest { cost: area * BLOCK_COST * weight(index(blocks)), nodes: 0, blocks }
    }

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

    /// The forests of a node of this area, those of its children being known; leaves have at most `most` primitives.
    fn forests<const W: usize>(
        &self,
        node: &bvh::Node,
        below: &[Costs<W>; 2],
        area: f32,
        most: u32,
    ) -> (Forests, Costs<W>) {
        let [a, b] = below;
        let both = |left: usize, right: usize| {
            let (a, b) = (of(a, left), of(b, right));
            Forest { cost: a.cost + b.cost, nodes: a.nodes + b.nodes, blocks: a.blocks + b.blocks }
        };
        // The cheapest way to part so many roots.
        let parted = |roots: usize| {
            let mut best = (both(1, roots - 1), 1);
            for left in 2..roots {
                let forest = both(left, roots - left);
                if forest.cost < best.0.cost {
                    best = (forest, left);
                }
            }
            best
        };
        let prims = node.child.iter().map(|&at| self.forest(at).map_or(at.len(), |f| f.prims)).sum();
        let (wide, left) = parted(W);
        let wide = Forest { cost: wide.cost + area * NODE_COST, nodes: wide.nodes + 1, ..wide };
        let leaf = self.leaf(prims, area);
        let is_leaf = prims <= most && leaf.cost <= wide.cost;
        let mut known = Forests { how: u32::from(is_leaf), prims, nodes: wide.nodes, blocks: wide.blocks };
        let mut all = [if is_leaf { leaf } else { wide }; W];
        let mut fewer = all[0];
        for (roots, place) in (2..).zip(all.iter_mut().skip(1)) {
            let (apart, left) = parted(roots);
            if apart.cost < fewer.cost {
                fewer = apart;
                known.how |= count(left) << ((roots - 1) * 3);
            }
            *place = fewer;
        }
        known.how |= count(left) << (WIDTH * 3);
        (known, all)
    }
}

/// The section for nodes of a width, and the bytes of each.
#[must_use]
pub const fn section(width: usize) -> (Section, usize) {
    match width {
        4 => (Section::Wide4Nodes, size_of::<Node<4>>()),
        _ => (Section::WideNodes, size_of::<Node>()),
    }
}

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

/// Builds a tree over `refs`; `blocks` says that all are triangles. `words` has [`WORDS`] for each of `nodes`.
///
/// # Errors
/// [`BuildError::Full`] if `nodes` is too short, with the most nodes that any tree could need.
pub fn build<'n>(
    config: &Config,
    refs: &'n mut [Ref],
    nodes: &'n mut [bvh::Node],
    words: &'n mut [u32],
    bounds: &Aabb,
    blocks: bool,
) -> Result<Tree<'n>, BuildError> {
    let lanes = if blocks { block::LANES } else { 1 };
    let forests: &mut [Forests] = bytemuck::cast_slice_mut(words);
    let leaves = Leaves { whole: 1, most: config.leaf, lanes: lanes.trailing_zeros() };
    let mut made = bvh::build::grow(config, refs, nodes, bounds, leaves)?;
    // Areas in units of the scene, so that they neither overflow nor vanish.
    let unit = 1.0 / size(sub(bounds.max, bounds.min));
    let none = Known { nodes: &[], forests: &[], width: config.children(), lanes, unit };
    plan(Known { nodes: nodes.get(..made).unwrap_or(&[]), ..none }, forests, bounds, config.leaf);
    let tree = Tree::new(refs, Known { nodes: nodes.get(..made).unwrap_or(&[]), forests, ..none }, None);
    let stack = Some(tree.stack).filter(|&stack| stack <= STACK);
    if stack.is_none() {
        // Rare: primitives of very unlike sizes. A tree halved by count is never deep.
        made = bvh::build::halved(refs, nodes, bounds)?;
        plan(Known { nodes: nodes.get(..made).unwrap_or(&[]), ..none }, forests, bounds, config.leaf);
    }
    Ok(Tree::new(refs, Known { nodes: nodes.get(..made).unwrap_or(&[]), forests, ..none }, stack))
}

/// The best forests of all nodes of `tree`, in which none is known yet; leaves have at most `leaf` primitives.
fn plan(tree: Known<'_>, forests: &mut [Forests], bounds: &Aabb, leaf: u32) {
    match tree.width {
        4 => plan_for::<4>(tree, forests, bounds, leaf),
        _ => plan_for::<8>(tree, forests, bounds, leaf),
    }
}

/// The same, for nodes of a width that the compiler knows: it unrolls what is done for each number of roots.
fn plan_for<const W: usize>(tree: Known<'_>, forests: &mut [Forests], bounds: &Aabb, leaf: u32) {
    let Known { nodes, unit, .. } = tree;
    let mut climb = Climb::new();
    // A left child's forests wait for the right one's: at most one for each level.
    let mut waiting = heapless::Vec::<Costs<W>, { index(MAX_STACK) + 2 }>::new();
    while let Some((at, place)) = climb.next(nodes) {
        let own = nodes.get(place.node()).map_or(*bounds, |n| n.bounds(place.side()));
        let known = Known { forests, ..tree };
        let Some(node) = nodes.get(index(at)) else { return };
        let mut below = |side: usize| match node.child[side] {
            child if child.is_node() => waiting.pop().unwrap_or([known.leaf(0, 0.0); W]),
            child => [known.leaf(child.len(), area(&node.bounds(side), unit)); W],
        };
        let right = below(1);
        let (best, all) = known.forests(node, &[below(0), right], area(&own, unit), leaf);
        let _ = waiting.push(all);
        if let Some(place) = forests.get_mut(index(at)) {
            *place = best;
        }
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
    fn new(refs: &'n [Ref], known: Known<'n>, stack: Option<u32>) -> Self {
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
