//! Binary bounding-volume hierarchy.
//!
//! A node holds the boxes of both its children (Rubin and Whitted, "A 3-Dimensional Representation for Fast Rendering
//! of Complex Scenes", SIGGRAPH 1980; two boxes a node as in Wald, Boulos and Shirley, ACM TOG 26(1), 2007), so a visit
//! reads one cache line and decides about two. Primitives stand in at most one leaf: no test is done twice.
//!
//! Choose it when in doubt. It costs 64 bytes a node, about 15 bytes a triangle beside the triangles' own 40, and
//! at most [`MAX_STACK`](crate::blob::MAX_STACK) stack entries of 8 bytes.
//!
//! # A node: 64 bytes
//! | offset | size | field | meaning |
//! |---|---|---|---|
//! | 0 | 48 | `planes` | for each of min x, max x, min y, max y, min z, max z: child 0's, child 1's |
//! | 48 | 8 | `child` | for child 0, child 1: number in the upper 28 bits, primitive count in the lower 4 |
//! | 56 | 8 | `reserved` | 0 |
//!
//! A count of 0 makes the number that of a node. A count from 1 to 15 makes the child a leaf, and the number its first
//! slot: `0x0000_1203` is the leaf of slots 0x120, 0x121 and 0x122; `0x0000_1200` is node 0x120. Nodes stand in walk
//! order, child 0 first, from node 0. A scene of up to 15 primitives may have no node: then all are one leaf.

#[cfg(feature = "build")]
pub mod build;
pub(crate) mod group;
pub(crate) mod tree;
pub(crate) mod walk;

pub use walk::walk;

use crate::blob::prims::Prims;
use crate::blob::{Blob, BlobError, Rule, Section};
use crate::geom::Aabb;
use crate::num::{count, index};
use crate::walk::Part;
use bytemuck::{Pod, Zeroable};
use tree::{Branch, Proof, Step};

/// Most primitives of a leaf.
pub const MAX_LEAF: u32 = 15;
/// Bits of a child's word that hold the primitive count.
const COUNT_BITS: u32 = 4;

/// A plane of a box, as a row of [`Node::planes`]. An enum, so that `planes[face.at()]` needs no bounds check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
#[allow(missing_docs)]
pub enum Face {
    MinX,
    MaxX,
    MinY,
    MaxY,
    MinZ,
    MaxZ,
}

impl Face {
    /// Its row.
    #[inline(always)]
    #[allow(clippy::as_conversions)] // an enum's own number
    pub(crate) const fn at(self) -> usize {
        self as usize
    }
}

/// A child: an inner node or a leaf.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Child(u32);

#[allow(clippy::len_without_is_empty)] // of an inner node one asks whether it is one
impl Child {
    /// No child: the word of node 0, which is nobody's child.
    pub(crate) const NONE: Self = Self(0);

    /// An inner node.
    #[must_use]
    pub const fn node(number: u32) -> Self {
        Self(number << COUNT_BITS)
    }

    /// A leaf of `len` slots, from 1 to [`MAX_LEAF`], from `first`.
    #[must_use]
    pub const fn leaf(first: u32, len: u32) -> Self {
        Self(first << COUNT_BITS | len)
    }

    /// Number of primitives; 0 for an inner node.
    #[inline(always)]
    #[must_use]
    pub const fn len(self) -> u32 {
        self.0 & MAX_LEAF
    }

    /// Whether this is an inner node.
    #[inline(always)]
    #[must_use]
    pub const fn is_node(self) -> bool {
        self.len() == 0
    }

    /// The node's number or the leaf's first slot.
    #[inline(always)]
    #[must_use]
    pub const fn number(self) -> u32 {
        self.0 >> COUNT_BITS
    }
}

/// An inner node, as the module's table says.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Node {
    /// Planes of the two children's boxes, by [`Face`].
    pub planes: [[f32; 2]; 6],
    /// The children.
    pub child: [Child; 2],
    /// 0.
    pub reserved: [u32; 2],
}

const _: () = assert!(size_of::<Node>() == 64);

impl Node {
    /// A node over two boxes, its children still to come.
    #[must_use]
    pub const fn new(a: &Aabb, b: &Aabb) -> Self {
        let planes = [
            [a.min[0], b.min[0]],
            [a.max[0], b.max[0]],
            [a.min[1], b.min[1]],
            [a.max[1], b.max[1]],
            [a.min[2], b.min[2]],
            [a.max[2], b.max[2]],
        ];
        Self { planes, child: [Child::NONE; 2], reserved: [0; 2] }
    }

    /// Gives child 0 or 1 another box.
    #[cfg(feature = "build")]
    fn set_bounds(&mut self, side: usize, b: &Aabb) {
        let side = side & 1;
        let planes = [b.min[0], b.max[0], b.min[1], b.max[1], b.min[2], b.max[2]];
        for (row, plane) in self.planes.iter_mut().zip(planes) {
            row[side] = plane;
        }
    }

    /// The box of child 0 or 1.
    #[must_use]
    pub fn bounds(&self, side: usize) -> Aabb {
        let side = side & 1;
        let p = &self.planes;
        Aabb { min: [p[0][side], p[2][side], p[4][side]], max: [p[1][side], p[3][side], p[5][side]] }
    }
}

impl Branch for Node {
    const SECTION: Section = Section::BvhNodes;

    #[inline(always)]
    fn children(&self) -> [Child; 2] {
        self.child
    }

    fn bounds(&self, side: usize) -> Aabb {
        Self::bounds(self, side)
    }
}

/// The hierarchy in a blob.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The inner nodes.
    pub nodes: &'a [Node],
}

impl<'a> View<'a> {
    /// The section of nodes, O(1): rule 10.
    ///
    /// # Errors
    /// The rule, if it is broken.
    pub fn parse(blob: &Blob<'a>) -> Result<Self, BlobError> {
        Ok(Self { nodes: blob.section(Section::BvhNodes)? })
    }

    /// Most steps of a walk: every node, and every primitive.
    #[must_use]
    pub const fn steps(&self, prims: &Prims<'_>) -> u32 {
        count(self.nodes.len()).saturating_add(prims.len)
    }

    /// Calls `each` with every inner node and every leaf, a node before what is below it.
    pub fn parts(&self, prims: &Prims<'_>, bounds: &Aabb, each: &mut impl FnMut(Part)) {
        tree::parts(self.nodes, prims.len, bounds, each);
    }

    /// The full check, O(n), with a stack of its own as deep as the walk's: rules 7 and 20 to 23.
    ///
    /// Returns the deepest stack of any walk.
    ///
    /// # Errors
    /// The first rule that is broken, and where.
    pub fn check(&self, prims: &Prims<'_>, bounds: &Aabb) -> Result<u32, BlobError> {
        tree::check(self.nodes, prims.len, &Boxes { nodes: self.nodes, prims, bounds })
    }
}

/// Rule 22: each box lies inside the one above it and contains what is below it.
struct Boxes<'c, 'a> {
    nodes: &'a [Node],
    prims: &'c Prims<'a>,
    /// Around the root.
    bounds: &'c Aabb,
}

impl Boxes<'_, '_> {
    /// The box of a place, by the way to it.
    fn bounds(&self, way: &[Step]) -> Aabb {
        let Some(last) = way.last() else { return *self.bounds };
        self.nodes.get(index(last.node)).map_or(Aabb::EMPTY, |node| node.bounds(last.side))
    }
}

impl Proof for Boxes<'_, '_> {
    /// The two boxes are boxes and lie inside the node's own; its reserved words are 0.
    fn node(&self, number: u32, way: &[Step]) -> Result<(), BlobError> {
        let node = self.nodes.get(index(number)).ok_or(tree::broken::<Node>(Rule::NodeOrder, number))?;
        let bounds = self.bounds(way);
        let inside = |b: Aabb| b.is_valid() && bounds.contains(&b);
        match node {
            n if !inside(n.bounds(0)) || !inside(n.bounds(1)) => Err(tree::broken::<Node>(Rule::NodeBounds, number)),
            n if n.reserved != [0; 2] => Err(tree::broken::<Node>(Rule::Reserved, number)),
            _ => Ok(()),
        }
    }

    fn leaf(&self, (first, len): (u32, u32), way: &[Step]) -> Result<(), BlobError> {
        if self.bounds(way).contains(&self.prims.bounds(first, len)) {
            return Ok(());
        }
        Err(tree::broken::<Node>(Rule::NodeBounds, way.last().map_or(0, |step| step.node)))
    }
}
