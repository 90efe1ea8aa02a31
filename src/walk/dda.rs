//! A ray's way through the cells of a lattice.
//!
//! Cleary and Wyvill, "Analysis of an algorithm for fast ray tracing using uniform space subdivision", The Visual
//! Computer 4, 1988, and Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", Eurographics 1987: of
//! the next plane on each axis the nearest is crossed, and nothing but that axis changes. Each plane's distance is
//! computed afresh from its number, so no error adds up, and the cells left on each axis are counted, so no cell
//! outside is ever met.
//!
//! The walk is as thick as the pad of the slab test. A plane has two distances: the cell behind it is *entered* at the
//! padded near one and the cell before it is *left* at the padded far one, a trifle later. A cell is visited if for
//! some `t` it is entered on every axis and left on none, which is when its slab interval is not empty: what
//! [`crate::geom`], rule 6, asks for. Mostly a cell on an axis is left before a plane of another axis is met; then one
//! cell follows the other. Otherwise, near an edge or a corner, or with a pad as large as a cell for a ray from very
//! far away, the walk turns *thick*: it keeps the first and last cell on each axis, and a plane that is met adds every
//! combination of the others. Either way a cell is visited once, when the last of its planes is met.
//!
//! Steps are paid to the meter by the structure's walk, one a cell. The search for the first cells (`Axis::span`) is
//! not paid: it starts at a guess that is mostly right, and looks at no more than twice as many planes as there are
//! cells along the axis.
use crate::geom::lattice::Lattice;
use crate::geom::ray::{Axis as Direction, Prepared};
use crate::geom::vec::{least, most};
use crate::num::{float, floor};

/// What a walk keeps of the cell it is in: told of each cell, by its place or by a step.
pub trait Cursor {
    /// The walk is at this cell.
    fn put(&mut self, cell: [u32; 3]);
    /// The walk goes one cell on along the axis, upwards or (`down`) downwards.
    fn step(&mut self, axis: Direction, down: bool);
}

/// What is kept of each axis.
#[derive(Clone, Copy, Debug)]
struct Axis {
    /// Where the next plane is entered; infinite where there is none.
    enter: f32,
    /// Where the last cell so far is left.
    leave: f32,
    /// Number of the next plane, that is, of the far side of the last cell so far.
    plane: f32,
    /// 1 or -1.
    up: f32,
    /// Cells beyond the last so far.
    left: u32,
    min: f32,
    cell: f32,
    near_origin: f32,
    far_origin: f32,
    inv: f32,
}

impl Axis {
    /// The planes of axis `k`, from the first that the ray meets, at plane `plane`; no cell so far.
    #[inline(always)]
    fn new(ray: &Prepared, lattice: &Lattice, k: usize, (plane, up): (f32, f32)) -> Self {
        Self {
            enter: f32::INFINITY,
            leave: f32::INFINITY,
            plane,
            up,
            left: 0,
            min: lattice.min[k],
            cell: lattice.cell[k],
            near_origin: ray.near_origin[k],
            far_origin: ray.far_origin[k],
            inv: ray.inv[k],
        }
    }

    /// The first and last of `n` cells at distance `enter`, where the first is about `low`. In the ray's order, plane
    /// `q` lies before cell `q`.
    #[inline(always)]
    fn span(&self, mut low: u32, n: u32, enter: f32) -> (u32, u32) {
        let plane = |q: u32| self.plane + self.up * float(q);
        // The guess may be off by what rounding does; the planes themselves decide.
        while low > 0 && !(self.far(plane(low)) < enter) {
            low -= 1;
        }
        while low + 1 < n && self.far(plane(low + 1)) < enter {
            low += 1;
        }
        let mut high = low;
        while high + 1 < n && !(self.near(plane(high + 1)) > enter) {
            high += 1;
        }
        (low, high)
    }

    /// The distance at which plane `i` is entered, as the slab test says.
    #[inline(always)]
    fn near(&self, i: f32) -> f32 {
        ((self.min + i * self.cell) - self.near_origin) * self.inv
    }

    /// The distance at which plane `i` is left behind.
    #[inline(always)]
    fn far(&self, i: f32) -> f32 {
        ((self.min + i * self.cell) - self.far_origin) * self.inv
    }

    /// Goes on to the next cell.
    #[inline(always)]
    fn advance(&mut self) {
        self.left = self.left.saturating_sub(1);
        self.plane += self.up;
        let x = self.min + self.plane * self.cell;
        self.enter = if self.left > 0 { (x - self.near_origin) * self.inv } else { f32::INFINITY };
        self.leave = (x - self.far_origin) * self.inv;
    }
}

/// A ray between cells `first..last` of a lattice.
#[derive(Clone, Copy, Debug)]
pub struct Dda {
    axes: [Axis; 3],
    /// Where the cell before the last one is left, on the axis that was stepped along.
    pending: f32,
    stepped: Direction,
    /// Beyond this the ray has left the cells.
    exit: f32,
    thick: bool,
    /// While thick: the first and the last cells so far on each axis, in the ray's order, from 0.
    low: [u32; 3],
    high: [u32; 3],
    /// While thick: the cell visited now, and the ones to be visited at this `t`.
    now: [u32; 3],
    from: [u32; 3],
    first: [u32; 3],
    last: [u32; 3],
}

impl Dda {
    /// The ray at the first cell that it meets of `first..last`, up to `t_max`; tells `cursor` of it.
    ///
    /// `None` if it meets none.
    #[inline]
    pub fn start(
        ray: &Prepared,
        lattice: &Lattice,
        (first, last): ([u32; 3], [u32; 3]),
        t_max: f32,
        cursor: &mut impl Cursor,
    ) -> Option<Self> {
        let (mut enter, mut exit) = (ray.t_min, t_max);
        for axis in Direction::ALL {
            let k = axis.at();
            let (a, b) = if ray.negative[k] { (last[k], first[k]) } else { (first[k], last[k]) };
            enter = most(ray.near(k, lattice.plane(axis, a)), enter);
            exit = least(ray.far(k, lattice.plane(axis, b)), exit);
        }
        if !(enter <= exit) {
            return None;
        }
        let at = ray.point(enter);
        let axis = |k: Direction| Self::axis(ray, lattice, k.at(), (first[k.at()], last[k.at()]), at[k.at()], enter);
        let (x, y, z) = (axis(Direction::X), axis(Direction::Y), axis(Direction::Z));
        let ((x, low_x, high_x), (y, low_y, high_y), (z, low_z, high_z)) = (x, y, z);
        let (low, high) = ([low_x, low_y, low_z], [high_x, high_y, high_z]);
        let thick = low != high;
        let mut dda = Self {
            axes: [x, y, z],
            pending: f32::NEG_INFINITY,
            stepped: Direction::X,
            exit,
            thick,
            low,
            high,
            now: low,
            from: low,
            first,
            last,
        };
        dda.tell(cursor);
        Some(dda)
    }

    /// An axis with its first and last cell at distance `enter`.
    #[inline(always)]
    fn axis(
        ray: &Prepared,
        lattice: &Lattice,
        k: usize,
        (first, last): (u32, u32),
        x: f32,
        enter: f32,
    ) -> (Axis, u32, u32) {
        let down = ray.negative[k];
        let (base, up) = if down { (float(last), -1.0) } else { (float(first), 1.0) };
        let mut axis = Axis::new(ray, lattice, k, (base, up));
        let n = last.saturating_sub(first).max(1);
        let cells = (x - axis.min) / axis.cell;
        let inside = if down { float(last) - cells } else { cells - float(first) };
        let (low, high) = axis.span(floor(least(most(inside, 0.0), float(n - 1))), n, enter);
        axis.left = n - 1 - high;
        axis.plane = base + up * float(high + 1);
        axis.leave = axis.far(axis.plane);
        if axis.left > 0 {
            axis.enter = axis.near(axis.plane);
        }
        (axis, low, high)
    }

    /// Goes on to the next cell and tells `cursor`. `false` if no other is entered up to `t_max`.
    #[inline(always)]
    pub fn advance(&mut self, t_max: f32, cursor: &mut impl Cursor) -> bool {
        if self.thick {
            return self.advance_thick(t_max, cursor);
        }
        let (k, t) = self.nearest();
        if !(t <= least(t_max, self.exit)) || t == f32::INFINITY {
            return false;
        }
        if !(self.pending < t) {
            self.thicken();
            return self.advance_thick(t_max, cursor);
        }
        let axis = &mut self.axes[k.at()];
        self.pending = axis.leave;
        self.stepped = k;
        axis.advance();
        cursor.step(k, axis.up < 0.0);
        true
    }

    /// The axis whose next plane is met first, and where; ties go to x, then to y.
    #[inline(always)]
    fn nearest(&self) -> (Direction, f32) {
        let [x, y, z] = [self.axes[0].enter, self.axes[1].enter, self.axes[2].enter];
        let (k, t) = if x <= y { (Direction::X, x) } else { (Direction::Y, y) };
        if t <= z { (k, t) } else { (Direction::Z, z) }
    }

    /// Turns thick: on the axis stepped along last, the cell before the last one is still there.
    #[cold]
    #[inline(never)]
    fn thicken(&mut self) {
        self.thick = true;
        for k in Direction::ALL.map(Direction::at) {
            let n = self.last[k].saturating_sub(self.first[k]).max(1);
            self.high[k] = (n - 1).saturating_sub(self.axes[k].left);
            self.low[k] = self.high[k];
        }
        let stepped = self.stepped.at();
        self.low[stepped] = self.low[stepped].saturating_sub(1);
        // The last cell of the box of those visited: the next is met at another plane.
        (self.from, self.now) = (self.high, self.high);
    }

    #[cold]
    #[inline(never)]
    fn advance_thick(&mut self, t_max: f32, cursor: &mut impl Cursor) -> bool {
        // The other combinations that are met at the same place: as an odometer counts.
        for k in Direction::ALL.map(Direction::at) {
            if self.now[k] < self.high[k] {
                self.now[k] += 1;
                self.tell(cursor);
                return true;
            }
            self.now[k] = self.from[k];
        }
        let (k, t) = self.nearest();
        if !(t <= least(t_max, self.exit)) || t == f32::INFINITY {
            return false;
        }
        for j in Direction::ALL.map(Direction::at) {
            let (axis, down) = (&self.axes[j], self.axes[j].up < 0.0);
            let base = if down { float(self.last[j]) } else { float(self.first[j]) };
            while self.low[j] < self.high[j] && axis.far(base + axis.up * float(self.low[j] + 1)) < t {
                self.low[j] += 1;
            }
        }
        let stepped = k.at();
        self.pending = self.axes[stepped].leave;
        self.stepped = k;
        self.axes[stepped].advance();
        self.high[stepped] += 1;
        self.from = self.low;
        self.from[stepped] = self.high[stepped];
        self.now = self.from;
        // One cell on each axis, and on this one the cell before: thin again.
        let single = |j: usize| self.low[j] == self.high[j] || (j == stepped && self.low[j] + 1 == self.high[j]);
        self.thick = !(single(0) && single(1) && single(2));
        self.tell(cursor);
        true
    }

    fn tell(&mut self, cursor: &mut impl Cursor) {
        let place = |k: usize| {
            if self.axes[k].up < 0.0 {
                self.last[k].wrapping_sub(1).wrapping_sub(self.now[k])
            } else {
                self.first[k].wrapping_add(self.now[k])
            }
        };
        cursor.put([place(0), place(1), place(2)]);
    }
}
