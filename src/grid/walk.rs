//! The walk: cell by cell, nearest first.
//!
//! A hit beyond the cell it is found in is kept as the best so far, and the walk goes on until a cell is entered beyond
//! it; one that is entered at it is still visited, because a primitive there may have the lesser number.
use super::View;
use crate::blob::prims::Prims;
use crate::geom::ray::{Axis, Prepared};
use crate::walk::dda::{Cursor, Dda};
use crate::walk::{Best, Mailbox, Meter, Stop, test_listed};

/// The number of the cell that a walk is in, kept by addition.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Number {
    pub(crate) at: u32,
    strides: [u32; 3],
}

impl Number {
    pub(crate) const fn new(strides: [u32; 3]) -> Self {
        Self { at: 0, strides }
    }
}

impl Cursor for Number {
    fn put(&mut self, cell: [u32; 3]) {
        let part = |k: usize| cell[k].wrapping_mul(self.strides[k]);
        self.at = part(0).wrapping_add(part(1)).wrapping_add(part(2));
    }

    #[inline(always)]
    fn step(&mut self, axis: Axis, down: bool) {
        let stride = self.strides[axis.at()];
        self.at = if down { self.at.wrapping_sub(stride) } else { self.at.wrapping_add(stride) };
    }
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
        let Some(shape) = self.shape else { return Ok(false) };
        let mut number = Number::new(shape.strides());
        let Some(mut way) = Dda::start(ray, &shape.lattice, ([0; 3], shape.cells), best.t, &mut number) else {
            return Ok(false);
        };
        loop {
            if !meter.node() {
                return Err(Stop::Fuel);
            }
            meter.at(|| shape.bounds(shape.place(number.at)));
            let list = self.lists.get(number.at).ok_or(Stop::Corrupt)?;
            if !list.is_empty() && test_listed::<ANY>(prims, list, ray, best, meter, mailbox)? {
                return Ok(true);
            }
            if !way.advance(best.t, &mut number) {
                return Ok(false);
            }
        }
    }
}
