//! The builder: a grid over the scene, then cell by cell another grid where that pays.
//!
//! Grids wait in a queue, which is also the order of their numbers. A cell of more primitives than
//! [`Config::threshold`] may get a grid. `Rule::Seed` gives one to each, as the lecture's drawing does, of about a cell
//! a primitive. `Rule::Sah` weighs several densities: a line that meets a cell meets a cell in it with the share of
//! their areas (`MacDonald` and Booth, "Heuristics for ray tracing using space subdivision", The Visual Computer 6,
//! 1990), so the expected steps and tests of a grid are known from its references, and a cell is parted if they are
//! fewer than the tests of its list.
//!
//! No scene makes it run away: a grid is kept only if it parts its primitives, grids are at most six deep, and cells,
//! grids and references have a budget of so many a primitive. That is the memory that is asked for: nothing can be
//! counted before it is built.
use super::{Grid, INNER, MAX_LEVELS, MOST_INNER, View};
use crate::blob::Section;
use crate::build::parts::{Parts, number_slots};
use crate::build::{BuildError, Config, Input, Ref, Rule, sah};
use crate::geom::Aabb;
use crate::geom::lattice::{Lattice, resolution};
use crate::geom::vec::{size, sub};
use crate::grid::build::{Choice, STEP_COST};
use crate::grid::{self, Shape};
use crate::num::{count, float, index, weight};
use core::ops::Range;

/// Words of a grid.
const GRID_WORDS: usize = size_of::<Grid>() / 4;
/// Most primitives of a cell that the seed's rule leaves whole, if the caller does not say: the lecture's drawing.
const SEED_LEFT: u32 = 2;
/// Cells that the seed's rule parts a cell into at least: two along each axis.
const SEED_CELLS: f32 = 8.0;
/// References for each one in the list that it replaces, that a grid of the seed's rule may take.
const MOST_GROWTH: usize = 4;
/// How the grid over the scene is chosen: finer ones saved few tests for many steps.
const TOP: Choice = Choice { densities: &[1.0, 2.0], ..Choice::SAH };
/// Cells a primitive of the grids in cells that are tried.
const DENSITIES: [f32; 4] = [1.0, 2.0, 4.0, 8.0];
/// Cost of entering a grid, in triangle tests.
const ENTRY_COST: f32 = 24.0;
/// Most primitives of a cell that are not worth a grid, if the caller does not say.
const SAH_LEFT: u32 = 4;
/// References by the boxes of the primitives, for each one in the list, that a grid may have to be considered.
const MOST_TOUCHED: f32 = 8.0;
/// Budget of cells in cells, and of references to primitives in them, that of replaced lists included, a primitive.
const BUDGET: usize = 16;

/// The grid over the scene, and what those in its cells may take.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    rule: Rule,
    /// Most primitives of a cell that gets no grid.
    left: usize,
    top: grid::build::Plan,
    prims: usize,
}

impl Plan {
    /// Chooses the resolution of the grid over the scene, and counts it.
    ///
    /// # Errors
    /// [`BuildError::TooLarge`] if there are 2^28 cells or references, or more.
    pub fn new(input: &Input<'_>, config: &Config) -> Result<Self, BuildError> {
        let rule = config.rule;
        let left = match (config.threshold, rule) {
            (0, Rule::Seed) => SEED_LEFT,
            (0, Rule::Sah) => SAH_LEFT,
            (asked, _) => asked,
        };
        let choice = if rule == Rule::Seed { &Choice::SEED } else { &TOP };
        let top = grid::build::Plan::with(input, config, choice)?;
        Ok(Self { rule, left: index(left), top, prims: index(input.len) })
    }

    /// Most grids.
    const fn grids(&self) -> usize {
        if self.prims == 0 { 0 } else { 1 + self.prims }
    }

    /// Words of [`crate::build::Arena::cells`].
    #[must_use]
    pub const fn words(&self) -> usize {
        let cells = if self.prims == 0 { 0 } else { index(self.top.cells) + self.prims * BUDGET + 1 };
        self.grids() * GRID_WORDS + cells
    }

    /// Words of [`crate::build::Arena::slots`].
    #[must_use]
    pub const fn listed(&self) -> usize {
        index(self.top.listed) + self.prims * BUDGET
    }
}

/// What is built so far.
struct Work<'p> {
    rule: Rule,
    left: usize,
    /// In [`Grid::lists`] the number of the cell that holds the grid.
    grids: &'p mut [Grid],
    /// Where each cell's list starts, whether it holds a grid or not, and where the last one ends.
    starts: &'p mut [u32],
    /// The lists of primitives, those that grids have replaced among them.
    listed: &'p mut [u32],
    grid_count: usize,
    cell_count: usize,
    listed_count: usize,
}

/// Builds what a plan says. `words` and `slots` are as long as it says.
pub fn build<'p>(
    input: &Input<'_>,
    plan: &Plan,
    refs: &'p mut [Ref],
    words: &'p mut [u32],
    slots: &'p mut [u32],
) -> Parts<'p> {
    let Some((head, starts)) = words.split_at_mut_checked(plan.grids() * GRID_WORDS) else { return Parts::default() };
    let (Plan { rule, left, .. }, grids, listed) = (*plan, bytemuck::cast_slice_mut(head), slots);
    let mut work = Work { rule, left, grids, starts, listed, grid_count: 0, cell_count: 0, listed_count: 0 };
    if plan.prims == 0 || work.append(input, &plan.top.shape, 0, None, usize::MAX, |_, _| true).is_none() {
        return Parts::default();
    }
    let stack = work.divide_all(input);
    work.compact();
    let Work { grids, starts, listed, grid_count, cell_count, listed_count, .. } = work;
    let (grids, _) = grids.split_at_mut(grid_count);
    let (starts, _) = starts.split_at_mut(cell_count + 1);
    let (listed, _) = listed.split_at_mut(listed_count);
    let order = number_slots(starts, listed, refs);
    // The lists are in place: what holds a grid may say so.
    for (number, grid) in grids.iter_mut().enumerate().skip(1) {
        if let Some(word) = starts.get_mut(index(grid.lists)) {
            (grid.lists, *word) = (*word, INNER | count(number));
        }
    }
    let mut parts = Parts::new(order, stack, count(cell_count).saturating_add(count(listed_count)));
    parts.push(Section::CellLists, listed, 1);
    parts.push(Section::NestedGrids, bytemuck::cast_slice(grids), GRID_WORDS);
    parts.push(Section::NestedCells, starts, 1);
    parts
}

impl Work<'_> {
    /// Parts cells for as long as it pays. Returns how many grids there are around the innermost one.
    fn divide_all(&mut self, input: &Input<'_>) -> u32 {
        let (mut number, mut level, mut level_end) = (0, 0, 1);
        while number < self.grid_count {
            if number == level_end {
                (level, level_end) = (level + 1, self.grid_count);
            }
            let Some(&grid) = self.grids.get(number) else { break };
            if level + 1 >= MAX_LEVELS {
                break;
            }
            let shape = grid.shape();
            for at in 0..shape.len().unwrap_or(0) {
                // A cell that can not be parted stays as it is.
                let _ = self.divide(input, grid.first + at, &shape.bounds(shape.place(at)));
            }
            number += 1;
        }
        level
    }

    /// Puts a grid in a cell; `None` if that does not pay, or there is no room for it.
    fn divide(&mut self, input: &Input<'_>, cell: u32, bounds: &Aabb) -> Option<()> {
        let (first, last) = (*self.starts.get(index(cell))?, *self.starts.get(index(cell) + 1)?);
        let list = self.listed.get(index(first)..index(last))?;
        let (rule, n) = (self.rule, list.len());
        if n <= self.left || self.grid_count == self.grids.len() {
            return None;
        }
        let shape = choose(rule, input, list, bounds)?;
        let most = if rule == Rule::Seed { n * MOST_GROWTH } else { usize::MAX };
        let keep = |listed: u32, longest: u32| {
            let pays = rule == Rule::Seed || cost(input, &shape, bounds, float(listed)) < weight(n) * input.test_cost();
            pays && index(longest) < n
        };
        self.append(input, &shape, cell, Some(&(index(first)..index(last), bounds)), most, keep)
    }

    /// Adds a grid for all primitives, or for those of a list in the box of a cell. `None`, and nothing added, if there
    /// is no room, there are more than `most` references, or `keep` does not like their number and the longest list's.
    fn append(
        &mut self,
        input: &Input<'_>,
        shape: &Shape,
        cell: u32,
        source: Option<&(Range<usize>, &Aabb)>,
        most: usize,
        keep: impl Fn(u32, u32) -> bool,
    ) -> Option<()> {
        let cells = index(shape.len()?);
        let starts = self.starts.get_mut(self.cell_count..)?.get_mut(..=cells)?;
        let (old, fresh) = self.listed.split_at_mut_checked(self.listed_count)?;
        let list = |each: Each<'_>| match source {
            None => input.listings(shape, |cell, prim| {
                each(cell, prim);
            }),
            Some((range, bounds)) => listings(input, old.get(range.clone()).unwrap_or(&[]), shape, bounds, each),
        };
        let base = count(self.listed_count);
        let listed =
            count_lists(starts, count(most.min(fresh.len())), list).filter(|&(sum, longest)| keep(sum, longest));
        let Some((sum, _)) = listed else {
            starts.fill(base);
            return None;
        };
        fill_lists(starts, base, fresh, list);
        let first = count(self.cell_count);
        *self.grids.get_mut(self.grid_count)? = Grid { lattice: shape.lattice, cells: shape.cells, first, lists: cell };
        self.grid_count += 1;
        self.cell_count += cells;
        self.listed_count += index(sum);
        Some(())
    }

    /// Takes out the lists that grids have replaced.
    fn compact(&mut self) {
        let (mut end, mut next) = (0, 1);
        for cell in 0..self.cell_count {
            let (Some(&first), Some(&last)) = (self.starts.get(cell), self.starts.get(cell + 1)) else { return };
            if let Some(start) = self.starts.get_mut(cell) {
                *start = count(end);
            }
            if next < self.grid_count && self.grids.get(next).is_some_and(|grid| index(grid.lists) == cell) {
                next += 1;
                continue;
            }
            self.listed.copy_within(index(first)..index(last), end);
            end += index(last - first);
        }
        if let Some(last) = self.starts.get_mut(self.cell_count) {
            *last = count(end);
        }
        self.listed_count = end;
    }
}

/// Told of a cell and a primitive in it; says whether to go on.
type Each<'e> = &'e mut dyn FnMut(u32, u32) -> bool;

/// Counts the list of each cell: how many references there are, and how long the longest list is. `None` beyond `most`:
/// where every primitive touches every cell, counting to the end would take as long as both numbers multiplied.
fn count_lists(starts: &mut [u32], most: u32, list: impl Fn(Each<'_>)) -> Option<(u32, u32)> {
    starts.fill(0);
    let mut sum = 0;
    list(&mut |cell, _| {
        if let Some(n) = starts.get_mut(index(cell)) {
            *n += 1;
        }
        sum += 1;
        sum <= most
    });
    (sum <= most).then(|| (sum, starts.iter().fold(0, |longest, &n| n.max(longest))))
}

/// Turns counts into where lists start, from `base`, and writes the lists: each cell's entry becomes the start of its
/// list, and filling moves it to the end.
fn fill_lists(starts: &mut [u32], base: u32, listed: &mut [u32], list: impl Fn(Each<'_>)) {
    let mut end = base;
    for start in starts.iter_mut() {
        (*start, end) = (end, end + *start);
    }
    list(&mut |cell, prim| {
        if let Some(next) = starts.get_mut(index(cell)) {
            if let Some(place) = listed.get_mut(index(*next - base)) {
                *place = prim;
            }
            *next += 1;
        }
        true
    });
    starts.copy_within(..starts.len() - 1, 1);
    if let Some(first) = starts.first_mut() {
        *first = base;
    }
}

/// Calls `each` with every cell of a grid in a cell and every primitive of its list that has a part in it, for as long
/// as it wants.
fn listings(input: &Input<'_>, list: &[u32], shape: &Shape, around: &Aabb, each: Each<'_>) {
    for &number in list {
        let prim = input.prim(number);
        let listed = shape.touched(&prim, &View::cut(&prim.bounds(), around), |_, cell, bounds| {
            if !prim.overlaps(bounds) || each(cell, number) { Ok(()) } else { Err(()) }
        });
        if listed.is_err() {
            return;
        }
    }
}

/// The grid for the primitives of a list in a cell, just large enough: as fine as the rule says. `None` if it would
/// have one cell, or list too much by the boxes of the primitives.
fn choose(rule: Rule, input: &Input<'_>, list: &[u32], bounds: &Aabb) -> Option<Shape> {
    let part = |number: u32| View::cut(&input.prim(number).bounds(), bounds);
    let all = list.iter().fold(Aabb::EMPTY, |all, &number| all.join(&part(number)));
    // A million in one place: what fills the cell in the same way no grid can part, and weighing many would take long.
    if list.iter().all(|&number| part(number) == all) {
        return None;
    }
    let n = weight(list.len());
    let shape = |total: f32| {
        let cells = resolution(&all, total, MOST_INNER);
        Shape { lattice: Lattice::over(&all, cells), cells, reserved: 0 }
    };
    if rule == Rule::Seed {
        return Some(shape(if n > SEED_CELLS { n } else { SEED_CELLS })).filter(|s| s.cells != [1; 3]);
    }
    let mut best: Option<(f32, Shape)> = None;
    for density in DENSITIES {
        let shape = shape(n * density);
        let listed = list.iter().fold(0.0, |sum, &number| sum + touched(&shape, &part(number)));
        let cost = cost(input, &shape, bounds, listed);
        let fair = shape.cells != [1; 3] && listed <= n * MOST_TOUCHED;
        // Also passes over the NaN of a box without area.
        if fair && best.as_ref().map_or(cost >= 0.0, |(least, _)| cost < *least) {
            best = Some((cost, shape));
        }
    }
    best.map(|(_, shape)| shape)
}

/// How many cells a box touches.
fn touched(shape: &Shape, b: &Aabb) -> f32 {
    let (first, last) = shape.lattice.ranges(b, shape.cells);
    let along = |k: usize| float(last[k].saturating_sub(first[k]));
    along(0) * along(1) * along(2)
}

/// What the steps and tests may be expected to cost that a line through a cell takes in a grid in it, with so many
/// references.
fn cost(input: &Input<'_>, shape: &Shape, bounds: &Aabb, listed: f32) -> f32 {
    let unit = 1.0 / size(sub(bounds.max, bounds.min));
    let share = sah::area(&shape.bounds([0; 3]), unit) / sah::area(bounds, unit);
    let [x, y, z] = shape.cells.map(float);
    ENTRY_COST + (x * y * z * STEP_COST + listed * input.test_cost()) * share
}
