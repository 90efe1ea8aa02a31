//! Eight-wide bounding-volume hierarchy, or four-wide.
//!
//! A node holds the boxes of up to eight children, plane by plane, so that one instruction does the same step of the slab
//! test for all of them (Wald, Benthin and Boulos, "Getting Rid of Packets", RT 2008; Dammertz, Hanika and Keller,
//! "Shallow Bounding Volume Hierarchies for Fast SIMD Ray Tracing of Incoherent Rays", EGSR 2008). Triangles stand in
//! blocks of four, coordinate by coordinate, for the same reason.
//!
//! Choose it on a host or in a browser, where there is SIMD. It is the fastest structure there; without SIMD `bvh` is.
//! Nodes of four make a blob 4 to 8 % smaller. But half as many more are visited, and on x86-64 rays take 2 to 24 % longer
//! whatever the instructions, also those for four numbers: so eight is the default. One box after another, as on a
//! Cortex-M, four take 16 to 19 % fewer instructions.
//!
//! # A node: 256 bytes
//! | offset | size | field | meaning |
//! |---|---|---|---|
//! | 0 | 192 | `planes` | for each of min x, max x, min y, max y, min z, max z: the eight children's |
//! | 192 | 32 | `child` | for each child: number in the upper 28 bits, primitive count in the lower 4 |
//! | 224 | 32 | `reserved` | 0 |
//!
//! A node of four has half of everything: 128 bytes, its `child` at 96 and its `reserved` at 112.
//!
//! Children stand in the first lanes, at least two of them. A lane without a child has an empty box, from plus to
//! minus infinity, and the word 0. A count of 0 makes the number that of a node, else the child is a leaf. Where the blob
//! has `blocks`, the number of a leaf is that of its first block, and it has as many blocks as its triangles take; else
//! it is that of its first slot, as in `bvh`. Nodes stand in walk order, children in the order of lanes, from node 0. A
//! scene of up to 15 primitives may have no node: then all are one leaf.

#[cfg(feature = "build")]
pub mod build;
mod check;
mod group;
mod interval;
mod many;
mod packet;
mod query;
mod slabs;
mod stream;
mod team;
mod walk;

pub use many::SCRATCH as STREAM_SCRATCH;
pub(crate) use many::{Answer, Many, Purse, Uncounted};
pub(crate) use query::Query;

use crate::blob::prims::Prims;
use crate::blob::{Blob, BlobError, Rule, Section, block};
use crate::bvh::tree;
use crate::bvh::{Child, MAX_LEAF};
use crate::geom::Aabb;
use crate::num::{count, index};
use crate::walk::Part;
use crate::walk::lanes::Lanes;
use bytemuck::AnyBitPattern;

/// Most children of a node, and as many as one has that is not asked to be narrower.
pub const WIDTH: usize = 8;
/// Most entries of the stack that a walk may need.
pub const STACK: u32 = 192;

/// An inner node, as the module's table says.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, AnyBitPattern)]
pub struct Node<const W: usize = WIDTH> {
    /// Planes of the children's boxes, by [`Face`](crate::bvh::Face).
    pub planes: [[f32; W]; 6],
    /// The children.
    pub child: [Child; W],
    /// 0.
    pub reserved: [u32; W],
}

const _: () = assert!(size_of::<Node>() == 256 && size_of::<Node<4>>() == 128);

/// A node of a width that blobs may have.
pub trait Wide<const W: usize> {
    /// The section that holds such nodes.
    const SECTION: Section;
    /// The section that holds those of the other width.
    const OTHER: Section;
    /// A lane for each child, of those that an instruction set has.
    type Lanes<L8: Lanes<8>, L4: Lanes<4>>: Lanes<W>;
}

impl Wide<8> for Node<8> {
    const SECTION: Section = Section::WideNodes;
    const OTHER: Section = Section::Wide4Nodes;
    type Lanes<L8: Lanes<8>, L4: Lanes<4>> = L8;
}

impl Wide<4> for Node<4> {
    const SECTION: Section = Section::Wide4Nodes;
    const OTHER: Section = Section::WideNodes;
    type Lanes<L8: Lanes<8>, L4: Lanes<4>> = L4;
}

/// The lanes for the children of a node.
pub(crate) type In<const W: usize, L8, L4> = <Node<W> as Wide<W>>::Lanes<L8, L4>;

impl<const W: usize> Node<W> {
    /// No children.
    pub const EMPTY: Self = {
        let (min, max) = ([f32::INFINITY; W], [f32::NEG_INFINITY; W]);
        Self { planes: [min, max, min, max, min, max], child: [Child::NONE; W], reserved: [0; W] }
    };

    /// The box of a child.
    #[must_use]
    pub fn bounds(&self, lane: usize) -> Aabb {
        let lane = lane % W;
        let p = &self.planes;
        Aabb { min: [p[0][lane], p[2][lane], p[4][lane]], max: [p[1][lane], p[3][lane], p[5][lane]] }
    }

    /// Puts a child into a lane.
    #[cfg(feature = "build")]
    fn set(&mut self, lane: usize, child: Child, b: &Aabb) {
        let lane = lane % W;
        for (row, plane) in self.planes.iter_mut().zip([b.min[0], b.max[0], b.min[1], b.max[1], b.min[2], b.max[2]]) {
            row[lane] = plane;
        }
        self.child[lane] = child;
    }

    /// As it stands in a blob.
    #[cfg(feature = "build")]
    #[must_use]
    pub fn words(&self) -> [[u32; W]; 8] {
        let mut words = [[0; W]; 8];
        for (row, planes) in words.iter_mut().zip(&self.planes) {
            for (word, plane) in row.iter_mut().zip(planes) {
                *word = plane.to_bits();
            }
        }
        words[6] = bytemuck::cast(self.child);
        words[7] = self.reserved;
        words
    }

    /// The lanes with a child, one bit each.
    #[inline(always)]
    fn present(&self) -> u32 {
        self.child.iter().enumerate().fold(0, |all, (lane, &child)| all | u32::from(child != Child::NONE) << lane)
    }

    /// Number of children.
    #[must_use]
    pub fn len(&self) -> usize {
        self.child.iter().take_while(|&&child| child != Child::NONE).count()
    }

    /// Whether there is no child.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The hierarchy in a blob.
#[derive(Clone, Copy, Debug)]
pub struct View<'a, const W: usize = WIDTH> {
    /// The inner nodes.
    pub nodes: &'a [Node<W>],
}

/// Whether a blob's nodes have four children.
#[must_use]
pub fn has_four(blob: &Blob<'_>) -> bool {
    blob.entries().iter().any(|entry| entry.section == Section::Wide4Nodes.number())
}

impl<'a, const W: usize> View<'a, W>
where
    Node<W>: Wide<W>,
{
    /// The section of nodes, O(1): rules 10 and 61.
    ///
    /// # Errors
    /// The rule, if it is broken: also where the nodes have another width.
    pub fn parse(blob: &Blob<'a>) -> Result<Self, BlobError> {
        let other = <Node<W> as Wide<W>>::OTHER;
        if blob.entries().iter().any(|entry| entry.section == other.number()) {
            return Err(BlobError::new(Rule::WideWidth, other));
        }
        Ok(Self { nodes: blob.section(<Node<W> as Wide<W>>::SECTION)? })
    }

    /// Most steps of a walk: every node, and every primitive.
    #[must_use]
    pub const fn steps(&self, prims: &Prims<'_>) -> u32 {
        count(self.nodes.len()).saturating_add(prims.len)
    }

    /// Calls `each` with every inner node and every leaf, a node before what is below it.
    pub fn parts(&self, prims: &Prims<'_>, bounds: &Aabb, each: &mut impl FnMut(Part)) {
        // Nodes that were not checked may go round in circles: no more are opened than there are.
        let mut left = self.nodes.len();
        let mut todo = heapless::Vec::<(Child, Aabb, u32), { index(STACK) + WIDTH }>::new();
        let mut next = (prims.len > 0).then_some((tree::root(self.nodes, prims.len), *bounds, 0));
        while let Some((child, bounds, level)) = next.take().or_else(|| todo.pop()) {
            each(Part { bounds, level, listed: (!child.is_node()).then_some(child.len()) });
            let Some(node) = self.nodes.get(index(child.number())).filter(|_| child.is_node()) else { continue };
            let Some(fewer) = left.checked_sub(1) else { return };
            left = fewer;
            for lane in (0..node.len()).rev() {
                // As long as any walk's stack may be.
                let _ = todo.push((node.child[lane % W], node.bounds(lane), level.saturating_add(1)));
            }
        }
    }
}

/// A leaf's first slot, and the block or slot after it.
#[inline(always)]
const fn slots(prims: &Prims<'_>, leaf: Child) -> (u32, u32) {
    if prims.blocks.is_empty() {
        return (leaf.number(), leaf.number().saturating_add(leaf.len()));
    }
    (leaf.number().saturating_mul(block::LANES), leaf.number().saturating_add(leaf.len().div_ceil(block::LANES)))
}

const _: () = assert!(MAX_LEAF == 15);
