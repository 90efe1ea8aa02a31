//! The lecture's form: a bit for each voxel and a hash table.
//!
//! Voxel `p = (i ny + j) nz + k` belongs to slot `p mod M` of `M`. The slot says where its *bucket* of voxels starts, a
//! bucket holds the quotients `p div M` of its voxels in ascending order, and slot and quotient together are the voxel:
//! membership is exact, with few bits (Cleary, "Compact Hash Tables Using Bidirectional Linear Probing", IEEE TC
//! C-33(9), 1984, stores the quotient for the same reason). The place of a voxel among all buckets is that of its list.
//!
//! Words: `voxel bits` has the bit of voxel `p` at bit `p mod 32` of word `p div 32`. `voxel index` has, packed,
//! `M + 1` numbers up to `occupied`, where each bucket starts and where the last one ends, and then, packed, the
//! quotients.
use super::{Table, word};
use crate::blob::packed::Packed;
use crate::blob::{BlobError, Rule, Section};
use crate::geom::ray::Axis;
use crate::grid::Shape;
use crate::num::{count, index};
use crate::walk::dda::Cursor;

/// The most voxels, and the largest table: so that the sum of two slots fits.
pub const MOST: u32 = (1 << 31) - 1;

/// Bits and buckets.
#[derive(Clone, Copy, Debug)]
pub struct Flat<'a> {
    bits: &'a [u32],
    buckets: Packed<'a>,
    tags: Packed<'a>,
    start: Hashed,
}

/// The voxel that a walk is in: its number, its slot and its quotient, all kept by addition.
///
/// What a step along an axis adds to the slot is reduced beforehand, so one conditional subtraction or addition brings
/// the slot back. (The lecture subtracts where `p > M`, and so reads one slot past the table where `p = M`; and where a
/// plane of voxels has more than `M`, one subtraction is not enough.)
#[derive(Clone, Copy, Debug)]
pub struct Hashed {
    /// Number of the voxel.
    pub voxel: u32,
    /// The number modulo the table's size.
    pub slot: u32,
    /// The number divided by the table's size.
    pub tag: u32,
    modulus: u32,
    strides: [u32; 3],
    slot_strides: [u32; 3],
    tag_strides: [u32; 3],
}

impl Hashed {
    /// At voxel 0 of a grid of up to 2^31 - 1 voxels; `modulus` is from 1 to 2^31 - 1.
    #[must_use]
    pub fn new(shape: &Shape, modulus: u32) -> Self {
        let (strides, modulus) = (shape.strides(), modulus.clamp(1, MOST));
        let (slot_strides, tag_strides) = (strides.map(|s| s % modulus), strides.map(|s| s / modulus));
        Self { voxel: 0, slot: 0, tag: 0, modulus, strides, slot_strides, tag_strides }
    }
}

impl Cursor for Hashed {
    fn put(&mut self, cell: [u32; 3]) {
        let part = |k: usize| cell[k].wrapping_mul(self.strides[k]);
        self.voxel = part(0).wrapping_add(part(1)).wrapping_add(part(2));
        // Never 0; said once more here, where the compiler can see it.
        let modulus = self.modulus.max(1);
        (self.slot, self.tag) = (self.voxel % modulus, self.voxel / modulus);
    }

    #[inline(always)]
    fn step(&mut self, axis: Axis, down: bool) {
        let (voxel, slot, tag) = (self.strides[axis.at()], self.slot_strides[axis.at()], self.tag_strides[axis.at()]);
        if down {
            let borrow = self.slot < slot;
            self.voxel = self.voxel.wrapping_sub(voxel);
            self.slot = self.slot.wrapping_sub(slot).wrapping_add(if borrow { self.modulus } else { 0 });
            self.tag = self.tag.wrapping_sub(tag).wrapping_sub(u32::from(borrow));
        } else {
            let sum = self.slot.wrapping_add(slot);
            let carry = sum >= self.modulus;
            self.voxel = self.voxel.wrapping_add(voxel);
            self.slot = sum.wrapping_sub(if carry { self.modulus } else { 0 });
            self.tag = self.tag.wrapping_add(tag).wrapping_add(u32::from(carry));
        }
    }
}

impl<'a> Flat<'a> {
    /// `None` if the sections do not hold what the table says.
    pub(super) fn new(shape: &Shape, table: &Table, bits: &'a [u32], index: &'a [u32]) -> Option<Self> {
        let voxels = shape.len().filter(|&n| n <= MOST)?;
        if table.modulus == 0 || table.modulus > MOST || bits.len() != crate::num::index(voxels.div_ceil(32)) {
            return None;
        }
        let (buckets, rest) = Packed::split(index, table.modulus + 1, table.occupied)?;
        let tags = Packed::whole(rest, table.occupied, most_tag(voxels, table.modulus))?;
        Some(Self { bits, buckets, tags, start: Hashed::new(shape, table.modulus) })
    }

    /// A cursor, at voxel 0.
    #[inline(always)]
    #[must_use]
    pub const fn cursor(&self) -> Hashed {
        self.start
    }

    /// Whether a voxel lists anything; `None` if there is no such voxel.
    #[inline(always)]
    #[must_use]
    pub fn has(&self, voxel: u32) -> Option<bool> {
        self.bits.get(index(voxel >> 5)).map(|word| word >> (voxel & 31) & 1 == 1)
    }

    /// The place of a voxel among all buckets; `None` if it is in none.
    ///
    /// Buckets have one voxel on average. This halves them all the same, so that no bytes can make it long.
    #[inline]
    #[must_use]
    pub fn find(&self, slot: u32, tag: u32) -> Option<u32> {
        let (first, last) = (self.buckets.get(slot)?, self.buckets.get(slot.wrapping_add(1))?);
        self.tags.find((first, last), tag)
    }

    /// The same by the voxel's number.
    #[must_use]
    pub fn entry(&self, voxel: u32) -> Option<u32> {
        let modulus = self.start.modulus.max(1);
        if self.has(voxel)? { self.find(voxel % modulus, voxel / modulus) } else { None }
    }

    /// Rules 31, 32 and 34.
    pub(super) fn check(&self, shape: &Shape, table: &Table) -> Result<(), BlobError> {
        let voxels = shape.len().unwrap_or(0);
        let on = self.bits.iter().fold(0u32, |sum, word| sum.saturating_add(word.count_ones()));
        let last = word(self.bits, count(self.bits.len()).saturating_sub(1));
        let beyond = if voxels.is_multiple_of(32) { 0 } else { last >> (voxels % 32) };
        if on != table.occupied || beyond != 0 {
            return Err(BlobError::new(Rule::VoxelBits, Section::VoxelBits).found(on).needed(table.occupied));
        }
        self.buckets.check_end(Section::VoxelIndex)?;
        self.tags.check_end(Section::VoxelIndex)?;
        let broken = |slot| BlobError::new(Rule::VoxelBuckets, Section::VoxelIndex).at(slot);
        // As many different voxels as bits are on, each of them with its bit on: they are the same.
        let mut next = 0;
        for slot in 0..table.modulus {
            let (first, last) = (self.buckets.get(slot).unwrap_or(0), self.buckets.get(slot + 1).unwrap_or(0));
            if first != next || last < first || last > table.occupied {
                return Err(broken(slot).found(first).needed(next));
            }
            let mut least = 0;
            for tag in self.tags.range(first, last) {
                let voxel = tag.checked_mul(table.modulus).and_then(|p| p.checked_add(slot));
                if tag < least || !voxel.is_some_and(|p| p < voxels && self.has(p) == Some(true)) {
                    return Err(broken(slot).found(tag).needed(least));
                }
                least = tag.saturating_add(1);
            }
            next = last;
        }
        if next == table.occupied { Ok(()) } else { Err(broken(table.modulus).found(next).needed(table.occupied)) }
    }
}

/// The largest quotient.
pub(super) const fn most_tag(voxels: u32, modulus: u32) -> u32 {
    match voxels.saturating_sub(1).checked_div(modulus) {
        Some(tag) => tag,
        None => 0,
    }
}
