//! The box test: all children of a node at once, or one after another where there are no lanes.
use super::Node;
use crate::bvh::walk::Rows;
use crate::bvh::{Child, Face};
use crate::geom::ray::Prepared;
use crate::geom::vec::{Vec3, least, most};
use crate::walk::lanes::{self, Lanes};

/// What the box test reads of a ray.
#[derive(Clone, Copy)]
pub(super) struct Slab {
    pub near_origin: Vec3,
    pub far_origin: Vec3,
    pub inv: Vec3,
    pub t_min: f32,
    pub rows: Rows,
}

/// What the box tests of a walk read of the ray, in every lane.
pub(super) struct Slabs<const W: usize, L, const QUICK: bool> {
    rows: Rows,
    near_origin: [L; 3],
    far_origin: [L; 3],
    inv: [L; 3],
    t_min: L,
    /// For where there are no lanes.
    ray: Slab,
}

impl<const W: usize, L: Lanes<W>, const QUICK: bool> Slabs<W, L, QUICK> {
    #[inline(always)]
    pub(super) fn new(ray: &Prepared) -> Self {
        Self::of(&Slab {
            near_origin: ray.near_origin,
            far_origin: if QUICK { farther(ray) } else { ray.far_origin },
            inv: ray.inv,
            t_min: ray.t_min,
            rows: Rows::new(ray),
        })
    }

    /// Of a ray whose numbers stand elsewhere.
    #[inline(always)]
    pub(super) fn of(ray: &Slab) -> Self {
        let all = |[x, y, z]: [f32; 3]| [L::splat(x), L::splat(y), L::splat(z)];
        Self {
            rows: ray.rows,
            near_origin: all(ray.near_origin),
            far_origin: all(ray.far_origin),
            inv: all(ray.inv),
            t_min: L::splat(ray.t_min),
            ray: *ray,
        }
    }

    #[inline(always)]
    fn plane(node: &Node<W>, face: Face, origin: L, inv: L) -> L {
        (L::load(&node.planes[face.at()]) - origin) * inv
    }

    #[inline(always)]
    fn most(a: L, b: L) -> L {
        if QUICK { a.quick_most(b) } else { a.most(b) }
    }

    #[inline(always)]
    fn least(a: L, b: L) -> L {
        if QUICK { a.quick_least(b) } else { a.least(b) }
    }

    /// Which children are met up to `t_max`, one bit a lane, and where their intervals begin.
    #[inline(always)]
    pub(super) fn test(&self, node: &Node<W>, t_max: f32) -> (u32, L) {
        if !lanes::HERE {
            let (met, near) = each(node, &self.ray, t_max);
            return (met, L::load(&near));
        }
        let ([nx, ny, nz], [fx, fy, fz]) = (self.rows.near, self.rows.far);
        let [ix, iy, iz] = self.inv;
        let [x, y, z] = self.near_origin;
        // A NaN constrains nothing: it is the first operand of whichever extreme it meets first.
        let near_x = Self::most(Self::plane(node, nx, x, ix), self.t_min);
        let near_y = Self::most(Self::plane(node, ny, y, iy), near_x);
        let near_z = Self::most(Self::plane(node, nz, z, iz), self.t_min);
        let near = Self::most(near_y, near_z);
        let [x, y, z] = self.far_origin;
        let t_max = L::splat(t_max);
        let far_x = Self::least(Self::plane(node, fx, x, ix), t_max);
        let far_y = Self::least(Self::plane(node, fy, y, iy), far_x);
        let far_z = Self::least(Self::plane(node, fz, z, iz), t_max);
        let far = Self::least(far_y, far_z);
        // An origin so far that its pad is infinite meets all boxes, the empty ones too.
        (if QUICK { near.quick_le(far) } else { near.le(far) & node.present() }, near)
    }
}

/// The padded origin of farther planes with twice the pad: a distance that would be `-0.0`, which the quick test takes for a
/// negative one, is then positive, unless it [underflows](crate::geom::ray::LARGE). Boxes that are taken for that are no loss, and none is lost.
#[inline(always)]
fn farther(ray: &Prepared) -> [f32; 3] {
    let away = |k: usize| ray.far_origin[k] + (ray.far_origin[k] - ray.origin[k]);
    [away(0), away(1), away(2)]
}

/// Which children are met up to `t_max`, one bit each, and where their intervals begin.
#[inline(always)]
fn each<const W: usize>(node: &Node<W>, ray: &Slab, t_max: f32) -> (u32, [f32; W]) {
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
