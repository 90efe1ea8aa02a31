//! From the root down by [`super::bins`] or by the full sweep: on all cores, if the feature says so.
//!
//! Nodes are numbered as they are met, child 0 first, whoever builds them: a thread that builds a subtree does so in
//! nodes of its own, which then move to where they would have been.
use super::bins::{self, Extent, Leaves, Parted};
use super::{HALVE_FROM, Place, full_nodes};
use crate::blob::MAX_STACK;
use crate::build::sah::{Choice, sweep};
use crate::build::{BuildError, Ref};
use crate::bvh::{Child, Node};
use crate::num::{count, index};

/// How runs are parted.
#[derive(Clone, Copy, Debug)]
pub enum Way {
    /// Quickly.
    Bins(Leaves),
    /// By weighing all places, down to single primitives.
    Sweep,
}

impl Way {
    fn part(&self, run: &mut [Ref], task: &Task) -> Parted {
        match self {
            _ if run.len() < 2 => None,
            Self::Bins(leaves) if task.level < HALVE_FROM => bins::part(run, &task.extent, leaves),
            Self::Sweep if task.level < HALVE_FROM => {
                let Choice::Split(at) = sweep(run, &task.extent.bounds) else { return None };
                let (left, right) = run.split_at_checked(at)?;
                Some((at, Extent::of(left), Extent::of(right)))
            }
            Self::Bins(leaves) if run.len() <= index(leaves.most) => None,
            _ => bins::in_half(run),
        }
    }
}

/// A run of references that is to become a child.
struct Task {
    first: usize,
    len: usize,
    extent: Extent,
    /// The place that waits for the child.
    place: Place,
    /// Level of the node that this may become; the root's is 1.
    level: u32,
}

/// Builds a tree, and returns how many nodes it has. Each node's first reserved word is its place.
pub fn descend(way: Way, refs: &mut [Ref], nodes: &mut [Node]) -> Result<usize, BuildError> {
    let extent = Extent::of(refs);
    let root = Task { first: 0, len: refs.len(), extent, place: Place::ROOT, level: 1 };
    let part = Part { way, refs, first: 0, nodes, base: 0 };
    #[cfg(feature = "parallel")]
    let made = part.fork(root);
    #[cfg(not(feature = "parallel"))]
    let made = part.run(root);
    made.map(|(_, made)| made)
}

/// What a thread works on: references from `first` on, and nodes whose numbers begin with `base`.
struct Part<'p> {
    way: Way,
    refs: &'p mut [Ref],
    first: usize,
    nodes: &'p mut [Node],
    base: usize,
}

impl Part<'_> {
    /// Builds a subtree, and returns what it is, and how many nodes it has.
    fn run(self, root: Task) -> Result<(Child, usize), BuildError> {
        let full = full_nodes(self.refs.len(), self.nodes.len());
        let mut tasks = heapless::Vec::<Task, { index(MAX_STACK) }>::new();
        let (mut made, top) = (0, root.place);
        let mut whole = Child::NONE;
        let mut next = Some(root);
        while let Some(task) = next.take().or_else(|| tasks.pop()) {
            let at = task.first - self.first;
            let run = self.refs.get_mut(at..at + task.len).unwrap_or(&mut []);
            let parted = self.way.part(run, &task);
            let number = self.base + made;
            let child = match parted {
                None => Child::leaf(count(task.first), count(task.len)),
                Some(_) => Child::node(count(number)),
            };
            if task.place == top {
                whole = child;
            } else {
                self.nodes.get_mut(task.place.node() - self.base).ok_or(full)?.child[task.place.side()] = child;
            }
            let Some(parted) = parted else { continue };
            let node = self.nodes.get_mut(made).ok_or(full)?;
            let (left, right) = task.split(parted, number, node);
            made += 1;
            tasks.push(right).map_err(|_| full)?;
            next = Some(left);
        }
        Ok((whole, made))
    }
}

impl Task {
    /// Makes a node, and returns what its children are to be made of.
    fn split(&self, (at, left, right): (usize, Extent, Extent), number: usize, node: &mut Node) -> (Self, Self) {
        *node = Node::new(&left.bounds, &right.bounds);
        node.reserved[0] = self.place.0;
        let child = |side, first, len, extent| Self {
            first,
            len,
            extent,
            place: Place::new(count(number), side),
            level: self.level + 1,
        };
        (child(0, self.first, at, left), child(1, self.first + at, self.len - at, right))
    }
}

#[cfg(feature = "parallel")]
impl Part<'_> {
    /// The same on all cores.
    fn fork(self, root: Task) -> Result<(Child, usize), BuildError> {
        /// A run of fewer is one thread's.
        const ALONE: usize = 8192;
        let n = self.refs.len();
        // Subtrees that are built at once need all the room that they could take.
        if n < ALONE || self.nodes.len() + 1 < n {
            return self.run(root);
        }
        let Self { way, refs, first, nodes, base } = self;
        let Some(parted) = way.part(refs, &root) else {
            return Ok((Child::leaf(count(root.first), count(root.len)), 0));
        };
        let at = parted.0;
        let full = full_nodes(n, nodes.len());
        let (node, nodes) = nodes.split_first_mut().ok_or(full)?;
        let (left, right) = root.split(parted, base, node);
        let (left_nodes, right_nodes) = nodes.split_at_mut_checked(at - 1).ok_or(full)?;
        let (left_refs, right_refs) = refs.split_at_mut_checked(at).ok_or(full)?;
        let left_part = Part { way, refs: left_refs, first, nodes: left_nodes, base: base + 1 };
        let right_part = Part { way, refs: right_refs, first: first + at, nodes: right_nodes, base: base + at };
        let (left, right) = rayon::join(|| left_part.fork(left), || right_part.fork(right));
        let ((left, left_made), (right, right_made)) = (left?, right?);
        let gap = at - 1 - left_made;
        node.child = [left, if right.is_node() { Child::node(right.number() - count(gap)) } else { right }];
        move_down(nodes.get_mut(left_made..at - 1 + right_made).unwrap_or(&mut []), gap, base);
        Ok((Child::node(count(base)), 1 + left_made + right_made))
    }
}

/// Moves the nodes of a subtree under node `above` down by so many places.
#[cfg(feature = "parallel")]
fn move_down(nodes: &mut [Node], gap: usize, above: usize) {
    if gap == 0 {
        return;
    }
    for i in gap..nodes.len() {
        let Some(mut node) = nodes.get(i).copied() else { break };
        for child in node.child.iter_mut().filter(|child| child.is_node()) {
            *child = Child::node(child.number() - count(gap));
        }
        let place = Place(node.reserved[0]);
        if place.node() != above {
            node.reserved[0] = Place::new(count(place.node() - gap), count(place.side())).0;
        }
        if let Some(to) = nodes.get_mut(i - gap) {
            *to = node;
        }
    }
}
