//! Octree.
//!
//! A cube around the scene is halved along each axis into eight, and so on where it is crowded; a primitive is listed
//! in every leaf that it has a part in (Glassner, "Space Subdivision for Fast Ray Tracing", IEEE CG&A 4(10), 1984).
//!
//! Choose it for scenes whose detail is uneven, where a grid's cells are too large here and too small there. Primitives
//! that many leaves share cost memory. An inner node takes 12 bytes, a leaf 4 and 4 for each primitive listed; an empty
//! leaf takes nothing. No coordinates are stored: every plane is one of a lattice over the root cube, with `2^d` cells
//! a side, and its number follows from the way down. The stack is as deep as the tree, at most 16.
//!
//! # Node: 12 bytes
//! | offset | size | field | meaning |
//! |---|---|---|---|
//! | 0 | 4 | `first` | number of the first child that is a node; the others follow it |
//! | 4 | 4 | `list` | number of the list of the first child that is a leaf; the others follow it |
//! | 8 | 1 | `inner` | bit `c` is set if child `c` is a node |
//! | 9 | 1 | `leaves` | bit `c` is set if child `c` is a leaf with a list |
//! | 10 | 2 | `pad` | 0 |
//!
//! Bits 0, 1 and 2 of a child's number are set if it lies on the upper side of the middle in x, y and z. For example
//! `inner` 0x41 and `first` 7: child 0 is node 7, child 6 is node 8.

#[cfg(feature = "build")]
pub mod build;
pub(crate) mod group;
mod walk;

use crate::blob::lists::Lists;
use crate::blob::prims::{Primitive, Prims};
use crate::blob::{Blob, BlobError, Rule, Section};
use crate::geom::Aabb;
use crate::geom::lattice::Lattice;
use crate::grid::Shape;
use crate::num::{count, index};
use crate::walk::Part;
use bytemuck::{Pod, Zeroable};

/// Most levels of nodes: the root cube has at most `2^16` cells a side.
pub const MAX_LEVELS: usize = 16;

/// An inner node, as the module's table says.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Node {
    /// Number of the first child that is a node.
    pub first: u32,
    /// Number of the list of the first child that is a leaf.
    pub list: u32,
    /// Which children are nodes.
    pub inner: u8,
    /// Which children are leaves with a list.
    pub leaves: u8,
    /// 0.
    pub pad: u16,
}

const _: () = assert!(size_of::<Node>() == 12);

/// What a node has in one of its eight places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Child {
    /// Nothing.
    Empty,
    /// The node of this number.
    Node(u32),
    /// A leaf with the list of this number.
    Leaf(u32),
}

impl Node {
    /// Child `c`, from 0 to 7.
    #[inline(always)]
    #[must_use]
    pub fn child(&self, c: u32) -> Child {
        let bit = 1u32 << (c & 7);
        let (inner, leaves) = (u32::from(self.inner), u32::from(self.leaves));
        if inner & bit != 0 {
            Child::Node(self.first.wrapping_add((inner & (bit - 1)).count_ones()))
        } else if leaves & bit != 0 {
            Child::Leaf(self.list.wrapping_add((leaves & (bit - 1)).count_ones()))
        } else {
            Child::Empty
        }
    }

    /// The children that are there, by their bits.
    #[inline(always)]
    #[must_use]
    pub fn children(&self) -> u32 {
        u32::from(self.inner) | u32::from(self.leaves)
    }
}

/// The place of a node or leaf in the lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Its first cell of the lattice along each axis.
    pub corner: [u32; 3],
    /// Its cells along an axis: a power of 2.
    pub side: u32,
}

impl Cell {
    /// The root's.
    #[must_use]
    pub const fn root(shape: &Shape) -> Self {
        Self { corner: [0; 3], side: shape.cells[0] }
    }

    /// Numbers of the planes that halve it.
    #[inline(always)]
    #[must_use]
    pub fn middle(&self) -> [u32; 3] {
        self.corner.map(|i| i.wrapping_add(self.side / 2))
    }

    /// That of child `c`.
    #[inline(always)]
    #[must_use]
    pub fn child(&self, c: u32) -> Self {
        let ([x, y, z], half) = (self.corner, self.side / 2);
        let upper = |i: u32, bit: u32| if c & bit == 0 { i } else { i.wrapping_add(half) };
        Self { corner: [upper(x, 1), upper(y, 2), upper(z, 4)], side: half }
    }

    /// Its box.
    #[must_use]
    pub fn bounds(&self, lattice: &Lattice) -> Aabb {
        lattice.bounds(self.corner, self.corner.map(|i| i.wrapping_add(self.side)))
    }
}

/// The octree in a blob. Without nodes there is no shape either, and all primitives are in one list.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The lattice over the root cube.
    pub shape: Option<&'a Shape>,
    /// The inner nodes.
    pub nodes: &'a [Node],
    /// The list of each leaf.
    pub lists: Lists<'a>,
    /// The scene's box.
    bounds: &'a Aabb,
}

const fn broken(rule: Rule, node: u32) -> BlobError {
    BlobError::new(rule, Section::OctreeNodes).at(node)
}

/// A node on the way down, and its children still to come.
struct Waiting {
    number: u32,
    cell: Cell,
    rest: u32,
}

impl Waiting {
    /// The next child's number and cell.
    fn next(&mut self) -> Option<(u32, Cell)> {
        let c = self.rest.trailing_zeros();
        self.rest &= self.rest.wrapping_sub(1);
        (c < 8).then(|| (c, self.cell.child(c)))
    }
}

type Way = heapless::Vec<Waiting, MAX_LEVELS>;

impl<'a> View<'a> {
    /// The sections, O(1): rules 7, 10, 25 and 40.
    ///
    /// # Errors
    /// The first rule that is broken.
    pub fn parse(blob: &Blob<'a>) -> Result<Self, BlobError> {
        let bounds = &blob.header().bounds;
        let (nodes, lists) = (blob.section(Section::OctreeNodes)?, Lists::parse(blob)?);
        let view = Self { shape: Shape::parse(blob, bounds)?, nodes, lists, bounds };
        let fits = match view.shape {
            None => view.nodes.is_empty() && view.lists.len() == usize::from(blob.header().prims > 0),
            Some(Shape { cells: [x, y, z], .. }) => {
                let levels = index(x.trailing_zeros());
                let cube = x == y && y == z && x.is_power_of_two() && (1..=MAX_LEVELS).contains(&levels);
                cube && !view.nodes.is_empty()
            }
        };
        if fits { Ok(view) } else { Err(BlobError::new(Rule::OctreeShape, Section::GridShape)) }
    }

    /// Most steps of a walk: every node, every leaf that lists anything, and every reference.
    #[must_use]
    pub const fn steps(&self) -> u32 {
        count(self.nodes.len()).saturating_add(count(self.lists.len())).saturating_add(count(self.lists.slots.len()))
    }

    /// Calls `each` with every node and every leaf that lists anything, a node before what is below it.
    pub fn parts(&self, each: &mut impl FnMut(Part)) {
        let listed = |list| self.lists.get(list).map(|list| count(list.len()));
        let Some(shape) = self.shape else {
            return each(Part { bounds: *self.bounds, level: 0, listed: listed(0) });
        };
        // Nodes that were not checked may go round in circles: no more are opened than there are.
        let mut left = self.nodes.len().saturating_sub(1);
        let mut way = Way::new();
        let root = Cell::root(shape);
        each(Part { bounds: root.bounds(&shape.lattice), level: 0, listed: None });
        let _ = way.push(Waiting { number: 0, cell: root, rest: 0xff });
        loop {
            let level = count(way.len());
            let Some(above) = way.last_mut() else { return };
            let node = self.nodes.get(index(above.number)).copied().unwrap_or_default();
            let Some((c, cell)) = above.next() else {
                way.pop();
                continue;
            };
            let bounds = cell.bounds(&shape.lattice);
            match node.child(c) {
                Child::Empty => {}
                Child::Leaf(list) => each(Part { bounds, level, listed: listed(list) }),
                Child::Node(number) => {
                    let Some(fewer) = left.checked_sub(1) else { return };
                    left = fewer;
                    each(Part { bounds, level, listed: None });
                    let _ = way.push(Waiting { number, cell, rest: 0xff });
                }
            }
        }
    }

    /// The full check, with a stack of its own as deep as the walk's: rules 7, 26 to 28, 41 and 42.
    ///
    /// Returns the deepest stack of any walk.
    ///
    /// # Errors
    /// The first rule that is broken, and where.
    pub fn check(&self, prims: &Prims<'_>) -> Result<u32, BlobError> {
        self.lists.check(prims)?;
        // Without nodes the one list has every primitive: rule 27.
        let Some(shape) = self.shape else { return Ok(0) };
        let deepest = self.check_order(shape.cells[0].trailing_zeros())?;
        for slot in 0..prims.len {
            if let Some(prim) = prims.get(slot) {
                self.check_listed(shape, slot, &prim)?;
            }
        }
        Ok(deepest)
    }

    /// One pass through the nodes, depth first. The children of a node must have the numbers that follow all that were
    /// given before it, and so must its lists. So no node has two parents, there is no cycle, and nothing is left out.
    fn check_order(&self, levels: u32) -> Result<u32, BlobError> {
        // The children of each node on the way down: the number of the next, and how many are left.
        let mut groups = heapless::Vec::<(u32, u32), MAX_LEVELS>::new();
        let (mut next_node, mut next_list, mut deepest) = (1u32, 0u32, 0);
        let _ = groups.push((0, 1));
        loop {
            let level = count(groups.len());
            let Some(group) = groups.last_mut() else { break };
            if group.1 == 0 {
                groups.pop();
                continue;
            }
            let number = group.0;
            *group = (number.saturating_add(1), group.1.saturating_sub(1));
            let node = self.check_node(number, (next_node, next_list))?;
            if level > levels {
                return Err(broken(Rule::OctreeDepth, number).found(level).needed(levels));
            }
            deepest = deepest.max(level);
            let inner = node.inner.count_ones();
            if inner > 0 && groups.push((next_node, inner)).is_err() {
                return Err(broken(Rule::OctreeDepth, number).found(level.saturating_add(1)).needed(levels));
            }
            next_node = next_node.saturating_add(inner);
            next_list = next_list.saturating_add(node.leaves.count_ones());
        }
        let ends = |found: u32, needed: usize| {
            let error = broken(Rule::OctreeOrder, count(self.nodes.len())).found(found).needed(count(needed));
            if index(found) == needed { Ok(()) } else { Err(error) }
        };
        ends(next_node, self.nodes.len())?;
        ends(next_list, self.lists.len())?;
        Ok(deepest)
    }

    /// A node whose children are to have these numbers: rules 7 and 41.
    fn check_node(&self, number: u32, (first, list): (u32, u32)) -> Result<&'a Node, BlobError> {
        let broken = |rule| broken(rule, number);
        let node = self.nodes.get(index(number)).ok_or(broken(Rule::OctreeOrder))?;
        if node.pad != 0 {
            return Err(broken(Rule::Reserved));
        }
        if node.first != first || node.list != list {
            let wrong = if node.first == first { (node.list, list) } else { (node.first, first) };
            return Err(broken(Rule::OctreeOrder).found(wrong.0).needed(wrong.1));
        }
        if node.inner & node.leaves != 0 || node.children() == 0 {
            return Err(broken(Rule::OctreeOrder));
        }
        Ok(node)
    }

    /// Whether every leaf that a primitive has a part in lists it: rule 28. What has no part in a node has none below.
    fn check_listed(&self, shape: &Shape, slot: u32, prim: &Primitive) -> Result<(), BlobError> {
        let mut way = Way::new();
        let _ = way.push(Waiting { number: 0, cell: Cell::root(shape), rest: 0xff });
        while let Some(above) = way.last_mut() {
            let number = above.number;
            let Some((c, cell)) = above.next() else {
                way.pop();
                continue;
            };
            if !prim.overlaps(&cell.bounds(&shape.lattice)) {
                continue;
            }
            let node = self.nodes.get(index(number)).ok_or(broken(Rule::OctreeOrder, number))?;
            match node.child(c) {
                Child::Node(number) => {
                    let below = Waiting { number, cell, rest: 0xff };
                    way.push(below).map_err(|_| broken(Rule::OctreeDepth, number))?;
                }
                Child::Leaf(list) if self.lists.get(list).is_some_and(|l| l.binary_search(&slot).is_ok()) => {}
                _ => return Err(broken(Rule::ListComplete, number).found(c).needed(slot)),
            }
        }
        Ok(())
    }
}
