//! What builders sort in place of the primitives.
use super::{BuildError, Config, Mesh};
use crate::geom::Aabb;
use crate::geom::vec::Vec3;
use crate::num::count;
use bytemuck::{Pod, Zeroable};

/// A primitive as a builder sees it: 32 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Ref {
    /// The primitive's bounding box.
    pub bounds: Aabb,
    /// The caller's number of it.
    pub prim: u32,
    /// Scratch of the builders.
    pub scratch: f32,
}

impl Ref {
    /// Twice the centre of the box: what centres are compared by.
    #[inline(always)]
    pub(crate) fn center2(&self) -> Vec3 {
        let (a, b) = (self.bounds.min, self.bounds.max);
        [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
    }
}

/// Fills one reference per primitive, in the caller's order, and returns the box around all.
pub(super) fn fill(mesh: &Mesh<'_>, config: &Config, refs: &mut [Ref]) -> Result<Aabb, BuildError> {
    let mut all = Aabb::EMPTY;
    for (i, place) in refs.iter_mut().enumerate() {
        let prim = count(i);
        let (_, primitive) = mesh.get(prim, config.local)?;
        let bounds = primitive.bounds();
        // The box of a huge primitive may overflow although its own numbers do not.
        if !primitive.is_valid() || !bounds.is_valid() {
            return Err(BuildError::Primitive { prim });
        }
        all = all.join(&bounds);
        *place = Ref { bounds, prim, scratch: 0.0 };
    }
    Ok(if refs.is_empty() { Aabb { min: [0.0; 3], max: [0.0; 3] } } else { all })
}
