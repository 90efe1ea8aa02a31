//! `jacks`: six-armed crosses, each with eight of half its size. After Haines, SPD (CC0).
use super::frame::{Mat3, ORIGIN, Vec3, X, Y, about, add, compose, turn};
use super::{Anchor, Recipe, Sink, View};

pub const RECIPE: Recipe = Recipe {
    name: "jacks",
    default: 3,
    sizes: [1, 7],
    build,
    setting,
    anchor: Anchor { hits_ours: 72_540, hits_published: None, mean_t: 7.730_674_299 },
};

fn setting(_: u32) -> (View, Vec<Vec3>) {
    let view = View { fov: 25.0, ..View::new([0.0, 0.0, -8.0], ORIGIN, Y) };
    (view, vec![[-10.0, 3.0, -20.0]])
}

fn build(size: u32, out: &mut dyn Sink) {
    let pose = compose(&about(X, -30_f64.to_radians()), &about(Y, -20_f64.to_radians()));
    jack(out, &pose, size, ORIGIN, 1.0);
}

/// A cross at `center`, given before the turn by `pose`, and `depth` - 1 generations of children.
fn jack(out: &mut dyn Sink, pose: &Mat3, depth: u32, center: Vec3, side: f64) {
    let end = |axis: usize, sign: f64| {
        let mut point = center;
        point[axis] += sign * 0.75 * side;
        turn(pose, point)
    };
    for axis in 0..3 {
        out.cylinder(end(axis, -1.0), end(axis, 1.0), 0.075 * side);
    }
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            out.sphere(end(axis, sign), 0.15 * side);
        }
    }
    if depth == 1 {
        return;
    }
    for octant in 0..8 {
        let shift = |bit: u32| {
            if octant >> bit & 1 == 0 { -0.5 * side } else { 0.5 * side }
        };
        let center = add(center, [shift(2), shift(1), shift(0)]);
        jack(out, pose, depth - 1, center, side / 2.0);
    }
}
