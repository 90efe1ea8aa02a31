//! Sparse voxels: the lecture's core.
//!
//! The cells of [`crate::grid`], with the same planes and numbers, but only those that list something are stored: at a
//! resolution where most cells are empty, which is where a ray meets few primitives that it does not hit. One bit says
//! whether a cell, here *voxel*, lists anything, and nothing else is read where it is off (Cleary and Wyvill, The
//! Visual Computer 4, 1988; the lecture "Ray Tracing with Spatial Hierarchies"). Where it is on, its list is found in
//! one of two ways:
//!
//! - [`Flat`]: one bit for each voxel, and a hash table whose slot is the voxel's number modulo its size.
//! - [`Blocks`]: one bit for each block of 4 by 4 by 4 voxels; for each block that has one on, one bit for each octant;
//!   for each octant that has one on, 8 bits; and counts of bits before. A ray crosses an empty block in one step.
//!
//! All numbers are packed ([`crate::blob::packed`]). Choose it where the grid is right and memory is scarce. It does
//! not adapt more than the grid does, and needs no stack.
//!
//! # Table: 24 bytes
//! | offset | size | field | meaning |
//! |---|---|---|---|
//! | 0 | 4 | `form` | 1 flat, 2 blocks |
//! | 4 | 4 | `modulus` | size of the hash table, below 2^31; 0 for blocks |
//! | 8 | 4 | `occupied` | number of voxels whose bit is on |
//! | 12 | 4 | `listed` | number of slots listed |
//! | 16 | 4 | `blocks` | number of blocks with such a voxel; 0 for flat |
//! | 20 | 4 | `octants` | number of octants of blocks with such a voxel; 0 for flat |

mod blocks;
#[cfg(feature = "build")]
pub mod build;
#[cfg(feature = "build")]
mod fill;
mod flat;
mod walk;

pub use blocks::{Block, Blocks};
pub use flat::{Flat, Hashed};

use crate::blob::lists::complete;
use crate::blob::packed::{Packed, PackedLists};
use crate::blob::prims::Prims;
use crate::blob::{Blob, BlobError, Rule, Section};
use crate::geom::Aabb;
use crate::grid::Shape;
use crate::num::{count, index};
use crate::walk::Part;
use bytemuck::{Pod, Zeroable};

/// The sections of a blob of sparse voxels.
pub const SECTIONS: &[Section] = &[
    Section::GridShape,
    Section::VoxelTable,
    Section::VoxelBits,
    Section::VoxelIndex,
    Section::VoxelStarts,
    Section::VoxelLists,
];

/// [`Table::form`] of [`Flat`].
pub const FLAT: u32 = 1;
/// [`Table::form`] of [`Blocks`].
pub const BLOCKS: u32 = 2;

/// The form and the counts, as the module's table says.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Table {
    /// [`FLAT`] or [`BLOCKS`].
    pub form: u32,
    /// Size of the hash table.
    pub modulus: u32,
    /// Voxels whose bit is on.
    pub occupied: u32,
    /// Slots listed.
    pub listed: u32,
    /// Blocks with such a voxel.
    pub blocks: u32,
    /// Octants of blocks with such a voxel.
    pub octants: u32,
}

const _: () = assert!(size_of::<Table>() == 24);

/// How a voxel's list is found.
#[derive(Clone, Copy, Debug)]
pub enum Form<'a> {
    /// By hashing.
    Flat(Flat<'a>),
    /// By counting.
    Blocks(Blocks<'a>),
}

/// Everything that a scene of one primitive or more has.
#[derive(Clone, Copy, Debug)]
pub struct Voxels<'a> {
    /// Planes and cells.
    pub shape: &'a Shape,
    /// Counts.
    pub table: &'a Table,
    /// Which voxels have a list.
    pub form: Form<'a>,
    /// The lists of those voxels, in the form's order.
    pub lists: PackedLists<'a>,
}

/// The sparse voxels in a blob; none if the scene has no primitive.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// What there is.
    pub voxels: Option<Voxels<'a>>,
}

impl<'a> View<'a> {
    /// The sections, O(1): rules 10, 25 and 30.
    ///
    /// # Errors
    /// The first rule that is broken.
    pub fn parse(blob: &Blob<'a>) -> Result<Self, BlobError> {
        let shape = Shape::parse(blob, &blob.header().bounds)?;
        let tables: &[Table] = blob.section(Section::VoxelTable)?;
        let sections = [Section::VoxelBits, Section::VoxelIndex, Section::VoxelStarts, Section::VoxelLists];
        let mut words: [&[u32]; 4] = [&[]; 4];
        for (words, section) in words.iter_mut().zip(sections) {
            *words = blob.section(section)?;
        }
        let broken = BlobError::new(Rule::VoxelTable, Section::VoxelTable);
        match (shape, tables) {
            (None, []) if blob.header().prims == 0 && words.iter().all(|w| w.is_empty()) => Ok(Self { voxels: None }),
            (Some(shape), [table]) => {
                let voxels = Voxels::new(shape, table, words, blob.header().prims).ok_or(broken)?;
                Ok(Self { voxels: Some(voxels) })
            }
            _ => Err(broken.found(count(tables.len())).needed(count(usize::from(shape.is_some())))),
        }
    }

    /// Most steps of a walk: every voxel, or every block and every voxel of those that have one on, and every
    /// reference.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.voxels.map_or(0, |v| steps(v.shape, v.table))
    }

    /// Calls `each` with every voxel and block, but for the empty voxels of blocks.
    pub fn parts(&self, each: &mut impl FnMut(Part)) {
        let Some(Voxels { shape, form, lists, .. }) = self.voxels else { return };
        let listed = |entry: u32| lists.place(entry).map(|(first, last)| last.wrapping_sub(first));
        match form {
            Form::Flat(flat) => {
                for number in 0..shape.len().unwrap_or(0) {
                    let entry = flat.entry(number);
                    let listed = Some(entry.and_then(listed).unwrap_or(0));
                    each(Part { bounds: shape.bounds(shape.place(number)), level: 1, listed });
                }
            }
            Form::Blocks(blocks) => {
                for number in 0..blocks.len() {
                    let (first, last) = blocks.cells(shape, blocks.place(number));
                    let bounds = shape.lattice.bounds(first, last);
                    let Ok(Some(block)) = blocks.block(number) else {
                        each(Part { bounds, level: 1, listed: Some(0) });
                        continue;
                    };
                    each(Part { bounds, level: 1, listed: None });
                    for bit in (0..64).filter(|&bit| block.has(bit)) {
                        let bounds = shape.bounds(Blocks::cell(first, bit));
                        each(Part { bounds, level: 2, listed: blocks.entry(&block, bit).and_then(listed) });
                    }
                }
            }
        }
    }

    /// The full check: rules 26 to 28 and 31 to 34. A walk needs no stack.
    ///
    /// # Errors
    /// The first rule that is broken, and where.
    pub fn check(&self, prims: &Prims<'_>) -> Result<u32, BlobError> {
        let Some(voxels) = self.voxels else { return Ok(0) };
        match &voxels.form {
            Form::Flat(flat) => flat.check(voxels.shape, voxels.table)?,
            Form::Blocks(blocks) => blocks.check(voxels.shape, voxels.table)?,
        }
        voxels.lists.check(prims.len, (Section::VoxelStarts, Section::VoxelLists))?;
        for slot in 0..prims.len {
            if let Some(p) = prims.get(slot) {
                let each = |cell, number, bounds: &Aabb| voxels.check_listed((cell, number), bounds, slot, prims);
                voxels.shape.touched(&p, &p.bounds(), each)?;
            }
        }
        Ok(0)
    }
}

impl<'a> Voxels<'a> {
    /// `None` if the sections do not hold what the table says.
    fn new(shape: &'a Shape, table: &'a Table, words: [&'a [u32]; 4], prims: u32) -> Option<Self> {
        let [bits, index, starts, slots] = words;
        let form = match table.form {
            FLAT if (table.blocks, table.octants) == (0, 0) => Form::Flat(Flat::new(shape, table, bits, index)?),
            BLOCKS if table.modulus == 0 => Form::Blocks(Blocks::new(shape, table, bits, index)?),
            _ => return None,
        };
        let starts = Packed::whole(starts, table.occupied.checked_add(1)?, table.listed)?;
        let slots = Packed::whole(slots, table.listed, prims.saturating_sub(1))?;
        Some(Self { shape, table, form, lists: PackedLists { starts, slots } })
    }

    /// Rule 28 for one voxel, by place and number.
    fn check_listed(
        &self,
        (cell, number): ([u32; 3], u32),
        bounds: &Aabb,
        slot: u32,
        prims: &Prims<'_>,
    ) -> Result<(), BlobError> {
        let entry = match &self.form {
            Form::Flat(flat) => flat.entry(number),
            Form::Blocks(blocks) => blocks.entry_at(cell),
        };
        let list = entry.and_then(|entry| self.lists.place(entry));
        let found = list.is_some_and(|list| self.lists.slots.find(list, slot).is_some());
        complete(found, bounds, slot, prims, || BlobError::new(Rule::ListComplete, Section::VoxelBits).at(number))
    }
}

/// Most steps of a walk.
fn steps(shape: &Shape, table: &Table) -> u32 {
    let voxels = if table.form == FLAT {
        shape.len()
    } else {
        blocks::shape(shape).len().map(|n| n.saturating_add(table.blocks.saturating_mul(64)))
    };
    voxels.unwrap_or(u32::MAX).saturating_add(table.listed)
}

/// Word `i` of `words`, 0 if there is none.
fn word(words: &[u32], i: u32) -> u32 {
    words.get(index(i)).copied().unwrap_or(0)
}
