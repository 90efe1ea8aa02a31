//! `mount`: a fractal mountain and four balls above it. After Haines, SPD (CC0).
use super::frame::{ORIGIN, Vec3, Z, about, add, turn, unit};
use super::{Anchor, Recipe, Sink, View};
use core::f64::consts::TAU;

pub const RECIPE: Recipe = Recipe {
    name: "mount",
    default: 6,
    // The random numbers are defined by shifts of 7 - size.
    sizes: [0, 7],
    build,
    setting,
    anchor: Anchor { hits_ours: 173_686, hits_published: Some(173_685), mean_t: 1.917_304_661 },
};

fn setting(_: u32) -> (View, Vec<Vec3>) {
    (View::new([-1.6, 1.6, 1.7], ORIGIN, Z), vec![[-100.0, -100.0, 100.0]])
}

fn build(size: u32, out: &mut dyn Sink) {
    balls(out);
    let mut field = Field::new(size);
    let whole = Square { x: 0, y: 0, width: field.cells };
    field.rise(whole);
    let corners = field.corners(out);
    field.emit(out, &corners, whole);
}

/// Four touching balls: a tetrahedron of centres.
fn balls(out: &mut dyn Sink) {
    const RADIUS: f64 = 0.17;
    const CENTER: Vec3 = [-0.8, 0.8, 1.0];
    let top = [0.0, 0.0, RADIUS * libm::sqrt(1.5)];
    let tilt = about(unit([1.0, 1.0, 0.0]), libm::acos(-1.0 / 3.0));
    let lower = turn(&tilt, top);
    out.sphere(add(CENTER, top), RADIUS);
    for angle in [0.0, TAU / 3.0, 2.0 * TAU / 3.0] {
        out.sphere(add(CENTER, turn(&about(Z, angle), lower)), RADIUS);
    }
}

/// How much farther a centre moves than a midpoint: the root of 2, to the original's digits.
#[allow(clippy::approx_constant)]
const DIAGONAL: f64 = 1.414_213_6;

/// Heights over [-1, 1]^2, found by midpoint displacement.
struct Field {
    size: u32,
    /// Cells a side, 2^size.
    cells: u32,
    /// (cells + 1)^2, row by row.
    heights: Vec<f64>,
}

#[derive(Clone, Copy)]
struct Square {
    x: u32,
    y: u32,
    width: u32,
}

impl Square {
    /// Lower left, lower right, upper right, upper left.
    fn quarters(self) -> [Self; 4] {
        let Self { x, y, width } = self;
        let half = width / 2;
        [[x, y], [x + half, y], [x + half, y + half], [x, y + half]].map(|[x, y]| Self { x, y, width: half })
    }

    /// Counter-clockwise from the lower left.
    fn corners(self) -> [[u32; 2]; 4] {
        let Self { x, y, width } = self;
        [[x, y], [x + width, y], [x + width, y + width], [x, y + width]]
    }
}

impl Field {
    fn new(size: u32) -> Self {
        let cells = 1 << size;
        let side = cells as usize + 1;
        Self { size, cells, heights: vec![0.0; side * side] }
    }

    fn index(&self, [x, y]: [u32; 2]) -> usize {
        y as usize * (self.cells as usize + 1) + x as usize
    }

    /// Sets the midpoints of a square's sides and its centre, then those of its quarters.
    ///
    /// Two squares with a common side compute its midpoint twice, with the same result.
    fn rise(&mut self, square: Square) {
        if square.width == 1 {
            return;
        }
        let half = square.width / 2;
        let corners = square.corners();
        let mut sum = 0.0;
        for (i, [x, y]) in corners.into_iter().enumerate() {
            let [next_x, next_y] = corners[(i + 1) % 4];
            let middle = [u32::midpoint(x, next_x), u32::midpoint(y, next_y)];
            let here = self.heights[self.index([x, y])];
            let there = self.heights[self.index([next_x, next_y])];
            self.set(middle, f64::midpoint(here, there), self.step(half));
            sum += here;
        }
        let center = [square.x + half, square.y + half];
        self.set(center, sum / 4.0, DIAGONAL * self.step(half));
        for quarter in square.quarters() {
            self.rise(quarter);
        }
    }

    /// How far a midpoint moves, for one standard deviation, `half` cells from the corners.
    fn step(&self, half: u32) -> f64 {
        let ratio = 2.0 / libm::pow(2.0, 1.0 / 1.2);
        let steepness = libm::sqrt(ratio * ratio - 1.0);
        f64::from(2 * half) / f64::from(self.cells) * steepness
    }

    fn set(&mut self, at: [u32; 2], mean: f64, step: f64) {
        let index = self.index(at);
        self.heights[index] = mean + step * gauss(at, self.size);
    }

    /// Stores all corners, row by row.
    fn corners(&self, out: &mut dyn Sink) -> Vec<u32> {
        let place = |i: u32| f64::from(2 * i) / f64::from(self.cells) - 1.0;
        let mut corner = |x, y| out.corner([place(x), place(y), self.heights[self.index([x, y])]]);
        let mut numbers = Vec::with_capacity(self.heights.len());
        for y in 0..=self.cells {
            numbers.extend((0..=self.cells).map(|x| corner(x, y)));
        }
        numbers
    }

    /// Two triangles per cell, quarter by quarter.
    fn emit(&self, out: &mut dyn Sink, corners: &[u32], square: Square) {
        if square.width > 1 {
            square.quarters().into_iter().for_each(|quarter| self.emit(out, corners, quarter));
            return;
        }
        let [a, b, c, d] = square.corners().map(|at| corners[self.index(at)]);
        out.triangle([a, b, c]);
        out.triangle([c, d, a]);
    }
}

/// A normally distributed number that depends on the place alone, by Marsaglia's polar method.
fn gauss([x, y]: [u32; 2], size: u32) -> f64 {
    const MODULUS: u32 = 134_456;
    let next = |i: u32| (28_411 + 8_121 * i) % MODULUS;
    let spread = |i: u32| 2.0 * f64::from(i) / f64::from(MODULUS) - 1.0;
    let place = (x << (23 - size)) + (y << (15 - size)) + (x << (7 - size));
    let mut i = 21 + (place & 0xffff);
    loop {
        let first = next(i);
        i = next(first);
        let (v, w) = (spread(first), spread(i));
        let q = v * v + w * w;
        if q < 1.0 {
            return v * libm::sqrt(-2.0 * libm::log(q) / q);
        }
    }
}
