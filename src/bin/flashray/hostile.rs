//! Rays that are known to make trouble, for primitives and for structures.
use crate::random::Random;
use flashray::blob::prims::Primitive;
use flashray::{Aabb, Ray, Scene};

type Point = [f32; 3];

/// What hostile rays are aimed at: the primitives of a scene, and the boxes of the structures over it.
pub struct Targets {
    prims: Vec<Primitive>,
    /// Of each structure by itself: a grid has a hundred times as many as a tree, and none shall go short of rays.
    boxes: Vec<Vec<Aabb>>,
    bounds: Aabb,
    middle: Point,
    half: Point,
}

impl Targets {
    /// Takes the primitives from the first scene and boxes from all: structures over the same mesh.
    pub fn new(scenes: &[Scene<'_>]) -> Self {
        let bounds = scenes.first().map_or(Aabb { min: [0.0; 3], max: [0.0; 3] }, Scene::bounds);
        let prims = scenes.first().map(|s| s.primitives().map(|(_, p)| p).collect()).unwrap_or_default();
        let boxes = |scene: &Scene<'_>| {
            let mut boxes = vec![bounds];
            scene.parts(|part| boxes.push(part.bounds));
            boxes
        };
        let boxes = scenes.iter().map(boxes).collect();
        let middle = [0, 1, 2].map(|k| bounds.min[k] / 2.0 + bounds.max[k] / 2.0);
        let half = [0, 1, 2].map(|k| (bounds.max[k] / 2.0 - bounds.min[k] / 2.0).max(f32::MIN_POSITIVE));
        Self { prims, boxes, bounds, middle, half }
    }

    /// Rays of every kind that has ever been a problem, in turn: at vertices and edges, along axes, in planes of boxes,
    /// along the lines where cells meet, from their corners, from inside, from far away, grazing, with tiny and huge
    /// directions, with tiny intervals, and at random.
    pub fn rays(&self, count: usize, seed: u64) -> Vec<Ray> {
        let mut random = Random::new(seed);
        (0..count).map(|i| self.ray(i, &mut random)).collect()
    }

    fn ray(&self, i: usize, random: &mut Random) -> Ray {
        let (middle, half) = (self.middle, self.half);
        let around = half.map(|h| h * 1.5);
        let from = random.point(middle, around);
        let target = self.feature(random);
        let (at, corner) = (towards(from, target), self.corner(random));
        match i % 16 {
            0 => at,
            1 => along(random, target, half),
            2 => towards(target, random.point(middle, around)),
            3 => self.in_plane(random, self.bounds.min, target),
            4 => Ray::new(random.point(middle, half), sub(target, middle)),
            5 => {
                // From very far away every box is within the rounding of the ray: few such rays, because each is as
                // slow as the list.
                let scenes = if i % 128 == 5 { 1e6 } else { 1e3 };
                towards([0, 1, 2].map(|k| middle[k] + (from[k] - middle[k]) * scenes), target)
            }
            6 => Ray { dir: at.dir.map(|d| d * 1e-30), ..at },
            7 => Ray { dir: at.dir.map(|d| d * 1e30), ..at },
            8 => at.within(1.0 - random.unit() * 1e-6, 1.0 + random.unit() * 1e-6),
            9 => at.within(-f32::INFINITY, f32::INFINITY),
            10 => towards(target, self.feature(random)).within(-1.0, 2.0),
            11 => along(random, corner, half),
            12 => self.in_plane(random, corner, target),
            13 => towards(corner, target),
            14 => towards(corner, self.corner(random)).within(-1.0, 2.0),
            _ => towards(from, random.point(middle, half)),
        }
    }

    /// A ray in an axis-aligned plane through one of two points.
    fn in_plane(&self, random: &mut Random, a: Point, b: Point) -> Ray {
        let axis = random.below(3);
        let mut from = random.point(self.middle, self.half.map(|h| h * 1.5));
        from[axis] = random.either(a[axis], b[axis]);
        let inside = random.point(self.middle, self.half);
        let mut dir = sub(random.either(b, inside), from);
        dir[axis] = 0.0;
        Ray::new(from, dir)
    }

    /// A corner of a box of one of the structures, each as likely as any other.
    fn corner(&self, random: &mut Random) -> Point {
        let boxes = self.boxes.get(random.below(self.boxes.len())).map_or(&[][..], Vec::as_slice);
        let b = boxes.get(random.below(boxes.len())).unwrap_or(&self.bounds);
        [0, 1, 2].map(|k| random.either(b.min[k], b.max[k]))
    }

    /// A vertex, a point on an edge, or a point of the scene's box.
    fn feature(&self, random: &mut Random) -> Point {
        let chosen = self.prims.get(random.below(self.prims.len())).filter(|_| random.below(8) > 0);
        match chosen {
            None => random.point(self.middle, self.half),
            Some(Primitive::Triangle(t)) => {
                let k = random.below(3);
                let share = [0.0, 0.5, random.unit()][random.below(3)];
                [0, 1, 2].map(|i| t.v[k][i] + (t.v[(k + 1) % 3][i] - t.v[k][i]) * share)
            }
            // The silhouette and the poles of the curved ones lie on their boxes.
            Some(other) => {
                let b = other.bounds();
                [0, 1, 2].map(|k| [b.min[k], b.min[k] / 2.0 + b.max[k] / 2.0, b.max[k]][random.below(3)])
            }
        }
    }
}

fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn towards(from: Point, to: Point) -> Ray {
    Ray::new(from, sub(to, from))
}

/// A ray along an axis, through a point; the other components are 0 or -0.
fn along(random: &mut Random, through: Point, half: Point) -> Ray {
    let axis = random.below(3);
    let mut dir = [0; 3].map(|_| random.either(0.0, -0.0));
    dir[axis] = random.either(1.0, -1.0);
    Ray::new([0, 1, 2].map(|k| through[k] - dir[k] * half[axis] * 3.0), dir)
}
