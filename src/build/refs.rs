//! What builders sort in place of the primitives.
use super::Input;
use crate::geom::Aabb;
use crate::geom::vec::Vec3;
use crate::num::{count, index};
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

/// Fills one reference per primitive, in the caller's order. More references are left as they are.
pub(super) fn fill(input: &Input<'_>, refs: &mut [Ref]) {
    for (i, place) in refs.iter_mut().take(index(input.len)).enumerate() {
        let prim = count(i);
        let bounds = input.triangle(prim).map_or_else(|| input.prim(prim).bounds(), |triangle| triangle.bounds());
        *place = Ref { bounds, prim, scratch: 0.0 };
    }
}
