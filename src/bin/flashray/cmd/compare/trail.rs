//! One ray in the plane, and the way that each structure takes along it.
use super::slice::{self, Plane, Point, Rect};
use flashray::walk::Meter;
use flashray::walk::mailbox::NoMailbox;
use flashray::{Aabb, Hit, Kind, Ray, Scene};
use std::collections::{HashMap, HashSet};

/// Of the ways from the left edge to the right, one that first hits about two thirds along, and past many nodes.
pub fn choose(scene: &Scene<'_>, plane: &Plane) -> Ray {
    const TRIES: usize = 12;
    let bounds = plane.bounds;
    let sides = [0, 1].map(|k| bounds.max[k] - bounds.min[k]);
    let air = plane.air();
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
    /// Where primitives are looked for: a cell, a leaf, or the leaves that a node holds and the ray meets.
    pub searched: Vec<Rect>,
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
        let (from, along) = (plane.flat(ray.origin), plane.flat(ray.dir));
        let stop = hit.map_or(1.0, |hit| f64::from(hit.t));
        let searched = searched(scene, &recorder.visits);
        let round = slice::round(scene);
        let visit = |bounds: &Aabb| {
            // A cell that is not stored is empty.
            let boxes = searched.get(&key(bounds)).map_or(std::slice::from_ref(bounds), Vec::as_slice);
            let rects = boxes.iter().filter_map(|b| plane.cut_part(b, round));
            let [near, far] = span(&whole(plane, bounds), from, along, stop);
            Visit {
                searched: rects.filter(|rect| span(rect, from, along, stop).is_sorted()).collect(),
                span: [near.min(1.0), far.max(near).min(1.0)],
            }
        };
        Self { visits: recorder.visits.iter().map(visit).collect(), tests: recorder.tests, hit }
    }
}

/// A box as a key.
type Key = [[u32; 3]; 2];

fn key(b: &Aabb) -> Key {
    [b.min, b.max].map(|p| p.map(f32::to_bits))
}

/// For each node or cell visited the boxes in which the visit looks for primitives.
fn searched(scene: &Scene<'_>, visits: &[Aabb]) -> HashMap<Key, Vec<Aabb>> {
    let visited: HashSet<Key> = visits.iter().map(key).collect();
    if matches!(scene.kind(), Kind::Bvh | Kind::Sphere | Kind::Wide) {
        return searched_in_nodes(scene, &visited);
    }
    // A ray meets few of the cells, of which a fine grid has tens of millions: no other is kept.
    let mut searched: HashMap<Key, Vec<Aabb>> = HashMap::new();
    scene.parts(|part| {
        let key = key(&part.bounds);
        if visited.contains(&key) {
            searched.entry(key).or_default().extend(part.listed.map(|_| part.bounds));
        }
    });
    searched
}

/// The same for a hierarchy, where a visit to a node is told by the box around the node's parts, and tests what
/// leaves there are among them.
fn searched_in_nodes(scene: &Scene<'_>, visited: &HashSet<Key>) -> HashMap<Key, Vec<Aabb>> {
    let mut parts = Vec::new();
    scene.parts(|part| parts.push(part));
    let mut searched = HashMap::new();
    for (i, part) in parts.iter().enumerate().filter(|(_, part)| part.listed.is_none()) {
        // A node comes before what is below it.
        let below = parts[i + 1..].iter().take_while(|other| other.level > part.level);
        let own: Vec<_> = below.filter(|other| other.level == part.level + 1).collect();
        let key = key(&own.iter().fold(Aabb::EMPTY, |all, part| all.join(&part.bounds)));
        if visited.contains(&key) {
            let leaves = own.iter().filter(|part| part.listed.is_some()).map(|part| part.bounds);
            searched.insert(key, leaves.collect());
        }
    }
    searched
}

/// A box seen along the plane's axis.
fn whole(plane: &Plane, b: &Aabb) -> Rect {
    Rect { min: plane.flat(b.min), max: plane.flat(b.max) }
}

/// From where to where a ray is inside a rectangle, up to `stop`; backwards if it is not.
fn span(rect: &Rect, from: Point, along: Point, stop: f64) -> [f64; 2] {
    let (mut near, mut far) = (0.0f64, stop);
    for k in 0..2 {
        if along[k] != 0.0 {
            let ends = [(rect.min[k] - from[k]) / along[k], (rect.max[k] - from[k]) / along[k]];
            near = near.max(ends[0].min(ends[1]));
            far = far.min(ends[0].max(ends[1]));
        }
    }
    [near, far]
}

/// Boxes visited, and how many primitives are tested. Never stops a walk.
#[derive(Default)]
struct Recorder {
    visits: Vec<Aabb>,
    tests: u32,
}

impl Meter for Recorder {
    fn node(&mut self) -> bool {
        true
    }

    fn prims(&mut self, n: u32) -> bool {
        self.tests = self.tests.saturating_add(n);
        true
    }

    fn at(&mut self, bounds: impl FnOnce() -> Aabb) {
        self.visits.push(bounds());
    }

    fn spared(&mut self, n: u32) {
        self.tests = self.tests.saturating_sub(n);
    }
}
