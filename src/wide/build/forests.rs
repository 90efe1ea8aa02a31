//! The best forests for every subtree, from the leaves up.
use super::{BLOCK_COST, NODE_COST, WIDTH};
use crate::blob::MAX_STACK;
use crate::build::sah::area;
use crate::bvh::build::order::Climb;
use crate::bvh::{self, Child};
use crate::geom::Aabb;
use crate::num::{count, index, weight};
use bytemuck::{Pod, Zeroable};

/// What is known about a binary node when all below it is.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct Forests {
    /// How the best of up to one, two .. eight roots come about, three bits each. Of one root: 0 is a wide node, 1 a
    /// leaf. Of more: 0 is with a root less, else so many roots stand for the left child and the rest for the right one.
    /// Three bits more: how many of the children of a wide node here stand for the left child.
    how: u32,
    /// Primitives below.
    pub prims: u32,
    /// Wide nodes, if this is one.
    pub nodes: u32,
    /// Blocks below, if this is a wide node.
    pub blocks: u32,
}

impl Forests {
    pub const fn how(&self, roots: usize) -> usize {
        index(self.how >> ((roots - 1) % WIDTH * 3) & 7)
    }

    pub const fn left(&self) -> usize {
        index(self.how >> (WIDTH * 3) & 7)
    }
}

/// What a forest is made of.
#[derive(Clone, Copy, Debug)]
struct Made {
    /// Wide nodes.
    nodes: u32,
    blocks: u32,
    roots: u32,
    /// Most entries of a walk's stack at a root and below it, were there nothing else.
    stack: u32,
}

/// The best forests of up to one, two .. eight roots of a child. Only the node above asks for them: so they are no more
/// than a tree is deep at a time.
#[derive(Clone, Copy, Debug)]
struct Best<const W: usize> {
    /// Least costs, weighed with the areas of roots.
    costs: [f32; W],
    made: [Made; W],
}

impl<const W: usize> Best<W> {
    /// Of a leaf.
    fn leaf(cost: f32, blocks: u32) -> Self {
        Self { costs: [cost; W], made: [Made { nodes: 0, blocks, roots: 1, stack: 0 }; W] }
    }

    /// The cheapest way to part so many roots between two children: how many stand for this one.
    #[inline(always)]
    fn parted(&self, right: &Self, roots: usize) -> (f32, usize) {
        let mut best = (self.costs[0] + right.costs[(roots - 2) % W], 1);
        for left in 2..roots {
            let cost = self.costs[left - 1] + right.costs[(roots - left - 1) % W];
            best = if cost < best.0 { (cost, left) } else { best };
        }
        best
    }

    /// What comes of that.
    fn both(&self, right: &Self, roots: usize, left: usize) -> Made {
        let (a, b) = (&self.made[(left - 1) % W], &right.made[(roots - left - 1) % W]);
        Made {
            nodes: a.nodes + b.nodes,
            blocks: a.blocks + b.blocks,
            roots: a.roots + b.roots,
            stack: a.stack.max(b.stack),
        }
    }
}

/// A binary tree and what is known about its nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known<'k> {
    pub nodes: &'k [bvh::Node],
    pub forests: &'k [Forests],
    /// Most children of a node.
    pub width: usize,
    /// Primitives of a block.
    pub lanes: u32,
    /// One over the scene's size: areas in units of it neither overflow nor vanish.
    pub unit: f32,
}

impl Known<'_> {
    pub fn forest(&self, at: Child) -> Option<&Forests> {
        self.forests.get(index(at.number())).filter(|_| at.is_node())
    }

    /// A leaf of so many primitives.
    fn leaf<const W: usize>(&self, prims: u32, area: f32) -> Best<W> {
        let blocks = prims.div_ceil(self.lanes);
        Best::leaf(area * BLOCK_COST * weight(index(blocks)), blocks)
    }

    /// The forests of a node of this area, those of its children being known; leaves have at most `most` primitives.
    fn forests<const W: usize>(
        &self,
        node: &bvh::Node,
        [a, b]: [&Best<W>; 2],
        area: f32,
        most: u32,
    ) -> (Forests, Best<W>) {
        let prims = node.child.iter().map(|&at| self.forest(at).map_or(at.len(), |f| f.prims)).sum();
        let (cost, left) = a.parted(b, W);
        let cost = cost + area * NODE_COST;
        let kids = a.both(b, W, left);
        // A walk takes one of the children from the stack before it visits it.
        let stack = kids.roots + kids.stack.saturating_sub(1);
        let wide = Made { nodes: kids.nodes + 1, blocks: kids.blocks, roots: 1, stack };
        let mut best = self.leaf(prims, area);
        let is_leaf = prims <= most && best.costs[0] <= cost;
        if !is_leaf {
            best = Best { costs: [cost; W], made: [wide; W] };
        }
        let mut known = Forests { how: u32::from(is_leaf), prims, nodes: wide.nodes, blocks: wide.blocks };
        for roots in 2..=W {
            let (cost, left) = a.parted(b, roots);
            let fewer = roots - 2;
            (best.costs[roots - 1], best.made[roots - 1]) = (best.costs[fewer], best.made[fewer]);
            if cost < best.costs[fewer] {
                (best.costs[roots - 1], best.made[roots - 1]) = (cost, a.both(b, roots, left));
                known.how |= count(left) << ((roots - 1) * 3);
            }
        }
        known.how |= count(left) << (WIDTH * 3);
        (known, best)
    }
}

/// The best forests of all nodes of `tree`, in which none is known yet; leaves have at most `leaf` primitives. Returns the
/// most entries of a walk's stack.
pub(super) fn plan(tree: Known<'_>, forests: &mut [Forests], bounds: &Aabb, leaf: u32) -> u32 {
    match tree.width {
        4 => plan_for::<4>(tree, forests, bounds, leaf),
        _ => plan_for::<8>(tree, forests, bounds, leaf),
    }
}

/// The same, for nodes of a width that the compiler knows: it unrolls what is done for each number of roots.
fn plan_for<const W: usize>(tree: Known<'_>, forests: &mut [Forests], bounds: &Aabb, leaf: u32) -> u32 {
    let Known { nodes, unit, .. } = tree;
    let mut climb = Climb::new();
    // A left child's forests wait for the right one's: at most one for each level.
    let mut waiting = heapless::Vec::<Best<W>, { index(MAX_STACK) + 2 }>::new();
    while let Some((at, place)) = climb.next(nodes) {
        let own = nodes.get(place.node()).map_or(*bounds, |n| n.bounds(place.side()));
        let known = Known { forests, ..tree };
        let Some(node) = nodes.get(index(at)) else { break };
        let mut below = |side: usize| match node.child[side] {
            child if child.is_node() => waiting.pop().unwrap_or(Best::leaf(0.0, 0)),
            child => known.leaf(child.len(), area(&node.bounds(side), unit)),
        };
        let right = below(1);
        let left = below(0);
        let (how, best) = known.forests(node, [&left, &right], area(&own, unit), leaf);
        let _ = waiting.push(best);
        if let Some(place) = forests.get_mut(index(at)) {
            *place = how;
        }
    }
    waiting.first().map_or(0, |best| best.made[0].stack)
}
