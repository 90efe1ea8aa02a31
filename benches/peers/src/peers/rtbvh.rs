//! rtbvh 0.6: candidate iterators over a binary tree or its 4-wide collapse; the caller tests triangles.
use super::brute::tri;
use crate::clock;
use crate::peer::*;
use ::rtbvh::{Aabb, Builder, Bvh, Mbvh, Primitive};
use glam::Vec3;

#[derive(Debug, Clone, Copy)]
struct Shape(Tri);
impl Primitive<i32> for Shape {
    fn center(&self) -> Vec3 {
        let v = self.0.map(Vec3::from_array);
        (v[0] + v[1] + v[2]) / 3.0
    }
    fn aabb(&self) -> Aabb<i32> {
        let mut b = Aabb::empty();
        for v in self.0 {
            b.grow(Vec3::from_array(v));
        }
        b
    }
}

enum Tree {
    Two(Bvh),
    Four(Mbvh),
}

struct R {
    wide: bool,
    tree: Option<(Tree, Vec<Shape>)>,
}

impl Peer for R {
    fn name(&self) -> String {
        if self.wide { "rtbvh-mbvh" } else { "rtbvh-bvh" }.into()
    }
    fn info(&self) -> String {
        format!(
            "rtbvh 0.6.2 {}, binned SAH build; own scalar triangle test",
            if self.wide { "Mbvh: 4-wide nodes (SSE)" } else { "Bvh: 2-wide 32 B nodes, scalar boxes" }
        )
    }
    fn extra(&self) -> bool {
        true // slow and partly wrong: see README.md
    }
    fn build(&mut self, tris: &[Tri]) -> Built {
        self.clear();
        let t0 = clock::process(); // builds on a rayon worker
        let (t, _, bytes) = clock::built(|| {
            let s: Vec<Shape> = tris.iter().map(|&t| Shape(t)).collect();
            let aabbs: Vec<Aabb<i32>> = s.iter().map(|s| s.aabb()).collect();
            let b = Builder { aabbs: Some(&aabbs), primitives: &s, primitives_per_leaf: None }
                .construct_binned_sah()
                .unwrap();
            let t = if self.wide { Tree::Four(Mbvh::from(b)) } else { Tree::Two(b) };
            (t, s)
        });
        let ms = (clock::process() - t0) * 1e3;
        self.tree = Some(t);
        Built { ms, bytes: Some(bytes) }
    }
    fn clear(&mut self) {
        self.tree = None;
    }
    fn closest(&self, rays: &[Ray], out: &mut [Hit]) {
        let (tree, s) = self.tree.as_ref().unwrap();
        for (r, o) in rays.iter().zip(out) {
            let mut best = Hit { t: r.tmax, prim: u32::MAX };
            let mut q = ::rtbvh::Ray::new(Vec3::from_array(r.o), Vec3::from_array(r.d));
            q.t_min = 0.0;
            q.t = r.tmax;
            match tree {
                Tree::Two(b) => {
                    for (i, q) in b.traverse_iter_indices(&mut q) {
                        tri(r, &s[i as usize].0, i, &mut best);
                        q.t = best.t;
                    }
                }
                Tree::Four(b) => {
                    for (i, q) in b.traverse_iter_indices(&mut q) {
                        tri(r, &s[i as usize].0, i, &mut best);
                        q.t = best.t;
                    }
                }
            }
            *o = if best.prim == u32::MAX { Hit::MISS } else { best };
        }
    }
    fn any(&self, rays: &[Ray], out: &mut [bool]) {
        let (tree, s) = self.tree.as_ref().unwrap();
        for (r, o) in rays.iter().zip(out) {
            let mut best = Hit { t: r.tmax, prim: u32::MAX };
            let mut q = ::rtbvh::Ray::new(Vec3::from_array(r.o), Vec3::from_array(r.d));
            q.t_min = 0.0;
            q.t = r.tmax;
            let mut test = |i: u32| {
                tri(r, &s[i as usize].0, i, &mut best);
                best.prim != u32::MAX
            };
            *o = match tree {
                Tree::Two(b) => b.traverse_iter_indices(&mut q).any(|(i, _)| test(i)),
                Tree::Four(b) => b.traverse_iter_indices(&mut q).any(|(i, _)| test(i)),
            };
        }
    }
}

pub fn peers() -> Vec<Box<dyn Peer>> {
    vec![Box::new(R { wide: true, tree: None }), Box::new(R { wide: false, tree: None })]
}
