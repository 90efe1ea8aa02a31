//! The builder: a resolution, a count, a fill.
//!
//! `Rule::Seed` takes one cell a primitive. `Rule::Sah` tries several densities and keeps the one of least expected
//! cost: a random line that meets the scene meets a cell with the share of their areas, so the expected numbers of
//! steps and tests are sums over cells (`MacDonald` and Booth, "Heuristics for ray tracing using space subdivision",
//! The Visual Computer 6, 1990). Cells along an axis follow the sides of the box (Woo;
//! [`crate::geom::lattice::resolution`]).
//!
//! Memory: 10 words for the shape, one a cell and one more, one a reference; counted before it is asked for.
use super::Shape;
use crate::blob::Section;
use crate::build::parts::{Parts, number_slots};
use crate::build::{BuildError, Config, Input, MOST_CELLS, Ref, Rule};
use crate::geom::Aabb;
use crate::geom::lattice::{Lattice, resolution};
use crate::num::{float, index};
use bytemuck::Zeroable;

/// Words of a shape.
pub const SHAPE_WORDS: usize = size_of::<Shape>() / 4;
/// Cost of a step to the next cell, in triangle tests. Measured on a host: 12 ns.
pub const STEP_COST: f32 = 2.4;

/// What a resolution is chosen by.
#[derive(Clone, Copy, Debug)]
pub struct Choice {
    /// Cells a primitive that are tried.
    pub densities: &'static [f32],
    /// Cost of a step to the next cell, in triangle tests.
    pub step: f32,
    /// There are fewer cells than so many.
    pub cells: u32,
}

impl Choice {
    /// That of the seed's rule for a grid: one cell a primitive.
    pub const SEED: Self = Self { densities: &[1.0], ..Self::SAH };
    /// That of least expected cost for a grid.
    pub const SAH: Self = Self { densities: &[1.0, 2.0, 4.0, 8.0, 16.0, 32.0], step: STEP_COST, cells: 1 << 28 };
}

/// References that a primitive may have on average, by boxes, unless the caller names a resolution: a million in one
/// place would otherwise be listed a million times.
const MOST_LISTED: f32 = 32.0;
/// There are fewer references than so many.
const MOST_REFS: u32 = 1 << 28;

/// A grid that is decided on but not made.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Its planes and cells.
    pub shape: Shape,
    /// Its cells.
    pub cells: u32,
    /// Its references.
    pub listed: u32,
}

impl Plan {
    /// Chooses the resolution and counts.
    ///
    /// # Errors
    /// [`BuildError::TooLarge`] if there are 2^28 cells or references, or more.
    pub fn new(input: &Input<'_>, config: &Config) -> Result<Self, BuildError> {
        Self::with(input, config, if config.rule == Rule::Seed { &Choice::SEED } else { &Choice::SAH })
    }

    /// The same by another choice, and its most cells.
    ///
    /// # Errors
    /// [`BuildError::TooLarge`] if there are more cells, or 2^28 references or more.
    pub fn with(input: &Input<'_>, config: &Config, choice: &Choice) -> Result<Self, BuildError> {
        let (b, n) = (&input.bounds, float(input.len));
        if input.len == 0 {
            return Ok(Self { shape: Shape::zeroed(), cells: 0, listed: 0 });
        }
        if config.cells > 0 {
            // So many along the longest side: whatever total that gives.
            return Self::of(input, resolution(b, f32::INFINITY, config.cells), choice.cells);
        }
        let mut best: Option<(f32, [u32; 3])> = None;
        for density in choice.densities {
            let (cost, cells, whole) = affordable(input, n * density, choice);
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, cells));
            }
            // Densities are powers of two: the greater ones would be halved until they are this one.
            if !whole {
                break;
            }
        }
        Self::of(input, best.map_or([1; 3], |(_, cells)| cells), choice.cells)
    }

    /// The plan of a grid of so many cells along each axis.
    ///
    /// # Errors
    /// Those of [`Plan::new`].
    pub(crate) fn of(input: &Input<'_>, cells: [u32; 3], most: u32) -> Result<Self, BuildError> {
        let shape = shape(&input.bounds, cells);
        let total = shape.len().filter(|&n| n < most).ok_or(BuildError::TooLarge)?;
        let listed = input.count_listings(&shape, MOST_REFS).ok_or(BuildError::TooLarge)?;
        Ok(Self { shape, cells: total, listed })
    }

    /// Words of [`crate::build::Arena::cells`].
    #[must_use]
    pub const fn words(&self) -> usize {
        if self.cells == 0 { 0 } else { SHAPE_WORDS + index(self.cells) + 1 }
    }
}

fn shape(bounds: &Aabb, cells: [u32; 3]) -> Shape {
    Shape { lattice: Lattice::over(bounds, cells), cells, reserved: 0 }
}

/// A resolution of about `total` cells, or of fewer if those are too many or would list too much; its expected cost;
/// and whether it is of as many.
fn affordable(input: &Input<'_>, mut total: f32, choice: &Choice) -> (f32, [u32; 3], bool) {
    let mut whole = true;
    loop {
        let cells = resolution(&input.bounds, total, MOST_CELLS);
        let (listed, cost) = expected(input, cells, choice.step);
        let fits = shape(&input.bounds, cells).len().is_some_and(|n| n < choice.cells) && listed < float(MOST_REFS);
        if (fits && listed <= float(input.len) * MOST_LISTED) || cells == [1; 3] {
            return (cost, cells, whole);
        }
        total *= 0.5;
        whole = false;
    }
}

/// References by the boxes of the primitives, and the steps and tests that a random line through the scene may be
/// expected to take.
fn expected(input: &Input<'_>, cells: [u32; 3], step: f32) -> (f32, f32) {
    let shape = shape(&input.bounds, cells);
    let area = |b: &Aabb| {
        let side = |k: usize| b.max[k] / 2.0 - b.min[k] / 2.0;
        (side(0) * side(1) + side(1) * side(2)) + side(2) * side(0)
    };
    let share = area(&shape.bounds([0; 3])) / area(&shape.lattice.bounds([0; 3], cells));
    let mut listed = 0.0;
    for prim in 0..input.len {
        let (first, last) = shape.lattice.ranges(&input.prim(prim).bounds(), cells);
        let along = |k: usize| float(last[k].saturating_sub(first[k]));
        listed += along(0) * along(1) * along(2);
    }
    let steps = float(cells[0]) * float(cells[1]) * float(cells[2]);
    let cost = (steps * step + listed * input.test_cost()) * share;
    (listed, if cost.is_finite() { cost } else { f32::MAX })
}

/// Fills the tables of a plan. `words` and `slots` are as long as the plan says.
pub fn build<'p>(
    input: &Input<'_>,
    plan: &Plan,
    refs: &'p mut [Ref],
    words: &'p mut [u32],
    slots: &'p mut [u32],
) -> Parts<'p> {
    let Some((head, starts)) = words.split_at_mut_checked(SHAPE_WORDS) else { return Parts::default() };
    head.copy_from_slice(bytemuck::cast_slice(&[plan.shape]));
    // Count, then sum up: each cell's entry becomes the start of its list, and filling moves it to the end.
    starts.fill(0);
    input.listings(&plan.shape, |cell, _| {
        if let Some(n) = starts.get_mut(index(cell)) {
            *n += 1;
        }
    });
    let mut sum = 0;
    for start in starts.iter_mut() {
        (*start, sum) = (sum, sum + *start);
    }
    input.listings(&plan.shape, |cell, prim| {
        if let Some(next) = starts.get_mut(index(cell)) {
            if let Some(slot) = slots.get_mut(index(*next)) {
                *slot = prim;
            }
            *next += 1;
        }
    });
    starts.copy_within(..starts.len() - 1, 1);
    if let Some(first) = starts.first_mut() {
        *first = 0;
    }
    let order = number_slots(starts, slots, refs);
    let mut parts = Parts::new(order, 0, plan.cells.saturating_add(plan.listed));
    parts.push(Section::GridShape, head, SHAPE_WORDS);
    parts.push(Section::CellStarts, starts, 1);
    parts.push(Section::CellLists, slots, 1);
    parts
}
