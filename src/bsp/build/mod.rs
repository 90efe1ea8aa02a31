//! The builder: top down, the part below each plane first, without recursion.
//!
//! `Seed` halves the box along x, y, z in turn until a leaf has at most [`Config::leaf`] primitives; where that helps
//! nothing it tries the other axes, and where none helps it goes on only while one half is empty, a few times. `Sah`
//! takes the plane of least expected cost (`sah`) and ends where that costs no less than a leaf; going on for one or
//! two splits more made blobs larger and walks slower on the meshes tried. Both end at a depth
//! limit, and where the memory that [`Needs`] names would not do: each node has a share of it in proportion
//! to its list, so a million primitives in one place take no more than their own.
//!
//! Memory: the lists of the node at hand and of those that wait stand on a stack of [`Ref`] (32 bytes), whose boxes are
//! those of the primitives' parts in the node. Planned are 2.5 references a primitive on that stack, 8 in the
//! leaves (4 bytes each), and 8 nodes (8 bytes each, and 2 for where their lists start).
//!
//! [`Needs`]: crate::build::Needs

mod clip;
mod radix;
mod sah;

use super::{Cell, Cut, Node};
use crate::blob::Section;
use crate::build::parts::{Parts, number_slots};
use crate::build::{Config, Input, Ref, Rule};
use crate::geom::Aabb;
use crate::geom::ray::Axis;
use crate::num::{count, float, floor, index, wide};
use clip::clipped;

/// Most inner nodes on a way down.
const MAX_DEPTH: u32 = 60;
/// Halvings in a row that may help nothing but shrink the box.
const MAX_FUTILE: u32 = 8;
/// Words of a node.
const NODE_WORDS: usize = 2;

/// The memory that a partition of so many primitives may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// Entries of [`crate::build::Arena::refs`].
    pub refs: usize,
    /// Pairs of children.
    pairs: u32,
    /// References in leaves: entries of [`crate::build::Arena::slots`].
    pub slots: u32,
}

impl Budget {
    /// For `n` primitives.
    #[must_use]
    pub const fn of(n: u32) -> Self {
        if n == 0 {
            return Self { refs: 0, pairs: 0, slots: 0 };
        }
        let refs = index(n).saturating_mul(5) / 2 + 64;
        // Numbers of children must stay below 2^30, and 2^31 references are within u32.
        let pairs = n.saturating_mul(4).saturating_add(64);
        let pairs = if pairs > 1 << 28 { 1 << 28 } else { pairs };
        Self { refs, pairs, slots: n.saturating_mul(8).saturating_add(64) }
    }

    /// Entries of [`crate::build::Arena::cells`]: nodes, and where the list of each leaf starts and the last one ends.
    #[must_use]
    pub const fn words(&self) -> usize {
        if self.slots == 0 { 0 } else { self.node_words() + index(self.pairs) + 2 }
    }

    const fn node_words(&self) -> usize {
        (2 * index(self.pairs) + 1) * NODE_WORDS
    }
}

/// A node that is to be made; its list is on top of the stack when its turn comes.
#[derive(Clone, Copy)]
struct Task {
    node: u32,
    len: usize,
    cell: Cell,
    level: u32,
    /// The axis whose turn it is.
    axis: Axis,
    futile: u32,
    /// What it may use of the budget.
    slots: u32,
    pairs: u32,
}

impl Task {
    /// The children's budgets: what their lists need, and of the rest a share by their lengths.
    fn shares(&self, marks: Marks) -> (Self, Self) {
        let (left, right) = (count(marks.left), count(marks.right));
        let share = |all: u32| {
            let part = u64::from(all) * u64::from(left) / (u64::from(left) + u64::from(right)).max(1);
            u32::try_from(part).unwrap_or(all)
        };
        let (spare, pairs) = (self.slots.saturating_sub(left + right), self.pairs.saturating_sub(1));
        let (more, below) = (share(spare), share(pairs));
        let of = |slots, pairs| Self { slots, pairs, ..*self };
        (of(left + more, below), of(right + (spare - more), pairs - below))
    }
}

/// How many primitives of a list are needed by either child, and by both.
#[derive(Clone, Copy)]
struct Marks {
    left: usize,
    right: usize,
    both: usize,
}

/// What a reference's `scratch` holds: the classes in the order in which they come to stand.
const RIGHT: f32 = 0.0;
const BOTH: f32 = 1.0;
const LEFT: f32 = 2.0;
const NEITHER: f32 = 3.0;

struct Builder<'b, 'i> {
    input: &'i Input<'i>,
    config: &'i Config,
    refs: &'b mut [Ref],
    /// References on the stack.
    top: usize,
    nodes: &'b mut [u32],
    /// Number of nodes.
    made: u32,
    starts: &'b mut [u32],
    leaves: usize,
    slots: &'b mut [u32],
    listed: usize,
    deepest: u32,
    limit: u32,
}

/// Builds a partition. The memory is as much as [`Budget`] says, and the references are filled.
pub fn build<'p>(
    input: &Input<'_>,
    config: &Config,
    refs: &'p mut [Ref],
    words: &'p mut [u32],
    slots: &'p mut [u32],
) -> Parts<'p> {
    let (n, budget) = (index(input.len), Budget::of(input.len));
    let Some((nodes, starts)) = words.split_at_mut_checked(budget.node_words()).filter(|_| n > 0) else {
        return Parts::default();
    };
    let depth = if config.rule == Rule::Seed { 8.0 + 2.0 * log2(input.len) } else { 8.0 + 1.3 * log2(input.len) };
    let limit = floor(depth).min(MAX_DEPTH);
    let mut builder =
        Builder { input, config, refs, top: n, nodes, made: 1, starts, leaves: 0, slots, listed: 0, deepest: 0, limit };
    builder.run(&budget);
    let Builder { refs, nodes, made, starts, leaves, slots, listed, deepest, .. } = builder;
    let nodes = nodes.get(..index(made) * NODE_WORDS).unwrap_or(&[]);
    let slots = slots.get_mut(..listed).unwrap_or(&mut []);
    let order = number_slots(starts.get(..=leaves).unwrap_or(&[]), slots, refs.get_mut(..n).unwrap_or(&mut []));
    let mut parts = Parts::new(order, deepest, made.saturating_add(count(listed)));
    parts.push(Section::CellLists, slots, 1);
    parts.push(Section::BspNodes, nodes, NODE_WORDS);
    parts
}

/// The whole logarithm, and what is between as a line.
fn log2(n: u32) -> f32 {
    let whole = n.max(1).ilog2();
    float(whole) + (float(n.max(1)) / float(1 << whole) - 1.0)
}

impl Builder<'_, '_> {
    fn run(&mut self, budget: &Budget) {
        let cell = Cell::root(&self.input.bounds);
        let (slots, pairs) = (budget.slots, budget.pairs);
        let root = Task { node: 0, len: self.top, cell, level: 0, axis: Axis::X, futile: 0, slots, pairs };
        let mut waiting = heapless::Vec::<Task, { index(MAX_DEPTH) }>::new();
        let mut next = Some(root);
        while let Some(task) = next.take().or_else(|| waiting.pop()) {
            let split = if self.may_split(&task) { self.choose(&task) } else { None };
            match split {
                None => self.leaf(&task),
                Some((cut, marks, child)) => {
                    let (left, right) = self.split(&child, cut, marks);
                    let pushed = waiting.push(right);
                    debug_assert!(pushed.is_ok(), "the depth limit bounds the stack");
                    next = Some(left);
                }
            }
        }
    }

    fn may_split(&self, task: &Task) -> bool {
        let enough = if self.config.rule == Rule::Seed { index(self.config.leaf) } else { 1 };
        task.len > enough && task.level < self.limit && task.pairs > 0
    }

    /// The list on top of the stack.
    fn list(&mut self, len: usize) -> &mut [Ref] {
        self.refs.get_mut(self.top.saturating_sub(len)..self.top).unwrap_or(&mut [])
    }

    /// Where to split, with the list marked, and what the children inherit; `None` for a leaf.
    fn choose(&mut self, task: &Task) -> Option<(Cut, Marks, Task)> {
        match self.config.rule {
            Rule::Seed => self.halve(task),
            Rule::Sah => self.cheapest(task),
        }
    }

    /// The seed's rule.
    fn halve(&mut self, task: &Task) -> Option<(Cut, Marks, Task)> {
        let (second, third) = task.axis.others();
        let mut shrinking = None;
        for axis in [task.axis, second, third] {
            let Some(cut) = middle(&task.cell.bounds, axis) else { continue };
            let marks = self.mark(task, cut);
            if !self.affords(task, marks) {
                continue;
            }
            let inherit = Task { axis: axis.others().0, ..*task };
            if marks.left.max(marks.right) < task.len {
                return Some((cut, marks, Task { futile: 0, ..inherit }));
            }
            // Nothing is parted, but one half is empty: going on may help.
            if marks.left.min(marks.right) == 0 && task.futile < MAX_FUTILE && shrinking.is_none() {
                shrinking = Some((cut, Task { futile: task.futile + 1, ..inherit }));
            }
        }
        let (cut, inherit) = shrinking?;
        Some((cut, self.mark(task, cut), inherit))
    }

    /// The surface-area heuristic.
    fn cheapest(&mut self, task: &Task) -> Option<(Cut, Marks, Task)> {
        let one = sah::leaf_cost(&task.cell.bounds, 1);
        if !(one > 0.0) {
            // Points on a line: areas say nothing.
            return self.halve(task);
        }
        let (stack, free) = self.refs.split_at_mut_checked(self.top)?;
        let list = stack.get(stack.len().saturating_sub(task.len)..)?;
        let bounds = &task.cell.bounds;
        // A node's share of references is never less than its list: so many are free.
        let spare = self.slots.get_mut(self.listed..)?;
        let cut = sah::plane(list, bytemuck::cast_slice_mut(free), spare, bounds)?;
        let marks = self.mark(task, cut);
        // What the children really list may be more than the sweep thought.
        let cheaper = sah::cost(bounds, cut, marks.left, marks.right) < one * f64::from(count(task.len));
        (cheaper && self.affords(task, marks)).then_some((cut, marks, *task))
    }

    /// Marks which child needs each primitive of a list.
    fn mark(&mut self, task: &Task, cut: Cut) -> Marks {
        let (input, k) = (self.input, cut.axis.at());
        let (below, above) = (task.cell.part(cut, false), task.cell.part(cut, true));
        let mut marks = Marks { left: 0, right: 0, both: 0 };
        for r in self.list(task.len) {
            let prim = input.prim(r.prim);
            let own = prim.bounds();
            // One that is not cut stays where it was needed before.
            let (left, right) = match () {
                () if own.max[k] <= cut.plane => (true, false),
                () if own.min[k] >= cut.plane => (false, true),
                () => (below.needs(&prim, &own), above.needs(&prim, &own)),
            };
            marks.left += usize::from(left);
            marks.right += usize::from(right);
            marks.both += usize::from(left && right);
            r.scratch = match (left, right) {
                (false, true) => RIGHT,
                (true, true) => BOTH,
                (true, false) => LEFT,
                (false, false) => NEITHER,
            };
        }
        marks
    }

    /// Whether the children's lists are within the node's share, and within the stack with what a sweep needs.
    fn affords(&self, task: &Task, marks: Marks) -> bool {
        let sweep = marks.left.max(marks.right) / 4 + 1;
        count(marks.left + marks.right) <= task.slots && self.top + marks.both + sweep <= self.refs.len()
    }

    /// Makes an inner node of a marked list, and two lists of it: the one above the plane, and on top the one below.
    fn split(&mut self, task: &Task, cut: Cut, marks: Marks) -> (Task, Task) {
        let child = self.made;
        self.put(task.node, Node::inner(cut, child));
        self.made += 2;
        let (below, above) = (task.cell.part(cut, false), task.cell.part(cut, true));
        let start = self.top - task.len;
        self.list(task.len).sort_unstable_by_key(|r| floor(r.scratch));
        // References that neither child needs are the last.
        self.top = start + (marks.left + marks.right - marks.both);
        let (first, top) = (start + (marks.right - marks.both), self.top);
        self.refs.copy_within(first..first + marks.both, top);
        self.top += marks.both;
        // The copy on top belongs to the list below the plane.
        self.clip(first, marks.both, &above.bounds);
        self.clip(top, marks.both, &below.bounds);
        let (left, right) = task.shares(marks);
        let left = Task { node: child, len: marks.left, cell: below, level: task.level + 1, ..left };
        (left, Task { node: child + 1, len: marks.right, cell: above, level: task.level + 1, ..right })
    }

    /// Clips `len` references from `first` to a child's box.
    fn clip(&mut self, first: usize, len: usize, cell: &Aabb) {
        for r in self.refs.get_mut(first..first + len).unwrap_or(&mut []) {
            let prim = self.input.prim(r.prim);
            r.bounds = clipped(&prim, &prim.bounds(), cell);
        }
    }

    /// Makes a leaf of the list on top, and takes that off.
    fn leaf(&mut self, task: &Task) {
        self.put(task.node, Node::leaf(count(self.listed), count(task.len)));
        self.deepest = self.deepest.max(task.level);
        let (first, listed) = (self.top - task.len, self.listed + task.len);
        let slots = self.slots.get_mut(self.listed..listed).unwrap_or(&mut []);
        for (slot, r) in slots.iter_mut().zip(self.refs.get(first..self.top).unwrap_or(&[])) {
            *slot = r.prim;
        }
        (self.top, self.listed) = (first, listed);
        self.leaves += 1;
        if let Some(start) = self.starts.get_mut(self.leaves) {
            *start = count(listed);
        }
    }

    fn put(&mut self, number: u32, node: Node) {
        let at = index(number) * NODE_WORDS;
        if let Some(words) = self.nodes.get_mut(at..at + NODE_WORDS) {
            words.copy_from_slice(&[node.place, node.word]);
        }
    }
}

/// The plane that halves a box; `None` if there is none strictly inside.
fn middle(bounds: &Aabb, axis: Axis) -> Option<Cut> {
    let (min, max) = (bounds.min[axis.at()], bounds.max[axis.at()]);
    let plane = crate::num::narrow((wide(min) + wide(max)) * 0.5);
    (min < plane && plane < max).then_some(Cut { axis, plane })
}
