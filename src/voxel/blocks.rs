//! Two levels of bits: blocks of 4 by 4 by 4 voxels.
//!
//! Blocks are numbered as voxels are, and those at the far sides may be cut short. A block's voxel `(i, j, k)` from its
//! own corner is bit `16 i + 4 j + k` of its mask. The lists of voxels stand block by block, bit by bit, so the list of
//! a voxel is found by how many are before it: rank by counts and by counting bits (Jacobson, "Space-efficient Static
//! Trees and Graphs", FOCS 1989).
//!
//! A surface leaves about half of a block's octants of 2 by 2 by 2 voxels empty, so of a mask only the octants are
//! stored that have a voxel. With the digits of 16 and of 2 exchanged, a bit's number has those digits first that say
//! which octant it is in: `i div 2`, `k div 2`, `j div 2`, and then `j mod 2`, `i mod 2`, `k mod 2`. Byte `o` of the
//! mask is then octant `o`, and one exchange of bits restores it.
//!
//! Words: `voxel bits` has 3 for every 64 blocks: their bits, the lower 32 first, and how many are on before.
//! `voxel index` has, packed, the bytes that are not 0, block by block; and then 4 words for every *group* of 8 blocks
//! whose bit is on: how many voxels there are before, how many bytes there are before, and 8 bits for each block that
//! say which of its octants have a byte; of the last group, 0 for those that are no block's.
use super::Table;
use crate::blob::packed::Packed;
use crate::blob::{BlobError, Rule, Section};
use crate::geom::ray::Axis;
use crate::grid::Shape;
use crate::grid::walk::Number;
use crate::num::{count, index};
use crate::walk::Stop;
use crate::walk::dda::Cursor;

/// Words of 64 blocks' bits.
pub(super) const BIT_WORDS: u32 = 3;
/// Blocks of a group.
pub(super) const GROUP: u32 = 8;
/// Words of a group.
pub(super) const GROUP_WORDS: u32 = 4;
/// The most that an octant's byte can be.
pub(super) const OCTANT: u32 = 255;
/// What a bit's number grows by for a step along each axis.
pub(super) const STRIDES: [u32; 3] = [16, 4, 1];

/// Bits and masks.
#[derive(Clone, Copy, Debug)]
pub struct Blocks<'a> {
    bits: &'a [[u32; index(BIT_WORDS)]],
    octants: Packed<'a>,
    /// The octants, and what follows them: eight bytes can be read from where any of them is.
    bytes: &'a [u8],
    groups: &'a [[u32; index(GROUP_WORDS)]],
    shape: Shape,
}

/// A block that has a voxel.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    mask: u64,
    place: Place,
}

/// Where a block's octants are.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// How many voxels are before the group.
    voxels: u32,
    /// The first octant of the group.
    group: u32,
    /// The first octant of the block: of those in the group, 56 at most are before it.
    octant: u32,
    /// Which octants there are: the lower 8 bits.
    present: u64,
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

/// Exchanges the digits of 16 and of 2 in the number of every bit.
#[inline(always)]
pub(super) const fn exchange(mask: u64) -> u64 {
    const LOWER: u64 = 0x0000_cccc_0000_cccc;
    let changed = (mask >> 14 ^ mask) & LOWER;
    mask ^ changed ^ changed << 14
}

/// The mask whose octants follow each other from the least of `bytes`; those that are there are on in the lower 8 bits.
#[inline(always)]
const fn unpack(mut bytes: u64, present: u64) -> u64 {
    let (mut mask, mut octant) = (0, 0);
    while octant < 8 {
        if present >> octant & 1 == 1 {
            mask |= (bytes & 255) << (8 * octant);
            bytes >>= 8;
        }
        octant += 1;
    }
    exchange(mask)
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
    pub(super) fn new(grid: &Shape, table: &Table, bits: &'a [u32], index_words: &'a [u32]) -> Option<Self> {
        grid.len()?;
        let shape = shape(grid);
        let (octants, groups) = Packed::split(index_words, table.octants, OCTANT)?;
        let ((bits, []), (groups, [])) = (bits.as_chunks(), groups.as_chunks()) else { return None };
        let bits_fit = bits.len() == index(shape.len()?.div_ceil(64));
        let fit = bits_fit && groups.len() == index(table.blocks.div_ceil(GROUP));
        fit.then_some(Self { bits, octants, bytes: bytemuck::cast_slice(index_words), groups, shape })
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
        let &[low, high, before] = self.bits.get(index(number >> 6)).ok_or(Stop::Corrupt)?;
        let bits = u64::from(low) | u64::from(high) << 32;
        let bit = 1u64 << (number & 63);
        if bits & bit == 0 {
            return Ok(None);
        }
        let rank = before.wrapping_add((bits & (bit - 1)).count_ones());
        self.ranked(rank).map(Some).ok_or(Stop::Corrupt)
    }

    /// The block that has so many others with a voxel before it. Out of line, because a walk is made many times over.
    #[inline(never)]
    fn ranked(&self, rank: u32) -> Option<Block> {
        let place = self.place_of(rank)?;
        let bytes = self.eight(place.octant)?;
        Some(Block { mask: unpack(bytes, place.present), place })
    }

    #[inline(always)]
    fn place_of(&self, rank: u32) -> Option<Place> {
        let &[voxels, group, low, high] = self.groups.get(index(rank / GROUP))?;
        let present = u64::from(low) | u64::from(high) << 32;
        let shift = rank % GROUP * 8;
        let octant = group.wrapping_add((present & ((1 << shift) - 1)).count_ones());
        Some(Place { voxels, group, octant, present: present >> shift })
    }

    /// Eight bytes from an octant on, which may be more than there are: then the last are no octants.
    #[inline(always)]
    fn eight(&self, octant: u32) -> Option<u64> {
        self.bytes.get(index(octant)..)?.first_chunk().map(|bytes| u64::from_le_bytes(*bytes))
    }

    /// The number of the list of a block's first voxel that has one; `None` if its mask is not there.
    #[inline]
    #[must_use]
    pub fn first(&self, block: &Block) -> Option<u32> {
        let Place { mut voxels, group, octant, .. } = block.place;
        let mut left = octant.wrapping_sub(group);
        while left > 0 {
            let bytes = self.eight(octant.wrapping_sub(left))?;
            let counted = if left < 8 { bytes & ((1 << (left * 8)) - 1) } else { bytes };
            voxels = voxels.wrapping_add(counted.count_ones());
            left = left.saturating_sub(8);
        }
        Some(voxels)
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
        if !block.has(bit) {
            return None;
        }
        Some(Self::after(block, self.first(block)?, bit))
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
        for (group, &[low, high, before]) in (0..).zip(self.bits) {
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
            return broken(count(self.bits.as_flattened().len()), on, table.blocks);
        }
        self.check_masks(grid, table)
    }

    /// Rules 33 and 34. Bits and counts of blocks are right, so the ranks of blocks are 0, 1, 2 ..
    fn check_masks(&self, grid: &Shape, table: &Table) -> Result<(), BlobError> {
        let broken = |rank: u32, found, needed| {
            let at = count(self.bytes.len() / 4 - self.groups.as_flattened().len())
                .saturating_add(rank / GROUP * GROUP_WORDS);
            Err(BlobError::new(Rule::VoxelMasks, Section::VoxelIndex).at(at).found(found).needed(needed))
        };
        self.octants.check_end(Section::VoxelIndex)?;
        let (mut rank, mut voxels, mut octants) = (0u32, 0u32, 0u32);
        for number in 0..self.len() {
            if matches!(self.block(number), Ok(None)) {
                continue;
            }
            let Some(block) = self.ranked(rank) else { return broken(rank, octants, table.octants) };
            if block.place.voxels != voxels && rank.is_multiple_of(GROUP) {
                return broken(rank, block.place.voxels, voxels);
            }
            // In the group this follows from its count: the bits counted are those that are summed here.
            if block.place.octant != octants {
                return broken(rank, block.place.octant, octants);
            }
            if !self.is_true(&block, grid, number) {
                return broken(rank, block.mask.count_ones(), 1);
            }
            rank = rank.saturating_add(1);
            voxels = voxels.saturating_add(block.mask.count_ones());
            octants = octants.saturating_add((block.place.present & 255).count_ones());
        }
        for rank in table.blocks..table.blocks.next_multiple_of(GROUP) {
            if self.place_of(rank).is_none_or(|place| place.present & 255 != 0) {
                return broken(rank, 1, 0);
            }
        }
        if octants != table.octants {
            return broken(table.blocks, octants, table.octants);
        }
        if voxels == table.occupied { Ok(()) } else { broken(table.blocks, voxels, table.occupied) }
    }

    /// Whether a block has a voxel, and so has each of its octants, and none is outside of the grid.
    fn is_true(&self, block: &Block, grid: &Shape, number: u32) -> bool {
        let (first, _) = self.cells(grid, self.place(number));
        let outside = |bit: &u32| {
            let cell = Self::cell(first, *bit);
            (0..3).any(|k| cell[k] >= grid.cells[k])
        };
        let octants = (block.place.present & 255).count_ones();
        let last = block.place.octant.saturating_add(octants);
        let filled = self.octants.range(block.place.octant, last).filter(|&byte| byte != 0);
        let within = !(0..64).filter(outside).any(|bit| block.has(bit));
        block.mask != 0 && filled.count() == index(octants) && within
    }
}
