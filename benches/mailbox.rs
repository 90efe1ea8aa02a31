//! What mailboxes save in the structures that list a primitive in several cells: for each scene, structure and query
//! the tests a ray, the tests that the last 8 slots and a word per primitive spare, and the time a ray without a
//! mailbox and with each.
//!
//!     cargo bench --features cli --bench mailbox [-- [--docs] IN ..]
//!
//! IN is as `flashray build` takes it: three procedural scenes unless told otherwise (one of like objects spread
//! evenly, one between, one uneven), and two meshes where their files are. With `--docs` the table goes into
//! docs/structures.md. Structures are as the default rule builds them; rays are the same for all of them. Rounds are
//! interleaved, the times medians; those of any hit include the counting, with a mailbox or without.
#![allow(missing_docs, clippy::cast_possible_truncation, clippy::cast_precision_loss, clippy::cast_sign_loss)]

#[path = "../src/bin/flashray/mesh/mod.rs"]
#[allow(dead_code, unused_imports)] // `--all-targets` makes tests of what is below, without a harness
mod mesh;
mod page;
#[path = "../src/bin/flashray/soup.rs"]
mod soup;
#[path = "../src/bin/flashray/spd/mod.rs"]
#[allow(dead_code, unused_imports)] // `--all-targets` makes tests of what is below, without a harness
mod spd;

use flashray::blob::Buffer;
use flashray::blob::prims::Primitive;
use flashray::build::{Config, to_vec};
use flashray::walk::Fuel;
use flashray::walk::mailbox::{Last8, Mailbox, NoMailbox, Signatures};
use flashray::{Kind, Ray, Scene};
use soup::Soup;
use std::hint::black_box;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

const RAYS: usize = 20_000;
const ROUNDS: usize = 9;
const INPUTS: [&str; 5] =
    ["spd:lattice", "spd:gears", "spd:tree", "../shared/meshes/bunny.obj", "../shared/meshes/kitchen.obj"];
/// What lists a primitive in several cells.
const KINDS: [Kind; 5] = [Kind::Grid, Kind::Voxel, Kind::Nested, Kind::Octree, Kind::Bsp];
const HEADS: &str = "\
    | scene | structure | refs | query | tests | spared by 8 | by a word each | ns without | with 8 | a word each |\n\
    |---|---|---:|---|---:|---:|---:|---:|---:|---:|\n";

fn main() -> ExitCode {
    let (options, named): (Vec<String>, Vec<String>) = std::env::args().skip(1).partition(|a| a.starts_with("--"));
    let inputs = if named.is_empty() { INPUTS.map(str::to_owned).to_vec() } else { named };
    let mut table = HEADS.to_owned();
    print!("{table}");
    for input in inputs {
        match read(&input) {
            Ok(soup) => table += &rows(&input, &soup),
            Err(why) => eprintln!("{input} is left out: {why}"),
        }
    }
    match options.iter().any(|option| option == "--docs").then(|| page::put("mailbox", &table)) {
        Some(Err(why)) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
        _ => ExitCode::SUCCESS,
    }
}

fn read(input: &str) -> Result<Soup, String> {
    match input.strip_prefix("spd:") {
        Some(spec) => Ok(spd::scene(spec)?.soup),
        None => mesh::read(Path::new(input)),
    }
}

/// Every structure over a scene, for both queries.
fn rows(input: &str, soup: &Soup) -> String {
    let (mut rows, mut shot) = (String::new(), Vec::new());
    let name = input.strip_prefix("spd:").or(Path::new(input).file_stem().and_then(|n| n.to_str())).unwrap_or(input);
    for kind in KINDS {
        let blob = Buffer::from(&to_vec(&soup.mesh(), &Config::new(kind)).expect("a good mesh")[..]);
        let scene = Scene::from_bytes(&blob).expect("a good blob");
        if shot.is_empty() {
            shot = rays(&scene);
        }
        let mut listed = 0u64;
        scene.parts(|part| listed += u64::from(part.listed.unwrap_or(0)));
        let refs = listed as f64 / f64::from(scene.len().max(1));
        for (query, costs) in [("closest", costs::<false>(&scene, &shot)), ("any", costs::<true>(&scene, &shot))] {
            let row = format!("| {name} | {} | {refs:.2} | {query} | {costs} |\n", kind.name());
            print!("{row}");
            rows += &row;
        }
    }
    rows
}

/// The cells of a row that tell of a query.
fn costs<const ANY: bool>(scene: &Scene<'_>, rays: &[Ray]) -> String {
    let mut words = vec![0; scene.len() as usize];
    let mut boxes = (NoMailbox, Last8::default(), Signatures::new(&mut words));
    let [tests, _] = counted::<ANY>(scene, rays, &mut boxes.0);
    let [_, eight] = counted::<ANY>(scene, rays, &mut boxes.1);
    let [_, all] = counted::<ANY>(scene, rays, &mut boxes.2);
    let mut times = [const { Vec::new() }; 3];
    for _ in 0..ROUNDS {
        times[0].push(timed::<ANY>(scene, rays, &mut boxes.0));
        times[1].push(timed::<ANY>(scene, rays, &mut boxes.1));
        times[2].push(timed::<ANY>(scene, rays, &mut boxes.2));
    }
    let [none, last, each] = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[ROUNDS / 2]
    });
    format!("{tests:.2} | {eight:.2} | {all:.2} | {none:.0} | {last:.0} | {each:.0}")
}

/// Tests and spared tests a ray.
fn counted<const ANY: bool>(scene: &Scene<'_>, rays: &[Ray], mailbox: &mut impl Mailbox) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for ray in rays {
        let steps = if ANY { scene.any_hit_mailed(ray, mailbox).1 } else { scene.closest_hit_mailed(ray, mailbox).1 };
        sum = [sum[0] + f64::from(steps.prims), sum[1] + f64::from(steps.spared)];
    }
    sum.map(|n| n / rays.len() as f64)
}

/// Nanoseconds a ray; for the closest hit with the meter of a plain query.
fn timed<const ANY: bool>(scene: &Scene<'_>, rays: &[Ray], mailbox: &mut impl Mailbox) -> f64 {
    let start = Instant::now();
    for ray in rays {
        if ANY {
            let _ = black_box(scene.any_hit_mailed(ray, mailbox));
        } else {
            let _ = black_box(scene.closest_hit_metered(ray, &mut Fuel(scene.limits().steps), mailbox));
        }
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
