//! The builder: top down, without recursion, nodes straight into walk order.
//!
//! Two rules. `Seed`: the node's box is halved along x, y, z in turn, and a primitive goes to the side of its centre;
//! where that leaves one side empty the other axes are tried. `Sah`: the split of least expected cost. Both fall back
//! to halving the run by count where they separate nothing, and always do so from level [`HALVE_FROM`] on, so a tree
//! has at most 32 + 28 levels, and any input ends.
//!
//! Memory: one [`Ref`] (32 bytes) a primitive, at most one node (64 bytes) less than there are primitives.
use super::{Child, MAX_LEAF, Node};
use crate::blob::MAX_STACK;
use crate::build::sah::{Choice, halve, sweep};
use crate::build::{BuildError, Config, Ref, Rule, What};
use crate::geom::Aabb;
use crate::num::{count, index};

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
    /// The parent and the side on which it waits for the child; none for the root.
    parent: Option<(usize, usize)>,
    /// Level of the node that this may become; the root's is 1.
    level: u32,
}

/// Builds a tree over `refs`, which it puts in slot order. Returns the nodes, the deepest stack and the most steps.
///
/// # Errors
/// [`BuildError::Full`] if `nodes` is too short, with the most nodes that any tree could need.
pub fn build<'n>(
    config: &Config,
    refs: &mut [Ref],
    nodes: &'n mut [Node],
    bounds: &Aabb,
) -> Result<(&'n [Node], u32, u32), BuildError> {
    let full = BuildError::Full { what: What::Nodes, needed: index(most_nodes(count(refs.len()))), had: nodes.len() };
    let mut tasks = heapless::Vec::<Task, { index(MAX_STACK) }>::new();
    let (mut made, mut deepest) = (0, 0);
    let mut next = Some(Task { first: 0, len: refs.len(), bounds: *bounds, parent: None, level: 1 });
    while let Some(task) = next.take().or_else(|| tasks.pop()) {
        let run = refs.get_mut(task.first..task.first + task.len).unwrap_or(&mut []);
        let choice = choose(config, run, &task);
        let child = match choice {
            Choice::Leaf => Child::leaf(count(task.first), count(task.len)),
            Choice::Split(_) => Child::node(count(made)),
        };
        if let Some((parent, side)) = task.parent {
            nodes.get_mut(parent).ok_or(full)?.child[side & 1] = child;
        }
        let Choice::Split(at) = choice else { continue };
        let node = nodes.get_mut(made).ok_or(full)?;
        let (left, right) = split(&task, run, at, made);
        *node = Node::new(&left.bounds, &right.bounds);
        (made, deepest) = (made + 1, deepest.max(task.level));
        tasks.push(right).map_err(|_| full)?;
        next = Some(left);
    }
    let steps = count(made).saturating_add(count(refs.len()));
    Ok((nodes.get(..made).ok_or(full)?, deepest, steps))
}

/// The two children of a run parted at `at`, under node `number`.
fn split(task: &Task, run: &[Ref], at: usize, number: usize) -> (Task, Task) {
    let (left, right) = run.split_at_checked(at).unwrap_or((run, &[]));
    let child = |run: &[Ref], first, side| Task {
        first: task.first + first,
        len: run.len(),
        bounds: run.iter().fold(Aabb::EMPTY, |all, r| all.join(&r.bounds)),
        parent: Some((number, side)),
        level: task.level + 1,
    };
    (child(left, 0, 0), child(right, at, 1))
}

fn choose(config: &Config, run: &mut [Ref], task: &Task) -> Choice {
    let leaf = index(config.leaf.min(MAX_LEAF));
    match config.rule {
        _ if run.len() < 2 => Choice::Leaf,
        Rule::Seed if run.len() <= leaf => Choice::Leaf,
        _ if task.level >= HALVE_FROM => {
            if run.len() <= leaf {
                Choice::Leaf
            } else {
                halve(run)
            }
        }
        Rule::Seed => middle(run, &task.bounds, index(task.level - 1) % 3),
        Rule::Sah => sweep(run, &task.bounds, leaf),
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
