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
    fn leaf(&self, prims: u32, area: f32) -> Forest {
        let blocks = prims.div_ceil(self.lanes);
        Forest { cost: area * BLOCK_COST * weight(index(blocks)), nodes: 0, blocks }
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

/// The best forests of all nodes of `tree`, in which none is known yet; leaves have at most `leaf` primitives.
pub(super) fn plan(tree: Known<'_>, forests: &mut [Forests], bounds: &Aabb, leaf: u32) {
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
