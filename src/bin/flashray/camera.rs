//! A pinhole camera.
use flashray::{Aabb, Ray};

pub type Vec3 = [f32; 3];

pub fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub fn add_scaled(a: Vec3, s: f32, b: Vec3) -> Vec3 {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

pub fn dot(a: Vec3, b: Vec3) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The unit vector along `a`; `a` itself if it has no length.
pub fn unit(a: Vec3) -> Vec3 {
    // Through f64: a scene may be 1e30 units wide.
    let [x, y, z] = a.map(f64::from);
    let length = (x * x + y * y + z * z).sqrt();
    if length > 0.0 { [(x / length) as f32, (y / length) as f32, (z / length) as f32] } else { a }
}

/// Any unit vector square to `a`.
fn square_to(a: Vec3) -> Vec3 {
    let smallest = usize::from(a[0].abs() >= a[1].abs() || a[0].abs() >= a[2].abs());
    let mut other = [0.0; 3];
    other[if a[2].abs() < a[smallest].abs() { 2 } else { smallest }] = 1.0;
    unit(cross(a, other))
}

#[derive(Clone, Copy, Debug)]
pub struct Camera {
    pub from: Vec3,
    ahead: Vec3,
    /// From the screen's middle to its edges.
    right: Vec3,
    up: Vec3,
}

impl Camera {
    /// Looks from a point at another; `fov` is the angle between the upper and the lower edge, in degrees.
    pub fn look(from: Vec3, at: Vec3, up: Vec3, fov: f32, aspect: f32) -> Self {
        let ahead = unit(sub(at, from));
        let side = cross(ahead, up);
        let right = if dot(side, side) > 0.0 { unit(side) } else { square_to(ahead) };
        let half = (fov.to_radians() / 2.0).tan();
        let up = cross(right, ahead).map(|x| x * half);
        Self { from, ahead, right: right.map(|x| x * half * aspect), up }
    }

    /// Frames a box from a quarter above and to the right of `-y`, or of `+z` if `up` is y.
    pub fn frame(bounds: &Aabb, up: Vec3, fov: f32, aspect: f32) -> Self {
        let middle = [0, 1, 2].map(|k| bounds.min[k] / 2.0 + bounds.max[k] / 2.0);
        let half = [0, 1, 2].map(|k| (bounds.max[k] / 2.0 - bounds.min[k] / 2.0).max(f32::MIN_POSITIVE));
        let direction = if up[1] == 0.0 { [0.55, -1.0, 0.5] } else { [0.55, 0.4, 1.0] };
        // In units of the box, so that any scale works; then step back until all corners are in view.
        let size = half[0].max(half[1]).max(half[2]);
        let mut camera = Self::look(add_scaled(middle, size, unit(direction)), middle, up, fov, aspect);
        let mut back = 0.0f32;
        for corner in 0..8 {
            let offset = [0, 1, 2].map(|k| if corner >> k & 1 == 1 { half[k] } else { -half[k] } / size);
            let depth = -dot(offset, camera.ahead);
            let across = |axis: Vec3| dot(offset, axis).abs() / dot(axis, axis);
            back = back.max(depth + across(camera.right).max(across(camera.up)) * 1.02);
        }
        camera.from = add_scaled(middle, -back * size, camera.ahead);
        camera
    }

    /// The ray through a point of the screen: `x` from -1 (left) to 1, `y` from -1 (bottom) to 1.
    pub fn ray(&self, x: f32, y: f32) -> Ray {
        Ray::new(self.from, unit(add_scaled(add_scaled(self.ahead, x, self.right), y, self.up)))
    }

    /// The direction upwards on the screen.
    pub fn up(&self) -> Vec3 {
        unit(self.up)
    }

    /// The direction to the right on the screen.
    pub fn right(&self) -> Vec3 {
        unit(self.right)
    }
}
