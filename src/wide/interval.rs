//! The box test of many rays at once: see [`super::group`].
use super::Node;
use crate::bvh::Face;
use crate::bvh::walk::Rows;
use crate::walk::lanes::Lanes;
use crate::walk::packet::Range;

impl Range {
    /// Which children any ray may meet up to `t_max`, and from which distance on.
    #[inline(always)]
    pub(super) fn meet<const W: usize, L: Lanes<W>>(&self, rows: Rows, node: &Node<W>, t_max: f32) -> (u32, L) {
        let (mut near, mut far) = (L::splat(self.t_min), L::splat(t_max));
        let ends = |face: Face, k: usize, origin: f32| {
            let x = L::load(&node.planes[face.at()]) - L::splat(origin);
            (x * L::splat(self.small[k]), x * L::splat(self.large[k]))
        };
        for k in 0..3 {
            let (a, b) = ends(rows.near[k], k, self.near_origin[k]);
            near = a.least(b).most(near);
            let (a, b) = ends(rows.far[k], k, self.far_origin[k]);
            far = a.most(b).least(far);
        }
        (near.le(far), near)
    }
}
