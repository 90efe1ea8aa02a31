//! A node's boxes one after another, where there are no lanes.
use super::Node;
use super::walk::Slab;
use crate::bvh::{Child, Face};
use crate::geom::vec::{least, most};

/// Which children are met up to `t_max`, one bit each, and where their intervals begin.
#[inline(always)]
pub(super) fn test<const W: usize>(node: &Node<W>, ray: &Slab, t_max: f32) -> (u32, [f32; W]) {
    let ([nx, ny, nz], [fx, fy, fz]) = (ray.rows.near, ray.rows.far);
    let (mut met, mut begin) = (0, [0.0; W]);
    for (lane, begin) in begin.iter_mut().enumerate() {
        if node.child[lane] == Child::NONE {
            break;
        }
        let plane = |face: Face| node.planes[face.at()][lane];
        let near = |k: usize, face: Face, t: f32| most((plane(face) - ray.near_origin[k]) * ray.inv[k], t);
        let far = |k: usize, face: Face, t: f32| least((plane(face) - ray.far_origin[k]) * ray.inv[k], t);
        *begin = near(2, nz, near(1, ny, near(0, nx, ray.t_min)));
        met |= u32::from(*begin <= far(2, fz, far(1, fy, far(0, fx, t_max)))) << lane;
    }
    (met, begin)
}
