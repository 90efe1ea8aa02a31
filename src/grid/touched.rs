//! The cells that a primitive's box touches, but for those that a larger box around them rules out.
//!
//! The box of a long slanted triangle touches as many cells as a grid of its size has, and few of them overlap it. So
//! where there are many, a slab of cells across the first axis is tested as one box, and so is each row of it: what is
//! tested grows with the square of the resolution instead of its cube, for builders and for checks.
use super::Shape;
use crate::blob::prims::Primitive;
use crate::geom::Aabb;

/// From so many cells on, larger boxes are tested first.
const MANY: u32 = 64;

/// A primitive's cells in a grid, one after another.
#[derive(Clone, Copy, Debug)]
pub struct Touched {
    shape: Shape,
    /// The cells that its box touches, and the next of them.
    first: [u32; 3],
    last: [u32; 3],
    next: [u32; 3],
    many: bool,
}

impl Touched {
    /// Those of a primitive of which only what lies in `part` counts.
    #[must_use]
    pub fn new(shape: &Shape, part: &Aabb) -> Self {
        let (first, last) = shape.lattice.ranges(part, shape.cells);
        let [x, y, z] = [0, 1, 2].map(|k| last[k].saturating_sub(first[k]));
        let many = x.saturating_mul(y).saturating_mul(z) > MANY;
        Self { shape: *shape, first, last, next: first, many }
    }

    /// The next cell: its place, its number and its box. Whether the primitive has a part in it is still to be asked.
    pub fn step(&mut self, prim: &Primitive) -> Option<([u32; 3], u32, Aabb)> {
        let ([_, fy, fz], [lx, ly, lz]) = (self.first, self.last);
        loop {
            let [x, y, z] = self.next;
            if x >= lx || y >= ly || z >= lz {
                return None;
            }
            if self.many && z == fz {
                let apart = |from, to| !prim.may_overlap(&self.shape.lattice.bounds(from, to));
                if y == fy && apart([x, fy, fz], [x.saturating_add(1), ly, lz]) {
                    self.next = [x.saturating_add(1), fy, fz];
                    continue;
                }
                if apart([x, y, fz], [x.saturating_add(1), y.saturating_add(1), lz]) {
                    self.next = self.row_after(x, y);
                    continue;
                }
            }
            self.next = if z.saturating_add(1) < lz { [x, y, z.saturating_add(1)] } else { self.row_after(x, y) };
            let [sx, sy, sz] = self.shape.strides();
            let number = x.wrapping_mul(sx).wrapping_add(y.wrapping_mul(sy)).wrapping_add(z.wrapping_mul(sz));
            return Some(([x, y, z], number, self.shape.bounds([x, y, z])));
        }
    }

    /// The first cell of the row after another.
    const fn row_after(&self, x: u32, y: u32) -> [u32; 3] {
        let [_, fy, fz] = self.first;
        if y.saturating_add(1) < self.last[1] { [x, y.saturating_add(1), fz] } else { [x.saturating_add(1), fy, fz] }
    }
}
