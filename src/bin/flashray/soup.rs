//! What every input becomes: triangles and analytic primitives, in the caller's order.
use flashray::build::Mesh;
use flashray::{Aabb, Cone, Cylinder, Sphere};

/// A scene read from a file or generated.
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

impl Soup {
    /// The borrowed form that builders take.
    pub fn mesh(&self) -> Mesh<'_> {
        Mesh::new(&self.positions, &self.triangles)
            .spheres(&self.spheres)
            .boxes(&self.boxes)
            .cylinders(&self.cylinders)
            .cones(&self.cones)
    }
}
