//! The builder: top down, then improved, then put in walk order, all without recursion.
//!
//! Two rules. `Seed`: the node's box is halved along x, y, z in turn, and a primitive goes to the side of its centre;
//! where that leaves one side empty the other axes are tried. `Sah`: the split of least expected cost, down to single
//! primitives; then `reinsert` moves subtrees to better places, and `order` joins small subtrees into leaves where
//! that costs less. Both rules fall back to halving the run by count where they separate nothing, and always do so from
//! level `HALVE_FROM` on, so a tree has at most 32 + 28 levels, and any input ends.
//!
//! Memory: one [`Ref`] (32 bytes) a primitive, at most one node (64 bytes) less than there are primitives.

pub mod order;
mod reinsert;

use super::{Child, MAX_LEAF, Node};
use crate::blob::MAX_STACK;
use crate::build::sah::{Choice, NODE_COST, NODE_COST_TUBES, halve, sweep};
use crate::build::{BuildError, Config, Ref, Rule, What};
use crate::geom::Aabb;
use crate::num::{count, index};
pub use order::Tree;

/// Nodes on this level and below are halved by count.
const HALVE_FROM: u32 = 32;

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
struct Place(u32);

impl Place {
    /// Where the root would be.
    const ROOT: Self = Self(u32::MAX);

    const fn new(node: u32, side: u32) -> Self {
        Self(node << 1 | side)
    }

    const fn node(self) -> usize {
        index(self.0 >> 1)
    }

    const fn side(self) -> usize {
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
    let made = top_down(config, refs, nodes, bounds)?;
    let rounds = if config.rule == Rule::Sah { config.reinsert } else { 0 };
    if rounds > 0 {
        reinsert::improve(nodes.get_mut(..made).unwrap_or(&mut []), bounds, rounds);
        if order::depth(nodes.get(..made).unwrap_or(&[])) > MAX_STACK {
            // Rare, and then the tree is as good as the top-down one.
            top_down(config, refs, nodes, bounds)?;
        }
    }
    let leaf = if config.rule == Rule::Sah { config.leaf } else { 1 };
    let node_cost = if tubes { NODE_COST_TUBES } else { NODE_COST };
    Ok(Tree::new(refs, nodes.get_mut(..made).unwrap_or(&mut []), bounds, leaf, node_cost))
}

/// Splits from the root down, and returns how many nodes that made. Each node's first reserved word is its place.
fn top_down(config: &Config, refs: &mut [Ref], nodes: &mut [Node], bounds: &Aabb) -> Result<usize, BuildError> {
    let full = BuildError::Full { what: What::Nodes, needed: index(most_nodes(count(refs.len()))), had: nodes.len() };
    let mut tasks = heapless::Vec::<Task, { index(MAX_STACK) }>::new();
    let mut made = 0;
    let mut next = Some(Task { first: 0, len: refs.len(), bounds: *bounds, place: None, level: 1 });
    while let Some(task) = next.take().or_else(|| tasks.pop()) {
        let run = refs.get_mut(task.first..task.first + task.len).unwrap_or(&mut []);
        let choice = choose(config, run, &task);
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

fn choose(config: &Config, run: &mut [Ref], task: &Task) -> Choice {
    let leaf = index(config.leaf.min(MAX_LEAF));
    match config.rule {
        _ if run.len() < 2 => Choice::Leaf,
        Rule::Seed if run.len() <= leaf => Choice::Leaf,
        _ if task.level >= HALVE_FROM => halve(run),
        Rule::Seed => middle(run, &task.bounds, index(task.level - 1) % 3),
        Rule::Sah => sweep(run, &task.bounds),
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
