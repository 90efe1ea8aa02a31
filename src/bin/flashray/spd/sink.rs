//! Where a scene's primitives go.
use super::Soup;
use super::frame::Vec3;
use flashray::{Cone, Cylinder, Sphere};

/// Takes the primitives of a scene, in order and in `f64`.
///
/// A [`Soup`] rounds them; the hit counts are checked on a sink that does not.
pub trait Sink {
    /// Stores a corner and returns its number.
    fn corner(&mut self, point: Vec3) -> u32;
    /// A triangle of three stored corners.
    fn triangle(&mut self, corners: [u32; 3]);
    /// A sphere.
    fn sphere(&mut self, center: Vec3, radius: f64);
    /// An open cylinder.
    fn cylinder(&mut self, base: Vec3, top: Vec3, radius: f64);
    /// An open truncated cone; `radii` at the base and at the top.
    fn cone(&mut self, base: Vec3, top: Vec3, radii: [f64; 2]);

    /// A convex quadrilateral of four stored corners, as a fan from the first.
    fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.triangle([a, b, c]);
        self.triangle([a, c, d]);
    }
}

/// The horizontal square |x|, |y| <= `half` at height `z`.
pub fn floor(out: &mut dyn Sink, half: f64, z: f64) {
    let corners = [[half, half, z], [-half, half, z], [-half, -half, z], [half, -half, z]];
    let corners = corners.map(|point| out.corner(point));
    out.quad(corners);
}

impl Sink for Soup {
    fn corner(&mut self, point: Vec3) -> u32 {
        let number = self.positions.len();
        self.positions.push(round(point));
        u32::try_from(number).expect("sizes bound a scene far below 2^32 corners")
    }

    fn triangle(&mut self, corners: [u32; 3]) {
        self.triangles.push(corners);
    }

    fn sphere(&mut self, center: Vec3, radius: f64) {
        self.spheres.push(Sphere { center: round(center), radius: narrow(radius) });
    }

    fn cylinder(&mut self, base: Vec3, top: Vec3, radius: f64) {
        let [base, top] = [base, top].map(round);
        self.cylinders.push(Cylinder { base, top, radius: narrow(radius), caps: 0 });
    }

    fn cone(&mut self, base: Vec3, top: Vec3, radii: [f64; 2]) {
        let [base, top] = [base, top].map(round);
        let [base_radius, top_radius] = radii.map(narrow);
        self.cones.push(Cone { base, top, base_radius, top_radius, caps: 0 });
    }
}

/// Each coordinate to the nearest `f32`.
pub fn round(point: Vec3) -> [f32; 3] {
    point.map(narrow)
}

/// To the nearest `f32`; every value of a scene is well within its range.
#[allow(clippy::cast_possible_truncation)]
fn narrow(value: f64) -> f32 {
    value as f32
}
