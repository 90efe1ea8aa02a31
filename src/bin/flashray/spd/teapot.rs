//! `teapot`: Newell's teapot of 32 Bezier patches on a chequered board. After Haines, SPD (CC0).
//!
//! The original lists all 512 control points. Most of the pot is turned on a lathe and the rest is
//! mirrored, so profiles and one side of handle and spout suffice here.
use super::frame::{ORIGIN, Vec3, Z};
use super::{Anchor, Recipe, Sink, View};

pub const RECIPE: Recipe = Recipe {
    name: "teapot",
    default: 12,
    sizes: [1, 504],
    build,
    setting,
    anchor: Anchor { hits_ours: 161_546, hits_published: Some(161_546), mean_t: 8.630_602_856 },
};

/// Control points of a bicubic patch; `s` runs over the rows, `t` along them.
type Patch = [[Vec3; 4]; 4];

/// Four rows of a turned patch: radius, reach of the inner control points, height.
type Profile = [[f64; 3]; 4];

/// A row that bends like a circle, by the factor Newell used.
const fn round(radius: f64, height: f64) -> [f64; 3] {
    [radius, 0.56 * radius, height]
}

const RIM: Profile = [round(1.4, 2.4), round(1.3375, 2.53125), round(1.4375, 2.53125), round(1.5, 2.4)];
const BODY: [Profile; 2] = [
    [round(1.5, 2.4), round(1.75, 1.875), round(2.0, 1.35), round(2.0, 0.9)],
    [round(2.0, 0.9), round(2.0, 0.45), round(1.5, 0.225), round(1.5, 0.15)],
];
/// The second row is not quite round in the original.
const LID: [Profile; 2] = [
    [round(0.0, 3.15), [0.8, 0.45, 3.15], round(0.0, 2.85), round(0.2, 2.7)],
    [round(0.2, 2.7), round(0.4, 2.55), round(1.3, 2.55), round(1.3, 2.4)],
];
const BOTTOM: Profile = [round(0.0, 0.0), round(1.425, 0.0), round(1.5, 0.075), round(1.5, 0.15)];

/// Four rows of a patch that spans the plane y = 0: x and z of the inner point, x and z of the outer
/// one, and how far the two points between them stand off the plane.
type Strip = [[f64; 5]; 4];

const HANDLE: [Strip; 2] = [
    [
        [-1.6, 2.025, -1.5, 2.25, 0.3],
        [-2.3, 2.025, -2.5, 2.25, 0.3],
        [-2.7, 2.025, -3.0, 2.25, 0.3],
        [-2.7, 1.8, -3.0, 1.8, 0.3],
    ],
    [
        [-2.7, 1.8, -3.0, 1.8, 0.3],
        [-2.7, 1.575, -3.0, 1.35, 0.3],
        [-2.5, 1.125, -2.65, 0.9375, 0.3],
        [-2.0, 0.9, -1.9, 0.6, 0.3],
    ],
];
const SPOUT: [Strip; 2] = [
    [
        [1.7, 1.425, 1.7, 0.6, 0.66],
        [2.6, 1.425, 3.1, 0.825, 0.66],
        [2.3, 2.1, 2.4, 2.025, 0.25],
        [2.7, 2.4, 3.3, 2.4, 0.25],
    ],
    [
        [2.7, 2.4, 3.3, 2.4, 0.25],
        [2.8, 2.475, 3.525, 2.49375, 0.25],
        [2.9, 2.475, 3.45, 2.5125, 0.15],
        [2.8, 2.4, 3.2, 2.4, 0.15],
    ],
];

fn setting(_: u32) -> (View, Vec<Vec3>) {
    (View::new([4.86, 7.2, 5.4], ORIGIN, Z), vec![[-3.1, 9.8, 12.1], [11.3, 5.1, 8.8]])
}

fn build(size: u32, out: &mut dyn Sink) {
    board(out, size);
    // Mirrored, so that it faces downwards.
    let bottom = turned(&BOTTOM).map(|patch| patch.map(|row| row.map(|[x, y, z]| [x, -y, z])));
    let patches = (turned(&RIM).into_iter())
        .chain(BODY.iter().flat_map(turned))
        .chain(HANDLE.iter().flat_map(mirrored))
        .chain(SPOUT.iter().flat_map(mirrored))
        .chain(LID.iter().flat_map(turned))
        .chain(bottom);
    for patch in patches {
        mesh(out, &patch, size);
    }
}

/// The board: squares of one colour, then of the other.
fn board(out: &mut dyn Sink, size: u32) {
    let place = |i: u32| 8.0 * f64::from(i) / f64::from(size) - 4.0;
    let numbers = grid(size, |i, j| out.corner([place(i), place(j), 0.0]));
    for colour in [1, 0] {
        for i in 0..size {
            for j in (0..size).filter(|j| (i + j) % 2 == colour) {
                let corner = |di: u32, dj: u32| numbers[at(size, i + di, j + dj)];
                out.quad([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]);
            }
        }
    }
}

/// Values over the corners of n x n cells; [`at`] finds them again.
fn grid<T>(size: u32, mut value: impl FnMut(u32, u32) -> T) -> Vec<T> {
    let mut values = Vec::with_capacity(at(size, size + 1, 0));
    for i in 0..=size {
        values.extend((0..=size).map(|j| value(i, j)));
    }
    values
}

fn at(size: u32, i: u32, j: u32) -> usize {
    i as usize * (size as usize + 1) + j as usize
}

/// Four quadrants of a surface of revolution.
fn turned(profile: &Profile) -> [Patch; 4] {
    let first = profile.map(|[r, k, z]| [[r, 0.0, z], [r, -k, z], [k, -r, z], [0.0, -r, z]]);
    let quarter = |patch: Patch| patch.map(|row| row.map(|[x, y, z]| [y, -x, z]));
    let second = quarter(first);
    let third = quarter(second);
    [first, second, third, quarter(third)]
}

/// Both sides of a strip.
fn mirrored(strip: &Strip) -> [Patch; 2] {
    let side = |h: f64, [xi, zi, xo, zo, _]: [f64; 5]| [[xi, 0.0, zi], [xi, h, zi], [xo, h, zo], [xo, 0.0, zo]];
    let near = strip.map(|row| side(-row[4], row));
    let far = strip.map(|row| {
        let mut points = side(row[4], row);
        points.reverse();
        points
    });
    [near, far]
}

/// Two triangles per cell of an n x n subdivision; none without area where a patch meets the axis.
fn mesh(out: &mut dyn Sink, patch: &Patch, size: u32) {
    let parameter = |i: u32| f64::from(i) / f64::from(size);
    let points = grid(size, |i, j| evaluate(patch, parameter(i), parameter(j)));
    let numbers: Vec<u32> = points.iter().map(|&point| out.corner(point)).collect();
    let on_axis = |&&i: &&usize| points[i][0].abs() < 1e-4 && points[i][1].abs() < 1e-4;
    for i in 0..size {
        for j in 0..size {
            let [a, b, c, d] = [[i, j], [i, j + 1], [i + 1, j + 1], [i + 1, j]].map(|[i, j]| at(size, i, j));
            for corners in [[a, b, c], [c, d, a]] {
                if corners.iter().filter(on_axis).count() < 2 {
                    out.triangle(corners.map(|i| numbers[i]));
                }
            }
        }
    }
}

/// The point of a patch at (s, t).
fn evaluate(patch: &Patch, s: f64, t: f64) -> Vec3 {
    let (rows, columns) = (bernstein(s), bernstein(t));
    core::array::from_fn(|axis| {
        let along = |row: &[Vec3; 4]| (0..4).map(|j| columns[j] * row[j][axis]).sum::<f64>();
        (0..4).map(|i| rows[i] * along(&patch[i])).sum()
    })
}

/// The cubic Bernstein polynomials.
fn bernstein(t: f64) -> [f64; 4] {
    let u = 1.0 - t;
    [u * u * u, 3.0 * u * u * t, 3.0 * u * t * t, t * t * t]
}
