//! Grids: which cells a primitive is looked for in.
use crate::random::Random;
use flashray::blob::prims::Primitive;
use flashray::geom::lattice::Lattice;
use flashray::grid::{Shape, touched::Touched};
use flashray::{Aabb, Triangle};

/// The cells that overlap a primitive, and how many were looked at.
fn overlapping(shape: &Shape, prim: &Primitive) -> (Vec<u32>, usize) {
    let (mut cells, mut found, mut looked) = (Touched::new(shape, &prim.bounds()), Vec::new(), 0);
    while let Some((place, number, bounds)) = cells.step(prim) {
        assert_eq!((shape.place(number), shape.bounds(place)), (place, bounds));
        looked += 1;
        if prim.overlaps(&bounds) {
            found.push(number);
        }
    }
    (found, looked)
}

#[test]
fn larger_boxes_rule_out_no_cell_that_overlaps() {
    let mut random = Random::new(5);
    let (mut looked, mut touched) = (0, 0);
    for i in 0..300 {
        // Also flat in a plane of cells, and with corners on their corners.
        let snap = |x: f32| if i % 3 == 0 { (x * 8.0).round() / 8.0 } else { x };
        let mut corner = || random.point([0.0; 3], [1.0; 3]).map(snap);
        let prim = Primitive::Triangle(Triangle { v: [corner(), corner(), corner()] });
        let cells = [1 + i % 40, 1 + i % 23, 1 + i % 31];
        let bounds = Aabb { min: [-1.0; 3], max: [1.0; 3] };
        let shape = Shape { lattice: Lattice::over(&bounds, cells), cells, reserved: 0 };
        let all = 0..shape.len().expect("few cells");
        let all: Vec<u32> = all.filter(|&n| prim.overlaps(&shape.bounds(shape.place(n)))).collect();
        let (found, steps) = overlapping(&shape, &prim);
        assert_eq!(found, all, "{prim:?} in {cells:?}");
        let (first, last) = shape.lattice.ranges(&prim.bounds(), cells);
        touched += (0..3).map(|k| (last[k] - first[k]) as usize).product::<usize>();
        looked += steps;
    }
    assert!(looked * 2 < touched, "{looked} of {touched} cells were looked at");
}

#[test]
fn a_needle_across_a_fine_grid_is_looked_for_in_few_cells() {
    let (cells, bounds) = ([512; 3], Aabb { min: [0.0; 3], max: [1.0; 3] });
    let shape = Shape { lattice: Lattice::over(&bounds, cells), cells, reserved: 0 };
    let needle = Primitive::Triangle(Triangle { v: [[0.0; 3], [1.0; 3], [0.999, 1.0, 1.0]] });
    let (found, looked) = overlapping(&shape, &needle);
    assert!(found.len() >= 512 && looked < 512 * 512 * 4, "{} found, {looked} looked at", found.len());
}
