//! `lattice`: a cubic lattice of balls and rods. After Haines, SPD (CC0).
use super::frame::{Vec3, add, scale};
use super::{Anchor, Recipe, Sink, View};

pub const RECIPE: Recipe = Recipe {
    name: "lattice",
    default: 12,
    sizes: [1, 160],
    build,
    setting,
    anchor: Anchor { hits_ours: 261_171, hits_published: Some(261_170), mean_t: 0.229_509_720 },
};

/// The eye stands between balls, on the face y = 1, and looks down into the lattice.
fn setting(size: u32) -> (View, Vec<Vec3>) {
    let middle = (f64::from(size / 2) + 0.5) / f64::from(size);
    let half = 0.5 / f64::from(size);
    let from = [middle, 1.0, 1.0 - half];
    let view = View { from, at: [middle, -1.0, -1.0 - half], up: [0.2, 1.0, 0.0], fov: 60.0 };
    let mut lights = Vec::new();
    for axis in 0..3 {
        for place in [2.0, -1.0] {
            let mut light = [0.5; 3];
            light[axis] = place;
            lights.push(light);
        }
    }
    (view, lights)
}

fn build(size: u32, out: &mut dyn Sink) {
    for x in 0..=size {
        for y in 0..=size {
            for z in 0..=size {
                node(out, size, [x, y, z]);
            }
        }
    }
}

/// One ball and its rods towards the greater neighbours.
fn node(out: &mut dyn Sink, size: u32, place: [u32; 3]) {
    let side = f64::from(size);
    let center = place.map(|i| f64::from(i) / side);
    let radius = 0.25 / side;
    out.sphere(center, radius);
    // The rod's rim stays just inside the ball.
    let inset = radius * (1.0 - libm::sqrt(0.25)) * 0.99;
    for axis in (0..3).filter(|&axis| place[axis] < size) {
        let mut along = [0.0; 3];
        along[axis] = 1.0;
        let base = add(center, scale(inset, along));
        let top = add(center, scale(1.0 / side - inset, along));
        out.cylinder(base, top, radius / 4.0);
    }
}
