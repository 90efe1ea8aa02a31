//! The builder: a resolution, a count, one sort, a fill.
//!
//! The resolution is chosen as for a grid ([`crate::grid::build`]), but finer ones are affordable. Each reference
//! becomes a pair of voxel and primitive; sorted, they are the lists, and say how many voxels and blocks there are. So
//! memory goes with the references and, for the flat form, a bit a voxel, and never with a word for each voxel.
//!
//! `Rule::Seed` builds the flat form with one voxel a primitive, as the lecture has it. `Rule::Sah` builds the form
//! that is smaller. The hash table has a slot for each occupied voxel; its size has no divisor in common with the
//! numbers of cells, so that neighbours along any axis do not share a slot.
use super::blocks::{BIT_WORDS, GROUP, GROUP_WORDS, OCTANT, STRIDES, exchange};
use super::fill::{fill_blocks, fill_flat, fill_lists, masks};
use super::flat::{MOST, most_tag};
use super::{BLOCKS, FLAT, Table};
use crate::blob::Section;
use crate::blob::packed::{pack, width, words};
use crate::build::parts::{Parts, number_slots};
use crate::build::{BuildError, Config, Input, Ref, Rule};
use crate::grid::Shape;
use crate::grid::build::{Choice, Plan as Grid, SHAPE_WORDS};
use crate::num::{count, index};

/// What a resolution is chosen by: empty voxels cost no memory worth the name, and little time.
const SAH: Choice = Choice { densities: &[1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0], step: 0.9, cells: u32::MAX };
const SEED: Choice = Choice { cells: MOST, ..Choice::SEED };
/// Words of shape and table.
const HEAD: usize = SHAPE_WORDS + size_of::<Table>() / 4;
/// How much larger than it need be a hash table may become.
const SEARCHED: u32 = 64;

/// Voxels that are decided on but not made.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    grid: Grid,
    /// Whether the flat form may be the answer, and the other.
    flat: bool,
    blocks: bool,
}

impl Plan {
    /// Chooses the resolution and counts.
    ///
    /// # Errors
    /// [`BuildError::TooLarge`] if there are 2^32 voxels or more, with [`Rule::Seed`] 2^31, or 2^28 references.
    pub fn new(input: &Input<'_>, config: &Config) -> Result<Self, BuildError> {
        let seed = config.rule == Rule::Seed;
        let grid = Grid::with(input, config, if seed { &SEED } else { &SAH })?;
        let most = grid.listed.min(grid.cells);
        // A bit a voxel may be more than blocks can be at worst.
        let flat = seed || (grid.cells <= MOST && grid.cells.div_ceil(32) < most_block_words(&grid.shape, most));
        Ok(Self { grid, flat, blocks: !seed })
    }

    /// Most voxels that list anything.
    fn most(&self) -> u32 {
        self.grid.listed.min(self.grid.cells)
    }

    /// Words of [`crate::build::Arena::cells`].
    #[must_use]
    pub fn words(&self) -> usize {
        if self.grid.cells == 0 {
            return 0;
        }
        let most = self.most();
        let flat = if self.flat { self.grid.cells.div_ceil(32) + 2 * most + SEARCHED + 4 } else { 0 };
        let blocks = if self.blocks { most_block_words(&self.grid.shape, most) } else { 0 };
        HEAD + self.scratch() + index(flat.max(blocks)) + index(most) + 2
    }

    /// Words among them, and of the slots, that are not part of the blob.
    #[must_use]
    pub const fn scratch(&self) -> usize {
        2 * index(self.grid.listed)
    }

    /// Words of [`crate::build::Arena::slots`].
    #[must_use]
    pub const fn slots(&self) -> usize {
        if self.grid.cells == 0 { 0 } else { index(self.grid.listed) + 1 }
    }
}

/// Words of the bits and masks of so many blocks with so many octants.
fn block_words(shape: &Shape, blocks: u32, octants: u32) -> u32 {
    let all = super::blocks::shape(shape).len().unwrap_or(u32::MAX);
    let bits = all.div_ceil(64).saturating_mul(BIT_WORDS);
    let groups = blocks.div_ceil(GROUP).saturating_mul(GROUP_WORDS);
    bits.saturating_add(groups).saturating_add(words(octants, width(OCTANT)))
}

/// The same at most, where so many voxels list something.
fn most_block_words(shape: &Shape, voxels: u32) -> u32 {
    let blocks = voxels.min(super::blocks::shape(shape).len().unwrap_or(u32::MAX));
    block_words(shape, blocks, voxels.min(blocks.saturating_mul(8)))
}

/// Words of the bits and buckets of so many voxels.
fn flat_words(shape: &Shape, modulus: u32, occupied: u32) -> u32 {
    let voxels = shape.len().unwrap_or(u32::MAX);
    let buckets = words(modulus.saturating_add(1), width(occupied));
    let tags = words(occupied, width(most_tag(voxels, modulus)));
    voxels.div_ceil(32).saturating_add(buckets).saturating_add(tags)
}

/// The size of a hash table.
fn modulus(shape: &Shape, occupied: u32) -> u32 {
    let prime_to = |m: u32, n: u32| {
        let (mut a, mut b) = (m, n);
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a == 1
    };
    let least = occupied.max(1);
    let [_, y, z] = shape.cells;
    (least..least + SEARCHED).find(|&m| prime_to(m, y) && prime_to(m, z)).unwrap_or(least)
}

/// The bit of a voxel, counted through all blocks: block times 64 and bit of its mask. Below 2^32, because there are at
/// most 256 blocks along each axis.
fn block_bit(shape: &Shape, blocks: &Shape, voxel: u32) -> u32 {
    let at = shape.place(voxel);
    let sum = |strides: [u32; 3], part: fn(u32) -> u32| {
        let along = |k: usize| part(at[k]).wrapping_mul(strides[k]);
        along(0).wrapping_add(along(1)).wrapping_add(along(2))
    };
    sum(blocks.strides(), |i| i / 4).wrapping_mul(64).wrapping_add(sum(STRIDES, |i| i % 4))
}

/// Fills the tables of a plan. `words` and `slots` are as long as the plan says.
pub fn build<'p>(
    input: &Input<'_>,
    plan: &Plan,
    refs: &'p mut [Ref],
    words: &'p mut [u32],
    slots: &'p mut [u32],
) -> Parts<'p> {
    let (shape, listed) = (plan.grid.shape, plan.grid.listed);
    let scratch = plan.scratch();
    if words.len() < HEAD + scratch || slots.len() <= index(listed) {
        return Parts::default();
    }
    let (head, rest) = words.split_at_mut(HEAD);
    let (pairs, rest) = rest.split_at_mut(scratch);
    let pairs: &mut [[u32; 2]] = bytemuck::cast_slice_mut(pairs);
    let table = sorted_pairs(input, plan, pairs);
    let (head, counts) = head.split_at_mut(SHAPE_WORDS);
    head.copy_from_slice(bytemuck::cast_slice(&[shape]));
    counts.copy_from_slice(bytemuck::cast_slice(&[table]));
    // The lists, in the order of the pairs.
    let (starts, rest) = rest.split_at_mut(index(table.occupied) + 2);
    fill_lists(pairs, starts, slots);
    let order = number_slots(starts.get(..=index(table.occupied)).unwrap_or(&[]), slots, refs);
    let starts_len = pack(starts, table.occupied + 1, listed);
    let slots_len = pack(slots, listed, input.len - 1);
    let fill = if table.form == FLAT { fill_flat } else { fill_blocks };
    let (bits, index) = fill(&shape, &table, pairs, rest);
    let mut parts = Parts::new(order, 0, super::steps(&shape, &table));
    parts.push(Section::GridShape, head, SHAPE_WORDS);
    parts.push(Section::VoxelTable, counts, size_of::<Table>() / 4);
    parts.push(Section::VoxelBits, bits, 1);
    parts.push(Section::VoxelIndex, index, 1);
    parts.push(Section::VoxelStarts, starts.get(..starts_len).unwrap_or(&[]), 1);
    parts.push(Section::VoxelLists, slots.get(..slots_len).unwrap_or(&[]), 1);
    parts
}

/// Fills one pair per reference, in the order of the form that is smaller, and says which and how much it is.
fn sorted_pairs(input: &Input<'_>, plan: &Plan, pairs: &mut [[u32; 2]]) -> Table {
    let (shape, blocks) = (plan.grid.shape, super::blocks::shape(&plan.grid.shape));
    let mut places = pairs.iter_mut();
    input.listings(&shape, |voxel, prim| {
        if let Some(place) = places.next() {
            *place = [voxel, prim];
        }
    });
    if plan.blocks {
        for pair in pairs.iter_mut() {
            pair[0] = block_bit(&shape, &blocks, pair[0]);
        }
    }
    pairs.sort_unstable();
    let occupied = count(pairs.chunk_by(|a, b| a[0] == b[0]).count());
    let (modulus, listed) = (modulus(&shape, occupied), count(pairs.len()));
    if plan.blocks {
        let (mut filled, mut octants) = (0, 0);
        for (_, mask) in masks(pairs) {
            filled += 1;
            octants += count(exchange(mask).to_le_bytes().iter().filter(|&&byte| byte != 0).count());
        }
        let words = block_words(&shape, filled, octants);
        if !plan.flat || flat_words(&shape, modulus, occupied) >= words {
            return Table { form: BLOCKS, modulus: 0, occupied, listed, blocks: filled, octants };
        }
        for pair in pairs.iter_mut() {
            pair[0] = voxel(&shape, &blocks, pair[0]);
        }
    }
    pairs.sort_unstable_by_key(|&[voxel, prim]| (voxel % modulus, voxel / modulus, prim));
    Table { form: FLAT, modulus, occupied, listed, blocks: 0, octants: 0 }
}

/// The voxel of a block's bit.
fn voxel(shape: &Shape, blocks: &Shape, bit: u32) -> u32 {
    let first = blocks.place(bit / 64).map(|i| i * 4);
    let (cell, strides) = (super::Blocks::cell(first, bit % 64), shape.strides());
    let along = |k: usize| cell[k].wrapping_mul(strides[k]);
    along(0).wrapping_add(along(1)).wrapping_add(along(2))
}
