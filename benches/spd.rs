//! Object tests and steps per ray of every structure on the eight SPD scenes of a published study, over the same mix of
//! rays, beside the study's counts.
//!
//!     cargo bench --features cli --bench spd [-- [--every=N] SCENE ..]
//!     cargo bench --features cli --bench spd -- [--every=N] --docs
//!
//! SCENE is `balls`, or `balls:2` for another size. With `--docs` the tables go into docs/structures.md. `--every=N`
//! counts on every Nth ray, for the impatient. Nothing is timed: the counts are the same on every machine. Every
//! structure must answer every ray that it is counted on with the bvh's bits, or the program fails.
//!
//! The study is Havran, *Heuristic Ray Shooting Algorithms* (2000). Its rays are those of the SPD's testing procedures:
//! 513 x 513 eye rays, reflected and refracted rays up to depth 5, one shadow ray for each light that the surface hit
//! faces (see `whitted.rs`). What can not be the same:
//!
//! - Objects are the study's but for polygons: here a gear's face is 142 triangles and every quadrilateral 2, so
//!   `gears` has 36,610 objects for 9,345, `teapot` 9,408 for 9,264.
//! - Surfaces face as their flat triangles do. The teapot's vertex normals, which bend its reflections, are not used.
//! - Cells here are cubes. So are the study's but for `tree`, whose box is 32 times as wide as it is high: 60 cells on
//!   each axis there, as many in 190 x 190 x 6 here.
//! - Published steps are cells and nodes by the study's own counting; here they are nodes and cells visited, where a
//!   node of the bvh is one step with both its children.
#![allow(missing_docs, clippy::cast_possible_truncation, clippy::cast_precision_loss)]

#[path = "../src/bin/flashray/camera.rs"]
#[allow(dead_code)]
mod camera;
#[path = "../src/bin/flashray/normal.rs"]
mod normal;
mod page;
#[path = "../src/bin/flashray/soup.rs"]
mod soup;
#[path = "../src/bin/flashray/spd/mod.rs"]
#[allow(dead_code, unused_imports)] // `--all-targets` makes tests of what is below, without a harness
mod spd;
mod whitted;

use flashray::blob::Buffer;
use flashray::build::{Config, Rule, to_vec};
use flashray::{Hit, Kind, Scene, Steps};
use rayon::prelude::*;
use spd::Spd;
use std::fmt::Write as _;
use std::process::ExitCode;
use whitted::Rays;

/// What the study publishes of a scene: rays, cells along the longest side of its uniform grid of about 20 cells an
/// object (of a grid of as many cubes), and tests / steps a ray.
struct Study {
    scene: &'static str,
    rays: usize,
    cells: u32,
    /// Uniform grids of 1 and of about 20 cells an object.
    grids: [&'static str; 2],
    /// The best recursive grid, the hierarchy of uniform grids, the adaptive grid.
    nested: [&'static str; 3],
    /// The best of several octrees.
    octree: &'static str,
}

impl Study {
    #[rustfmt::skip]
    const ALL: [Self; 8] = [
        Self { scene: "balls", rays: 1_402_297, cells: 152, grids: ["359 / 5.69", "41.5 / 17.3"],
            nested: ["25.7 / 14.3", "18.8 / 8.6", "14.9 / 11.3"], octree: "26.4 / 16.6" },
        Self { scene: "gears", rays: 2_845_519, cells: 98, grids: ["39.8 / 6.84", "17.5 / 19.0"],
            nested: ["27.2 / 11.4", "32.9 / 7.1", "32 / 13"], octree: "68.8 / 23.5" },
        Self { scene: "lattice", rays: 1_687_153, cells: 59, grids: ["20.7 / 5.09", "8.81 / 13.7"],
            nested: ["34.9 / 6.4", "25.1 / 5.9", "25.2 / 16.8"], octree: "13.7 / 31.2" },
        Self { scene: "mount", rays: 1_334_642, cells: 35, grids: ["19.0 / 8.85", "13.3 / 15.0"],
            nested: ["14.9 / 11.9", "51.8 / 5.6", "16.1 / 17.4"], octree: "23.5 / 23.5" },
        Self { scene: "rings", rays: 1_653_384, cells: 60, grids: ["45.3 / 11.8", "21.5 / 33.7"],
            nested: ["27.8 / 20.7", "25.7 / 12.9", "33.5 / 15.1"], octree: "32.1 / 44.7" },
        Self { scene: "teapot", rays: 895_744, cells: 80, grids: ["33.7 / 15.0", "13.3 / 41.2"],
            nested: ["18.2 / 18.8", "22.6 / 16.4", "19.1 / 15.3"], octree: "45.8 / 44.0" },
        Self { scene: "tetra", rays: 309_431, cells: 40, grids: ["20.6 / 7.43", "9.17 / 18.2"],
            nested: ["21.3 / 12.3", "28.9 / 8.1", "16.0 / 9.5"], octree: "24.1 / 13.9" },
        Self { scene: "tree", rays: 1_373_492, cells: 190, grids: ["728 / 7.60", "355 / 56.4"],
            nested: ["12.0 / 14.6", "10.9 / 5.3", "3.70 / 9.92"], octree: "23.8 / 18.5" },
    ];

    /// The study's counts of the kind's own kin.
    fn of(&self, kind: Kind) -> String {
        let [sparse, dense] = self.grids;
        let [recursive, uniform, adaptive] = self.nested;
        match kind {
            Kind::Grid => format!("D = 1: {sparse}; D about 20: {dense}"),
            Kind::Nested => format!("recursive grid: {recursive}; HUG: {uniform}; adaptive grid: {adaptive}"),
            Kind::Octree => format!("octree: {}", self.octree),
            _ => "-".into(),
        }
    }
}

const KINDS: [Kind; 7] = [Kind::Grid, Kind::Voxel, Kind::Nested, Kind::Octree, Kind::Bsp, Kind::Bvh, Kind::Sphere];
/// Where a ray is tested against more than so many objects, a sample of the rays is enough,
const CROWD: u64 = 100;
/// every 16th of the others.
const SAMPLE: usize = 16;

fn main() -> ExitCode {
    let (options, named): (Vec<String>, Vec<String>) = std::env::args().skip(1).partition(|a| a.starts_with("--"));
    let docs = options.iter().any(|option| option == "--docs");
    if docs && !named.is_empty() {
        return failure("--docs takes all scenes");
    }
    let specs = if named.is_empty() { Study::ALL.map(|study| study.scene.to_owned()).to_vec() } else { named };
    let every = options.iter().find_map(|option| option.strip_prefix("--every=")).map_or(Ok(1), str::parse);
    let Ok(every @ 1..) = every else { return failure("--every takes a number from 1") };
    let mut tables = Tables::new(every);
    for spec in &specs {
        match spd::scene(spec) {
            Ok(spd) => tables.add(&spd),
            Err(why) => return failure(&why),
        }
    }
    println!("{}", tables.text());
    if tables.wrong > 0 {
        return failure(&format!("{} answers differ from the bvh's", tables.wrong));
    }
    match docs.then(|| page::put("spd counts", &tables.text())) {
        Some(Err(why)) => failure(&why),
        _ => ExitCode::SUCCESS,
    }
}

fn failure(why: &str) -> ExitCode {
    eprintln!("{why}");
    ExitCode::FAILURE
}

/// Both tables as they grow, scene by scene.
struct Tables {
    rays: String,
    counts: String,
    /// Counted is every so manieth ray.
    every: usize,
    wrong: usize,
}

impl Tables {
    fn new(every: usize) -> Self {
        let rays = "| scene | eye | reflected | refracted | shadow | all | the study's | ratio |\n\
            |---|---:|---:|---:|---:|---:|---:|---:|\n";
        let counts = "| scene | structure | textbook rule | cost rule | published |\n|---|---|---:|---:|---|\n";
        Self { rays: rays.into(), counts: counts.into(), every, wrong: 0 }
    }

    fn add(&mut self, spd: &Spd) {
        let bvh = build(spd, &Config::new(Kind::Bvh));
        let rays = Rays::new(spd, &Scene::from_bytes(&bvh).expect("a good blob"), 513);
        // What is published holds for the published sizes.
        let study = Study::ALL.iter().find(|study| study.scene == spd.name && spd.anchor.is_some());
        let (count, known) = (rays.count(), study.map(|study| study.rays));
        let ratio = known.map_or("-".into(), |known| format!("{:.3}", count as f64 / known as f64));
        let known = known.map_or("-".into(), thousands);
        let parts = [rays.eye, rays.reflected, rays.refracted, rays.shadow.len(), count].map(thousands).join(" | ");
        // Writing to a string does not fail, here and below.
        let _ = writeln!(self.rays, "| {} | {parts} | {known} | {ratio} |", spd.name);
        for kind in KINDS {
            let counts = [Rule::Seed, Rule::Sah].map(|rule| self.count(spd, &Config::new(kind).rule(rule), &rays));
            let published = study.map_or("-".into(), |study| study.of(kind));
            self.row(spd, kind.name(), &counts.join(" | "), &published);
            if let (Kind::Grid, Some(study)) = (kind, study) {
                let count = self.count(spd, &Config::new(kind).cells(study.cells), &rays);
                let name = format!("grid of {} cells a side", study.cells);
                self.row(spd, &name, &format!("{count} | -"), &format!("D about 20: {}", study.grids[1]));
            }
        }
    }

    fn row(&mut self, spd: &Spd, structure: &str, counts: &str, published: &str) {
        eprintln!("{} {structure}: {counts}", spd.name);
        let _ = writeln!(self.counts, "| {} | {structure} | {counts} | {published} |", spd.name);
    }

    /// Tests / steps a ray, with every answer compared.
    fn count(&mut self, spd: &Spd, config: &Config, rays: &Rays) -> String {
        let blob = build(spd, config);
        let scene = Scene::from_bytes(&blob).expect("a good blob");
        let probe = Sum::new(&scene, rays, self.every * SAMPLE * SAMPLE);
        let crowded = probe.tests > probe.rays * CROWD;
        let sum = Sum::new(&scene, rays, if crowded { self.every * SAMPLE } else { self.every });
        if sum.wrong > 0 {
            eprintln!("{}, {} {:?}: {} answers are wrong", spd.name, config.kind.name(), config.rule, sum.wrong);
        }
        self.wrong += sum.wrong;
        let each = |n: u64| n as f64 / sum.rays as f64;
        format!("{}{:.2} / {:.2}", if crowded { "~ " } else { "" }, each(sum.tests), each(sum.steps))
    }

    fn text(&self) -> String {
        let of = if self.every == 1 { "all rays".into() } else { format!("one ray in {}", self.every) };
        let sample = self.every * SAMPLE;
        format!(
            "{}\nCounted on {of}; with ~, where a ray is tested against more than {CROWD} objects, on one in {sample}.\n\n{}",
            self.rays, self.counts
        )
    }
}

/// What rays cost.
#[derive(Clone, Copy, Default)]
struct Sum {
    rays: u64,
    tests: u64,
    steps: u64,
    /// Answers that are not the bvh's.
    wrong: usize,
}

impl Sum {
    /// Of every so manieth ray.
    fn new(scene: &Scene<'_>, rays: &Rays, every: usize) -> Self {
        let closest = rays.closest.par_iter().step_by(every).map(|(ray, hit)| {
            let (found, steps) = scene.closest_hit_counted(ray);
            let bits = |hit: &Option<Hit>| hit.map(|h| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.prim));
            (bits(&found) == bits(hit), steps)
        });
        let shadow = rays.shadow.par_iter().step_by(every).map(|(ray, shadowed)| {
            let (found, steps) = scene.any_hit_counted(ray);
            (found == *shadowed, steps)
        });
        closest.chain(shadow).map(Self::one).reduce(Self::default, Self::plus)
    }

    fn one((right, Steps { nodes, prims, .. }): (bool, Steps)) -> Self {
        Self { rays: 1, tests: u64::from(prims), steps: u64::from(nodes), wrong: usize::from(!right) }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            tests: self.tests + other.tests,
            steps: self.steps + other.steps,
            wrong: self.wrong + other.wrong,
        }
    }
}

fn build(spd: &Spd, config: &Config) -> Buffer {
    Buffer::from(&to_vec(&spd.soup.mesh(), config).expect("a good mesh")[..])
}

/// With commas: 1,402,297.
fn thousands(n: usize) -> String {
    let digits = n.to_string();
    let groups: Vec<&str> = digits.as_bytes().rchunks(3).rev().filter_map(|g| std::str::from_utf8(g).ok()).collect();
    groups.join(",")
}
