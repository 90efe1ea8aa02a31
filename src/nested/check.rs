//! The proof that a walk's answers are right.
//!
//! First that the grids make a tree whose cells and lists fill their sections, in one pass over the cells with running
//! counts. Then, for each primitive, that every cell that it has a part in leads to it: down from grid to grid.
use super::{Cell, Grid, INNER, MAX_LEVELS, View};
use crate::blob::lists::Order;
use crate::blob::prims::{Primitive, Prims};
use crate::blob::{BlobError, Rule, Section};
use crate::geom::Aabb;
use crate::grid::touched::Touched;
use crate::num::{count, index};

/// A grid that a primitive is looked for in.
struct Visit {
    cells: Touched,
    /// Its first cell.
    base: u32,
}

impl Visit {
    fn new(grid: &Grid, part: &Aabb) -> Self {
        Self { cells: Touched::new(&grid.shape(), part), base: grid.first }
    }

    /// The next cell: its number and its box.
    fn step(&mut self, p: &Primitive) -> Option<(u32, Aabb)> {
        let (_, number, bounds) = self.cells.step(p)?;
        Some((self.base.wrapping_add(number), bounds))
    }
}

impl View<'_> {
    /// The full check: rules 23, 25 to 28, 35 and 36. Returns the deepest stack, that is, how many grids there are
    /// around the innermost one.
    ///
    /// # Errors
    /// The first rule that is broken, and where.
    pub fn check(&self, prims: &Prims<'_>) -> Result<u32, BlobError> {
        let Some(top) = self.grids.first() else { return Ok(0) };
        let stack = self.check_tree()?;
        let mut order = Order::new(Section::CellLists);
        for cell in 0..self.len() {
            if let Some(Cell::List(list)) = self.get(cell) {
                order.list(list.iter().copied())?;
            }
        }
        order.end(prims.len)?;
        for slot in 0..prims.len {
            if let Some(p) = prims.get(slot) {
                self.check_listed(top, slot, &p)?;
            }
        }
        Ok(stack)
    }

    /// Rules 23, 25, 26 and 35: grids, cells and lists in their order.
    fn check_tree(&self) -> Result<u32, BlobError> {
        let (mut level, mut level_end, mut next_grid) = (0u32, 1u32, 1u32);
        let (mut next_cell, mut end) = (0u32, 0u32);
        for (number, grid) in (0u32..).zip(self.grids) {
            if number == level_end {
                (level, level_end) = (level.saturating_add(1), next_grid);
            }
            let broken = |rule| BlobError::new(rule, Section::NestedGrids).at(number);
            // Some cell before those of this grid holds it.
            if number >= next_grid {
                return Err(broken(Rule::GridOrder).found(number).needed(next_grid));
            }
            if level >= MAX_LEVELS {
                return Err(broken(Rule::StackTrue).found(level).needed(MAX_LEVELS - 1));
            }
            let fair = number == 0 || (grid.is_small() && grid.lattice.covers(&Aabb::EMPTY, grid.cells));
            if !fair || grid.first != next_cell {
                return Err(broken(Rule::Lattice).found(grid.first).needed(next_cell));
            }
            let last = grid.shape().len().and_then(|n| next_cell.checked_add(n)).filter(|&n| n <= self.len());
            let last = last.ok_or(broken(Rule::Lattice).found(next_cell).needed(self.len()))?;
            for cell in next_cell..last {
                self.check_cell(cell, &mut next_grid, &mut end)?;
            }
            next_cell = last;
        }
        let (grids, slots) = (count(self.grids.len()), count(self.slots.len()));
        if next_grid != grids {
            return Err(BlobError::new(Rule::GridOrder, Section::NestedGrids).at(grids).found(grids).needed(next_grid));
        }
        // The last grid's end is that of the cells: so it was loaded.
        let last = self.words.last().copied().unwrap_or(0);
        if end != slots || last != slots {
            return Err(BlobError::new(Rule::ListPlace, Section::NestedCells).at(self.len()).found(last).needed(slots));
        }
        Ok(level)
    }

    /// A cell holds the next grid, or the next list; `end` is where the lists before end.
    fn check_cell(&self, cell: u32, next_grid: &mut u32, end: &mut u32) -> Result<(), BlobError> {
        let word = self.words.get(index(cell)).copied().unwrap_or(0);
        let broken = |rule| BlobError::new(rule, Section::NestedCells).at(cell);
        if word & INNER != 0 && (word ^ INNER != *next_grid || index(*next_grid) >= self.grids.len()) {
            return Err(broken(Rule::GridOrder).found(word ^ INNER).needed(*next_grid));
        }
        let start = self.start(word).unwrap_or(u32::MAX);
        if start != *end {
            return Err(broken(Rule::ListPlace).found(start).needed(*end));
        }
        match self.get(cell) {
            Some(Cell::Grid(_)) => *next_grid = next_grid.saturating_add(1),
            Some(Cell::List(list)) => *end = end.saturating_add(count(list.len())),
            None => return Err(broken(Rule::ListPlace).found(start).needed(count(self.slots.len()))),
        }
        Ok(())
    }

    /// Rules 28 and 36 for one primitive.
    fn check_listed(&self, top: &Grid, slot: u32, p: &Primitive) -> Result<(), BlobError> {
        let own = p.bounds();
        let mut visits = heapless::Vec::<Visit, { index(MAX_LEVELS) }>::new();
        let mut visit = Visit::new(top, &own);
        loop {
            let Some((cell, bounds)) = visit.step(p) else {
                match visits.pop() {
                    Some(around) => visit = around,
                    None => return Ok(()),
                }
                continue;
            };
            let broken = |rule| BlobError::new(rule, Section::NestedCells).at(cell).needed(slot);
            match self.get(cell) {
                Some(Cell::List(list)) if list.binary_search(&slot).is_ok() => {}
                _ if !p.overlaps(&bounds) => {}
                Some(Cell::Grid(number)) => {
                    let grid = self.grids.get(index(number)).ok_or(broken(Rule::GridOrder))?;
                    let part = Self::cut(&own, &bounds);
                    let all = grid.lattice.bounds([0; 3], grid.cells);
                    if !all.contains(&part) {
                        return Err(BlobError::new(Rule::GridBounds, Section::NestedGrids).at(number).needed(slot));
                    }
                    let around = core::mem::replace(&mut visit, Visit::new(grid, &part));
                    visits.push(around).map_err(|_| broken(Rule::StackTrue))?;
                }
                _ => return Err(broken(Rule::ListComplete)),
            }
        }
    }
}
