//! obvhs 0.4: Bvh2 and CwBvh, with the triangles put into leaf order (as its examples do).
use crate::clock;
use crate::peer::*;
use glam::Vec3A;
use obvhs::{
    BvhBuildParams, bvh2::Bvh2, bvh2::builder::build_bvh2_from_tris, cwbvh::CwBvh,
    cwbvh::builder::build_cwbvh_from_tris, ray::RayHit, rt_triangle::RtTriangle, triangle::Triangle,
};
use std::time::Duration;

enum Tree {
    Two(Bvh2),
    Cw(CwBvh),
}

struct Obvhs {
    wide: bool,
    preset: &'static str,
    params: BvhBuildParams,
    extra: bool,
    max: usize,
    tree: Option<(Tree, Vec<RtTriangle>)>,
}

#[inline(always)]
fn ray(r: &Ray) -> obvhs::ray::Ray {
    obvhs::ray::Ray::new(Vec3A::from_array(r.o), Vec3A::from_array(r.d), 0.0, r.tmax)
}

impl Peer for Obvhs {
    fn name(&self) -> String {
        format!("obvhs-{}-{}", if self.wide { "cwbvh" } else { "bvh2" }, self.preset)
    }
    fn info(&self) -> String {
        let l = if self.wide {
            "CwBvh: 8-wide 80 B quantized nodes, SSE 2x4 boxes"
        } else {
            "Bvh2: 2-wide, 48 B nodes, one box at a time (glam Vec3A, SSE)"
        };
        format!("obvhs 0.4 {l}; one 64 B RtTriangle at a time; PLOC build, preset {}", self.preset)
    }
    fn extra(&self) -> bool {
        self.extra
    }
    fn max_tris(&self) -> usize {
        self.max
    }
    fn build(&mut self, tris: &[Tri]) -> Built {
        self.clear();
        let t: Vec<Triangle> =
            tris.iter().map(|t| Triangle { v0: t[0].into(), v1: t[1].into(), v2: t[2].into() }).collect();
        let ((tree, rt), ms, _) = clock::built(|| {
            let mut d = Duration::ZERO;
            let (tree, ix) = if self.wide {
                let mut b = build_cwbvh_from_tris(&t, self.params, &mut d);
                b.exact_node_aabbs = None;
                let ix = b.primitive_indices.clone();
                (Tree::Cw(b), ix)
            } else {
                let b = build_bvh2_from_tris(&t, self.params, &mut d);
                let ix = b.primitive_indices.clone();
                (Tree::Two(b), ix)
            };
            let rt: Vec<RtTriangle> = ix.iter().map(|&i| RtTriangle::from(&t[i as usize])).collect();
            (tree, rt)
        });
        // what traversal needs; the builder leaves spare capacity in its vectors
        let bytes = size_of_val(&rt[..])
            + match &tree {
                Tree::Two(b) => size_of_val(&b.nodes[..]) + size_of_val(&b.primitive_indices[..]),
                Tree::Cw(b) => size_of_val(&b.nodes[..]) + size_of_val(&b.primitive_indices[..]),
            };
        self.tree = Some((tree, rt));
        Built { ms, bytes: Some(bytes) }
    }
    fn clear(&mut self) {
        self.tree = None;
    }
    fn closest(&self, rays: &[Ray], out: &mut [Hit]) {
        let (tree, rt) = self.tree.as_ref().unwrap();
        match tree {
            Tree::Two(b) => {
                for (r, o) in rays.iter().zip(out) {
                    let mut h = RayHit::none();
                    let ok = b.ray_traverse(ray(r), &mut h, |q, i| rt[i].intersect(q));
                    *o =
                        if ok { Hit { t: h.t, prim: b.primitive_indices[h.primitive_id as usize] } } else { Hit::MISS };
                }
            }
            Tree::Cw(b) => {
                for (r, o) in rays.iter().zip(out) {
                    let mut h = RayHit::none();
                    let ok = b.ray_traverse(ray(r), &mut h, |q, i| rt[i].intersect(q));
                    *o =
                        if ok { Hit { t: h.t, prim: b.primitive_indices[h.primitive_id as usize] } } else { Hit::MISS };
                }
            }
        }
    }
    fn any(&self, rays: &[Ray], out: &mut [bool]) {
        let (tree, rt) = self.tree.as_ref().unwrap();
        match tree {
            Tree::Two(b) => {
                for (r, o) in rays.iter().zip(out) {
                    *o = !b.ray_traverse_miss(ray(r), |q, i| rt[i].intersect(q));
                }
            }
            Tree::Cw(b) => {
                for (r, o) in rays.iter().zip(out) {
                    *o = !b.ray_traverse_miss(ray(r), |q, i| rt[i].intersect(q));
                }
            }
        }
    }
}

pub fn peers() -> Vec<Box<dyn Peer>> {
    let row = |wide, preset, params, extra, max| -> Box<dyn Peer> {
        Box::new(Obvhs { wide, preset, params, extra, max, tree: None })
    };
    vec![
        row(false, "fast", BvhBuildParams::fast_build(), false, usize::MAX),
        row(false, "best", BvhBuildParams::very_slow_build(), false, 300_000),
        row(true, "fast", BvhBuildParams::fast_build(), false, usize::MAX),
        row(true, "best", BvhBuildParams::very_slow_build(), false, 600_000),
    ]
}
