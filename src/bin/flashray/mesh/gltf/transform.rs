//! Transforms of nodes, in `f64`.
use gltf::scene::Transform as Stored;

/// An affine transform: the three columns of its matrix, then the translation.
#[derive(Debug, Clone, PartialEq)]
pub struct Transform([[f64; 3]; 4]);

impl Transform {
    /// The transform that moves nothing.
    pub const IDENTITY: Self = Self([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]);

    /// The transform of a node relative to its parent.
    pub fn of_node(stored: &Stored) -> Result<Self, String> {
        match *stored {
            Stored::Matrix { matrix } => {
                let [[a, b, c, p], [d, e, f, q], [g, h, i, r], [x, y, z, s]] =
                    matrix.map(|column| column.map(f64::from));
                // Writers that multiply matrices leave rounding errors here.
                if [p, q, r, s - 1.0].iter().any(|value| value.abs() > 1e-6) {
                    return Err("the last row of its matrix is not 0 0 0 1".into());
                }
                Ok(Self([[a, b, c], [d, e, f], [g, h, i], [x, y, z]]))
            }
            Stored::Decomposed { translation, rotation, scale } => {
                let [x, y, z] = turned(rotation.map(f64::from));
                let [sx, sy, sz] = scale.map(f64::from);
                let moved = translation.map(f64::from);
                Ok(Self([x.map(|v| v * sx), y.map(|v| v * sy), z.map(|v| v * sz), moved]))
            }
        }
    }

    /// The transform of a child with `local`, as seen from outside this node.
    pub fn of_child(&self, local: &Self) -> Self {
        let [x, y, z, moved] = local.0;
        Self([self.turn(x), self.turn(y), self.turn(z), self.apply(moved)])
    }

    /// Where `point` comes to lie.
    pub fn apply(&self, point: [f64; 3]) -> [f64; 3] {
        // What is not moved keeps its bits, also the sign of a zero.
        if *self == Self::IDENTITY {
            return point;
        }
        let ([x, y, z], [dx, dy, dz]) = (self.turn(point), self.0[3]);
        [x + dx, y + dy, z + dz]
    }

    /// `vector` without the translation.
    fn turn(&self, vector: [f64; 3]) -> [f64; 3] {
        let [a, b, c, _] = self.0;
        let [x, y, z] = vector;
        let row = |a: f64, b: f64, c: f64| a * x + b * y + c * z;
        [row(a[0], b[0], c[0]), row(a[1], b[1], c[1]), row(a[2], b[2], c[2])]
    }
}

/// The columns of a rotation by the quaternion `turn`, of any length but 0.
fn turned(turn: [f64; 4]) -> [[f64; 3]; 3] {
    let [x, y, z, w] = turn;
    let length = x * x + y * y + z * z + w * w;
    // Files store quaternions in decimal, so their length is not quite 1: this divides it out.
    let s = if length > 0.0 { 2.0 / length } else { 0.0 };
    [
        [1.0 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w)],
        [s * (x * y - z * w), 1.0 - s * (x * x + z * z), s * (y * z + x * w)],
        [s * (x * z + y * w), s * (y * z - x * w), 1.0 - s * (x * x + y * y)],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The transform of a node with these parts.
    fn node(translation: [f32; 3], rotation: [f32; 4], scale: [f32; 3]) -> Transform {
        Transform::of_node(&Stored::Decomposed { translation, rotation, scale }).unwrap()
    }

    #[test]
    fn scale_comes_before_rotation_before_translation() {
        // A quarter turn about z, of a quaternion with length 2.
        let found = node([10.0, 20.0, 30.0], [0.0, 0.0, 2.0, 2.0], [2.0, 3.0, 4.0]);
        assert_eq!(found.apply([1.0, 1.0, 1.0]), [7.0, 22.0, 34.0]);
        let matrix = [[0.0, 2.0, 0.0, 0.0], [-3.0, 0.0, 0.0, 0.0], [0.0, 0.0, 4.0, 0.0], [10.0, 20.0, 30.0, 1.0]];
        assert_eq!(Transform::of_node(&Stored::Matrix { matrix }), Ok(found.clone()));
        let child = node([1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], [2.0; 3]);
        let both = found.of_child(&child);
        assert_eq!(both.apply([1.0, 2.0, 3.0]), found.apply(child.apply([1.0, 2.0, 3.0])));
    }

    #[test]
    fn the_turn_goes_the_right_way_about_every_axis() {
        let turned = |[x, y, z]: [f32; 3], point| node([0.0; 3], [x, y, z, 1.0], [1.0; 3]).apply(point);
        assert_eq!(turned([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
        assert_eq!(turned([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]), [1.0, 0.0, 0.0]);
        assert_eq!(turned([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn nothing_moves_by_the_identity() {
        assert_eq!(node([0.0; 3], [0.0, 0.0, 0.0, 1.0], [1.0; 3]), Transform::IDENTITY);
        assert!(Transform::IDENTITY.apply([-0.0, 0.0, 0.0])[0].is_sign_negative());
    }
}
