//! `balls`: each sphere carries nine of a third its size. After Haines, SPD (CC0).
use super::frame::{Mat3, ORIGIN, Vec3, X, Y, Z, about, add, cross, scale, turn, unit};
use super::sink::floor;
use super::{Anchor, Recipe, Sink, View};
use core::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

pub const RECIPE: Recipe = Recipe {
    name: "balls",
    default: 4,
    sizes: [0, 7],
    build,
    setting,
    anchor: Anchor { hits_ours: 263_169, hits_published: Some(263_169), mean_t: 4.227_042_899 },
};

fn setting(_: u32) -> (View, Vec<Vec3>) {
    let lights = vec![[4.0, 3.0, 2.0], [1.0, -4.0, 4.0], [-3.0, 1.0, 5.0]];
    (View::new([2.1, 1.3, 1.7], ORIGIN, Z), lights)
}

fn build(depth: u32, out: &mut dyn Sink) {
    floor(out, 12.0, -0.5);
    ball(out, &directions(), depth, Ball { center: ORIGIN, radius: 0.5, axis: Z });
}

#[derive(Clone, Copy)]
struct Ball {
    center: Vec3,
    radius: f64,
    /// Away from the parent: no child grows back along it.
    axis: Vec3,
}

/// Where the nine children of a ball with axis +Z touch it.
fn directions() -> [Vec3; 9] {
    const D: f64 = FRAC_1_SQRT_2;
    let tilt = about(unit([1.0, -1.0, 0.0]), libm::asin(2.0 / libm::sqrt(6.0)));
    let three = [[D, D, 0.0], [D, 0.0, -D], [0.0, D, -D]].map(|v| turn(&tilt, v));
    let copies = [0.0, TAU / 3.0, 2.0 * TAU / 3.0].map(|angle| about(Z, angle));
    core::array::from_fn(|i| turn(&copies[i / 3], three[i % 3]))
}

fn ball(out: &mut dyn Sink, directions: &[Vec3; 9], depth: u32, parent: Ball) {
    let Ball { center, radius, axis } = parent;
    out.sphere(center, radius);
    if depth == 0 {
        return;
    }
    let orient = onto(axis);
    for &direction in directions {
        let axis = turn(&orient, direction);
        // The two radii, r and r/3.
        let center = add(center, scale(4.0 * radius / 3.0, axis));
        ball(out, directions, depth - 1, Ball { center, radius: radius / 3.0, axis });
    }
}

/// The least rotation of +Z onto a unit vector.
fn onto(axis: Vec3) -> Mat3 {
    if axis[2] >= 0.9999 {
        about(X, 0.0)
    } else if axis[2] <= -0.9999 {
        about(Y, PI)
    } else {
        about(unit(cross(Z, axis)), libm::acos(axis[2]))
    }
}
