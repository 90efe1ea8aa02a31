//! `flashray rays`: sample rays, a quarter each from a camera, between points around the scene, through vertices, and
//! through edges, all taken from the blob itself; or one of the kinds that `bench` measures; or hostile ones.
use super::trace::encode_ray;
use crate::camera::{Camera, Vec3, add_scaled, sub, unit};
use crate::hostile::Targets;
use crate::kinds::{KINDS, Order, Rays, Stage};
use crate::random::Random;
use crate::{Failure, file};
use clap::builder::PossibleValuesParser;
use flashray::blob::prims::Primitive;
use flashray::{Ray, Scene};
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Args {
    /// The blob; with --hostile also others over the same scene, whose cells are aimed at too
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// The file of rays to write, in the form that `trace` reads
    #[arg(short, long, value_name = "RAYS")]
    output: PathBuf,
    /// How many, up to 100000000
    #[arg(long, default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(..=MOST))]
    count: u32,
    /// Rays that are known to make trouble: in planes and along lines of cells, at edges, from far away, with odd
    /// intervals
    #[arg(long)]
    hostile: bool,
    /// One kind instead of a sample, as `bench` has them; about as many as --count says
    #[arg(long, value_parser = PossibleValuesParser::new(KINDS), conflicts_with_all = ["hostile", "seed"])]
    kind: Option<String>,
    /// Where the random numbers start
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// The most rays that are made at a time: their file has 3.2 GB.
pub const MOST: i64 = 100_000_000;

pub fn run(args: &Args) -> Result<(), Failure> {
    let all = args.files.iter().map(|path| file::read(path)).collect::<Result<Vec<_>, _>>()?;
    let scenes = args.files.iter().zip(&all).map(|(path, bytes)| file::scene(path, bytes));
    let scenes = scenes.collect::<Result<Vec<_>, _>>()?;
    let count = args.count as usize;
    if scenes.len() > 1 && !args.hostile {
        crate::args::usage("several blobs make sense with --hostile only");
    }
    let spinner = super::spinner("aiming");
    let kind = args.kind.as_ref().and_then(|kind| KINDS.iter().position(|name| name == kind));
    let rays = match (&scenes[..], kind) {
        ([scene], Some(kind)) => {
            Rays::new(&Stage::default(), scene, count, Order::Squares).kinds.into_iter().nth(kind).unwrap_or_default()
        }
        ([scene], None) if !args.hostile => sample(scene, count, args.seed),
        (scenes, _) => Targets::new(scenes).rays(count, args.seed),
    };
    let count = rays.len();
    let rays: Vec<u8> = rays.iter().flat_map(encode_ray).collect();
    file::write(&args.output, &rays)?;
    spinner.finish_and_clear();
    file::say(&format!("{}: {count} rays", args.output.display()))
}

/// A direction, each as likely as any other.
pub fn on_sphere(random: &mut Random) -> Vec3 {
    loop {
        let p = random.point([0.0; 3], [1.0; 3]);
        let square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
        if square > 0.01 && square <= 1.0 {
            return unit(p);
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
        let from = add_scaled(middle, radius, on_sphere(&mut random));
        match i / quarter.max(1) {
            0 if y < side => camera.ray(at(x), -at(y)),
            0 | 1 => Ray::new(from, sub(add_scaled(middle, radius, on_sphere(&mut random)), from)),
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
