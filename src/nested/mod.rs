//! Hierarchy of grids.
//!
//! A grid over the scene, and in a cell of many primitives another grid just large enough for what they have in the
//! cell (Jevans and Wyvill, "Adaptive voxel subdivision for ray tracing", Graphics Interface 1989). A ray goes from
//! cell to cell ([`crate::walk::dda`]); where a cell holds a grid it first goes through that.
//!
//! Choose it for a scene whose primitives are of very different sizes, or crowd in a few places: there a uniform grid
//! has too few cells where it matters. It costs 4 bytes a cell, 44 a grid and 4 a reference.
//!
//! # Grid: 44 bytes
//! | offset | size | field | meaning |
//! |---|---|---|---|
//! | 0 | 12 | `min` | plane 0 of each axis |
//! | 12 | 12 | `cell` | size of a cell; plane `i` is at `min + i * cell` in `f32` |
//! | 24 | 12 | `cells` | number of cells along each axis: from 1 to 2^20 in grid 0, to 64 in the others |
//! | 36 | 4 | `first` | number of its first cell among the cells of all grids |
//! | 40 | 4 | `lists` | where the list of the cell that holds it would start; 0 for grid 0 |
//!
//! Grid 0 is the one over the scene. The others are numbered in the order of the cells that hold them. Cell
//! `(i, j, k)` of a grid has the number `first + (i * cells[1] + j) * cells[2] + k`. Its word is where its list starts
//! in the section of lists, or 2^31 plus the number of the grid in it. A list ends where that of the next cell starts;
//! where the next cell holds a grid, that grid says where. One word more than there are cells ends the last list.

#[cfg(feature = "build")]
pub mod build;
mod check;
mod walk;

use crate::blob::{Blob, BlobError, Rule, Section};
use crate::geom::Aabb;
use crate::geom::lattice::Lattice;
use crate::grid::Shape;
use crate::num::{count, index};
use crate::walk::Part;
use bytemuck::{Pod, Zeroable};

/// Most grids one in another, that of the scene included.
pub const MAX_LEVELS: u32 = 6;
/// Most cells along an axis of a grid in a cell.
pub const MOST_INNER: u32 = 64;
/// Set in the word of a cell that holds a grid.
const INNER: u32 = 1 << 31;

/// A grid's planes and cells, as the module's table says.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Grid {
    /// Where the planes are.
    pub lattice: Lattice,
    /// Number of cells along each axis.
    pub cells: [u32; 3],
    /// Number of the first cell.
    pub first: u32,
    /// Where the list of the cell that holds this grid would start.
    pub lists: u32,
}

const _: () = assert!(size_of::<Grid>() == 44);

impl Grid {
    /// Planes and cells as those of a uniform grid.
    #[inline(always)]
    #[must_use]
    pub const fn shape(&self) -> Shape {
        Shape { lattice: self.lattice, cells: self.cells, reserved: 0 }
    }

    /// Whether there are as few cells along each axis as a grid in a cell may have: what bounds the work of a step.
    #[inline(always)]
    #[must_use]
    pub(crate) const fn is_small(&self) -> bool {
        let [x, y, z] = self.cells;
        x >= 1 && x <= MOST_INNER && y >= 1 && y <= MOST_INNER && z >= 1 && z <= MOST_INNER
    }
}

/// What a cell holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell<'a> {
    /// Another grid, by number.
    Grid(u32),
    /// A list of slots, perhaps an empty one.
    List(&'a [u32]),
}

/// The grids in a blob; without one there is no cell, and the scene has no primitive.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// All grids, that of the scene first.
    pub grids: &'a [Grid],
    /// The words of all cells, and where the last list ends.
    pub words: &'a [u32],
    /// The slots listed.
    pub slots: &'a [u32],
}

impl<'a> View<'a> {
    /// The sections, O(1): rules 10 and 25, of the latter what concerns the grid over the scene.
    ///
    /// # Errors
    /// The first rule that is broken.
    pub fn parse(blob: &Blob<'a>) -> Result<Self, BlobError> {
        let (grids, words): (&[Grid], _) = (blob.section(Section::NestedGrids)?, blob.section(Section::NestedCells)?);
        let view = Self { grids, words, slots: blob.section(Section::CellLists)? };
        let header = blob.header();
        let broken = BlobError::new(Rule::Lattice, Section::NestedGrids).found(view.len());
        let Some((top, last)) = grids.first().zip(grids.last()) else {
            // No grid is one of no primitives, and then there is no cell and no list either.
            let empty = words.is_empty() && view.slots.is_empty() && header.prims == 0;
            return if empty { Ok(view) } else { Err(broken) };
        };
        let needed = last.shape().len().and_then(|n| last.first.checked_add(n)).unwrap_or(u32::MAX);
        let fits = top.first == 0 && top.lists == 0 && top.lattice.covers(&header.bounds, top.cells);
        if fits && needed == view.len() && needed < INNER { Ok(view) } else { Err(broken.needed(needed)) }
    }

    /// Number of cells.
    #[must_use]
    pub const fn len(&self) -> u32 {
        count(self.words.len().saturating_sub(1))
    }

    /// Whether there is no cell.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Most steps of a walk: every cell of every grid, and every reference.
    #[must_use]
    pub const fn steps(&self) -> u32 {
        self.len().saturating_add(count(self.slots.len()))
    }

    /// What a cell holds; `None` if there is no such cell, or its list is not in the section.
    #[inline(always)]
    #[must_use]
    pub fn get(&self, cell: u32) -> Option<Cell<'a>> {
        let at = index(cell);
        let word = *self.words.get(at)?;
        if word & INNER != 0 {
            return Some(Cell::Grid(word ^ INNER));
        }
        let end = self.start(*self.words.get(at.wrapping_add(1))?)?;
        self.slots.get(index(word)..index(end)).map(Cell::List)
    }

    /// Where the list of a cell of this word starts, or would start.
    #[inline(always)]
    fn start(&self, word: u32) -> Option<u32> {
        if word & INNER == 0 {
            return Some(word);
        }
        self.grids.get(index(word ^ INNER)).map(|grid| grid.lists)
    }

    /// Calls `each` with every cell, grid by grid; what holds another grid is an inner node.
    pub fn parts(&self, each: &mut impl FnMut(Part)) {
        // Grids of one level stand together, because they are numbered in the order of the cells that hold them.
        let (mut level, mut level_end, mut seen) = (1u32, 1, 1u32);
        // Grids that were not checked may share cells: no more are told of than there are.
        let mut left = self.words.len();
        for (number, grid) in self.grids.iter().enumerate() {
            if number >= level_end {
                (level, level_end) = (level.saturating_add(1), index(seen));
            }
            let shape = grid.shape();
            for at in 0..shape.len().unwrap_or(0) {
                let Some(cell) = self.get(grid.first.wrapping_add(at)) else { return };
                let Some(fewer) = left.checked_sub(1) else { return };
                left = fewer;
                let listed = match cell {
                    Cell::Grid(_) => None,
                    Cell::List(list) => Some(count(list.len())),
                };
                seen = seen.saturating_add(u32::from(listed.is_none()));
                each(Part { bounds: shape.bounds(shape.place(at)), level, listed });
            }
        }
    }

    /// The part of a box that lies in a cell of a grid: what a grid in that cell is to enclose.
    pub(crate) fn cut(bounds: &Aabb, cell: &Aabb) -> Aabb {
        use crate::geom::vec::{least3, most3};
        Aabb { min: most3(cell.min, bounds.min), max: least3(cell.max, bounds.max) }
    }
}
