//! `gears`: a block of meshing gears. After Haines, SPD (CC0).
use super::frame::{ORIGIN, Vec3, Z};
use super::polygon::gear_face;
use super::sink::floor;
use super::{Anchor, Recipe, Sink, View};
use core::f64::consts::TAU;

pub const RECIPE: Recipe = Recipe {
    name: "gears",
    default: 4,
    sizes: [1, 30],
    build,
    setting,
    anchor: Anchor { hits_ours: 245_332, hits_published: Some(245_332), mean_t: 2.841_401_488 },
};

/// Teeth of every gear.
pub const TEETH: u32 = 36;

fn setting(_: u32) -> (View, Vec<Vec3>) {
    let lights = vec![[2.0, 4.0, 4.0], [-2.0, 4.0, 3.0], [2.0, -2.5, 2.5], [-1.0, -4.0, 2.0], [-1.111, -2.121, 2.626]];
    (View::new([-1.1, -2.1, 2.6], ORIGIN, Z), lights)
}

fn build(size: u32, out: &mut dyn Sink) {
    floor(out, 2.0, 0.0);
    let side = f64::from(size);
    // Neighbours stand 1.9 radii apart, so that their teeth mesh.
    let outer = 1.0 / (side - 0.05 * (side - 1.0));
    let height = f64::min(0.1, 1.0 / (2.0 * side));
    let face = gear_face(TEETH);
    for iz in 0..size {
        for iy in 0..size {
            for ix in 0..size {
                let [x, y, z] = [ix, iy, iz].map(f64::from);
                let at = [1.9 * outer * x - 1.0 + outer, 1.9 * outer * y - 1.0 + outer];
                // Every other gear is turned by half a tooth.
                let odd = (ix + iy + iz) % 2 == 1;
                gear(out, &face, &outline(at, outer, odd), [1.0 - z / side, height]);
            }
        }
    }
}

/// The outline of a gear, counter-clockwise: per tooth, two corners at the tip and two at the root.
pub fn outline([x, y]: [f64; 2], outer: f64, odd: bool) -> Vec<[f64; 2]> {
    let pitch = TAU / f64::from(TEETH);
    let phase = if odd { pitch / 2.0 } else { 0.0 };
    let (tip, root) = (0.995 * outer, 0.9 * outer);
    let corners = [(-0.19, tip), (0.19, tip), (0.3, root), (0.7, root)];
    let tooth = |k: u32| {
        corners.map(|(part, radius)| {
            let angle = phase + (f64::from(k) + part) * pitch;
            [x + radius * libm::cos(angle), y + radius * libm::sin(angle)]
        })
    };
    (0..TEETH).flat_map(tooth).collect()
}

/// Upper face, sides, lower face.
fn gear(out: &mut dyn Sink, face: &[[u32; 3]], outline: &[[f64; 2]], [z, height]: [f64; 2]) {
    let mut ring = |z: f64| -> Vec<u32> { outline.iter().map(|&[x, y]| out.corner([x, y, z])).collect() };
    let (upper, lower) = (ring(z), ring(z - height));
    for &corners in face {
        out.triangle(corners.map(|i| upper[i as usize]));
    }
    let count = outline.len();
    for i in 0..count {
        let next = (i + 1) % count;
        out.quad([upper[i], lower[i], lower[next], upper[next]]);
    }
    // The lower outline runs the other way, from the second corner of the first tip.
    for &corners in face {
        out.triangle(corners.map(|i| lower[(count + 1 - i as usize) % count]));
    }
}
