//! The SPD test view.
use super::frame::{Vec3, add, cross, scale, sub, unit};
use super::sink::round;

/// A pinhole view with a square screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The eye.
    pub from: [f64; 3],
    /// The point at the middle of the screen.
    pub at: [f64; 3],
    /// The direction that appears upwards; need not be square to the view.
    pub up: [f64; 3],
    /// The angle from edge to edge, in degrees.
    pub fov: f64,
}

impl View {
    /// A view of the SPD's usual 45 degrees.
    pub(super) const fn new(from: Vec3, at: Vec3, up: Vec3) -> Self {
        Self { from, at, up, fov: 45.0 }
    }

    /// The SPD test rays, origin and unit direction rounded once to `f32`.
    ///
    /// There are `n` x `n`, through the corners of a screen of (n-1) x (n-1) pixels: row by row from
    /// the top, each row from left to right. `n` is at least 2; the published counts have 513.
    pub fn rays(&self, n: u32) -> impl Iterator<Item = ([f32; 3], [f32; 3])> + use<> {
        let origin = round(self.from);
        self.directions(n).map(move |direction| (origin, round(direction)))
    }

    /// The unrounded unit directions of [`rays`](Self::rays).
    pub(super) fn directions(&self, n: u32) -> impl Iterator<Item = Vec3> + use<> {
        let half = libm::tan((self.fov / 2.0).to_radians());
        let ahead = unit(sub(self.at, self.from));
        let right = unit(cross(ahead, self.up));
        let up = scale(half, cross(right, ahead));
        let right = scale(half, right);
        let pixels = f64::from(n.saturating_sub(1));
        // Both edges and, for even pixel counts, the middle come out without rounding error.
        let screen = move |k: u32| (2.0 * f64::from(k) - pixels) / pixels;
        let corners = (0..n).flat_map(move |row| (0..n).map(move |column| (row, column)));
        corners.map(move |(row, column)| unit(add(ahead, add(scale(screen(column), right), scale(-screen(row), up)))))
    }
}
