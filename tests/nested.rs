//! Grids in cells: every rule of theirs broken.
use crate::blobs::{Break, break_one_by_one, edit, header, words};
use crate::common::build;
use crate::common::meshes::mixed;
use flashray::blob::{Rule, Section};
use flashray::build::{Config, Mesh, Rule as Split, to_vec};
use flashray::nested::Grid;
use flashray::{Kind, Sphere};
use std::time::{Duration, Instant};

/// A blob of 60 primitives of all kinds in grids within the cells of a grid.
fn good_nested() -> Vec<u8> {
    build(&mixed(60, 1), &Config::new(Kind::Nested).rule(Split::Seed).cells(3)).to_vec()
}

/// The first cell whose word, and the next one's, are as asked for.
fn nested_cell(bytes: &[u8], wanted: fn(u32, u32) -> bool) -> usize {
    let cells = words(bytes, Section::NestedCells);
    (0..cells.len() - 1).find(|&c| wanted(cells[c], cells[c + 1])).expect("a cell")
}

/// Set in the word of a cell that holds a grid.
const INNER: u32 = 1 << 31;

/// For each rule about grids in cells an edit that breaks it and no rule before it.
pub const BREAKS: &[(Rule, Break)] = &[
    (Rule::Lattice, |b| edit::<Grid>(b, Section::NestedGrids, 0, |g| g.first = 1)),
    (Rule::Lattice, |b| edit::<Grid>(b, Section::NestedGrids, 0, |g| g.lists = 1)),
    (Rule::Lattice, |b| edit::<Grid>(b, Section::NestedGrids, 0, |g| g.lattice.cell[0] *= 0.9)),
    (Rule::Lattice, |b| edit::<Grid>(b, Section::NestedGrids, 1, |g| g.lattice.cell[1] = 0.0)),
    (Rule::Lattice, |b| edit::<Grid>(b, Section::NestedGrids, 1, |g| g.cells[1] += 1)),
    (Rule::Lattice, |b| edit::<Grid>(b, Section::NestedGrids, 1, |g| g.cells = [65, 1, 1])),
    (Rule::Lattice, |b| edit::<Grid>(b, Section::NestedGrids, 1, |g| g.first += 1)),
    (Rule::Lattice, |b| edit::<Grid>(b, Section::NestedGrids, 1, |g| g.lattice.min[2] = f32::NAN)),
    // A grid that is skipped, one that does not exist, one that holds itself.
    (Rule::GridOrder, |b| {
        let cell = nested_cell(b, |word, _| word & INNER != 0);
        edit::<u32>(b, Section::NestedCells, cell, |w| *w += 1);
    }),
    (Rule::GridOrder, |b| {
        let cell = nested_cell(b, |word, _| word & INNER != 0);
        edit::<u32>(b, Section::NestedCells, cell, |w| *w = u32::MAX);
    }),
    (Rule::GridOrder, |b| {
        let (cells, grids) = (words(b, Section::NestedCells), words(b, Section::NestedGrids));
        let at = |number: u32| cells.iter().position(|&w| w == INNER | number).expect("a grid's cell");
        let (first, start) = (grids[11 + 9] as usize, grids[11 + 10]);
        let last = grids.len() as u32 / 11 - 1;
        // The cell of the last grid holds the first but one, which leaves the last without a cell.
        assert!(at(1) < first && cells[at(last)] & INNER != 0 && start <= cells[cells.len() - 1]);
        edit::<u32>(b, Section::NestedCells, at(last), |w| *w = INNER | 1);
    }),
    (Rule::ListPlace, |b| {
        let cell = nested_cell(b, |word, next| word < next && next & INNER == 0);
        edit::<u32>(b, Section::NestedCells, cell, |w| *w += 1);
    }),
    (Rule::ListPlace, |b| edit::<Grid>(b, Section::NestedGrids, 2, |g| g.lists += 1)),
    (Rule::ListPlace, |b| {
        let end = words(b, Section::NestedCells).len() - 1;
        edit::<u32>(b, Section::NestedCells, end, |w| *w -= 1);
    }),
    (Rule::ListOrder, |b| edit::<u32>(b, Section::CellLists, 0, |s| *s = 60)),
    // The last of a list goes to the next cell, which lists nothing.
    (Rule::ListComplete, |b| {
        let cells = words(b, Section::NestedCells);
        let plain = |c: usize| cells[c] & INNER == 0;
        let lonely = |&c: &usize| plain(c) && plain(c + 1) && cells[c] < cells[c + 1] && cells[c + 1] == cells[c + 2];
        let cell = (0..cells.len() - 2).find(lonely).expect("an empty cell after another");
        edit::<u32>(b, Section::NestedCells, cell + 1, |w| *w -= 1);
    }),
    (Rule::GridBounds, |b| edit::<Grid>(b, Section::NestedGrids, 1, |g| g.lattice.min[0] += g.lattice.cell[0] * 0.5)),
    (Rule::StackTrue, |b| header(b, |h| h.stack += 1)),
    (Rule::StepsTrue, |b| header(b, |h| h.steps -= 1)),
];

#[test]
fn rules_about_grids_in_cells_are_broken_one_by_one() {
    break_one_by_one(&good_nested(), BREAKS);
}

#[test]
fn cells_of_as_many_primitives_as_the_threshold_says_get_no_grid() {
    let soup = mixed(300, 2);
    let grids = |blob: &[u8]| words(blob, Section::NestedGrids).len() / 11;
    for (rule, own) in [(Split::Seed, 2), (Split::Sah, 4)] {
        let config = Config::new(Kind::Nested).rule(rule).cells(3);
        let built = [1, own, 8, 300].map(|threshold| build(&soup, &config.threshold(threshold)));
        assert!(*built[1] == *build(&soup, &config), "{rule:?}: its own is not {own}");
        let counts = built.each_ref().map(|blob| grids(blob));
        assert!(counts.is_sorted_by(|a, b| a >= b), "{rule:?}: {counts:?}");
        assert!(counts[1] > 1 && counts[3] == 1, "{rule:?}: {counts:?}");
    }
}

#[test]
fn primitives_that_fill_their_cell_are_not_counted_in_every_cell_of_a_grid_that_is_not_kept() {
    // About one centre, no two alike. Counted to the end, a grid of as many cells takes n^2 steps: ten minutes.
    let ball = |i: u16| Sphere { center: [f32::from(i) * 1e-7, 0.0, 0.0], radius: 1.0 + f32::from(i) * 1e-5 };
    let balls: Vec<_> = (0..60_000).map(ball).collect();
    let begin = Instant::now();
    let config = Config::new(Kind::Nested).rule(Split::Seed);
    to_vec(&Mesh::default().spheres(&balls), &config).expect("builds");
    assert!(begin.elapsed() < Duration::from_secs(30), "{:?}", begin.elapsed());
}
