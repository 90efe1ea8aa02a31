//! `flashray trace`, and the files of rays and hits.
use crate::{Failure, file};
use clap::ValueEnum;
use flashray::walk::PacketSize;
use flashray::{Hit, Ray, Scene};
use rayon::prelude::*;
use std::path::PathBuf;
use std::time::Instant;

#[derive(clap::Args)]
pub struct Args {
    /// The blob
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Rays: 32 bytes each, little-endian f32: origin x y z, least t, direction x y z, greatest t
    #[arg(long, value_name = "RAYS")]
    rays: PathBuf,
    /// Hits: 16 bytes a ray, t u v (f32) and prim (u32); a miss is +inf 0 0 0xffffffff. With --any one byte, 0 or 1
    #[arg(short, long, value_name = "HITS")]
    output: PathBuf,
    /// Ask only whether there is a hit
    #[arg(long)]
    any: bool,
    /// How rays are handed to the library: the answers are the same
    #[arg(long, value_enum, default_value = "single")]
    mode: Mode,
    /// Rays of a packet, with --mode packet
    #[arg(long, value_enum, default_value = "8")]
    packet: Size,
    /// Threads, up to 1024; 0 means one per core
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u32).range(..=1024))]
    threads: u32,
    /// Print one JSON object instead of a sentence
    #[arg(long)]
    json: bool,
}

/// How rays are handed to the library.
#[derive(Clone, Copy, ValueEnum)]
pub enum Mode {
    /// One ray a call
    Single,
    /// Many rays a call
    Group,
    /// Many rays a call, and so many of them against a box or a triangle
    Packet,
}

#[derive(Clone, Copy, ValueEnum)]
enum Size {
    #[value(name = "4")]
    Four,
    #[value(name = "8")]
    Eight,
    #[value(name = "16")]
    Sixteen,
}

impl Size {
    const fn of(self) -> PacketSize {
        match self {
            Self::Four => PacketSize::Four,
            Self::Eight => PacketSize::Eight,
            Self::Sixteen => PacketSize::Sixteen,
        }
    }
}

impl Mode {
    /// The closest hits of many rays.
    pub fn closest(self, scene: &Scene<'_>, of: PacketSize, rays: &[Ray], hits: &mut [Option<Hit>]) {
        match self {
            Self::Single => rays.iter().zip(hits).for_each(|(ray, hit)| *hit = scene.closest_hit(ray)),
            Self::Group => scene.closest_hits(rays, hits),
            Self::Packet => scene.closest_hits_in_packets(of, rays, hits),
        }
    }

    /// Whether they hit anything.
    pub fn any(self, scene: &Scene<'_>, of: PacketSize, rays: &[Ray], hits: &mut [bool]) {
        match self {
            Self::Single => rays.iter().zip(hits).for_each(|(ray, hit)| *hit = scene.any_hit(ray)),
            Self::Group => scene.any_hits(rays, hits),
            Self::Packet => scene.any_hits_in_packets(of, rays, hits),
        }
    }
}

const RAY: usize = 32;

/// Rays that a thread takes at a time.
const CHUNK: usize = 4096;

pub fn run(args: &Args) -> Result<(), Failure> {
    let bytes = file::read(&args.file)?;
    let scene = file::scene(&args.file, &bytes)?;
    let rays = file::read(&args.rays)?;
    if rays.len() % RAY != 0 {
        let (path, found) = (args.rays.display(), rays.len());
        return Err(format!(
            "{path}: {found} bytes are no whole number of rays of {RAY}: {} are left over",
            found % RAY
        ));
    }
    let rays: Vec<Ray> = rays.par_chunks_exact(RAY).map(decode).collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads as usize).build();
    let pool = pool.map_err(|e| format!("{} threads: {e}", args.threads))?;
    let start = Instant::now();
    let (mode, of) = (args.mode, args.packet.of());
    let (hits, count) =
        pool.install(|| if args.any { any(&scene, &rays, mode, of) } else { closest(&scene, &rays, mode, of) });
    let seconds = start.elapsed().as_secs_f64();
    file::write(&args.output, &hits)?;
    let rate = super::millions_per_second(rays.len(), seconds);
    let threads = pool.current_num_threads();
    if args.json {
        let facts = serde_json::json!({
            "rays": rays.len(), "hits": count, "seconds": seconds, "mrays_per_second": rate, "threads": threads,
        });
        file::say(&facts.to_string())
    } else {
        let (path, rays) = (args.output.display(), rays.len());
        file::say(&format!("{path}: {rays} rays, {count} hits, {rate:.2} Mrays/s, threads: {threads}"))
    }
}

/// Answers in the file's form, and how many rays hit.
fn closest(scene: &Scene<'_>, rays: &[Ray], mode: Mode, of: PacketSize) -> (Vec<u8>, usize) {
    let mut hits = vec![None; rays.len()];
    each(rays, &mut hits, "tracing", |rays, hits: &mut [Option<Hit>]| mode.closest(scene, of, rays, hits));
    (hits.iter().copied().flat_map(encode_hit).collect(), hits.iter().flatten().count())
}

fn any(scene: &Scene<'_>, rays: &[Ray], mode: Mode, of: PacketSize) -> (Vec<u8>, usize) {
    let mut hits = vec![false; rays.len()];
    each(rays, &mut hits, "tracing", |rays, hits: &mut [bool]| mode.any(scene, of, rays, hits));
    (hits.iter().map(|&hit| u8::from(hit)).collect(), hits.iter().filter(|&&hit| hit).count())
}

/// Runs `work` on chunks on all threads.
fn each<H: Send>(rays: &[Ray], hits: &mut [H], what: &'static str, work: impl Fn(&[Ray], &mut [H]) + Sync) {
    let bar = super::progress(what, rays.len() as u64);
    rays.par_chunks(CHUNK).zip(hits.par_chunks_mut(CHUNK)).for_each(|(rays, hits)| {
        work(rays, hits);
        bar.inc(rays.len() as u64);
    });
    bar.finish_and_clear();
}

/// A ray from its 32 bytes.
pub fn decode(bytes: &[u8]) -> Ray {
    let mut words = bytes.chunks_exact(4).map(|b| b.try_into().map_or(0.0, f32::from_le_bytes));
    let mut next = || words.next().unwrap_or(0.0);
    let (origin, t_min) = ([next(), next(), next()], next());
    let (dir, t_max) = ([next(), next(), next()], next());
    Ray { origin, dir, t_min, t_max }
}

/// A ray's 32 bytes.
pub fn encode_ray(ray: &Ray) -> [u8; RAY] {
    let (o, d) = (ray.origin, ray.dir);
    let mut bytes = [0; RAY];
    let words = [o[0], o[1], o[2], ray.t_min, d[0], d[1], d[2], ray.t_max];
    for (place, word) in bytes.chunks_exact_mut(4).zip(words) {
        place.copy_from_slice(&word.to_le_bytes());
    }
    bytes
}

/// An answer's 16 bytes.
pub fn encode_hit(hit: Option<Hit>) -> [u8; 16] {
    let hit = hit.unwrap_or(Hit { t: f32::INFINITY, u: 0.0, v: 0.0, prim: u32::MAX });
    let mut bytes = [0; 16];
    let words = [hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.prim];
    for (place, word) in bytes.chunks_exact_mut(4).zip(words) {
        place.copy_from_slice(&word.to_le_bytes());
    }
    bytes
}
