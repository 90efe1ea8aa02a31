//! The `bvh` crate 0.13 (f32, its `simd` feature on, built on one thread). It has no closest-hit query: it hands out
//! candidate shapes, so the caller tests triangles and keeps the nearest.
use super::brute::tri;
use crate::clock;
use crate::peer::*;
use ::bvh::aabb::{Aabb, Bounded, IntersectsAabb};
use ::bvh::bounding_hierarchy::BHShape;
use ::bvh::bvh::Bvh;
use nalgebra::{Point3, Vector3};
use std::cell::Cell;

struct Shape {
    t: Tri,
    node: usize,
    id: u32,
}
impl Bounded<f32, 3> for Shape {
    fn aabb(&self) -> Aabb<f32, 3> {
        let lo = |k: usize| self.t[0][k].min(self.t[1][k]).min(self.t[2][k]);
        let hi = |k: usize| self.t[0][k].max(self.t[1][k]).max(self.t[2][k]);
        Aabb::with_bounds(Point3::new(lo(0), lo(1), lo(2)), Point3::new(hi(0), hi(1), hi(2)))
    }
}
impl BHShape<f32, 3> for Shape {
    fn set_bh_node_index(&mut self, i: usize) {
        self.node = i
    }
    fn bh_node_index(&self) -> usize {
        self.node
    }
}

#[derive(Clone, Copy, PartialEq)]
enum How {
    /// `traverse_iterator`, the documented way: every triangle whose box the whole ray line touches.
    Iter,
    /// `nearest_traverse_iterator` (heap), stopping once a box begins behind the best hit.
    Nearest,
    /// `traverse_iterator` with our own query type that also rejects boxes behind the best hit.
    Pruned,
}

struct Query {
    o: Vector3<f32>,
    inv: Vector3<f32>,
    tmax: Cell<f32>,
}
impl IntersectsAabb<f32, 3> for Query {
    #[inline(always)]
    fn intersects_aabb(&self, b: &Aabb<f32, 3>) -> bool {
        let a = (b.min.coords - self.o).component_mul(&self.inv);
        let c = (b.max.coords - self.o).component_mul(&self.inv);
        let (lo, hi) = (a.inf(&c), a.sup(&c));
        lo.x.max(lo.y).max(lo.z.max(0.0)) <= hi.x.min(hi.y).min(hi.z.min(self.tmax.get()))
    }
}

struct B {
    how: How,
    extra: bool,
    tree: Option<(Bvh<f32, 3>, Vec<Shape>)>,
}

fn ray(r: &Ray) -> ::bvh::ray::Ray<f32, 3> {
    ::bvh::ray::Ray::new(Point3::from(r.o), Vector3::from(r.d))
}

impl Peer for B {
    fn name(&self) -> String {
        format!(
            "bvh-{}",
            match self.how {
                How::Iter => "iter",
                How::Nearest => "nearest",
                How::Pruned => "pruned",
            }
        )
    }
    fn info(&self) -> String {
        let how = match self.how {
            How::Iter => "traverse_iterator (documented way; no pruning by distance)",
            How::Nearest => "nearest_traverse_iterator (heap) with early stop",
            How::Pruned => "traverse_iterator with a custom pruning query (unordered)",
        };
        format!(
            "bvh 0.13 f32, feature simd (wide f32x4), 2-wide nodes, 1 triangle per leaf; {how}; own scalar triangle test"
        )
    }
    fn extra(&self) -> bool {
        self.extra
    }
    fn build(&mut self, tris: &[Tri]) -> Built {
        self.clear();
        let (t, ms, bytes) = clock::built(|| {
            let mut s: Vec<Shape> = tris.iter().enumerate().map(|(i, &t)| Shape { t, node: 0, id: i as u32 }).collect();
            (Bvh::build(&mut s), s)
        });
        self.tree = Some(t);
        Built { ms, bytes: Some(bytes) }
    }
    fn clear(&mut self) {
        self.tree = None;
    }
    fn closest(&self, rays: &[Ray], out: &mut [Hit]) {
        let (b, s) = self.tree.as_ref().unwrap();
        for (r, o) in rays.iter().zip(out) {
            let mut best = Hit { t: r.tmax, prim: u32::MAX };
            match self.how {
                How::Iter => {
                    let q = ray(r);
                    for x in b.traverse_iterator(&q, s) {
                        tri(r, &x.t, x.id, &mut best);
                    }
                }
                How::Nearest => {
                    let q = ray(r);
                    for x in b.nearest_traverse_iterator(&q, s) {
                        match q.intersection_slice_for_aabb(&x.aabb()) {
                            Some((near, _)) if near > best.t => break,
                            _ => tri(r, &x.t, x.id, &mut best),
                        }
                    }
                }
                How::Pruned => {
                    let q = Query {
                        o: Vector3::from(r.o),
                        inv: Vector3::from(r.d).map(|x| 1.0 / x),
                        tmax: Cell::new(r.tmax),
                    };
                    for x in b.traverse_iterator(&q, s) {
                        tri(r, &x.t, x.id, &mut best);
                        q.tmax.set(best.t);
                    }
                }
            }
            *o = if best.prim == u32::MAX { Hit::MISS } else { best };
        }
    }
    fn any(&self, rays: &[Ray], out: &mut [bool]) {
        let (b, s) = self.tree.as_ref().unwrap();
        for (r, o) in rays.iter().zip(out) {
            let mut best = Hit { t: r.tmax, prim: u32::MAX };
            let mut test = |x: &Shape| {
                tri(r, &x.t, x.id, &mut best);
                best.prim != u32::MAX
            };
            *o = match self.how {
                How::Pruned => {
                    let q = Query {
                        o: Vector3::from(r.o),
                        inv: Vector3::from(r.d).map(|x| 1.0 / x),
                        tmax: Cell::new(r.tmax),
                    };
                    b.traverse_iterator(&q, s).any(&mut test)
                }
                _ => {
                    let q = ray(r);
                    b.traverse_iterator(&q, s).any(&mut test)
                }
            };
        }
    }
}

pub fn peers() -> Vec<Box<dyn Peer>> {
    [(How::Iter, false), (How::Nearest, false), (How::Pruned, true)]
        .into_iter()
        .map(|(how, extra)| Box::new(B { how, extra, tree: None }) as Box<dyn Peer>)
        .collect()
}
