//! One ray in the plane, and the way that each structure takes along it.
use super::slice::{Plane, Point, Rect};
use flashray::walk::Meter;
use flashray::walk::mailbox::NoMailbox;
use flashray::{Aabb, Hit, Ray, Scene};
use std::collections::HashMap;

/// Of the ways from the left edge to the right, one that first hits about two thirds along, and past many nodes.
pub fn choose(scene: &Scene<'_>, plane: &Plane) -> Ray {
    const TRIES: usize = 12;
    let bounds = plane.bounds;
    let sides = [0, 1].map(|k| bounds.max[k] - bounds.min[k]);
    let air = sides[0].max(sides[1]) * 0.035;
    // An odd share, so that no way runs along a plane of the structure.
    let height = |i: usize| bounds.min[1] + sides[1] * (i as f64 + 0.537) / TRIES as f64;
    let ray = |from: usize, to: usize| {
        let (start, end) = ([bounds.min[0] - air, height(from)], [bounds.max[0] + air, height(to)]);
        let (start, end) = (plane.deep(start), plane.deep(end));
        Ray { origin: start, dir: [0, 1, 2].map(|k| end[k] - start[k]), t_min: 0.0, t_max: 1.0 }
    };
    let ways = (0..TRIES * TRIES).map(|i| (i / TRIES, i % TRIES)).filter(|(from, to)| from != to);
    let rays = ways.filter(|(from, to)| from.abs_diff(*to) <= TRIES / 2).map(|(from, to)| ray(from, to));
    let far = |ray: &Ray| {
        let (hit, steps) = scene.closest_hit_counted(ray);
        hit.map_or(2.0, |hit| (hit.t - 0.65).abs() - 0.04 * steps.nodes.min(14) as f32)
    };
    rays.min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or_else(|| ray(0, 1))
}

/// A node or cell that a ray visits.
pub struct Visit {
    pub rect: Rect,
    /// Whether primitives are looked for here: a leaf or a cell, or a node that holds its leaves.
    pub leaf: bool,
    /// Where the ray enters it and leaves it or has its hit, as shares of its way.
    pub span: [f64; 2],
}

/// The way of a ray through a structure.
pub struct Trail {
    pub visits: Vec<Visit>,
    /// Primitives tested.
    pub tests: u32,
    pub hit: Option<Hit>,
}

impl Trail {
    /// Follows a ray.
    pub fn new(scene: &Scene<'_>, plane: &Plane, ray: &Ray) -> Self {
        let mut recorder = Recorder::default();
        // The blob was checked: a walk ends by itself.
        let hit = scene.closest_hit_metered(ray, &mut recorder, &mut NoMailbox).unwrap_or(None);
        let leaves = recorder.leaves(scene);
        let (from, along) = (plane.flat(ray.origin), plane.flat(ray.dir));
        let stop = hit.map_or(1.0, |hit| f64::from(hit.t));
        let rects: Vec<Rect> = recorder.visits.iter().map(|(b, _)| whole(plane, b)).collect();
        let visit = |(i, rect): (usize, &Rect)| {
            let goes_on = rects[i + 1..].iter().any(|later| rect.holds(later));
            let leaf = leaves[i] || (recorder.visits[i].1 > 0 && !goes_on);
            Visit { rect: *rect, leaf, span: span(rect, from, along, stop) }
        };
        Self { visits: rects.iter().enumerate().map(visit).collect(), tests: recorder.tests, hit }
    }
}

/// A box seen along the plane's axis.
fn whole(plane: &Plane, b: &Aabb) -> Rect {
    Rect { min: plane.flat(b.min), max: plane.flat(b.max) }
}

/// Where a ray is inside a rectangle, up to `stop`.
fn span(rect: &Rect, from: Point, along: Point, stop: f64) -> [f64; 2] {
    let (mut near, mut far) = (0.0f64, stop);
    for k in 0..2 {
        if along[k] != 0.0 {
            let ends = [(rect.min[k] - from[k]) / along[k], (rect.max[k] - from[k]) / along[k]];
            near = near.max(ends[0].min(ends[1]));
            far = far.min(ends[0].max(ends[1]));
        }
    }
    [near.min(1.0), far.max(near).min(1.0)]
}

/// Boxes visited, the primitives tested in each, and in all. Never stops a walk.
#[derive(Default)]
struct Recorder {
    visits: Vec<(Aabb, u32)>,
    tests: u32,
}

impl Recorder {
    /// For each visit whether it is to a leaf or cell.
    fn leaves(&self, scene: &Scene<'_>) -> Vec<bool> {
        let key = |b: &Aabb| [b.min, b.max].map(|p| p.map(f32::to_bits));
        let mut leaf: HashMap<_, bool> = self.visits.iter().map(|(b, _)| (key(b), false)).collect();
        scene.parts(|part| {
            if let Some(leaf) = leaf.get_mut(&key(&part.bounds)) {
                *leaf |= part.listed.is_some();
            }
        });
        self.visits.iter().map(|(b, _)| leaf[&key(b)]).collect()
    }
}

impl Meter for Recorder {
    fn node(&mut self) -> bool {
        true
    }

    fn prims(&mut self, n: u32) -> bool {
        self.tests = self.tests.saturating_add(n);
        if let Some((_, tests)) = self.visits.last_mut() {
            *tests = tests.saturating_add(n);
        }
        true
    }

    fn at(&mut self, bounds: impl FnOnce() -> Aabb) {
        self.visits.push((bounds(), 0));
    }

    fn spared(&mut self) {
        self.tests = self.tests.saturating_sub(1);
    }
}
