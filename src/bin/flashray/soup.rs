//! What every input becomes: triangles and analytic primitives, in the caller's order.
use flashray::{Aabb, Cone, Cylinder, Sphere};

/// A scene read from a file or generated: the borrowed form of it is `flashray::build::Mesh`.
///
/// Primitive numbers run through the triangles first, then spheres, boxes, cylinders and cones.
#[derive(Debug, Default, Clone)]
pub struct Soup {
    pub positions: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
    pub spheres: Vec<Sphere>,
    pub boxes: Vec<Aabb>,
    pub cylinders: Vec<Cylinder>,
    pub cones: Vec<Cone>,
}
