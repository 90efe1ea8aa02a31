//! `shells`: a sea shell of overlapping balls along a logarithmic spiral. After Haines, SPD (CC0).
use super::frame::{Vec3, Z};
use super::{Anchor, Recipe, Sink, View};
use core::f64::consts::PI;

pub const RECIPE: Recipe = Recipe {
    name: "shells",
    default: 5,
    sizes: [0, 16],
    build,
    setting,
    anchor: Anchor { hits_ours: 79_188, hits_published: None, mean_t: 70.493_538_294 },
};

fn setting(_: u32) -> (View, Vec<Vec3>) {
    (View::new([-6.0, -60.0, 35.0], [0.0, 8.0, -15.0], Z), vec![[-100.0, -100.0, 100.0]])
}

fn build(size: u32, out: &mut dyn Sink) {
    let steps = 180 << size;
    // Two thirds of the balls are smaller than 1.
    for i in -(2 * steps / 3)..=steps / 3 {
        let angle = 18.0 * PI * f64::from(i) / f64::from(steps);
        let radius = libm::exp(0.15 * angle);
        let center = [radius * libm::sin(angle), radius * libm::cos(angle), -2.0 * radius];
        out.sphere(center, radius);
    }
}
