//! The tables of sparse voxels, from sorted pairs of voxel and primitive.
use super::Table;
use super::blocks::{BIT_WORDS, GROUP, GROUP_WORDS, OCTANT, exchange};
use super::flat::most_tag;
use crate::blob::packed::{pack, width, words};
use crate::grid::Shape;
use crate::num::{count, index};

/// Writes where the list of each voxel starts, where the last one ends, and the primitives listed.
pub(super) fn fill_lists(pairs: &[[u32; 2]], starts: &mut [u32], slots: &mut [u32]) {
    let mut places = starts.iter_mut();
    let mut last = None;
    for (i, (&[voxel, prim], slot)) in pairs.iter().zip(slots.iter_mut()).enumerate() {
        if last != Some(voxel)
            && let Some(place) = places.next()
        {
            *place = count(i);
        }
        (last, *slot) = (Some(voxel), prim);
    }
    if let Some(place) = places.next() {
        *place = count(pairs.len());
    }
}

/// Bits, and packed buckets and quotients.
pub(super) fn fill_flat<'p>(
    shape: &Shape,
    table: &Table,
    pairs: &[[u32; 2]],
    words: &'p mut [u32],
) -> (&'p [u32], &'p [u32]) {
    let all = shape.len().unwrap_or(0);
    let (bits, rest) = words.split_at_mut(index(all.div_ceil(32)));
    let (buckets, tags) = rest.split_at_mut(index(table.modulus) + 2);
    bits.fill(0);
    buckets.fill(0);
    let voxels = pairs.chunk_by(|a, b| a[0] == b[0]).filter_map(|list| list.first());
    for (tag, &[voxel, _]) in tags.iter_mut().zip(voxels) {
        *tag = voxel / table.modulus;
        if let Some(word) = bits.get_mut(index(voxel >> 5)) {
            *word |= 1 << (voxel & 31);
        }
        // Counted at the slot after: the sums are then where the slots start.
        if let Some(n) = buckets.get_mut(index(voxel % table.modulus) + 1) {
            *n += 1;
        }
    }
    let mut sum = 0;
    for start in buckets.iter_mut() {
        sum += *start;
        *start = sum;
    }
    let first = pack(buckets, table.modulus + 1, table.occupied);
    let second = pack(tags, table.occupied, most_tag(all, table.modulus));
    let gap = buckets.len() - first;
    rest.copy_within(first + gap..first + gap + second, first);
    (bits, rest.get(..first + second).unwrap_or(&[]))
}

/// The blocks of pairs of a block's bit and a primitive, in order, and their masks.
pub(super) fn masks(pairs: &[[u32; 2]]) -> impl Iterator<Item = (u32, u64)> {
    pairs.chunk_by(|a, b| a[0] / 64 == b[0] / 64).filter_map(|block| {
        let mask = block.iter().fold(0, |mask, [bit, _]| mask | 1 << (bit % 64));
        Some((block.first()?[0] / 64, mask))
    })
}

/// Bits and masks of blocks, with counts.
pub(super) fn fill_blocks<'p>(
    shape: &Shape,
    table: &Table,
    pairs: &[[u32; 2]],
    rest: &'p mut [u32],
) -> (&'p [u32], &'p [u32]) {
    let all = super::blocks::shape(shape).len().unwrap_or(0);
    let (bits, rest) = rest.split_at_mut(index(all.div_ceil(64) * BIT_WORDS));
    let octants_len = index(words(table.octants, width(OCTANT)));
    let groups_len = index(table.blocks.div_ceil(GROUP) * GROUP_WORDS);
    let masked = rest.get_mut(..octants_len + groups_len).unwrap_or(&mut []);
    bits.fill(0);
    masked.fill(0);
    let (octants, groups) = masked.split_at_mut(octants_len.min(masked.len()));
    let mut next = Next { rank: 0, octants: 0, voxels: 0 };
    for (number, mask) in masks(pairs) {
        turn_on(bits, number / 64 * BIT_WORDS + number % 64 / 32, 1 << (number % 32));
        next.put(mask, octants, groups);
    }
    let mut sum = 0;
    for group in bits.chunks_exact_mut(index(BIT_WORDS)) {
        if let [low, high, before] = group {
            *before = sum;
            sum += low.count_ones() + high.count_ones();
        }
    }
    (bits, masked)
}

/// What is before the next block.
struct Next {
    rank: u32,
    octants: u32,
    voxels: u32,
}

impl Next {
    /// Writes a block's octants, and the counts if it is the first of its group.
    fn put(&mut self, mask: u64, octants: &mut [u32], groups: &mut [u32]) {
        let (group, rank) = (self.rank / GROUP * GROUP_WORDS, self.rank % GROUP);
        if rank == 0 {
            turn_on(groups, group, self.voxels);
            turn_on(groups, group + 1, self.octants);
        }
        for (octant, byte) in (0..).zip(exchange(mask).to_le_bytes()) {
            if byte != 0 {
                turn_on(groups, group + 2 + rank / 4, 1 << (rank % 4 * 8 + octant));
                turn_on(octants, self.octants / 4, u32::from(byte) << (self.octants % 4 * 8));
                self.octants += 1;
            }
        }
        self.voxels += mask.count_ones();
        self.rank += 1;
    }
}

/// Turns bits of a word on.
fn turn_on(words: &mut [u32], word: u32, bits: u32) {
    if let Some(word) = words.get_mut(index(word)) {
        *word |= bits;
    }
}
