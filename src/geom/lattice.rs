//! Equally spaced planes, and the cells between them.
//!
//! A plane's place is computed from its number, `min + i * cell`, always in these two steps: builder, check and walk
//! see the same `f32`, and it never falls as `i` grows, because rounding is monotone. Nothing else is asked of it.
use super::aabb::Aabb;
use super::ray::Axis;
use super::vec::{Vec3, least, most};
use crate::num::{float, floor};
use bytemuck::{Pod, Zeroable};

/// Most cells along an axis: their numbers are exact in `f32`.
pub const MAX_CELLS: u32 = 1 << 20;

/// Three sets of parallel planes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Lattice {
    /// Plane 0 of each axis.
    pub min: [f32; 3],
    /// Distance from one plane to the next; more than 0.
    pub cell: [f32; 3],
}

impl Lattice {
    /// Planes that part `bounds` into `n` cells along each axis, so that plane 0 and plane `n` enclose it.
    #[must_use]
    pub fn over(bounds: &Aabb, n: [u32; 3]) -> Self {
        let mut lattice = Self { min: bounds.min, cell: [f32::MIN_POSITIVE; 3] };
        for (k, n) in n.into_iter().enumerate() {
            let cells = float(n);
            let mut cell = most((bounds.max[k] / cells) - (bounds.min[k] / cells), f32::MIN_POSITIVE);
            // Each try doubles what is added, so that a scene far from 0 is enclosed after a few.
            let mut more = cell * f32::EPSILON;
            while lattice.min[k] + cells * cell < bounds.max[k] && more < f32::MAX {
                cell += more;
                more *= 2.0;
            }
            lattice.cell[k] = cell;
        }
        lattice
    }

    /// Plane `i` of axis `k`.
    #[inline(always)]
    #[must_use]
    pub fn plane(&self, k: Axis, i: u32) -> f32 {
        self.min[k.at()] + float(i) * self.cell[k.at()]
    }

    /// Every fourth plane: plane `i` of the result is plane `4 i` of this, bit by bit.
    ///
    /// For `4 cell` is exact, unless it overflows, and so is the number `4 i`. Hence both products are the same real
    /// number, rounded once. Where `4 cell` overflows, planes from 4 on are not finite either: such a lattice has
    /// fewer than 4 cells, and the only block is without end.
    #[must_use]
    pub fn blocks(&self) -> Self {
        Self { min: self.min, cell: self.cell.map(|c| c * 4.0) }
    }

    /// The box of cells `first..last` along each axis.
    #[must_use]
    pub fn bounds(&self, first: [u32; 3], last: [u32; 3]) -> Aabb {
        let at = |i: [u32; 3]| Axis::ALL.map(|k| self.plane(k, i[k.at()]));
        Aabb { min: at(first), max: at(last) }
    }

    /// Whether its cells have a size, and `n` of them along each axis enclose `bounds`.
    #[must_use]
    pub fn covers(&self, bounds: &Aabb, n: [u32; 3]) -> bool {
        let fair = |k: usize| n[k] >= 1 && n[k] <= MAX_CELLS && self.cell[k] > 0.0 && self.min[k].is_finite();
        let all = self.bounds([0; 3], n);
        fair(0) && fair(1) && fair(2) && all.is_valid() && all.contains(bounds)
    }

    /// Which of `n` cells along axis `k` a point is in, about: the number may be wrong by what rounding does, and is
    /// clamped to the lattice.
    #[inline(always)]
    pub(crate) fn guess(&self, k: Axis, x: f32, n: u32) -> u32 {
        // NaN becomes cell 0.
        floor(least(most((x - self.min[k.at()]) / self.cell[k.at()], 0.0), float(n.saturating_sub(1))))
    }

    /// The cells `first..last` of the `n` along axis `k` that a closed interval touches; none if it lies outside.
    #[must_use]
    pub fn range(&self, k: Axis, (low, high): (f32, f32), n: u32) -> (u32, u32) {
        let mut first = self.guess(k, low, n);
        while first > 0 && self.plane(k, first) >= low {
            first -= 1;
        }
        while first < n && self.plane(k, first + 1) < low {
            first += 1;
        }
        let mut last = self.guess(k, high, n);
        while last > first && self.plane(k, last) > high {
            last -= 1;
        }
        while last < n && self.plane(k, last) <= high {
            last += 1;
        }
        (first, most_of(last, first))
    }

    /// The cells `first..last` along each axis, of `n`, that a box touches.
    #[must_use]
    pub fn ranges(&self, b: &Aabb, n: [u32; 3]) -> ([u32; 3], [u32; 3]) {
        let [x, y, z] = Axis::ALL.map(|k| self.range(k, (b.min[k.at()], b.max[k.at()]), n[k.at()]));
        ([x.0, y.0, z.0], [x.1, y.1, z.1])
    }
}

const fn most_of(a: u32, b: u32) -> u32 {
    if a > b { a } else { b }
}

/// How many cells along each axis, for about `total` cells that are as nearly cubes as the box allows (Woo, "Ray
/// Tracing News" 3(1)): each axis gets its share of the longest side's, and at least one.
#[must_use]
pub fn resolution(bounds: &Aabb, total: f32, most_cells: u32) -> [u32; 3] {
    let side: Vec3 = [0, 1, 2].map(|k| most(bounds.max[k] / 2.0 - bounds.min[k] / 2.0, 0.0));
    let longest = most(most(side[0], side[1]), side[2]);
    if !(longest > 0.0) {
        return [1; 3];
    }
    let share = side.map(|s| s / longest);
    let cells = |n: f32| share.map(|s| most(s * n, 1.0));
    // As many along the longest side as give the total: from below, in steps of a cell at least.
    let mut n = 1.0;
    while n < float(most_cells) {
        let next = most(n * 1.02, n + 1.0);
        let c = cells(next);
        if c[0] * c[1] * c[2] > total {
            break;
        }
        n = next;
    }
    cells(least(n, float(most_cells))).map(|c| floor(c).clamp(1, most_cells))
}
