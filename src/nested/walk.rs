//! The walk: cell by cell, nearest first, and through the grid in a cell before the next cell.
//!
//! The ways through the grids around wait on a stack. As in a uniform grid a hit beyond its cell is kept as the best so
//! far, and bounds the ways of all grids from then on.
use super::{Cell, Grid, MAX_LEVELS, View};
use crate::blob::prims::Prims;
use crate::geom::ray::Prepared;
use crate::grid::walk::Number;
use crate::num::index;
use crate::walk::dda::Dda;
use crate::walk::{Best, Mailbox, Meter, Stop, test_listed};

/// A ray's way through one of the grids.
struct Way<'a> {
    grid: &'a Grid,
    /// The cell it is at, counted from the grid's first.
    number: Number,
    dda: Dda,
}

impl<'a> Way<'a> {
    /// At the first cell met; `None` if the ray meets none up to `t_max`.
    #[inline(always)]
    fn start(grid: &'a Grid, ray: &Prepared, t_max: f32) -> Option<Self> {
        let mut number = Number::new(grid.shape().strides());
        let dda = Dda::start(ray, &grid.lattice, ([0; 3], grid.cells), t_max, &mut number)?;
        Some(Self { grid, number, dda })
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
        let mut waiting = heapless::Vec::<Way<'_>, { index(MAX_LEVELS - 1) }>::new();
        // Grid 0 was looked at when the blob was loaded; it alone may have many cells along an axis.
        let Some(top) = self.grids.first() else { return Ok(false) };
        let Some(mut way) = Way::start(top, ray, best.t) else { return Ok(false) };
        loop {
            if !meter.node() {
                return Err(Stop::Fuel);
            }
            meter.at(|| {
                let shape = way.grid.shape();
                shape.bounds(shape.place(way.number.at))
            });
            match self.get(way.grid.first.wrapping_add(way.number.at)).ok_or(Stop::Corrupt)? {
                Cell::List(list) => {
                    if !list.is_empty() && test_listed::<ANY>(prims, list, ray, best, meter, mailbox)? {
                        return Ok(true);
                    }
                }
                Cell::Grid(number) => {
                    let grid = self.grids.get(index(number)).filter(|g| g.is_small()).ok_or(Stop::Corrupt)?;
                    if let Some(inner) = Way::start(grid, ray, best.t) {
                        waiting.push(core::mem::replace(&mut way, inner)).map_err(|_| Stop::Corrupt)?;
                        continue;
                    }
                }
            }
            while !way.dda.advance(best.t, &mut way.number) {
                match waiting.pop() {
                    Some(around) => way = around,
                    None => return Ok(false),
                }
            }
        }
    }
}
