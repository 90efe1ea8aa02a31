//! `flashray rays`: sample rays, a quarter each from a camera, between points around the scene, through vertices, and
//! through edges, all taken from the blob itself.
use super::trace::encode_ray;
use crate::camera::{Camera, Vec3, add_scaled, sub, unit};
use crate::{Failure, file};
use flashray::blob::prims::Primitive;
use flashray::{Ray, Scene};
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Args {
    /// The blob
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The file of rays to write, in the form that `trace` reads
    #[arg(short, long, value_name = "RAYS")]
    output: PathBuf,
    /// How many, up to 100000000
    #[arg(long, default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(..=MOST))]
    count: u32,
    /// Where the random numbers start
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// The most rays that are made at a time: their file has 3.2 GB.
pub const MOST: i64 = 100_000_000;

pub fn run(args: &Args) -> Result<(), Failure> {
    let bytes = file::read(&args.file)?;
    let scene = file::scene(&args.file, &bytes)?;
    let rays: Vec<u8> = sample(&scene, args.count as usize, args.seed).iter().flat_map(encode_ray).collect();
    file::write(&args.output, &rays)?;
    file::say(&format!("{}: {} rays", args.output.display(), args.count))
}

/// `xorshift64*` (Vigna, ACM TOMS 42(4), 2016): the same rays everywhere.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    fn next(&mut self) -> u32 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 32) as u32
    }

    /// From 0 to below 1.
    pub fn unit(&mut self) -> f32 {
        (self.next() >> 8) as f32 / 16_777_216.0
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() as usize) % n.max(1)
    }

    fn on_sphere(&mut self) -> Vec3 {
        loop {
            let p = [0.0; 3].map(|_: f32| self.unit() * 2.0 - 1.0);
            let square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
            if square > 0.01 && square <= 1.0 {
                return unit(p);
            }
        }
    }
}

/// The sample of a scene.
pub fn sample(scene: &Scene<'_>, count: usize, seed: u64) -> Vec<Ray> {
    let bounds = scene.bounds();
    let middle = [0, 1, 2].map(|k| bounds.min[k] / 2.0 + bounds.max[k] / 2.0);
    let radius = [0, 1, 2].map(|k| bounds.max[k] - middle[k]).iter().fold(f32::MIN_POSITIVE, |a, &b| a.max(b)) * 1.8;
    let prims: Vec<Primitive> = scene.primitives().map(|(_, p)| p).collect();
    let camera = Camera::frame(&bounds, [0.0, 1.0, 0.0], 45.0, 1.0);
    let mut random = Random::new(seed);
    let (quarter, local) = (count / 4, scene.local_origin());
    let side = (quarter as f64).sqrt().max(1.0) as usize;
    let mut ray = |i: usize| {
        let (x, y) = (i % side, i / side);
        let at = |k: usize| (k as f32 + 0.5) / side as f32 * 2.0 - 1.0;
        let from = add_scaled(middle, radius, random.on_sphere());
        match i / quarter.max(1) {
            0 if y < side => camera.ray(at(x), -at(y)),
            0 | 1 => Ray::new(from, sub(add_scaled(middle, radius, random.on_sphere()), from)),
            2 => Ray::new(from, sub(point(&prims, &mut random, false), from)),
            _ => Ray::new(from, sub(point(&prims, &mut random, true), from)),
        }
    };
    let shifted = |r: Ray| Ray { origin: add_scaled(r.origin, 1.0, local), ..r };
    (0..count).map(|i| shifted(ray(i))).collect()
}

/// A vertex of a random primitive, or a point on an edge.
fn point(prims: &[Primitive], random: &mut Random, edge: bool) -> Vec3 {
    let at = random.below(prims.len());
    match prims.get(at) {
        Some(Primitive::Triangle(t)) => {
            let k = random.below(3);
            let share = if edge { random.unit() } else { 0.0 };
            add_scaled(t.v[k], share, sub(t.v[(k + 1) % 3], t.v[k]))
        }
        Some(other) => {
            // The silhouette and the poles of the curved ones lie on their boxes.
            let b = other.bounds();
            [0, 1, 2].map(|k| if random.below(2) == 0 { b.min[k] } else { b.max[k] / 2.0 + b.min[k] / 2.0 })
        }
        None => [0.0; 3],
    }
}
