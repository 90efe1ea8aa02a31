//! Sections into a caller's buffer.
//!
//! The length is known before the first byte is written, and a buffer that is too short is left alone.
use super::header::{Entry, Header, align, seal};
use super::{Kind, MAGIC, MAX_SECTIONS, Section, VERSION};
use crate::geom::Aabb;
use crate::num::{bytes_of, count, index};
use bytemuck::Zeroable;
use core::ops::Range;
use heapless::Vec;

/// Which sections a blob has, and where.
#[derive(Clone, Debug)]
pub struct Layout {
    entries: Vec<Entry, { index(MAX_SECTIONS) }>,
    length: u32,
}

/// What the header says beside the layout.
#[derive(Clone, Copy, Debug)]
pub struct Facts {
    /// The structure.
    pub kind: Kind,
    /// Number of primitives.
    pub prims: u32,
    /// Deepest stack of a walk.
    pub stack: u32,
    /// Most steps of a walk.
    pub steps: u32,
    /// Box around all primitives.
    pub bounds: Aabb,
    /// Local origin.
    pub local: [f32; 3],
    /// Longest side of the triangles' boxes.
    pub longest: f32,
}

impl Layout {
    /// Places sections of so many entries of such a size, in ascending order of number; empty ones are left out.
    ///
    /// `None` if the blob would be 4 GiB or longer.
    #[must_use]
    pub fn new(sections: &[(Section, u32, usize)]) -> Option<Self> {
        let mut entries = Vec::new();
        let present = || sections.iter().filter(|(_, n, _)| *n > 0);
        let table = bytes_of(count(present().count()), count(size_of::<Entry>()))?;
        let mut length = count(size_of::<Header>()).checked_add(table)?;
        for &(section, n, size) in present() {
            let offset = align(length)?;
            let bytes = bytes_of(n, count(size))?;
            length = offset.checked_add(bytes)?;
            entries.push(Entry { section: section.number(), offset, length: bytes }).ok()?;
        }
        Some(Self { entries, length })
    }

    /// Bytes of the whole blob.
    #[must_use]
    pub const fn len(&self) -> usize {
        index(self.length)
    }

    /// Never: a blob has a header.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        false
    }

    /// Starts a blob in the first [`Layout::len`] bytes of `out`; `None` if `out` is shorter.
    #[must_use]
    pub fn start<'o>(&self, out: &'o mut [u8], facts: &Facts) -> Option<Writer<'_, 'o>> {
        let bytes = out.get_mut(..self.len())?;
        // All but the sections, which whoever writes them fills.
        let mut from = 0;
        for entry in &self.entries {
            bytes.get_mut(from..index(entry.offset))?.fill(0);
            from = index(entry.offset) + index(entry.length);
        }
        bytes.get_mut(from..)?.fill(0);
        let header = Header {
            magic: MAGIC,
            version: VERSION,
            length: self.length,
            kind: facts.kind.number(),
            prims: facts.prims,
            stack: facts.stack,
            steps: facts.steps,
            bounds: facts.bounds,
            local: facts.local,
            longest: facts.longest,
            sections: count(self.entries.len()),
            ..Header::zeroed()
        };
        let (head, rest) = bytes.split_at_mut_checked(size_of::<Header>())?;
        head.copy_from_slice(bytemuck::bytes_of(&header));
        let table: &[u8] = bytemuck::cast_slice(&self.entries);
        rest.get_mut(..table.len())?.copy_from_slice(table);
        Some(Writer { layout: self, bytes })
    }
}

/// A blob being written.
#[derive(Debug)]
pub struct Writer<'l, 'o> {
    layout: &'l Layout,
    bytes: &'o mut [u8],
}

impl<'o> Writer<'_, 'o> {
    /// Writes a section's entries from an iterator, as many as the layout has room for.
    pub fn section<T: bytemuck::NoUninit>(&mut self, section: Section, items: impl Iterator<Item = T>) {
        let range = self.range(section);
        let place = self.bytes.get_mut(range).unwrap_or(&mut []);
        let mut items = items.fuse();
        for place in place.chunks_exact_mut(size_of::<T>().max(1)) {
            match items.next() {
                Some(item) => place.copy_from_slice(bytemuck::bytes_of(&item)),
                None => place.fill(0),
            }
        }
    }

    /// The places of two sections, the first of which stands before the other; empty for one that the layout has not.
    pub fn places(&mut self, first: Section, second: Section) -> [&mut [u8]; 2] {
        let (first, second) = (self.range(first), self.range(second));
        let middle = if second.is_empty() { first.end } else { second.start };
        let (head, tail) = self.bytes.split_at_mut_checked(middle).unwrap_or((&mut [], &mut []));
        [head.get_mut(first).unwrap_or(&mut []), tail.get_mut(..second.len()).unwrap_or(&mut [])]
    }

    /// Where a section is; nowhere, if the layout has it not.
    fn range(&self, section: Section) -> Range<usize> {
        let entry = self.layout.entries.iter().find(|e| e.section == section.number());
        entry.map_or(0..0, |e| index(e.offset)..index(e.offset) + index(e.length))
    }

    /// Writes the checksum; the blob is complete.
    #[must_use]
    pub fn finish(self) -> &'o [u8] {
        seal(self.bytes);
        self.bytes
    }
}
