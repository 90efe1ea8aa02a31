//! Two levels of bits: blocks of 4 by 4 by 4 voxels.
//!
//! Blocks are numbered as voxels are, and those at the far sides may be cut short. A block's voxel `(i, j, k)` from its
//! own corner is bit `16 i + 4 j + k` of its mask. The lists of voxels stand block by block, bit by bit, so the list of a
//! voxel is found by how many are before it: rank by counts and by counting bits (Jacobson, "Space-efficient Static
//! Trees and Graphs", FOCS 1989).
//!
//! Words: `voxel bits` has 3 for every 64 blocks: their bits, the lower 32 first, and how many are on before.
//! `voxel index` has 17 for every 8 blocks whose bit is on: how many voxels there are before, and the 8 masks, lower
//! words first; the last group is filled up with masks of 0.
use super::{Table, word};
use crate::blob::{BlobError, Rule, Section};
use crate::geom::ray::Axis;
use crate::grid::Shape;
use crate::grid::walk::Number;
use crate::num::{count, index};
use crate::walk::Stop;
use crate::walk::dda::Cursor;

/// Words of 64 blocks' bits.
pub(super) const BIT_WORDS: u32 = 3;
/// Masks of a group.
pub(super) const GROUP: u32 = 8;
/// Words of a group.
pub(super) const GROUP_WORDS: u32 = 2 * GROUP + 1;
/// What a bit's number grows by for a step along each axis.
pub(super) const STRIDES: [u32; 3] = [16, 4, 1];

/// Bits and masks.
#[derive(Clone, Copy, Debug)]
pub struct Blocks<'a> {
    bits: &'a [u32],
    masks: &'a [u32],
    shape: Shape,
}

/// A block that has a voxel.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    mask: u64,
    /// How many such blocks are before it.
    rank: u32,
}

impl Block {
    /// Whether a voxel lists anything.
    #[inline(always)]
    #[must_use]
    pub const fn has(&self, bit: u32) -> bool {
        self.mask >> (bit & 63) & 1 == 1
    }

    /// How many voxels of the block that list something are before one.
    #[inline(always)]
    const fn before(&self, bit: u32) -> u32 {
        (self.mask & ((1 << (bit & 63)) - 1)).count_ones()
    }
}

/// The grid of blocks over a grid; its far sides may lie beyond the grid's.
#[must_use]
pub(super) fn shape(shape: &Shape) -> Shape {
    Shape { lattice: shape.lattice.blocks(), cells: shape.cells.map(|n| n.div_ceil(4)), reserved: 0 }
}

/// The block that a walk is in.
#[derive(Clone, Copy, Debug)]
pub(super) struct At {
    pub(super) place: [u32; 3],
    pub(super) number: Number,
}

impl Cursor for At {
    fn put(&mut self, cell: [u32; 3]) {
        self.place = cell;
        self.number.put(cell);
    }

    #[inline(always)]
    fn step(&mut self, axis: Axis, down: bool) {
        let place = &mut self.place[axis.at()];
        *place = if down { place.wrapping_sub(1) } else { place.wrapping_add(1) };
        self.number.step(axis, down);
    }
}

impl<'a> Blocks<'a> {
    /// `None` if the sections do not hold what the table says.
    pub(super) fn new(grid: &Shape, table: &Table, bits: &'a [u32], masks: &'a [u32]) -> Option<Self> {
        grid.len()?;
        let shape = shape(grid);
        let fits = |words: &[u32], groups: u32, size: u32| groups.checked_mul(size).map(index) == Some(words.len());
        let bits_fit = fits(bits, shape.len()?.div_ceil(64), BIT_WORDS);
        let fit = bits_fit && fits(masks, table.blocks.div_ceil(GROUP), GROUP_WORDS);
        fit.then_some(Self { bits, masks, shape })
    }

    /// Planes and number of the blocks.
    #[must_use]
    pub const fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Number of blocks.
    #[must_use]
    pub fn len(&self) -> u32 {
        self.shape.len().unwrap_or(0)
    }

    /// Whether there is no block.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The place of a block, by its number.
    #[must_use]
    pub fn place(&self, block: u32) -> [u32; 3] {
        self.shape.place(block)
    }

    /// The voxels `first..last` of a block.
    #[inline(always)]
    #[must_use]
    pub fn cells(&self, grid: &Shape, place: [u32; 3]) -> ([u32; 3], [u32; 3]) {
        let first = place.map(|i| i.wrapping_mul(4));
        let last = |k: usize| first[k].wrapping_add(4).min(grid.cells[k]);
        (first, [last(0), last(1), last(2)])
    }

    /// The place of a voxel by its bit, in the block whose first voxel is `first`.
    #[inline(always)]
    #[must_use]
    pub const fn cell(first: [u32; 3], bit: u32) -> [u32; 3] {
        [first[0].wrapping_add(bit >> 4 & 3), first[1].wrapping_add(bit >> 2 & 3), first[2].wrapping_add(bit & 3)]
    }

    /// A block if it has a voxel.
    ///
    /// # Errors
    /// [`Stop::Corrupt`] if there is no such block, or no mask for it.
    #[inline(always)]
    pub fn block(&self, number: u32) -> Result<Option<Block>, Stop> {
        let at = index((number >> 6).wrapping_mul(BIT_WORDS));
        let &[low, high, before] = self.bits.get(at..).and_then(<[u32]>::first_chunk).ok_or(Stop::Corrupt)?;
        let bits = u64::from(low) | u64::from(high) << 32;
        let bit = 1u64 << (number & 63);
        if bits & bit == 0 {
            return Ok(None);
        }
        let rank = before.wrapping_add((bits & (bit - 1)).count_ones());
        let mask = self.mask(rank).ok_or(Stop::Corrupt)?;
        Ok(Some(Block { mask, rank }))
    }

    #[inline(always)]
    fn mask(&self, rank: u32) -> Option<u64> {
        let at = (rank / GROUP).wrapping_mul(GROUP_WORDS).wrapping_add(1 + 2 * (rank % GROUP));
        let &[low, high] = self.masks.get(index(at)..)?.first_chunk()?;
        Some(u64::from(low) | u64::from(high) << 32)
    }

    /// The number of the list of a block's first voxel that has one; `None` if its mask is not there.
    #[inline]
    #[must_use]
    pub fn first(&self, block: &Block) -> Option<u32> {
        let group = index((block.rank / GROUP).wrapping_mul(GROUP_WORDS));
        let (before, masks) = self.masks.get(group..)?.split_first()?;
        let masks = masks.get(..index(2 * (block.rank % GROUP)))?;
        Some(masks.iter().fold(*before, |sum, word| sum.wrapping_add(word.count_ones())))
    }

    /// The number of the list of a voxel, in a block whose first list has the number `first`.
    #[inline(always)]
    #[must_use]
    pub const fn after(block: &Block, first: u32, bit: u32) -> u32 {
        first.wrapping_add(block.before(bit))
    }

    /// The number of the list of a voxel of a block.
    #[must_use]
    pub fn entry(&self, block: &Block, bit: u32) -> Option<u32> {
        let first = self.first(block)?;
        block.has(bit).then_some(Self::after(block, first, bit))
    }

    /// The number of the list of a voxel, by its place.
    #[must_use]
    pub fn entry_at(&self, cell: [u32; 3]) -> Option<u32> {
        let [sx, sy, sz] = self.shape.strides();
        let [x, y, z] = cell.map(|i| i / 4);
        let number = x.wrapping_mul(sx).wrapping_add(y.wrapping_mul(sy)).wrapping_add(z.wrapping_mul(sz));
        let [i, j, k] = cell.map(|i| i % 4);
        self.entry(&self.block(number).ok()??, i * STRIDES[0] + j * STRIDES[1] + k)
    }

    /// Rules 31 and 33.
    pub(super) fn check(&self, grid: &Shape, table: &Table) -> Result<(), BlobError> {
        let broken = |at, found, needed| {
            Err(BlobError::new(Rule::VoxelBits, Section::VoxelBits).at(at).found(found).needed(needed))
        };
        let mut on = 0u32;
        for group in 0..self.len().div_ceil(64) {
            let [low, high, before] = [0, 1, 2].map(|i| word(self.bits, group * BIT_WORDS + i));
            if before != on {
                return broken(group * BIT_WORDS + 2, before, on);
            }
            let bits = u64::from(low) | u64::from(high) << 32;
            let left = self.len() - group * 64;
            if left < 64 && bits >> left != 0 {
                return broken(group * BIT_WORDS, high, 0);
            }
            on = on.saturating_add(bits.count_ones());
        }
        if on != table.blocks {
            return broken(count(self.bits.len()), on, table.blocks);
        }
        self.check_masks(grid, table)
    }

    /// Rule 33. Bits and counts of blocks are right, so blocks come with ascending ranks.
    fn check_masks(&self, grid: &Shape, table: &Table) -> Result<(), BlobError> {
        let broken = |rank: u32, found, needed| {
            let at = rank / GROUP * GROUP_WORDS;
            Err(BlobError::new(Rule::VoxelMasks, Section::VoxelIndex).at(at).found(found).needed(needed))
        };
        let mut voxels = 0u32;
        for number in 0..self.len() {
            let Ok(Some(block)) = self.block(number) else { continue };
            let before = word(self.masks, block.rank / GROUP * GROUP_WORDS);
            if block.rank.is_multiple_of(GROUP) && before != voxels {
                return broken(block.rank, before, voxels);
            }
            let (first, _) = self.cells(grid, self.place(number));
            let outside = |bit: &u32| {
                let cell = Self::cell(first, *bit);
                (0..3).any(|k| cell[k] >= grid.cells[k])
            };
            if block.mask == 0 || (0..64).filter(outside).any(|bit| block.has(bit)) {
                return broken(block.rank, block.mask.count_ones(), 1);
            }
            voxels = voxels.saturating_add(block.mask.count_ones());
        }
        for rank in table.blocks..table.blocks.next_multiple_of(GROUP) {
            if self.mask(rank) != Some(0) {
                return broken(rank, 1, 0);
            }
        }
        if voxels == table.occupied { Ok(()) } else { broken(table.blocks, voxels, table.occupied) }
    }
}
