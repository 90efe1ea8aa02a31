//! Uniform grid.
//!
//! The box around the scene is parted into cells of one size, and each cell lists the primitives that have a part in it
//! (Fujimoto, Tanaka and Iwata, "ARTS: Accelerated Ray-Tracing System", IEEE CG&A 6(4), 1986). A ray goes from cell to
//! cell ([`crate::walk::dda`]). Lists stand end to end in one array, found by one offset per cell: the compact grid of
//! Lagae and Dutre, "Compact, Fast and Robust Grids for Ray Tracing", CGF 27(4), 2008.
//!
//! Choose it for primitives of one size spread evenly. It does not adapt: a small busy part of a large scene falls into
//! a few cells. It costs 4 bytes a cell and 4 a reference, and no stack.
//!
//! # Shape: 40 bytes
//! | offset | size | field | meaning |
//! |---|---|---|---|
//! | 0 | 12 | `min` | plane 0 of each axis |
//! | 12 | 12 | `cell` | size of a cell; plane `i` is at `min + i * cell` in `f32` |
//! | 24 | 12 | `cells` | number of cells along each axis, from 1 to 2^20 |
//! | 36 | 4 | `reserved` | 0 |
//!
//! Cell `(i, j, k)` has the number `(i * cells[1] + j) * cells[2] + k`.

#[cfg(feature = "build")]
pub mod build;
pub mod touched;
pub(crate) mod walk;

use crate::blob::lists::Lists;
use crate::blob::prims::{Primitive, Prims};
use crate::blob::{Blob, BlobError, Rule, Section};
use crate::geom::Aabb;
use crate::geom::lattice::Lattice;
use crate::num::{count, index};
use crate::walk::Part;
use bytemuck::{Pod, Zeroable};
use touched::Touched;

/// A grid's planes and cells, as the module's table says.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Shape {
    /// Where the planes are.
    pub lattice: Lattice,
    /// Number of cells along each axis.
    pub cells: [u32; 3],
    /// 0.
    pub reserved: u32,
}

const _: () = assert!(size_of::<Shape>() == 40);

impl Shape {
    /// Number of cells; `None` from 2^32 on.
    #[must_use]
    pub const fn len(&self) -> Option<u32> {
        let [x, y, z] = self.cells;
        match x.checked_mul(y) {
            Some(xy) => xy.checked_mul(z),
            None => None,
        }
    }

    /// Whether there is no cell.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == Some(0)
    }

    /// What a cell's number grows by for a step along each axis.
    #[inline(always)]
    #[must_use]
    pub const fn strides(&self) -> [u32; 3] {
        let [_, y, z] = self.cells;
        [y.wrapping_mul(z), z, 1]
    }

    /// The place of a cell, by its number.
    #[must_use]
    pub fn place(&self, number: u32) -> [u32; 3] {
        let [_, y, z] = self.cells.map(|n| n.max(1));
        [number / z / y, number / z % y, number % z]
    }

    /// The box of a cell.
    #[must_use]
    pub fn bounds(&self, cell: [u32; 3]) -> Aabb {
        self.lattice.bounds(cell, cell.map(|i| i.saturating_add(1)))
    }

    /// Calls `each` with place, number and box of every cell that the box of a primitive, cut to `part`, touches, but
    /// for those that cannot overlap it; stops at an error.
    ///
    /// # Errors
    /// The first of `each`.
    pub fn touched<E>(
        &self,
        prim: &Primitive,
        part: &Aabb,
        mut each: impl FnMut([u32; 3], u32, &Aabb) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut cells = Touched::new(self, part);
        while let Some((place, number, bounds)) = cells.step(prim) {
            each(place, number, &bounds)?;
        }
        Ok(())
    }

    /// The one entry of a section, with what can be said of it in O(1): rules 7, 10 and 25.
    ///
    /// # Errors
    /// The first rule that is broken.
    pub fn parse<'a>(blob: &Blob<'a>, bounds: &Aabb) -> Result<Option<&'a Self>, BlobError> {
        let shapes: &[Self] = blob.section(Section::GridShape)?;
        let broken = |rule| BlobError::new(rule, Section::GridShape);
        match shapes {
            [] => Ok(None),
            [shape] if shape.reserved != 0 => Err(broken(Rule::Reserved)),
            [shape] if !shape.lattice.covers(bounds, shape.cells) => Err(broken(Rule::Lattice)),
            [shape] => Ok(Some(shape)),
            _ => Err(broken(Rule::SectionLength).found(count(shapes.len())).needed(1)),
        }
    }
}

/// The grid in a blob; without a shape it has no cell, and the scene no primitive.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Planes and cells.
    pub shape: Option<&'a Shape>,
    /// The list of each cell.
    pub lists: Lists<'a>,
}

impl<'a> View<'a> {
    /// The sections, O(1): rules 7, 10 and 25.
    ///
    /// # Errors
    /// The first rule that is broken.
    pub fn parse(blob: &Blob<'a>) -> Result<Self, BlobError> {
        let shape = Shape::parse(blob, &blob.header().bounds)?;
        let lists = Lists::parse(blob)?;
        let needed = shape.map_or(Some(0), Shape::len);
        let fits = needed.is_some_and(|n| index(n) == lists.len());
        // A grid of no cells is one of no primitives.
        if !fits || (shape.is_none() && blob.header().prims > 0) {
            let error = BlobError::new(Rule::Lattice, Section::GridShape).found(count(lists.len()));
            return Err(error.needed(needed.unwrap_or(u32::MAX)));
        }
        Ok(Self { shape, lists })
    }

    /// Most steps of a walk: every cell, and every reference.
    #[must_use]
    pub const fn steps(&self) -> u32 {
        count(self.lists.len()).saturating_add(count(self.lists.slots.len()))
    }

    /// Calls `each` with every cell.
    pub fn parts(&self, each: &mut impl FnMut(Part)) {
        let Some(shape) = self.shape else { return };
        for cell in 0..count(self.lists.len()) {
            let listed = self.lists.get(cell).map(|list| count(list.len()));
            each(Part { bounds: shape.bounds(shape.place(cell)), level: 1, listed });
        }
    }

    /// The full check: rules 26 to 28. A walk needs no stack.
    ///
    /// # Errors
    /// The first rule that is broken, and where.
    pub fn check(&self, prims: &Prims<'_>) -> Result<u32, BlobError> {
        self.lists.check(prims)?;
        for slot in 0..prims.len {
            if let (Some(shape), Some(p)) = (self.shape, prims.get(slot)) {
                shape.touched(&p, &p.bounds(), |_, cell, bounds| self.lists.check_listed(cell, bounds, slot, prims))?;
            }
        }
        Ok(0)
    }
}
