//! `tetra`: the Sierpinski tetrahedron. After Haines, SPD (CC0).
use super::frame::{ORIGIN, Vec3, add, scale};
use super::{Anchor, Recipe, Sink, View};

pub const RECIPE: Recipe = Recipe {
    name: "tetra",
    default: 6,
    sizes: [1, 12],
    build,
    setting,
    anchor: Anchor { hits_ours: 49_949, hits_published: Some(49_950), mean_t: 3.727_775_095 },
};

/// The corners of a cube whose signs multiply to +1.
const CORNERS: [Vec3; 4] = [[-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0], [1.0, 1.0, 1.0]];

/// View and light are those of Kay and Kajiya, turned; the light as in the first edition of 1987.
fn setting(_: u32) -> (View, Vec<Vec3>) {
    let from = [1.022_846, -3.177_154, -2.174_512];
    let at = [-0.004_103, -0.004_103, 0.216_539];
    (View::new(from, at, [-0.816_497, -0.816_497, 0.816_497]), vec![[1.876_066, -18.123_936, -5.000_422]])
}

fn build(size: u32, out: &mut dyn Sink) {
    tetra(out, size - 1, ORIGIN, 1.0);
}

/// The tetrahedron in the cube of half side `half`, or the four in its corners.
fn tetra(out: &mut dyn Sink, depth: u32, center: Vec3, half: f64) {
    if depth == 0 {
        let points = CORNERS.map(|corner| out.corner(add(center, scale(half, corner))));
        for face in [[0, 1, 2], [3, 2, 1], [2, 3, 0], [1, 0, 3]] {
            out.triangle(face.map(|i: usize| points[i]));
        }
        return;
    }
    for corner in CORNERS {
        tetra(out, depth - 1, add(center, scale(half / 2.0, corner)), half / 2.0);
    }
}
