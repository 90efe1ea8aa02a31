//! What mailboxes save in a grid: for each input the tests a ray, the tests spared, and the time a ray, with no
//! mailbox, with the last 8 slots, and with a word per primitive.
//!
//!     cargo bench --features cli --bench mailbox [-- IN..]
//!
//! IN is as `flashray build` takes it. Rounds are interleaved, the times medians.
#![allow(missing_docs, clippy::cast_possible_truncation, clippy::cast_precision_loss, clippy::cast_sign_loss)]

#[path = "../src/bin/flashray/mesh/mod.rs"]
#[allow(dead_code, unused_imports)] // `--all-targets` makes tests of what is below, without a harness
mod mesh;
#[path = "../src/bin/flashray/soup.rs"]
mod soup;
#[path = "../src/bin/flashray/spd/mod.rs"]
#[allow(dead_code, unused_imports)] // `--all-targets` makes tests of what is below, without a harness
mod spd;

use flashray::blob::Buffer;
use flashray::blob::prims::Primitive;
use flashray::build::{Config, to_vec};
use flashray::walk::mailbox::{Last8, Mailbox, NoMailbox, Signatures};
use flashray::walk::{Fuel, Steps};
use flashray::{Kind, Ray, Scene};
use soup::Soup;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

const RAYS: usize = 20_000;
const ROUNDS: usize = 9;
const INPUTS: [&str; 5] =
    ["../shared/meshes/bunny.obj", "../shared/meshes/kitchen.obj", "spd:tree", "spd:gears", "spd:lattice"];

fn main() {
    let named: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let inputs = if named.is_empty() { INPUTS.map(str::to_owned).to_vec() } else { named };
    println!("| input | listed a primitive | mailbox | cells a ray | tests a ray | spared a ray | ns a ray |");
    println!("|---|---|---|---|---|---|---|");
    for input in inputs {
        match read(&input) {
            Ok(soup) => measure(&input, &soup),
            Err(why) => eprintln!("{input} is left out: {why}"),
        }
    }
}

fn read(input: &str) -> Result<Soup, String> {
    match input.strip_prefix("spd:") {
        Some(spec) => Ok(spd::scene(spec)?.soup),
        None => mesh::read(Path::new(input)),
    }
}

fn measure(input: &str, soup: &Soup) {
    let blob = Buffer::from(&to_vec(&soup.mesh(), &Config::new(Kind::Grid)).expect("a good mesh")[..]);
    let scene = Scene::from_bytes(&blob).expect("a good blob");
    let rays = rays(&scene);
    let mut words = vec![0; scene.len() as usize];
    let mut boxes = (NoMailbox, Last8::default(), Signatures::new(&mut words));
    let counts = [
        counted(&scene, &rays, &mut boxes.0),
        counted(&scene, &rays, &mut boxes.1),
        counted(&scene, &rays, &mut boxes.2),
    ];
    let mut times = [const { Vec::new() }; 3];
    for _ in 0..ROUNDS {
        times[0].push(timed(&scene, &rays, &mut boxes.0));
        times[1].push(timed(&scene, &rays, &mut boxes.1));
        times[2].push(timed(&scene, &rays, &mut boxes.2));
    }
    let mut listed = 0u64;
    scene.parts(|part| listed += u64::from(part.listed.unwrap_or(0)));
    let listed = listed as f64 / f64::from(scene.len().max(1));
    for ((name, [cells, tests, spared]), times) in ["none", "last 8", "signatures"].iter().zip(counts).zip(&mut times) {
        times.sort_by(f64::total_cmp);
        let name_of = Path::new(input).file_stem().map_or(input.into(), |n| n.to_string_lossy());
        let time = times[ROUNDS / 2];
        println!("| {name_of} | {listed:.2} | {name} | {cells:.2} | {tests:.2} | {spared:.2} | {time:.0} |");
    }
}

/// Cells, tests and spared tests a ray.
fn counted(scene: &Scene<'_>, rays: &[Ray], mailbox: &mut impl Mailbox) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for ray in rays {
        let Steps { nodes, prims, spared } = scene.closest_hit_mailed(ray, mailbox).1;
        sum = [sum[0] + f64::from(nodes), sum[1] + f64::from(prims), sum[2] + f64::from(spared)];
    }
    sum.map(|n| n / rays.len() as f64)
}

/// Nanoseconds a ray, with the meter of a plain query.
fn timed(scene: &Scene<'_>, rays: &[Ray], mailbox: &mut impl Mailbox) -> f64 {
    let start = Instant::now();
    for ray in rays {
        let _ = black_box(scene.closest_hit_metered(ray, &mut Fuel(scene.limits().steps), mailbox));
    }
    start.elapsed().as_secs_f64() * 1e9 / rays.len() as f64
}

/// A third each between points around the scene, from such a point at a primitive, and from a primitive at another.
fn rays(scene: &Scene<'_>) -> Vec<Ray> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut next = move || {
        // xorshift64* (Vigna, ACM TOMS 42(4), 2016).
        state ^= state >> 12;
        state ^= state << 25;
        state ^= state >> 27;
        (state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 40) as f32 / 16_777_216.0
    };
    let prims: Vec<Primitive> = scene.primitives().map(|(_, p)| p).collect();
    let b = scene.bounds();
    let mut ends = Vec::new();
    for i in 0..RAYS {
        let around = [0, 1, 2].map(|k| b.min[k] + (b.max[k] - b.min[k]) * (next() * 2.0 - 0.5));
        let mut surface = || {
            let own = prims[((next() * prims.len() as f32) as usize).min(prims.len() - 1)].bounds();
            [0, 1, 2].map(|k| own.min[k] + (own.max[k] - own.min[k]) * next())
        };
        let (one, two) = (surface(), surface());
        let other = [0, 1, 2].map(|k| b.min[k] + (b.max[k] - b.min[k]) * next());
        ends.push(match i % 3 {
            0 => (around, other),
            1 => (around, one),
            _ => (one, two),
        });
    }
    ends.into_iter().map(|(from, to)| Ray::new(from, [0, 1, 2].map(|k| to[k] - from[k]))).collect()
}
