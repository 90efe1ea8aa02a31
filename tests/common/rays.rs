//! Rays that are known to make trouble.
use crate::soup::Soup;
use flashray::{Ray, Scene};

/// `xorshift64*`.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub fn next(&mut self) -> u32 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 32) as u32
    }

    /// From 0 to below 1.
    pub fn unit(&mut self) -> f32 {
        (self.next() >> 8) as f32 / 16_777_216.0
    }

    /// From -1 to below 1.
    pub fn signed(&mut self) -> f32 {
        self.unit() * 2.0 - 1.0
    }

    pub fn below(&mut self, n: usize) -> usize {
        self.next() as usize % n.max(1)
    }

    pub fn point(&mut self, middle: [f32; 3], half: [f32; 3]) -> [f32; 3] {
        [0, 1, 2].map(|k| middle[k] + half[k] * self.signed())
    }
}

fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Rays of every kind that has ever been a problem, in turn: at vertices and edges, along axes, in planes of boxes,
/// from inside, from far away, grazing, with tiny and huge directions, with tiny intervals, and at random.
pub fn hostile(scene: &Scene<'_>, soup: &Soup, count: usize, seed: u64) -> Vec<Ray> {
    let mut random = Random::new(seed);
    let b = scene.bounds();
    let middle = [0, 1, 2].map(|k| b.min[k] / 2.0 + b.max[k] / 2.0);
    let half = [0, 1, 2].map(|k| (b.max[k] / 2.0 - b.min[k] / 2.0).max(f32::MIN_POSITIVE));
    let around = half.map(|h| h * 1.5);
    (0..count).map(|i| one(i, &mut random, soup, (middle, half, around), &b)).collect()
}

fn one(
    i: usize,
    random: &mut Random,
    soup: &Soup,
    (middle, half, around): ([f32; 3], [f32; 3], [f32; 3]),
    b: &flashray::Aabb,
) -> Ray {
    let from = random.point(middle, around);
    let target = feature(random, soup, middle, half);
    let axis = random.below(3);
    let sign = if random.below(2) == 0 { 1.0 } else { -1.0 };
    let mut along = [if random.below(2) == 0 { 0.0 } else { -0.0 }; 3];
    along[axis] = sign;
    let at = Ray::new(from, sub(target, from));
    match i % 12 {
        0 => at,
        1 => Ray::new(sub(target, along.map(|x| x * half[axis] * 3.0)), along),
        2 => Ray::new(target, sub(random.point(middle, around), target)),
        3 => in_plane(random, axis, b, (from, target), (middle, half)),
        4 => Ray::new(random.point(middle, half), sub(target, middle)),
        5 => {
            // From very far away every box is within the rounding of the ray: few such rays, because each is as slow as
            // the list.
            let scenes = if i % 96 == 5 { 1e6 } else { 1e3 };
            let far = [0, 1, 2].map(|k| middle[k] + (from[k] - middle[k]) * scenes);
            Ray::new(far, sub(target, far))
        }
        6 => Ray { dir: at.dir.map(|d| d * 1e-30), ..at },
        7 => Ray { dir: at.dir.map(|d| d * 1e30), ..at },
        8 => at.within(1.0 - random.unit() * 1e-6, 1.0 + random.unit() * 1e-6),
        9 => at.within(-f32::INFINITY, f32::INFINITY),
        10 => {
            let other = feature(random, soup, middle, half);
            Ray::new(target, sub(other, target)).within(-1.0, 2.0)
        }
        _ => Ray::new(from, sub(random.point(middle, half), from)),
    }
}

/// A ray in a plane of the scene's box, or of a primitive's.
fn in_plane(
    random: &mut Random,
    axis: usize,
    b: &flashray::Aabb,
    (mut from, target): ([f32; 3], [f32; 3]),
    (middle, half): ([f32; 3], [f32; 3]),
) -> Ray {
    from[axis] = if random.below(2) == 0 { b.min[axis] } else { target[axis] };
    let mut dir = sub(random.point(middle, half), from);
    dir[axis] = 0.0;
    Ray::new(from, dir)
}

/// A vertex, a point on an edge, or a point of the box.
fn feature(random: &mut Random, soup: &Soup, middle: [f32; 3], half: [f32; 3]) -> [f32; 3] {
    let chosen = random.below(soup.triangles.len());
    let Some(t) = soup.triangles.get(chosen).filter(|_| random.below(8) > 0) else {
        return random.point(middle, half);
    };
    let [p, q] = [0, 1].map(|k| soup.positions[t[(chosen + k) % 3] as usize]);
    match random.below(3) {
        0 => p,
        1 => [0, 1, 2].map(|k| p[k] / 2.0 + q[k] / 2.0),
        _ => {
            let share = random.unit();
            [0, 1, 2].map(|k| p[k] + (q[k] - p[k]) * share)
        }
    }
}
