//! The header and the section table.
//!
//! | offset | size | field | meaning |
//! |---|---|---|---|
//! | 0 | 4 | `magic` | the bytes `FRAY` |
//! | 4 | 4 | `version` | 2, or 1 |
//! | 8 | 4 | `length` | bytes of the whole blob |
//! | 12 | 4 | `checksum` | CRC-32 (ISO-HDLC) of the bytes from 16 to the end |
//! | 16 | 4 | `kind` | the structure: 1 list, 2 bvh, 3 grid, 4 voxel, 5 nested, 6 octree, 7 bsp, 8 sphere, 9 wide |
//! | 20 | 4 | `prims` | number of primitives, below 2^28 |
//! | 24 | 4 | `stack` | deepest stack of a walk, in entries: at most 64, of a wide hierarchy 192 |
//! | 28 | 4 | `steps` | most steps of a walk: nodes visited and primitives tested |
//! | 32 | 24 | `bounds` | box around all primitives: least corner, greatest corner |
//! | 56 | 12 | `local` | local origin: added to every coordinate to get the caller's |
//! | 68 | 4 | `sections` | entries of the section table, at most 16 |
//! | 72 | 4 | `longest` | longest side of the boxes of triangles; 0 if not told, as in version 1 |
//! | 76 | 4 | `reserved` | 0 |
//!
//! A table entry has 12 bytes: section number, offset, length.
use super::error::{BlobError, Rule, Section};
use super::{BLOB_ALIGN, MAX_PRIMS, MAX_STACK, SECTION_ALIGN, crc32};
use crate::geom::Aabb;
use crate::geom::vec::finite;
use crate::num::{count, index};
use bytemuck::{Pod, Zeroable};

/// The first four bytes, read as a little-endian number.
pub const MAGIC: u32 = u32::from_le_bytes(*b"FRAY");
/// The format version that this library writes.
pub const VERSION: u32 = 2;
/// The oldest that it reads.
pub const OLDEST_VERSION: u32 = 1;
/// Most entries of a section table.
pub const MAX_SECTIONS: u32 = 16;
/// Where the bytes start that the checksum covers: what is before it proves itself.
const SUMMED: usize = 16;

/// An acceleration structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[repr(u32)]
pub enum Kind {
    /// Every primitive is tested: the oracle, and right for a handful.
    List = 1,
    /// Binary bounding-volume hierarchy.
    Bvh = 2,
    /// Uniform grid, a list for every cell.
    Grid = 3,
    /// Uniform grid, a list for every cell that has one.
    Voxel = 4,
    /// Hierarchy of grids.
    Nested = 5,
    /// Octree with a list for every leaf.
    Octree = 6,
    /// Axis-aligned binary space partition.
    Bsp = 7,
    /// Binary bounding-sphere hierarchy.
    Sphere = 8,
    /// Eight-wide bounding-volume hierarchy, or four-wide.
    Wide = 9,
}

/// Every structure, with its name on the command line.
pub const KINDS: &[(Kind, &str)] = &[
    (Kind::List, "list"),
    (Kind::Bvh, "bvh"),
    (Kind::Grid, "grid"),
    (Kind::Voxel, "voxel"),
    (Kind::Nested, "nested"),
    (Kind::Octree, "octree"),
    (Kind::Bsp, "bsp"),
    (Kind::Sphere, "sphere"),
    (Kind::Wide, "wide"),
];

impl Kind {
    /// The structure's number in a header.
    #[must_use]
    #[allow(clippy::as_conversions)] // an enum's own number
    pub const fn number(self) -> u32 {
        self as u32
    }

    /// The structure's name.
    #[must_use]
    pub fn name(self) -> &'static str {
        KINDS.iter().find(|(kind, _)| *kind == self).map_or("", |(_, name)| name)
    }

    /// The sections that a blob of this structure may have beside the primitives'.
    #[must_use]
    pub const fn sections(self) -> &'static [Section] {
        match self {
            Self::List => &[],
            Self::Bvh => &[Section::BvhNodes],
            Self::Grid => &[Section::GridShape, Section::CellStarts, Section::CellLists],
            Self::Voxel => crate::voxel::SECTIONS,
            Self::Nested => &[Section::CellLists, Section::NestedGrids, Section::NestedCells],
            Self::Octree => &[Section::GridShape, Section::CellStarts, Section::CellLists, Section::OctreeNodes],
            Self::Bsp => &[Section::CellLists, Section::BspNodes],
            Self::Sphere => &[Section::SphereNodes],
            Self::Wide => &[Section::Blocks, Section::WideNodes, Section::Wide4Nodes],
        }
    }
}

/// The first 80 bytes of a blob; the table in this module's source and in `docs/format.md` says what each means.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Header {
    /// [`MAGIC`].
    pub magic: u32,
    /// From [`OLDEST_VERSION`] to [`VERSION`].
    pub version: u32,
    /// Bytes of the whole blob.
    pub length: u32,
    /// CRC-32 of the bytes from 16 to the end.
    pub checksum: u32,
    /// Number of the [`Kind`].
    pub kind: u32,
    /// Number of primitives.
    pub prims: u32,
    /// Deepest stack of a walk, in entries.
    pub stack: u32,
    /// Most steps of a walk: nodes visited and primitives tested.
    pub steps: u32,
    /// Box around all primitives.
    pub bounds: Aabb,
    /// Local origin.
    pub local: [f32; 3],
    /// Entries of the section table.
    pub sections: u32,
    /// Longest side of the boxes of triangles: the shorter, the more often their test can do without f64. 0 if not told.
    pub longest: f32,
    /// 0.
    pub reserved: u32,
}

const _: () = assert!(size_of::<Header>() == 80 && size_of::<Entry>() == 12);

impl Header {
    /// The structure, if this library knows it.
    #[must_use]
    pub fn kind(&self) -> Option<Kind> {
        KINDS.iter().map(|&(kind, _)| kind).find(|&kind| kind.number() == self.kind)
    }
}

/// An entry of the section table.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Entry {
    /// Number of the [`Section`].
    pub section: u32,
    /// Offset of its first byte from the blob's first byte.
    pub offset: u32,
    /// Its length in bytes.
    pub length: u32,
}

/// The first multiple of [`SECTION_ALIGN`] not below `n`, if there is one.
pub(super) const fn align(n: u32) -> Option<u32> {
    match n.checked_add(SECTION_ALIGN - 1) {
        Some(n) => Some(n / SECTION_ALIGN * SECTION_ALIGN),
        None => None,
    }
}

const fn broken(rule: Rule) -> BlobError {
    BlobError::new(rule, Section::Header)
}

/// Header and table of `bytes`: rules 1 to 9, 11 and 12, and the count's own limit of rule 13.
pub(super) fn parse(bytes: &[u8]) -> Result<(&Header, &[Entry]), BlobError> {
    let short = broken(Rule::Size).found(count(bytes.len()));
    let head = bytes.get(..size_of::<Header>()).ok_or(short.needed(count(size_of::<Header>())))?;
    let address = count(bytes.as_ptr().align_offset(BLOB_ALIGN));
    let crooked = broken(Rule::Alignment).found(4u32.wrapping_sub(address)).needed(count(BLOB_ALIGN));
    let header: &Header = bytemuck::try_from_bytes(head).map_err(|_| crooked)?;
    parse_header(header, bytes.len())?;
    let size = header.sections.saturating_mul(count(size_of::<Entry>())).saturating_add(count(size_of::<Header>()));
    let table = bytes.get(size_of::<Header>()..index(size)).ok_or(short.needed(size))?;
    let entries: &[Entry] = bytemuck::try_cast_slice(table).map_err(|_| crooked)?;
    parse_entries(entries, size, header.length)?;
    parse_kind(header, entries)?;
    Ok((header, entries))
}

/// No section belongs to another structure: it would be bytes that nobody looks at.
fn parse_kind(header: &Header, entries: &[Entry]) -> Result<(), BlobError> {
    let kind = header.kind().ok_or(broken(Rule::KindKnown).found(header.kind))?;
    let fits = |e: &Entry| {
        let own = kind.sections().iter().any(|s| s.number() == e.section);
        own || e.section < Section::Blocks.number()
    };
    match entries.iter().position(|e| !fits(e)) {
        None => Ok(()),
        Some(i) => {
            let error = BlobError::new(Rule::SectionOrder, Section::Table).at(count(i));
            Err(error.found(entries.get(i).map_or(0, |e| e.section)))
        }
    }
}

fn parse_header(header: &Header, length: usize) -> Result<(), BlobError> {
    if header.magic != MAGIC {
        return Err(broken(Rule::Magic).found(header.magic).needed(MAGIC));
    }
    if !(OLDEST_VERSION..=VERSION).contains(&header.version) {
        return Err(broken(Rule::Version).found(header.version).needed(VERSION));
    }
    if index(header.length) != length {
        return Err(broken(Rule::Length).found(count(length)).needed(header.length));
    }
    if header.kind().is_none() {
        return Err(broken(Rule::KindKnown).found(header.kind));
    }
    if header.reserved != 0 || header.version == 1 && header.longest.to_bits() != 0 {
        return Err(broken(Rule::Reserved));
    }
    if !(header.longest.to_bits() == 0 || header.longest > 0.0 && header.longest.is_finite()) {
        return Err(broken(Rule::Longest));
    }
    if header.sections > MAX_SECTIONS {
        return Err(broken(Rule::SectionOrder).found(header.sections).needed(MAX_SECTIONS));
    }
    if !header.bounds.is_valid() || !finite(header.local) {
        return Err(broken(Rule::Bounds));
    }
    let most = if header.kind() == Some(Kind::Wide) { crate::wide::STACK } else { MAX_STACK };
    if header.stack > most {
        return Err(broken(Rule::Stack).found(header.stack).needed(most));
    }
    if header.prims > MAX_PRIMS {
        return Err(broken(Rule::PrimCount).found(header.prims).needed(MAX_PRIMS));
    }
    Ok(())
}

/// Sections are known, ascending, packed at multiples of 64, and end with the blob.
fn parse_entries(entries: &[Entry], mut end: u32, length: u32) -> Result<(), BlobError> {
    let mut last = 0;
    for (i, entry) in entries.iter().enumerate() {
        let broken = |rule| BlobError::new(rule, Section::Table).at(count(i));
        let known = Section::LISTED.iter().any(|s| s.number() == entry.section);
        if !known || entry.section <= last {
            return Err(broken(Rule::SectionOrder).found(entry.section).needed(last.saturating_add(1)));
        }
        if entry.length == 0 {
            return Err(broken(Rule::SectionLength).needed(1));
        }
        let place = align(end).ok_or(broken(Rule::SectionPlace).found(entry.offset))?;
        if entry.offset != place {
            return Err(broken(Rule::SectionPlace).found(entry.offset).needed(place));
        }
        end = place.checked_add(entry.length).ok_or(broken(Rule::SectionPlace).found(entry.length))?;
        last = entry.section;
    }
    if end != length {
        return Err(BlobError::new(Rule::SectionPlace, Section::Table)
            .at(count(entries.len()))
            .found(end)
            .needed(length));
    }
    Ok(())
}

/// Rule 14.
pub(super) fn check_sum(bytes: &[u8], header: &Header) -> Result<(), BlobError> {
    let sum = crc32(bytes.get(SUMMED..).unwrap_or(&[]));
    if sum == header.checksum { Ok(()) } else { Err(broken(Rule::Checksum).found(sum).needed(header.checksum)) }
}

/// Rule 15.
pub(super) fn check_padding(bytes: &[u8], entries: &[Entry]) -> Result<(), BlobError> {
    let mut end = size_of::<Header>() + size_of_val(entries);
    for (i, entry) in entries.iter().enumerate() {
        let gap = bytes.get(end..index(entry.offset)).unwrap_or(&[]);
        if let Some(&byte) = gap.iter().find(|&&b| b != 0) {
            return Err(BlobError::new(Rule::Padding, Section::Table).at(count(i)).found(u32::from(byte)));
        }
        end = index(entry.offset.saturating_add(entry.length));
    }
    Ok(())
}

/// Writes the checksum of a finished blob into its header.
#[cfg(feature = "build")]
pub(super) fn seal(bytes: &mut [u8]) {
    let sum = crc32(bytes.get(SUMMED..).unwrap_or(&[])).to_le_bytes();
    if let Some(place) = bytes.get_mut(SUMMED - 4..SUMMED) {
        place.copy_from_slice(&sum);
    }
}
