//! Why a blob is refused.
use core::fmt;

macro_rules! rules {
    ($($(#[$doc:meta])* $name:ident = $number:literal, $text:literal;)*) => {
        /// What a blob must fulfil; the numbers are those of `docs/format.md`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[non_exhaustive]
        #[repr(u8)]
        pub enum Rule { $($(#[$doc])* $name = $number,)* }

        impl Rule {
            /// Every rule, in the order of the numbers.
            pub const ALL: &[Self] = &[$(Self::$name),*];

            /// What the rule demands, in a few words.
            #[must_use]
            pub const fn text(self) -> &'static str {
                match self { $(Self::$name => $text,)* }
            }
        }
    };
}

rules! {
    /// The bytes hold a whole header and section table.
    Size = 1, "the bytes hold a whole header and section table";
    /// The blob starts at a multiple of 4 in memory.
    Alignment = 2, "the blob starts at a multiple of 4 in memory";
    /// It begins with `FRAY`.
    Magic = 3, "the blob begins with FRAY";
    /// Its format version is one that this library reads.
    Version = 4, "the format version is one that this library reads";
    /// The length in the header is the number of bytes.
    Length = 5, "the length in the header is the number of bytes";
    /// The structure is known.
    KindKnown = 6, "the structure is known";
    /// Reserved words are 0.
    Reserved = 7, "reserved words are 0";
    /// Sections belong to the structure and are in ascending order of number.
    SectionOrder = 8, "sections belong to the structure and are in ascending order";
    /// Each section starts at the first multiple of 64 after what is before it, and the last one ends the blob.
    SectionPlace = 9, "sections follow each other at multiples of 64 and end with the blob";
    /// A section holds a whole number of entries, at least one.
    SectionLength = 10, "a section holds a whole number of entries, at least one";
    /// Bounds and local origin are finite and ordered.
    Bounds = 11, "bounds and local origin are finite and ordered";
    /// The walk's stack is within the library's.
    Stack = 12, "the deepest stack is within the library's";
    /// The primitive count is what the sections hold, and below 2^28.
    PrimCount = 13, "the counts of primitives, references and numbers agree";
    /// The checksum is that of the bytes.
    Checksum = 14, "the checksum is that of the bytes";
    /// Bytes between sections are 0.
    Padding = 15, "bytes between sections are 0";
    /// A primitive's numbers are finite, its radii are not negative, its flags are known.
    PrimShape = 16, "a primitive's numbers are finite and in range";
    /// A primitive lies inside the bounds of the header.
    PrimBounds = 17, "a primitive lies inside the header's bounds";
    /// References run through each kind's primitives in order, each once.
    RefOrder = 18, "references run through each kind's primitives in order, each once";
    /// A caller's number is below the primitive count.
    IdRange = 19, "a caller's number is below the primitive count";
    /// Nodes stand in walk order: each child's number is one more than the last node before it.
    NodeOrder = 20, "nodes stand in walk order";
    /// Leaves hold the primitives in order, from 1 to 15 each, all of them once.
    LeafOrder = 21, "leaves hold the primitives in order, each once";
    /// A child's box lies inside its parent's, and contains what is below it.
    NodeBounds = 22, "a box contains what is below it";
    /// The deepest stack in the header is the true one.
    StackTrue = 23, "the deepest stack in the header is the true one";
    /// The most steps in the header is the true number.
    StepsTrue = 24, "the most steps in the header is the true number";
    /// A grid has the cells that its tables are for, each with a size, and they enclose the bounds.
    Lattice = 25, "a grid's cells have a size, enclose the bounds, and are as many as its table has entries";
    /// Each list starts where the one before it ends, the first at 0, and the last one ends the section.
    ListPlace = 26, "lists follow each other and fill their section";
    /// Each list ascends; a slot is listed for the first time after all lower ones, and each is listed.
    ListOrder = 27, "lists ascend, and each slot appears, first after all lower ones";
    /// A cell lists every primitive that has a part in it.
    ListComplete = 28, "a cell lists every primitive that has a part in it";
    /// A voxel table's form is known, and its counts are what the sections hold.
    VoxelTable = 30, "a voxel table's form is known, and its counts are what the sections hold";
    /// As many bits are on as the counts say, and none is that is no voxel's or block's.
    VoxelBits = 31, "as many bits are on as the counts say, and none that is no voxel's or block's";
    /// Buckets follow each other, and hold the voxels whose bits are on, each in its own, in ascending order.
    VoxelBuckets = 32, "buckets hold the voxels whose bits are on, each in its own, in ascending order";
    /// Each block or octant whose bit is on has a voxel, none is outside of the grid, and earlier counts are true.
    VoxelMasks = 33, "each block or octant whose bit is on has a voxel, none outside of the grid, and counts are true";
    /// Bits after packed numbers are 0.
    PackedEnd = 34, "bits after packed numbers are 0";
    /// Each grid in a cell has the next number, each is in one cell, and that is one of a grid before it.
    GridOrder = 35, "grids in cells are numbered in the order of the cells that hold them";
    /// A grid in a cell encloses, of each primitive that has a part in the cell, what of its box lies there.
    GridBounds = 36, "a grid in a cell encloses what its primitives have in the cell";
    /// An octree with nodes has 2^d cells along each axis, d from 1 to 16; one without has one list.
    OctreeShape = 40, "an octree with nodes has 2^d cells along each axis, d from 1 to 16; one without has one list";
    /// The children of an octree's node are the next nodes and lists; none is both, and there is one.
    OctreeOrder = 41, "the children of an octree's node are the next nodes and lists; none is both, and there is one";
    /// A node of an octree has more than one cell along each axis.
    OctreeDepth = 42, "a node of an octree has more than one cell along each axis";
    /// A plane lies strictly inside the box that it parts.
    Plane = 45, "a plane lies strictly inside the box that it parts";
    /// A sphere has its centre in the bounds and contains the boxes of all primitives below it.
    SphereBounds = 50, "a sphere has its centre in the bounds and contains the boxes below it";
    /// A block has triangles in its first lanes, at least one; the others are 0 and have no number.
    BlockLanes = 55, "a block has triangles in its first lanes, and nothing in the others";
    /// A wide node has at least two children, in its first lanes; the others have empty boxes.
    WideLanes = 56, "a wide node has at least two children in its first lanes, and nothing in the others";
    /// The nodes of a wide hierarchy are of one width, the one that is read.
    WideWidth = 61, "the nodes of a wide hierarchy are of one width";
    /// The longest side of the triangles' boxes is a number, and none is longer; 0 says nothing.
    Longest = 62, "the longest side of the triangles' boxes is a number, and none is longer";
}

impl Rule {
    /// The rule's number in `docs/format.md`.
    #[must_use]
    #[allow(clippy::as_conversions)] // an enum's own number
    pub const fn number(self) -> u8 {
        self as u8
    }
}

/// A part of a blob.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[repr(u8)]
pub enum Section {
    /// The header.
    Header = 0,
    /// Triangles, 36 bytes each.
    Triangles = 1,
    /// Spheres, 16 bytes each.
    Spheres = 2,
    /// Axis-aligned boxes, 24 bytes each.
    Boxes = 3,
    /// Cylinders, 32 bytes each.
    Cylinders = 4,
    /// Cones, 36 bytes each.
    Cones = 5,
    /// One word per slot: which primitive of which kind stands there.
    Refs = 6,
    /// One word per slot: the caller's number of that primitive.
    Ids = 7,
    /// Triangles in blocks of four with the caller's numbers, 160 bytes each.
    Blocks = 8,
    /// Nodes of a binary bounding-volume hierarchy, 64 bytes each.
    BvhNodes = 16,
    /// Planes and cell numbers of a grid, one entry of 40 bytes.
    GridShape = 17,
    /// For each cell of a grid where its list starts, and where the last one ends.
    CellStarts = 18,
    /// The slots that cells list.
    CellLists = 19,
    /// The form and the counts of sparse voxels, one entry of 24 bytes.
    VoxelTable = 20,
    /// Bits of voxels, or of blocks with counts.
    VoxelBits = 21,
    /// What finds a voxel's list: buckets, or masks with counts.
    VoxelIndex = 22,
    /// Where each voxel's list starts, and where the last one ends, packed.
    VoxelStarts = 23,
    /// The slots that voxels list, packed.
    VoxelLists = 24,
    /// Planes and cell numbers of the grids of a hierarchy, 44 bytes each.
    NestedGrids = 25,
    /// For each cell of a hierarchy of grids the grid in it, or where its list starts.
    NestedCells = 26,
    /// Inner nodes of an octree, 12 bytes each.
    OctreeNodes = 28,
    /// Nodes of a binary space partition, 8 bytes each.
    BspNodes = 32,
    /// Nodes of the bounding-sphere hierarchy, 40 bytes each.
    SphereNodes = 34,
    /// Nodes of the eight-wide hierarchy, 256 bytes each.
    WideNodes = 36,
    /// Nodes of the four-wide hierarchy, 128 bytes each.
    Wide4Nodes = 37,
    /// The section table.
    Table = 255,
}

impl Section {
    /// The sections that a table may list, in the order in which they must stand.
    pub const LISTED: &[Self] = &[
        Self::Triangles,
        Self::Spheres,
        Self::Boxes,
        Self::Cylinders,
        Self::Cones,
        Self::Refs,
        Self::Ids,
        Self::Blocks,
        Self::BvhNodes,
        Self::GridShape,
        Self::CellStarts,
        Self::CellLists,
        Self::VoxelTable,
        Self::VoxelBits,
        Self::VoxelIndex,
        Self::VoxelStarts,
        Self::VoxelLists,
        Self::NestedGrids,
        Self::NestedCells,
        Self::OctreeNodes,
        Self::BspNodes,
        Self::SphereNodes,
        Self::WideNodes,
        Self::Wide4Nodes,
    ];

    /// The section's number in the table.
    #[must_use]
    #[allow(clippy::as_conversions)] // an enum's own number
    pub const fn number(self) -> u32 {
        self as u32
    }

    /// The section's name in messages.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Header => "header",
            Self::Triangles => "triangles",
            Self::Spheres => "spheres",
            Self::Boxes => "boxes",
            Self::Cylinders => "cylinders",
            Self::Cones => "cones",
            Self::Refs => "refs",
            Self::Ids => "ids",
            Self::Blocks => "blocks",
            Self::BvhNodes => "bvh nodes",
            Self::GridShape => "grid shape",
            Self::CellStarts => "cell starts",
            Self::CellLists => "cell lists",
            Self::VoxelTable => "voxel table",
            Self::VoxelBits => "voxel bits",
            Self::VoxelIndex => "voxel index",
            Self::VoxelStarts => "voxel starts",
            Self::VoxelLists => "voxel lists",
            Self::NestedGrids => "nested grids",
            Self::NestedCells => "nested cells",
            Self::OctreeNodes => "octree nodes",
            Self::BspNodes => "bsp nodes",
            Self::SphereNodes => "sphere nodes",
            Self::WideNodes => "wide nodes",
            Self::Wide4Nodes => "wide4 nodes",
            Self::Table => "section table",
        }
    }
}

/// The first rule that a blob breaks, and where.
///
/// ```
/// use flashray::{Scene, blob::Rule};
/// let error = Scene::from_bytes(&[]).unwrap_err();
/// assert_eq!(error.rule, Rule::Size);
/// let text = "rule 1, header: the bytes hold a whole header and section table (found 0, needed 80)";
/// assert_eq!(error.to_string(), text);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlobError {
    /// The rule.
    pub rule: Rule,
    /// The part of the blob.
    pub section: Section,
    /// The entry of that part, from 0.
    pub index: u32,
    /// What stands there, where a number says it.
    pub found: u32,
    /// What was needed: a least, a most or the very number, as the rule says.
    pub needed: u32,
}

impl BlobError {
    #[cold]
    pub(crate) const fn new(rule: Rule, section: Section) -> Self {
        Self { rule, section, index: 0, found: 0, needed: 0 }
    }

    pub(crate) const fn at(mut self, index: u32) -> Self {
        self.index = index;
        self
    }

    pub(crate) const fn found(mut self, found: u32) -> Self {
        self.found = found;
        self
    }

    pub(crate) const fn needed(mut self, needed: u32) -> Self {
        self.needed = needed;
        self
    }
}

impl fmt::Display for BlobError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "rule {}, {}", self.rule.number(), self.section.name())?;
        if !matches!(self.section, Section::Header) {
            write!(f, " entry {}", self.index)?;
        }
        write!(f, ": {}", self.rule.text())?;
        match self.rule {
            Rule::Checksum | Rule::Magic => {
                write!(f, " (found {:#010x}, needed {:#010x})", self.found, self.needed)
            }
            _ if self.found == 0 && self.needed == 0 => Ok(()),
            _ => write!(f, " (found {}, needed {})", self.found, self.needed),
        }
    }
}

impl core::error::Error for BlobError {}
