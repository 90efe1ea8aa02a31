//! Why a build failed.
use core::fmt;

/// A part of the memory that a build works in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum What {
    /// The arena's references, one per primitive.
    Refs,
    /// The arena's nodes.
    Nodes,
    /// The arena's words for cells.
    Cells,
    /// The arena's words for listed primitives.
    Slots,
    /// The output buffer, in bytes.
    Out,
}

/// Why a build failed. Nothing was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BuildError {
    /// The caller's memory is too small.
    Full {
        /// Which part.
        what: What,
        /// What would be enough.
        needed: usize,
        /// What there was.
        had: usize,
    },
    /// A triangle names a vertex that does not exist.
    Index {
        /// The triangle.
        triangle: u32,
        /// The vertex that it names.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A primitive has a NaN or infinite number, a negative radius, a box with `min > max`, or an unknown flag; or it
    /// goes beyond 2^126 along an axis, counted from the local origin.
    Primitive {
        /// Its number.
        prim: u32,
    },
    /// There are 2^28 primitives or more, or the blob would be 4 GiB or longer; or a grid of the resolution asked for
    /// would have 2^28 cells or references or more (of voxels, 2^32 cells; with [`Rule::Seed`](super::Rule::Seed)
    /// 2^31).
    TooLarge,
    /// The leaf size is not from 1 to 15.
    Leaf {
        /// What it is.
        found: u32,
    },
    /// The width is neither 8 nor 4, or the structure is not wide.
    Width {
        /// What it is.
        found: u32,
    },
    /// There are more than 1024 cells along the longest side.
    Cells {
        /// How many.
        found: u32,
    },
    /// The local origin is not finite.
    Local,
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Full { what, needed, had } => {
                let what = match what {
                    What::Refs => "the arena's references are",
                    What::Nodes => "the arena's nodes are",
                    What::Cells => "the arena's words for cells are",
                    What::Slots => "the arena's words for listed primitives are",
                    What::Out => "the output buffer is",
                };
                write!(f, "{what} full: {needed} needed, {had} there")
            }
            Self::Index { triangle, vertex, vertices } => {
                write!(f, "triangle {triangle} names vertex {vertex}, but there are {vertices}")
            }
            Self::Primitive { prim } => write!(
                f,
                "primitive {prim} is not one: a number that is NaN, infinite or too large, a negative radius, or min > max"
            ),
            Self::TooLarge => f.write_str(
                "too large: a blob holds fewer than 2^28 primitives, cells of a grid and references, and 2^32 bytes",
            ),
            Self::Leaf { found } => write!(f, "a leaf of {found} primitives: 1 to 15 are possible"),
            Self::Width { found } => {
                write!(f, "a width of {found}: 8 and 4 are possible, of the structure `wide` alone")
            }
            Self::Cells { found } => write!(f, "{found} cells along the longest side: up to 1024 are possible"),
            Self::Local => f.write_str("the local origin is not finite"),
        }
    }
}

impl core::error::Error for BuildError {}
