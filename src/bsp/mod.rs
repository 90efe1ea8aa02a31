//! Axis-aligned binary space partition.
//!
//! A plane parts the box of a node in two, and so on down to leaves that list the primitives with a part in them
//! (Kaplan, "Space-Tracing: A Constant Time Ray-Tracer", SIGGRAPH 1985 course notes; with the surface-area heuristic
//! `MacDonald` and Booth, "Heuristics for ray tracing using space subdivision", The Visual Computer 6, 1990). A node is
//! a plane and a number: 8 bytes, whatever it parts. Boxes are not stored: the root's is the header's, the others
//! follow from the planes.
//!
//! Choose it where a small stack and small nodes count and rays come one at a time: leaves are met in the order of the
//! ray, so the first hit mostly ends the walk. A primitive is listed in several leaves, and may be tested more than
//! once.
//!
//! # A node: 8 bytes
//! | offset | size | field | meaning |
//! |---|---|---|---|
//! | 0 | 4 | `place` | inner node: the plane as `f32`; leaf: where its list starts in `cell lists` |
//! | 4 | 4 | `word` | upper 30 bits: number of the first child, or length of the list; lower 2: axis, or 3 for a leaf |
//!
//! Node 0 is the root. The children of a node follow each other, the one below the plane first; a pair comes after
//! everything that is met before its parent, child 0 first.
//!
//! # What a leaf lists
//! A primitive that lies on one side of a plane, or ends in it, is not listed on the other: its box is inside the one
//! child, so the interval of `t` in which it counts is inside that child's (rule 3 of [`crate::geom`]). What is flat
//! and in the plane belongs to the child below. So a cell owns its greatest planes and not its least, but for the
//! root's own; a primitive is listed where it has a part in the cell in this sense, [`Cell::needs`].

#[cfg(feature = "build")]
pub mod build;
mod check;
pub(crate) mod group;
mod walk;

use crate::blob::prims::{Primitive, Prims};
use crate::blob::{Blob, BlobError, MAX_STACK, Section};
use crate::geom::Aabb;
use crate::geom::ray::Axis;
use crate::num::{count, index};
use crate::walk::Part;
use bytemuck::{Pod, Zeroable};

/// Bits of a node's word that hold the axis.
const AXIS_BITS: u32 = 2;
/// What they hold in a leaf.
const LEAF: u32 = 3;
/// Children and lengths of lists are below this.
pub const MAX_NUMBER: u32 = 1 << 30;

/// A node, as the module's table says.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Node {
    /// The bits of the plane, or the first reference.
    pub place: u32,
    /// Number and axis.
    pub word: u32,
}

const _: () = assert!(size_of::<Node>() == 8);

/// Where a node is parted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Perpendicular to the plane.
    pub axis: Axis,
    /// Where the plane is on the axis.
    pub plane: f32,
}

impl Node {
    /// An inner node whose children are `child` and `child + 1`.
    #[must_use]
    pub const fn inner(cut: Cut, child: u32) -> Self {
        let axis = match cut.axis {
            Axis::X => 0,
            Axis::Y => 1,
            Axis::Z => 2,
        };
        Self { place: cut.plane.to_bits(), word: child << AXIS_BITS | axis }
    }

    /// A leaf that lists `len` slots from `first`.
    #[must_use]
    pub const fn leaf(first: u32, len: u32) -> Self {
        Self { place: first, word: len << AXIS_BITS | LEAF }
    }

    /// Where it is parted; `None` for a leaf.
    #[inline(always)]
    #[must_use]
    pub const fn cut(self) -> Option<Cut> {
        let axis = match self.word & LEAF {
            0 => Axis::X,
            1 => Axis::Y,
            2 => Axis::Z,
            _ => return None,
        };
        Some(Cut { axis, plane: f32::from_bits(self.place) })
    }

    /// The first child's number, or the length of the list.
    #[inline(always)]
    #[must_use]
    pub const fn number(self) -> u32 {
        self.word >> AXIS_BITS
    }
}

/// A node's box, and the root's.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// The node's.
    pub bounds: Aabb,
    /// The root's.
    root: Aabb,
}

impl Cell {
    /// The root's cell.
    #[must_use]
    pub const fn root(bounds: &Aabb) -> Self {
        Self { bounds: *bounds, root: *bounds }
    }

    /// The part below (`above`: above) a plane.
    #[must_use]
    pub const fn part(mut self, cut: Cut, above: bool) -> Self {
        *self.end(cut.axis, above) = cut.plane;
        self
    }

    /// The end of its box that a plane replaces.
    const fn end(&mut self, axis: Axis, above: bool) -> &mut f32 {
        if above { &mut self.bounds.min[axis.at()] } else { &mut self.bounds.max[axis.at()] }
    }

    /// Whether a primitive, whose box is `own`, must be listed if this is a leaf.
    #[must_use]
    pub fn needs(&self, prim: &Primitive, own: &Aabb) -> bool {
        let (cell, root) = (&self.bounds, &self.root);
        let along = |k: usize| {
            // A plane at the root's own end cuts nothing: planes lie strictly inside.
            (own.max[k] > cell.min[k] || cell.min[k] == root.min[k])
                && (own.min[k] < cell.max[k] || own.max[k] <= cell.max[k])
        };
        along(0) && along(1) && along(2) && prim.overlaps(cell)
    }
}

/// The way from the root to a node: for each inner node its number, whether the way goes above, and the end of the box
/// that its plane replaced.
#[derive(Debug, Default)]
struct Way {
    steps: heapless::Vec<(u32, bool, f32), { index(MAX_STACK) }>,
}

impl Way {
    /// Goes to a child. `None` if the way gets too long.
    fn down(&mut self, cell: &mut Cell, number: u32, cut: Cut, above: bool) -> Option<()> {
        let end = cell.end(cut.axis, above);
        self.steps.push((number, above, *end)).ok()?;
        *end = cut.plane;
        Some(())
    }
}

/// The partition in a blob.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The nodes; none if there is no primitive.
    pub nodes: &'a [Node],
    /// The slots that the leaves list.
    pub slots: &'a [u32],
    /// The root's box.
    bounds: &'a Aabb,
}

/// What [`View::pass`] tells of a node.
struct Visit<'v> {
    number: u32,
    node: Node,
    cell: &'v Cell,
    level: u32,
}

impl<'a> View<'a> {
    /// The sections, O(1): rule 10.
    ///
    /// # Errors
    /// The rule, if it is broken.
    pub fn parse(blob: &Blob<'a>) -> Result<Self, BlobError> {
        let (nodes, slots) = (blob.section(Section::BspNodes)?, blob.section(Section::CellLists)?);
        Ok(Self { nodes, slots, bounds: &blob.header().bounds })
    }

    /// Most steps of a walk: every node, and every reference.
    #[must_use]
    pub const fn steps(&self) -> u32 {
        count(self.nodes.len()).saturating_add(count(self.slots.len()))
    }

    /// The slots that a leaf lists; `None` if they are not in the section.
    #[inline(always)]
    fn list(&self, leaf: Node) -> Option<&'a [u32]> {
        self.slots.get(index(leaf.place)..index(leaf.place.saturating_add(leaf.number())))
    }

    /// Goes through the nodes depth first, child 0 first; below a node only if `each` says so.
    ///
    /// # Errors
    /// The first of `each`; or what `deep` makes of a node that is not there (level 0) or lies too deep.
    fn pass<E>(
        &self,
        mut each: impl FnMut(&Visit<'_>) -> Result<bool, E>,
        deep: impl Fn(u32, u32) -> E,
    ) -> Result<(), E> {
        let (mut way, mut cell) = (Way::default(), Cell::root(self.bounds));
        let mut number = 0;
        loop {
            let node = *self.nodes.get(index(number)).ok_or_else(|| deep(number, 0))?;
            let level = count(way.steps.len());
            let below = each(&Visit { number, node, cell: &cell, level })?;
            if let Some(cut) = node.cut().filter(|_| below) {
                way.down(&mut cell, number, cut, false).ok_or_else(|| deep(number, level))?;
                number = node.number();
                continue;
            }
            // Back to the last node whose child 1 is still to come.
            loop {
                let Some((parent, above, end)) = way.steps.pop() else { return Ok(()) };
                let node = self.nodes.get(index(parent)).ok_or_else(|| deep(parent, 0))?;
                let Some(cut) = node.cut() else { return Err(deep(parent, 0)) };
                *cell.end(cut.axis, above) = end;
                if !above {
                    way.down(&mut cell, parent, cut, true).ok_or_else(|| deep(parent, level))?;
                    number = node.number().saturating_add(1);
                    break;
                }
            }
        }
    }

    /// Calls `each` with every node, a node before what is below it.
    pub fn parts(&self, each: &mut impl FnMut(Part)) {
        // Nodes that were not checked may go round in circles: no more are told of than there are.
        let mut left = self.nodes.len();
        let told = self.pass(
            |visit| {
                left = left.checked_sub(1).ok_or(())?;
                let listed = visit.node.cut().is_none().then_some(visit.node.number());
                each(Part { bounds: visit.cell.bounds, level: visit.level, listed });
                Ok(true)
            },
            |_, _| (),
        );
        // What ended it early is for the check to say.
        let _ = told;
    }

    /// The box of a node, found from the root down.
    fn bounds_of(&self, target: u32) -> Aabb {
        let (mut cell, mut number) = (Cell::root(self.bounds), 0);
        for _ in 0..MAX_STACK {
            let Some(node) = self.nodes.get(index(number)).filter(|_| number != target) else { break };
            let (Some(cut), child) = (node.cut(), node.number()) else { break };
            // What is below child 1 stands behind what is below child 0.
            let second = self.nodes.get(index(child.saturating_add(1)));
            let from = second.filter(|n| n.cut().is_some()).map_or(u32::MAX, |n| n.number());
            let above = target == child.saturating_add(1) || target >= from;
            cell = cell.part(cut, above);
            number = child.saturating_add(u32::from(above));
        }
        cell.bounds
    }

    /// The full check: rules 20, 23, 26 to 28 and 45. Returns the deepest stack of any walk.
    ///
    /// # Errors
    /// The first rule that is broken, and where.
    #[inline(never)]
    pub fn check(&self, prims: &Prims<'_>) -> Result<u32, BlobError> {
        check::run(self, prims)
    }
}
