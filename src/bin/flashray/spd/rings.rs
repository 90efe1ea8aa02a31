//! `rings`: a pyramid of balls knotted from six interlocked rings. After Haines, SPD (CC0).
use super::frame::{Mat3, Vec3, X, Z, about, add, compose, turn};
use super::{Anchor, Recipe, Sink, View};
use core::f64::consts::{FRAC_PI_8, PI, TAU};

pub const RECIPE: Recipe = Recipe {
    name: "rings",
    default: 7,
    sizes: [1, 93],
    build,
    setting,
    anchor: Anchor { hits_ours: 263_169, hits_published: Some(263_169), mean_t: 16.501_342_328 },
};

/// Radius of tubes and joints.
const TUBE: f64 = 0.07412;

/// Distance of the layers: objects of radius 1 just fill a cone of 45 degrees.
fn spacing() -> f64 {
    1.0 / libm::sin(FRAC_PI_8)
}

fn setting(_: u32) -> (View, Vec<Vec3>) {
    let s = spacing();
    let lights = vec![[3.0, -s, 3.0], [-4.0, -s, 1.0], [2.0, -s, -4.0]];
    (View::new([-1.0, -s, 0.5], [-1.0, 0.0, 0.5], Z), lights)
}

fn build(size: u32, out: &mut dyn Sink) {
    wall(out, size);
    let rings = rings();
    for layer in 0..size {
        let depth = f64::from(layer);
        for z in 0..=layer {
            for x in 0..=layer {
                let across = [x, z].map(|i| 2.0 * f64::from(i) - depth);
                object(out, &rings, [across[0], spacing() * (depth + 1.0), across[1]]);
            }
        }
    }
}

/// The square behind the last layer, a little larger than the screen.
fn wall(out: &mut dyn Sink, size: u32) {
    let y = spacing() * f64::from(size + 1);
    let half = 1.01 * (y + spacing()) * libm::tan(FRAC_PI_8);
    let corners = [[half, half], [half, -half], [-half, -half], [-half, half]];
    let corners = corners.map(|[x, z]| out.corner([x - 1.0, y, z + 0.5]));
    out.quad(corners);
}

/// The corners of six pentagons, one in each plane through the centre of a dodecahedron that is
/// parallel to a face.
fn rings() -> [[Vec3; 5]; 6] {
    let tilt = about(X, 2.0 * libm::acos(libm::cos(PI / 3.0) / libm::sin(PI / 5.0)));
    let plane = |k: u32| -> Mat3 {
        match k {
            0 => about(Z, 0.0),
            _ => compose(&about(Z, PI * f64::from(2 * k - 1) / 5.0), &tilt),
        }
    };
    let radius = 1.0 / (1.0 + TUBE);
    let corner = |i: u32| {
        let angle = TAU * f64::from(i) / 5.0;
        [radius * libm::cos(angle), radius * libm::sin(angle), 0.0]
    };
    [0, 1, 2, 3, 4, 5].map(plane).map(|m| [0, 1, 2, 3, 4].map(|i| turn(&m, corner(i))))
}

/// One object: tubes along the pentagons, a ball at every joint.
fn object(out: &mut dyn Sink, rings: &[[Vec3; 5]; 6], center: Vec3) {
    for ring in rings {
        for (i, &point) in ring.iter().enumerate() {
            let here = add(center, point);
            out.cylinder(here, add(center, ring[(i + 4) % 5]), TUBE);
            out.sphere(here, TUBE);
        }
    }
}
