//! The walks: voxel by voxel, or block by block and within a block voxel by voxel, nearest first.
//!
//! A hit beyond the voxel it is found in is kept, as in [`crate::grid`]. A block's planes are voxels' planes, bit by
//! bit, and a box inside another has its interval inside the other's: so every voxel whose interval is not empty lies
//! in a block of which the same is true, and the walk over blocks comes to it before it meets one beyond the best hit.
use super::blocks::{At, STRIDES};
use super::{Block, Blocks, Flat, Form, View, Voxels};
use crate::blob::prims::Prims;
use crate::geom::ray::Prepared;
use crate::grid::walk::Number;
use crate::num::index;
use crate::walk::dda::{Cursor, Dda};
use crate::walk::{Best, Mailbox, Meter, Stop, test_listed};

/// Slots that are unpacked at a time.
const PIECE: u32 = 16;

/// A query on its way: what every step needs.
struct Query<'q, M, B> {
    voxels: &'q Voxels<'q>,
    prims: &'q Prims<'q>,
    ray: &'q Prepared,
    best: &'q mut Best,
    meter: &'q mut M,
    mailbox: &'q mut B,
}

impl View<'_> {
    /// Finds the closest hit, or with `ANY` whether there is one. Returns whether the walk ended at a hit.
    ///
    /// # Errors
    /// [`Stop`] if the meter runs out or the bytes contradict themselves.
    // Out of line everywhere: a query has one function for all structures, whose stack would be that of the deepest.
    #[inline(never)]
    pub fn walk<const ANY: bool>(
        &self,
        prims: &Prims<'_>,
        ray: &Prepared,
        best: &mut Best,
        meter: &mut impl Meter,
        mailbox: &mut impl Mailbox,
    ) -> Result<bool, Stop> {
        let Some(voxels) = &self.voxels else { return Ok(false) };
        let mut query = Query { voxels, prims, ray, best, meter, mailbox };
        match &voxels.form {
            Form::Flat(flat) => query.flat::<ANY>(flat),
            Form::Blocks(blocks) => query.blocks::<ANY>(blocks),
        }
    }
}

impl<M: Meter, B: Mailbox> Query<'_, M, B> {
    fn flat<const ANY: bool>(&mut self, flat: &Flat<'_>) -> Result<bool, Stop> {
        let shape = self.voxels.shape;
        let mut at = flat.cursor();
        let Some(mut way) = Dda::start(self.ray, &shape.lattice, ([0; 3], shape.cells), self.best.t, &mut at) else {
            return Ok(false);
        };
        loop {
            if !self.meter.node() {
                return Err(Stop::Fuel);
            }
            self.meter.at(|| shape.bounds(shape.place(at.voxel)));
            if flat.has(at.voxel).ok_or(Stop::Corrupt)? {
                let entry = flat.find(at.slot, at.tag).ok_or(Stop::Corrupt)?;
                if self.list::<ANY>(entry)? {
                    return Ok(true);
                }
            }
            if !way.advance(self.best.t, &mut at) {
                return Ok(false);
            }
        }
    }

    fn blocks<const ANY: bool>(&mut self, blocks: &Blocks<'_>) -> Result<bool, Stop> {
        let shape = blocks.shape();
        let mut at = At { place: [0; 3], number: Number::new(shape.strides()) };
        let Some(mut way) = Dda::start(self.ray, &shape.lattice, ([0; 3], shape.cells), self.best.t, &mut at) else {
            return Ok(false);
        };
        loop {
            if !self.meter.node() {
                return Err(Stop::Fuel);
            }
            let grid = self.voxels.shape;
            self.meter.at(|| {
                let (first, last) = blocks.cells(grid, at.place);
                grid.lattice.bounds(first, last)
            });
            if let Some(block) = blocks.block(at.number.at)?
                && self.block::<ANY>(blocks, &block, blocks.cells(grid, at.place))?
            {
                return Ok(true);
            }
            if !way.advance(self.best.t, &mut at) {
                return Ok(false);
            }
        }
    }

    /// The voxels of a block.
    fn block<const ANY: bool>(
        &mut self,
        blocks: &Blocks<'_>,
        block: &Block,
        cells: ([u32; 3], [u32; 3]),
    ) -> Result<bool, Stop> {
        let shape = self.voxels.shape;
        let mut number = Number::new(STRIDES);
        number.put(cells.0);
        let corner = number.at;
        let Some(mut way) = Dda::start(self.ray, &shape.lattice, cells, self.best.t, &mut number) else {
            return Ok(false);
        };
        // Counted when it is needed: many a ray crosses a block and meets none of its lists.
        let mut first = None;
        loop {
            if !self.meter.node() {
                return Err(Stop::Fuel);
            }
            let bit = number.at.wrapping_sub(corner);
            self.meter.at(|| shape.bounds(Blocks::cell(cells.0, bit)));
            if block.has(bit) {
                let first = match first {
                    Some(first) => first,
                    None => *first.insert(blocks.first(block).ok_or(Stop::Corrupt)?),
                };
                if self.list::<ANY>(Blocks::after(block, first, bit))? {
                    return Ok(true);
                }
            }
            if !way.advance(self.best.t, &mut number) {
                return Ok(false);
            }
        }
    }

    /// Tests the primitives of a list.
    #[inline(always)]
    fn list<const ANY: bool>(&mut self, entry: u32) -> Result<bool, Stop> {
        let lists = &self.voxels.lists;
        let (mut first, last) = lists.place(entry).ok_or(Stop::Corrupt)?;
        while first < last {
            let n = (last - first).min(PIECE);
            let mut piece = [0; index(PIECE)];
            for (place, i) in piece.iter_mut().zip(first..first.wrapping_add(n)) {
                *place = lists.slots.get(i).ok_or(Stop::Corrupt)?;
            }
            let piece = piece.get(..index(n)).ok_or(Stop::Corrupt)?;
            if test_listed::<ANY>(self.prims, piece, self.ray, self.best, self.meter, self.mailbox)? {
                return Ok(true);
            }
            first = first.wrapping_add(n);
        }
        Ok(false)
    }
}
