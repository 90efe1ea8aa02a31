//! Vectors and rotations in `f64`.
//!
//! Rotations are right-handed and active: [`turn`] moves the point, not the axes.

/// A point or a direction.
pub type Vec3 = [f64; 3];

/// A 3 x 3 matrix, by rows.
pub type Mat3 = [[f64; 3]; 3];

/// The point from which all others are counted.
pub const ORIGIN: Vec3 = [0.0; 3];
/// The axes, as unit vectors.
pub const X: Vec3 = [1.0, 0.0, 0.0];
pub const Y: Vec3 = [0.0, 1.0, 0.0];
pub const Z: Vec3 = [0.0, 0.0, 1.0];

/// `a + b`.
pub fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a - b`.
pub fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a`, `k` times as long.
pub fn scale(k: f64, a: Vec3) -> Vec3 {
    [k * a[0], k * a[1], k * a[2]]
}

/// The scalar product.
pub fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector product.
pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a` at length 1; `a` must not be zero.
pub fn unit(a: Vec3) -> Vec3 {
    scale(1.0 / dot(a, a).sqrt(), a)
}

/// The matrix times the column `a`.
pub fn turn(m: &Mat3, a: Vec3) -> Vec3 {
    m.map(|row| dot(row, a))
}

/// The product: first `b`, then `a`.
pub fn compose(a: &Mat3, b: &Mat3) -> Mat3 {
    let column = |j: usize| [b[0][j], b[1][j], b[2][j]];
    a.map(|row| [dot(row, column(0)), dot(row, column(1)), dot(row, column(2))])
}

/// The rotation about a unit axis by an angle in radians.
pub fn about(axis: Vec3, angle: f64) -> Mat3 {
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let [x, y, z] = axis;
    let [tx, ty, tz] = scale(1.0 - cos, axis);
    [
        [tx * x + cos, tx * y - sin * z, tx * z + sin * y],
        [ty * x + sin * z, ty * y + cos, ty * z - sin * x],
        [tz * x - sin * y, tz * y + sin * x, tz * z + cos],
    ]
}
