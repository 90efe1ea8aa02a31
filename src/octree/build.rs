//! The builder: depth first, with the lists that are still to be split on a stack in the words lent for references.
//!
//! `Rule::Seed` splits wherever more than [`Config::leaf`] primitives are listed, unless that runs away. `Rule::Sah`
//! splits where the expected cost falls. A random line that meets a cube meets one of its eight parts with the share of
//! their areas, a quarter (`MacDonald` and Booth, "Heuristics for ray tracing using space subdivision", The Visual
//! Computer 6, 1990). Where a leaf would be crowded and its parts do not pay, theirs may.
//!
//! A split that does not reduce the largest child, which lists as many primitives as the node, is the sign of one that
//! runs away, and stops, but for one case: what it does reduce is the space that they are in. That is so for `Seed`
//! while all children together list less than half as many again, which is not so around a vertex that more triangles
//! meet in, and for `Sah` while the expected cost falls without looking further ahead. To stop there too leaves crowds
//! whole: tests a ray of `spd:teapot:6` rose from 11.0 to 31.2 (camera) and from 15.6 to 25.3 (diffuse) for 5 % fewer
//! bytes (`Sah`: from 9.9 to 31.1, from 14.8 to 25.3; 7 %), and of 968 triangles on a ground a thousand times their
//! size, where every list has the ground, from 1.6 to 970, because the root was not split. What is always certain is
//! the depth, at most 16, and the budget.
//!
//! Every node has a budget of words, which its children share as their lists are long: a tree has at most 16 words a
//! primitive, and 64, whatever the primitives. The memory is measured by that, so it always suffices.
use super::{Cell, MAX_LEVELS, Node};
use crate::blob::Section;
use crate::build::parts::{Parts, number_slots};
use crate::build::{Config, Input, Ref, Rule};
use crate::geom::Aabb;
use crate::geom::lattice::Lattice;
use crate::geom::vec::most;
use crate::grid::Shape;
use crate::num::{count, float, index};
use bytemuck::Zeroable;
use core::ops::Range;

/// Words of a shape.
const SHAPE_WORDS: usize = size_of::<Shape>() / 4;
/// Words of a node.
const NODE_WORDS: usize = size_of::<Node>() / 4;
/// Words that nodes, lists and their starts may take: so many a primitive,
const BUDGET: u32 = 16;
/// and so many for any scene.
const SPARE: u32 = 64;
/// Cost of a node visited, in primitive tests.
const NODE_COST: f32 = 4.0;
/// Cost of a leaf visited, beside its tests.
const LEAF_COST: f32 = 2.0;
/// Share of the lines through a cube that meet one of its eight parts.
const SHARE: f32 = 0.25;

/// An octree that memory is measured for.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// The lattice over the root cube; none if the scene is so large that its planes overflow, and then it has no node.
    shape: Option<Shape>,
    budget: u32,
    len: u32,
}

impl Plan {
    /// Places the root cube: its least corner is that of the scene, so that a flat scene lies along its side and not
    /// across its middle.
    #[must_use]
    pub fn new(input: &Input<'_>) -> Self {
        let (b, cells) = (&input.bounds, [1 << MAX_LEVELS; 3]);
        let side = most(most(b.max[0] - b.min[0], b.max[1] - b.min[1]), b.max[2] - b.min[2]);
        // Where rounding makes the sum less than the greatest corner, the lattice has to reach that all the same.
        let cube = Aabb { min: b.min, max: [0, 1, 2].map(|k| most(b.min[k] + side, b.max[k])) };
        let shape = Shape { lattice: Lattice::over(&cube, cells), cells, reserved: 0 };
        let budget =
            if input.len == 0 { 0 } else { input.len.saturating_mul(BUDGET).saturating_add(SPARE).min(1 << 30) };
        Self { shape: shape.lattice.covers(b, cells).then_some(shape), budget, len: input.len }
    }

    /// Words of [`crate::build::Arena::cells`].
    #[must_use]
    pub const fn words(&self) -> usize {
        if self.len == 0 { 0 } else { SHAPE_WORDS + index(self.budget) + 1 }
    }

    /// Words of [`crate::build::Arena::slots`]: for all lists, and for one twice, while it is split.
    #[must_use]
    pub const fn slots(&self) -> usize {
        index(self.budget) + index(self.len)
    }
}

/// Builds the tree of a plan. `words` and `slots` are as long as the plan says.
pub fn build<'p>(
    input: &Input<'_>,
    config: &Config,
    plan: &Plan,
    refs: &'p mut [Ref],
    words: &'p mut [u32],
    slots: &'p mut [u32],
) -> Parts<'p> {
    let Some((head, tables)) = words.split_at_mut_checked(SHAPE_WORDS) else { return Parts::default() };
    let shape = plan.shape.unwrap_or(Shape::zeroed());
    head.copy_from_slice(bytemuck::cast_slice(&[shape]));
    let top = slots.len() - index(plan.len);
    for (i, slot) in slots.iter_mut().skip(top).enumerate() {
        *slot = count(i);
    }
    let all = top..slots.len();
    let lattice = shape.lattice;
    let mut builder =
        Builder { input, config, lattice, refs, tables, slots, nodes: 0, lists: 0, listed: 0, deepest: 0 };
    let root = Cell::root(&shape);
    if plan.shape.is_some() && builder.pays(&all, &root, plan.budget) {
        builder.nodes = 1;
        builder.node(0, all, &root, plan.budget, 1);
    } else {
        builder.emit(all);
    }
    builder.parts(head)
}

struct Builder<'b, 'p> {
    input: &'b Input<'b>,
    config: &'b Config,
    lattice: Lattice,
    /// One a primitive, in the caller's order; its scratch holds the children that it has a part in.
    refs: &'p mut [Ref],
    /// Nodes from the first word up; starts of lists from the last word down.
    tables: &'p mut [u32],
    /// Lists of leaves from the first word up; lists of nodes still to be split from the last word down.
    slots: &'p mut [u32],
    nodes: usize,
    lists: usize,
    listed: usize,
    deepest: u32,
}

impl<'p> Builder<'_, 'p> {
    /// What was built, as sections; `shape` is that of the lattice.
    fn parts(self, shape: &'p [u32]) -> Parts<'p> {
        let Self { nodes, lists, listed, deepest, refs, tables, slots, .. } = self;
        let (nodes, rest) = tables.split_at_mut(nodes * NODE_WORDS);
        // The starts stand at the end, the last one first.
        let starts = rest.split_at_mut(rest.len() - lists - 1).1;
        starts.reverse();
        let (slots, _) = slots.split_at_mut(listed);
        let order = number_slots(starts, slots, refs);
        let steps = count(nodes.len() / NODE_WORDS + lists + listed);
        let mut parts = Parts::new(order, deepest, steps);
        parts.push(Section::GridShape, if nodes.is_empty() { &[] } else { shape }, SHAPE_WORDS);
        parts.push(Section::CellStarts, starts, 1);
        parts.push(Section::CellLists, slots, 1);
        parts.push(Section::OctreeNodes, nodes, NODE_WORDS);
        parts
    }

    /// Splits node `number`, whose list is the lowest of those still to be split, and then its children.
    fn node(&mut self, number: usize, list: Range<usize>, cell: &Cell, budget: u32, level: u32) {
        self.deepest = self.deepest.max(level);
        let counts = self.mark(&list, cell);
        let lists = self.part(&list, counts);
        let budgets = shares(counts, budget);
        let mut node = Node { first: count(self.nodes), list: count(self.lists), ..Node::zeroed() };
        for (c, list) in lists.iter().enumerate() {
            let (bit, child) = (1u8 << c, cell.child(count(c)));
            if self.pays(list, &child, budgets[c]) {
                node.inner |= bit;
            } else if !list.is_empty() {
                node.leaves |= bit;
                self.emit(list.clone());
            }
        }
        if let Some(place) = self.tables.get_mut(number * NODE_WORDS..(number + 1) * NODE_WORDS) {
            place.copy_from_slice(bytemuck::cast_slice(&[node]));
        }
        self.nodes += index(node.inner.count_ones());
        // The lists of children that are nodes move up to where this node's was: the last one first, none over another.
        let (mut moved, mut top) = (lists, list.end);
        for (c, list) in moved.iter_mut().enumerate().rev() {
            if node.inner & 1 << c != 0 {
                let from = list.clone();
                *list = top - list.len()..top;
                top = list.start;
                self.slots.copy_within(from, top);
            }
        }
        let mut next = index(node.first);
        for (c, list) in moved.into_iter().enumerate() {
            if node.inner & 1 << c != 0 {
                self.node(next, list, &cell.child(count(c)), budgets[c], level + 1);
                next += 1;
            }
        }
    }

    /// Notes for each primitive of a list the children that it has a part in, and counts them.
    fn mark(&mut self, list: &Range<usize>, cell: &Cell) -> [u32; 8] {
        let parts = boxes(cell, &self.lattice);
        let mut counts = [0; 8];
        for &prim in self.slots.get(list.clone()).unwrap_or(&[]) {
            let set = overlapped(self.input, prim, &parts, &mut counts);
            if let Some(r) = self.refs.get_mut(index(prim)) {
                r.scratch = f32::from_bits(set);
            }
        }
        counts
    }

    /// Writes the lists of the children below a marked list.
    fn part(&mut self, list: &Range<usize>, counts: [u32; 8]) -> [Range<usize>; 8] {
        let Some((free, above)) = self.slots.split_at_mut_checked(list.start) else { return Default::default() };
        let mut top = list.start;
        let mut lists: [Range<usize>; 8] = Default::default();
        for (c, own) in lists.iter_mut().enumerate().rev() {
            *own = top.saturating_sub(index(counts[c]))..top;
            top = own.start;
            let has = |prim: &&u32| self.refs.get(index(**prim)).is_some_and(|r| r.scratch.to_bits() & 1 << c != 0);
            let prims = above.iter().take(list.len()).filter(has);
            for (place, prim) in free.get_mut(own.clone()).unwrap_or(&mut []).iter_mut().zip(prims) {
                *place = *prim;
            }
        }
        lists
    }

    /// Makes a list a leaf's: the next one.
    fn emit(&mut self, list: Range<usize>) {
        let words = self.tables.len();
        let end = self.listed + list.len();
        self.slots.copy_within(list, self.listed);
        for (i, start) in [(self.lists, self.listed), (self.lists + 1, end)] {
            if let Some(place) = self.tables.get_mut(words - 1 - i) {
                *place = count(start);
            }
        }
        self.lists += 1;
        self.listed = end;
    }

    /// Whether a list had better be split.
    fn pays(&self, list: &Range<usize>, cell: &Cell, budget: u32) -> bool {
        let list = self.slots.get(list.clone()).unwrap_or(&[]);
        let (n, crowded) = (count(list.len()), count(list.len()) > self.config.leaf);
        if cell.side < 2 || n < 2 || (self.config.rule == Rule::Seed && !crowded) {
            return false;
        }
        let parts = boxes(cell, &self.lattice);
        let mut counts = [0; 8];
        for &prim in list {
            overlapped(self.input, prim, &parts, &mut counts);
        }
        let sum = counts.iter().fold(0u32, |sum, n| sum.saturating_add(*n));
        let largest = counts.into_iter().fold(0, u32::max);
        // What only rounding put here may have a part in no child.
        if sum == 0 || cost_in_words(counts) > budget {
            return false;
        }
        if self.config.rule == Rule::Seed {
            return largest < n || sum.saturating_sub(n) < n / 2;
        }
        let leaf = LEAF_COST + float(n);
        split_cost(counts.map(|n| LEAF_COST + float(n))) < leaf
            || (crowded && largest < n && cell.side > 2 && split_cost(self.ahead(list, cell)) < leaf)
    }

    /// The least cost of each child if it may be split itself, once.
    fn ahead(&self, list: &[u32], cell: &Cell) -> [f32; 8] {
        let mut costs = [0.0; 8];
        for (c, cost) in (0..8).zip(&mut costs) {
            let child = cell.child(c);
            let (bounds, parts) = (child.bounds(&self.lattice), boxes(&child, &self.lattice));
            let (mut n, mut counts) = (0, [0; 8]);
            for &prim in list.iter().filter(|p| self.input.prim(**p).overlaps(&bounds)) {
                overlapped(self.input, prim, &parts, &mut counts);
                n += 1;
            }
            let (leaf, split) = (LEAF_COST + float(n), split_cost(counts.map(|n| LEAF_COST + float(n))));
            *cost = if split < leaf { split } else { leaf };
        }
        costs
    }
}

/// The boxes of a cell's eight children.
fn boxes(cell: &Cell, lattice: &Lattice) -> [Aabb; 8] {
    [0, 1, 2, 3, 4, 5, 6, 7].map(|c| cell.child(c).bounds(lattice))
}

/// The children that a primitive has a part in, as bits; counts them.
fn overlapped(input: &Input<'_>, prim: u32, parts: &[Aabb; 8], counts: &mut [u32; 8]) -> u32 {
    let prim = input.prim(prim);
    let mut set = 0;
    for (c, (part, n)) in parts.iter().zip(counts).enumerate() {
        if prim.overlaps(part) {
            set |= 1 << c;
            *n += 1;
        }
    }
    set
}

/// Expected cost of a node whose children cost so much; those that cost no more than an empty leaf are not visited.
fn split_cost(children: [f32; 8]) -> f32 {
    NODE_COST + SHARE * children.into_iter().filter(|&c| c > LEAF_COST).fold(0.0, |sum, c| sum + c)
}

/// Words of a node with leaves of so many primitives.
fn cost_in_words(counts: [u32; 8]) -> u32 {
    counts.into_iter().filter(|&n| n > 0).fold(count(NODE_WORDS), |sum, n| sum.saturating_add(n).saturating_add(1))
}

/// A node's budget, shared by its children as their lists are long: at least what leaves of them take.
fn shares(counts: [u32; 8], budget: u32) -> [u32; 8] {
    let (own, all) = (count(NODE_WORDS), cost_in_words(counts));
    let (left, sum) = (u64::from(budget.saturating_sub(own)), u64::from(all.saturating_sub(own)).max(1));
    counts.map(|n| if n == 0 { 0 } else { u32::try_from(left * (u64::from(n) + 1) / sum).unwrap_or(0) })
}
