//! The probe: 8,192 rays whose answers boil down to one number, the same on every machine.
//!
//! Firmware, WebAssembly and host include this file, so that "the same bits everywhere" is a comparison of two numbers.
//! Rays come from the scene's bounds by `+ - * /` and exact square roots in a fixed order; half of them are a pinhole
//! camera's, half are chords of the sphere around the bounds. No heap, no panic, no `std`.
#![allow(clippy::cast_precision_loss)] // small whole numbers

use flashray::{Hit, Ray, Scene};

type Vec3 = [f32; 3];

/// Rays in each of the two sets.
pub const RAYS: u32 = SIDE * SIDE;
/// The camera's picture is a square of so many rays.
const SIDE: u32 = 64;
/// So many rays are made, then traced, then summed up: only the tracing is watched.
const BATCH: u32 = 64;
/// The answer to a ray that meets nothing, as a record says it.
const MISS: Hit = Hit { t: f32::INFINITY, u: 0.0, v: 0.0, prim: u32::MAX };

/// One of the two sets of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Set {
    /// 64 x 64 rays from one eye, 2 radii from the centre; the bounds just fit into the picture.
    Camera,
    /// Rays from one random point of the sphere around the bounds to another.
    Chords,
}

/// What to do around the tracing of each batch of rays: count instructions, for example.
pub trait Watch {
    /// Must call `work` once.
    fn around(&mut self, set: Set, work: impl FnOnce());
}

/// Nothing to do.
impl Watch for () {
    fn around(&mut self, _: Set, work: impl FnOnce()) {
        work();
    }
}

/// What the probe found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// CRC-32 of all records: camera first, row by row from the top left, then chords.
    pub crc: u32,
    /// How many rays hit.
    pub hits: u32,
}

/// Traces both sets.
pub fn run(scene: &Scene<'_>, watch: &mut impl Watch) -> Answer {
    let ball = Ball::around(scene);
    let mut sum = Sum { crc: !0, hits: 0 };
    let mut camera = Camera::new(&ball);
    trace(scene, Set::Camera, || camera.next(), &mut sum, watch);
    let mut random = Random(0x2545_f491);
    trace(scene, Set::Chords, || random.chord(&ball), &mut sum, watch);
    Answer { crc: !sum.crc, hits: sum.hits }
}

/// Traces one set, batch by batch.
fn trace(scene: &Scene<'_>, set: Set, mut next: impl FnMut() -> Ray, sum: &mut Sum, watch: &mut impl Watch) {
    let mut rays = [Ray::new([0.0; 3], [0.0; 3]); BATCH as usize];
    let mut hits = [None; BATCH as usize];
    for _ in 0..RAYS / BATCH {
        rays.fill_with(&mut next);
        watch.around(set, || {
            for (ray, hit) in rays.iter().zip(&mut hits) {
                *hit = scene.closest_hit(ray);
            }
        });
        for &hit in &hits {
            sum.add(hit);
        }
    }
}

/// An answer as the four little-endian words of a HITS record: `t`, `u`, `v`, `prim`.
pub fn record(hit: Option<Hit>) -> [u32; 4] {
    let Hit { t, u, v, prim } = hit.unwrap_or(MISS);
    [t.to_bits(), u.to_bits(), v.to_bits(), prim]
}

/// The records so far.
struct Sum {
    /// CRC-32 (ISO-HDLC) before its last inversion.
    crc: u32,
    hits: u32,
}

impl Sum {
    fn add(&mut self, hit: Option<Hit>) {
        self.hits = self.hits.wrapping_add(u32::from(hit.is_some()));
        for word in record(hit) {
            self.crc = (0..32).fold(self.crc ^ word, |crc, _| (crc >> 1) ^ ((crc & 1) * 0xedb8_8320));
        }
    }
}

/// The sphere around the scene's bounds.
struct Ball {
    /// Centre, in the caller's coordinates.
    center: Vec3,
    /// From the centre to the greatest corner of the bounds.
    half: Vec3,
    radius: f32,
}

impl Ball {
    fn around(scene: &Scene<'_>) -> Self {
        let bounds = scene.bounds();
        let half = scale(sub(bounds.max, bounds.min), 0.5);
        let center = add(add(scale(bounds.min, 0.5), scale(bounds.max, 0.5)), scene.local_origin());
        Self { center, half, radius: libm::sqrtf(dot(half, half)) }
    }
}

/// A pinhole camera, and the number of the next ray.
struct Camera {
    eye: Vec3,
    /// From the eye to the middle of the picture.
    middle: Vec3,
    /// From the middle to the picture's right edge, and to its upper edge.
    right: Vec3,
    up: Vec3,
    next: u32,
}

impl Camera {
    fn new(ball: &Ball) -> Self {
        let back = unit([0.5, 0.4, 1.0]);
        let right = unit(cross([0.0, 1.0, 0.0], back));
        let up = cross(back, right);
        let eye = scale(back, 2.0 * ball.radius);
        // The least square window, at distance 1, that holds all corners of the bounds.
        let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        for corner in 0..8u32 {
            let [x, y, z] = ball.half;
            let side = |bit: u32, h: f32| if corner & bit == 0 { -h } else { h };
            let to = sub([side(1, x), side(2, y), side(4, z)], eye);
            let depth = -dot(to, back);
            let at = [dot(to, right) / depth, dot(to, up) / depth];
            for ((low, high), at) in low.iter_mut().zip(&mut high).zip(at) {
                *low = if at < *low { at } else { *low };
                *high = if at > *high { at } else { *high };
            }
        }
        let ([left, bottom], [rightmost, top]) = (low, high);
        let (wide, tall) = ((rightmost - left) * 0.5, (top - bottom) * 0.5);
        let reach = if wide > tall { wide } else { tall };
        let middle = add(scale(right, (left + rightmost) * 0.5), scale(up, (bottom + top) * 0.5));
        let (middle, eye) = (sub(middle, back), add(ball.center, eye));
        Self { eye, middle, right: scale(right, reach), up: scale(up, reach), next: 0 }
    }

    fn next(&mut self) -> Ray {
        let at = |i: u32| (i as f32 + 0.5) * (2.0 / SIDE as f32) - 1.0;
        let (x, y) = (at(self.next % SIDE), -at(self.next / SIDE));
        self.next = self.next.wrapping_add(1);
        Ray::new(self.eye, add(self.middle, add(scale(self.right, x), scale(self.up, y))))
    }
}

/// Marsaglia's xorshift32.
struct Random(u32);

impl Random {
    /// Evenly from -1 to 1, in steps of 2^-23.
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        (self.0 >> 8) as f32 * (2.0 / 16_777_216.0) - 1.0
    }

    /// Evenly from the unit sphere.
    fn direction(&mut self) -> Vec3 {
        loop {
            let p = [self.next(), self.next(), self.next()];
            let square = dot(p, p);
            if square > 0.01 && square <= 1.0 {
                return unit(p);
            }
        }
    }

    /// From one point of the sphere towards another.
    fn chord(&mut self, ball: &Ball) -> Ray {
        let (from, to) = (self.direction(), self.direction());
        Ray::new(add(ball.center, scale(from, ball.radius)), scale(sub(to, from), ball.radius))
    }
}

fn add([ax, ay, az]: Vec3, [bx, by, bz]: Vec3) -> Vec3 {
    [ax + bx, ay + by, az + bz]
}

fn sub([ax, ay, az]: Vec3, [bx, by, bz]: Vec3) -> Vec3 {
    [ax - bx, ay - by, az - bz]
}

fn scale([x, y, z]: Vec3, s: f32) -> Vec3 {
    [x * s, y * s, z * s]
}

fn dot([ax, ay, az]: Vec3, [bx, by, bz]: Vec3) -> f32 {
    ax * bx + ay * by + az * bz
}

fn cross([ax, ay, az]: Vec3, [bx, by, bz]: Vec3) -> Vec3 {
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

fn unit(a: Vec3) -> Vec3 {
    let [x, y, z] = a;
    let length = libm::sqrtf(dot(a, a));
    [x / length, y / length, z / length]
}
