//! The container: one run of bytes that holds a scene and its acceleration structure, read in place.
//!
//! ```text
//! 0          80         80 + 12 s                                   length
//! | header   | s table  | 0.. | section | 0.. | section | .. | section |
//!              entries          ^ each starts at a multiple of 64
//! ```
//!
//! Everything is little-endian, there are no pointers, and offsets are `u32` from the first byte. A blob that starts at
//! a multiple of 4 in memory works; one that starts at a multiple of 64 has its nodes on cache lines of their own.
//!
//! Loading has two stages. [`Blob::parse`] is O(1): magic, version, lengths, the section table, alignment. The full
//! check is O(n), needs no memory, and proves the rest. Every rule of both has a number, the same here and in
//! `docs/format.md`, which is normative; each has a test that breaks it. What a walk needs for its *safety* is
//! checked by the walk itself, so a blob that only parsed is as safe as one that was checked.

pub mod block;
#[cfg(feature = "alloc")]
mod buffer;
mod crc;
mod error;
mod header;
pub mod lists;
pub mod packed;
#[cfg(all(feature = "alloc", feature = "std", target_os = "linux"))]
mod pages;
pub mod prims;
#[cfg(feature = "build")]
pub mod write;

#[cfg(feature = "alloc")]
pub use buffer::Buffer;
pub use crc::crc32;
pub use error::{BlobError, Rule, Section};
pub use header::{Entry, Header, KINDS, Kind, MAGIC, MAX_SECTIONS, OLDEST_VERSION, VERSION};

use bytemuck::AnyBitPattern;

#[cfg(target_endian = "big")]
compile_error!("blobs are little-endian and read in place: big-endian targets are not supported");

/// Sections start at multiples of this, counted from the blob's first byte.
pub const SECTION_ALIGN: u32 = 64;
/// A blob must start at a multiple of this in memory.
pub const BLOB_ALIGN: usize = 4;
/// Most primitives in one blob: numbers of primitives and nodes take 28 bits.
pub const MAX_PRIMS: u32 = (1 << 28) - 1;
/// Most entries of the stack that any walk of any blob may need.
pub const MAX_STACK: u32 = 64;

/// Bytes that passed the cheap stage: header and sections lie where they should.
#[derive(Clone, Copy, Debug)]
pub struct Blob<'a> {
    bytes: &'a [u8],
    header: &'a Header,
    entries: &'a [Entry],
}

impl<'a> Blob<'a> {
    /// The cheap stage, O(1): rules 1 to 13.
    ///
    /// # Errors
    /// The first rule that is broken, and where.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, BlobError> {
        let (header, entries) = header::parse(bytes)?;
        Ok(Self { bytes, header, entries })
    }

    /// The container's part of the full check, O(n): checksum and padding, rules 14 and 15.
    ///
    /// # Errors
    /// The first rule that is broken, and where.
    pub fn check(&self) -> Result<(), BlobError> {
        header::check_sum(self.bytes, self.header)?;
        header::check_padding(self.bytes, self.entries)
    }

    /// The header.
    #[must_use]
    pub const fn header(&self) -> &'a Header {
        self.header
    }

    /// The section table.
    #[must_use]
    pub const fn entries(&self) -> &'a [Entry] {
        self.entries
    }

    /// The entries of a section; none if the blob has no such section.
    ///
    /// # Errors
    /// [`Rule::SectionLength`] if the section's length is no multiple of an entry's size.
    pub fn section<T: AnyBitPattern>(&self, section: Section) -> Result<&'a [T], BlobError> {
        let Some(entry) = self.entries.iter().find(|e| e.section == section.number()) else {
            return Ok(&[]);
        };
        let (start, len) = (crate::num::index(entry.offset), crate::num::index(entry.length));
        let bytes = self.bytes.get(start..).and_then(|b| b.get(..len)).unwrap_or(&[]);
        bytemuck::try_cast_slice(bytes).map_err(|_| {
            let size = crate::num::count(size_of::<T>());
            BlobError::new(Rule::SectionLength, section).found(entry.length).needed(size)
        })
    }
}
