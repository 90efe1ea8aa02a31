//! `sombrero`: a damped ripple over a square. After Haines, SPD (CC0).
use super::frame::{ORIGIN, Vec3, Z};
use super::{Anchor, Recipe, Sink, View};
use core::f64::consts::TAU;

pub const RECIPE: Recipe = Recipe {
    name: "sombrero",
    default: 2,
    sizes: [1, 7],
    build,
    setting,
    anchor: Anchor { hits_ours: 112_239, hits_published: None, mean_t: 11.989_107_244 },
};

fn setting(_: u32) -> (View, Vec<Vec3>) {
    let view = View { fov: 40.0, ..View::new([0.0, 5.0, -8.0], ORIGIN, Z) };
    (view, vec![[10.0, 10.0, -10.0]])
}

fn build(size: u32, out: &mut dyn Sink) {
    let samples = 32 << (size - 1);
    // As in the original, heights are sampled on a slightly smaller square than they are placed on.
    let sample = |i: u32| 8.0 * f64::from(i) / f64::from(samples) - 4.0;
    let place = |i: u32| 8.0 * f64::from(i) / f64::from(samples - 1) - 4.0;
    let mut numbers = Vec::new();
    for i in 0..samples {
        for j in 0..samples {
            let rho = libm::hypot(sample(j), sample(i));
            let height = libm::cos(TAU * rho) * libm::exp(-rho) - 3.0;
            numbers.push(out.corner([place(j), height, place(i)]));
        }
    }
    let corner = |i: u32, j: u32| numbers[(i * samples + j) as usize];
    for i in 0..samples - 1 {
        for j in 0..samples - 1 {
            let (near, far) = (corner(i, j), corner(i + 1, j + 1));
            out.triangle([near, far, corner(i, j + 1)]);
            out.triangle([near, corner(i + 1, j), far]);
        }
    }
}
