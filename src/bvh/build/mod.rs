//! The builder: top down, then improved, then put in walk order; without recursion, but for threads.
//!
//! Two rules. `Seed`: the node's box is halved along x, y, z in turn, and a primitive goes to the side of its centre;
//! where that leaves one side empty the other axes are tried. `Sah`: the split of least expected cost, found among
//! `bins`, or by the full sweep where scenes are small or quality is high; then `reinsert`, or for the high quality
//! `converge`, moves subtrees to better places, and `order` joins small subtrees into leaves where that costs less. Both
//! rules fall back to halving the run by count where they separate nothing, and always do so from level `HALVE_FROM` on,
//! so a tree has at most 32 + 28 levels, and any input ends.
//!
//! Memory: one [`Ref`] (32 bytes) a primitive, at most one node (64 bytes) less than there are primitives.

mod bins;
mod converge;
mod descend;
pub mod order;
mod reinsert;

use super::{Child, MAX_LEAF, Node};
use crate::blob::{Kind, MAX_STACK};
use crate::build::sah::{Choice, NODE_COST, NODE_COST_TUBES, halve};
use crate::build::{BuildError, Config, Quality, Ref, Rule, What};
use crate::geom::Aabb;
use crate::num::{count, floor, index};
pub(crate) use bins::Leaves;
use descend::Way;
pub use order::Tree;

/// Nodes on this level and below are halved by count.
const HALVE_FROM: u32 = 32;

/// A scene of up to so many primitives gets the full sweep by [`Quality::Default`], too: all that a small machine has room
/// for. It takes 50 ms. In blocks of four, bins make as good a tree, with fuller blocks.
const SMALL: usize = 16_384;
const SMALL_IN_BLOCKS: usize = 4096;
/// Rounds of reinsertion by [`Quality::Default`], and the share of subtrees, those with the largest boxes, that take part:
/// nearly all that reinsertion gains it gains by these. A share of 0.2 takes a third more time than 0.05. In a kitchen rays
/// through single primitives take 4 % fewer steps and tests then, those through blocks 1 % more.
const LARGEST_ROUNDS: u32 = 4;
const LARGEST: f32 = 0.2;
const LARGEST_IN_BLOCKS: f32 = 0.05;
/// Most rounds of reinsertion for [`Quality::High`]: after four to eight they bring next to nothing, and end.
const HIGH_ROUNDS: u32 = 16;

/// Most nodes for so many primitives.
#[must_use]
pub const fn most_nodes(prims: u32) -> u32 {
    prims.saturating_sub(1)
}

/// A run of references that is to become a child.
struct Task {
    first: usize,
    len: usize,
    bounds: Aabb,
    /// The place that waits for the child; none for the root.
    place: Option<Place>,
    /// Level of the node that this may become; the root's is 1.
    level: u32,
}

/// A child's place: a node and a side of it, as one number for [`Node::reserved`], which holds it while building.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place(u32);

impl Place {
    /// Where the root would be.
    pub(crate) const ROOT: Self = Self(u32::MAX);

    const fn new(node: u32, side: u32) -> Self {
        Self(node << 1 | side)
    }

    pub(crate) const fn node(self) -> usize {
        index(self.0 >> 1)
    }

    pub(crate) const fn side(self) -> usize {
        index(self.0 & 1)
    }

    const fn sibling(self) -> Self {
        Self(self.0 ^ 1)
    }
}

/// Builds a tree over `refs`; `tubes` says that there are cylinders or cones among them.
///
/// # Errors
/// [`BuildError::Full`] if `nodes` is too short, with the most nodes that any tree could need.
pub fn build<'n>(
    config: &Config,
    refs: &'n mut [Ref],
    nodes: &'n mut [Node],
    bounds: &Aabb,
    tubes: bool,
) -> Result<Tree<'n>, BuildError> {
    let leaf = if config.rule == Rule::Sah { config.leaf } else { 1 };
    let node_cost = if tubes { NODE_COST_TUBES } else { NODE_COST };
    // So few are tested for what a node costs.
    let whole = leaf.min(floor(node_cost));
    let made = grow(config, refs, nodes, bounds, Leaves { whole, most: leaf, lanes: 0 })?;
    Ok(Tree::new(refs, nodes.get_mut(..made).unwrap_or(&mut []), bounds, leaf, node_cost))
}

/// A tree in no order, whose nodes' first reserved words are their places; returns how many there are.
pub(crate) fn grow(
    config: &Config,
    refs: &mut [Ref],
    nodes: &mut [Node],
    bounds: &Aabb,
    leaves: Leaves,
) -> Result<usize, BuildError> {
    if config.rule == Rule::Seed {
        return top_down(config, refs, nodes, bounds, HALVE_FROM);
    }
    // Where one primitive is tested at a time leaves are small, and the tree below them counts.
    let one_by_one = leaves.lanes == 0;
    let (small, share) = if one_by_one { (SMALL, LARGEST) } else { (SMALL_IN_BLOCKS, LARGEST_IN_BLOCKS) };
    let (way, rounds, share) = match config.quality {
        Quality::Fast => (Way::Bins(leaves), 0, 0.0),
        // What is built in no time may as well be built well.
        Quality::Default if refs.len() <= small => (Way::Sweep, 2, 1.0),
        Quality::Default => (Way::Bins(leaves), LARGEST_ROUNDS, share),
        Quality::High => (Way::Sweep, HIGH_ROUNDS, 1.0),
    };
    let mut made = descend::descend(way, refs, nodes)?;
    if rounds > 0 {
        let grown = nodes.get_mut(..made).unwrap_or(&mut []);
        match config.quality {
            Quality::High => converge::converge(refs, grown, bounds, rounds),
            _ => reinsert::improve(grown, bounds, rounds, share),
        }
        if order::depth(nodes.get(..made).unwrap_or(&[])) > MAX_STACK {
            // Rare, and then the tree is as good as the top-down one.
            made = descend::descend(way, refs, nodes)?;
        }
    }
    Ok(made)
}

/// What is said where `had` nodes are too few for so many primitives.
const fn full_nodes(prims: usize, had: usize) -> BuildError {
    BuildError::Full { what: What::Nodes, needed: index(most_nodes(count(prims))), had }
}

/// The same, with every run halved by count: no other tree is less deep.
pub(crate) fn halved(refs: &mut [Ref], nodes: &mut [Node], bounds: &Aabb) -> Result<usize, BuildError> {
    top_down(&Config::new(Kind::Bvh), refs, nodes, bounds, 0)
}

/// Splits from the root down, and returns how many nodes that made. Each node's first reserved word is its place.
fn top_down(
    config: &Config,
    refs: &mut [Ref],
    nodes: &mut [Node],
    bounds: &Aabb,
    halve_from: u32,
) -> Result<usize, BuildError> {
    let full = full_nodes(refs.len(), nodes.len());
    let mut tasks = heapless::Vec::<Task, { index(MAX_STACK) }>::new();
    let mut made = 0;
    let mut next = Some(Task { first: 0, len: refs.len(), bounds: *bounds, place: None, level: 1 });
    while let Some(task) = next.take().or_else(|| tasks.pop()) {
        let run = refs.get_mut(task.first..task.first + task.len).unwrap_or(&mut []);
        let choice = choose(config, run, &task, halve_from);
        let child = match choice {
            Choice::Leaf => Child::leaf(count(task.first), count(task.len)),
            Choice::Split(_) => Child::node(count(made)),
        };
        if let Some(place) = task.place {
            nodes.get_mut(place.node()).ok_or(full)?.child[place.side()] = child;
        }
        let Choice::Split(at) = choice else { continue };
        let node = nodes.get_mut(made).ok_or(full)?;
        let (left, right) = split(&task, run, at, made);
        *node = Node::new(&left.bounds, &right.bounds);
        node.reserved[0] = task.place.unwrap_or(Place::ROOT).0;
        made += 1;
        tasks.push(right).map_err(|_| full)?;
        next = Some(left);
    }
    Ok(made)
}

/// The two children of a run parted at `at`, under node `number`.
fn split(task: &Task, run: &[Ref], at: usize, number: usize) -> (Task, Task) {
    let (left, right) = run.split_at_checked(at).unwrap_or((run, &[]));
    let child = |run: &[Ref], first, side| Task {
        first: task.first + first,
        len: run.len(),
        bounds: run.iter().fold(Aabb::EMPTY, |all, r| all.join(&r.bounds)),
        place: Some(Place::new(count(number), side)),
        level: task.level + 1,
    };
    (child(left, 0, 0), child(right, at, 1))
}

fn choose(config: &Config, run: &mut [Ref], task: &Task, halve_from: u32) -> Choice {
    let leaf = index(config.leaf.min(MAX_LEAF));
    match config.rule {
        _ if run.len() < 2 => Choice::Leaf,
        Rule::Seed if run.len() <= leaf => Choice::Leaf,
        _ if task.level >= halve_from => halve(run),
        Rule::Seed => middle(run, &task.bounds, index(task.level - 1) % 3),
        Rule::Sah => halve(run),
    }
}

/// The seed's rule, beginning with `axis`.
fn middle(run: &mut [Ref], bounds: &Aabb, axis: usize) -> Choice {
    for axis in [axis, (axis + 1) % 3, (axis + 2) % 3] {
        let plane = bounds.min[axis] + bounds.max[axis];
        let at = partition(run, |r| r.center2()[axis] < plane);
        if at > 0 && at < run.len() {
            return Choice::Split(at);
        }
    }
    halve(run)
}

/// Moves what satisfies `first` to the front and returns how many do.
fn partition(run: &mut [Ref], first: impl Fn(&Ref) -> bool) -> usize {
    let mut at = 0;
    for i in 0..run.len() {
        if run.get(i).is_some_and(&first) {
            run.swap(i, at);
            at += 1;
        }
    }
    at
}
