//! `flashray bench`: how fast queries are on one thread, for each structure, instruction set, mode and kind of rays.
mod measure;
mod report;

use super::trace::Mode;
use crate::kinds::{self, Input, KINDS, Order, Rays, Stage};
use crate::{Failure, file};
use clap::ValueEnum;
use flashray::blob::{Buffer, MAGIC};
use flashray::build::{Config, to_buffer};
use flashray::walk::Isa;
use flashray::{Kind, Scene};
use measure::Times;
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

#[derive(clap::Args)]
pub struct Args {
    /// Blobs, or what `build` takes: OBJ, PLY, STL, glTF or GLB files, or spd:NAME[:SIZE]. Each is a scene of its own
    #[arg(required = true, value_name = "FILE")]
    files: Vec<String>,
    /// The structures that are built of what is no blob yet; several with commas between. wide4 is wide with nodes of four
    #[arg(long, value_name = "NAME,..", value_delimiter = ',', value_parser = super::build::structures_and_widths(),
        default_value = "wide,bvh")]
    structure: Vec<(&'static str, Config)>,
    /// Rays of each kind: camera, diffuse, shadow, chord; from 64 to 10000000
    #[arg(long, default_value_t = 65_536, value_parser = clap::value_parser!(u32).range(64..=10_000_000))]
    rays: u32,
    /// Speeds are medians of so many rounds, in each of which all take turns; from 1 to 1000
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Print one JSON object instead of tables
    #[arg(long)]
    json: bool,
}

/// A blob of the scene.
struct Built {
    /// What its structure is called.
    name: &'static str,
    blob: Buffer,
    /// None for what was a blob before.
    seconds: Option<f64>,
}

/// One way to ask: a structure, its instructions, and how many rays at a time.
struct Way<'a> {
    structure: &'static str,
    scene: Scene<'a>,
    mode: Mode,
    /// The name of the instruction set, of those structures that use any.
    lanes: Option<&'static str>,
}

impl Way<'_> {
    /// What it is called in messages and tables.
    fn name(&self) -> String {
        [self.structure, self.lanes.unwrap_or("-"), &report::name(self.mode)].join(" ")
    }
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let measured = args.files.iter().map(|name| one(name, args)).collect::<Result<Vec<Value>, _>>()?;
    let facts = json!({ "rounds": args.rounds, "files": measured });
    file::say(&if args.json { facts.to_string() } else { report::text(&facts) })
}

/// All that is measured of one scene.
fn one(name: &str, args: &Args) -> Result<Value, Failure> {
    let spinner = super::spinner("building");
    let (built, stage) = load(name, &args.structure)?;
    spinner.set_message("checking");
    let check = |built: &'_ Built| Scene::from_bytes(&built.blob).map(|_| ());
    built.iter().try_for_each(check).map_err(|e| format!("{name}: {e}"))?;
    spinner.finish_and_clear();
    // What was checked just now.
    let scenes = built.iter().map(|built| Scene::trust(&built.blob)).collect::<Result<Vec<_>, _>>();
    let scenes = scenes.map_err(|e| format!("{name}: {e}"))?;
    let first = scenes.first().ok_or("no structure")?;
    let rays = Rays::new(&stage, first, args.rays as usize, Order::Squares);
    let away = kinds::away(first, args.rays as usize);
    let ways: Vec<Way<'_>> = built.iter().zip(&scenes).flat_map(|(built, scene)| ways(built.name, scene)).collect();
    let bar = super::progress("measuring", u64::from(args.rounds) * 5 * ways.len() as u64);
    let times = Times::new(&ways, &rays, &away, args.rounds as usize, &bar).map_err(|why| format!("{name}: {why}"))?;
    bar.finish_and_clear();
    let structures = built.iter().zip(&scenes).map(|(built, scene)| report::structure(built, scene, &rays));
    let counts: serde_json::Map<String, Value> =
        KINDS.iter().zip(&rays.kinds).map(|(kind, rays)| ((*kind).to_owned(), json!(rays.len()))).collect();
    Ok(json!({
        "file": name, "primitives": first.len(), "rays": counts, "structures": structures.collect::<Vec<_>>(),
        "ways": ways.iter().zip(times.all).map(|(way, times)| report::way(way, times)).collect::<Vec<_>>(),
    }))
}

/// A blob as it is, or each structure of what is to be built.
fn load(name: &str, structures: &[(&'static str, Config)]) -> Result<(Vec<Built>, Stage), Failure> {
    let path = Path::new(name);
    let is_mesh = name.starts_with("spd:") || path.extension().is_some_and(|end| end != "fray");
    if !is_mesh || begins_as_a_blob(path) {
        let blob = file::read(path)?;
        // What is no blob is told of when it is checked.
        let name = Scene::trust(&blob).map_or("", |scene| called(&scene));
        return Ok((vec![Built { name, blob, seconds: None }], Stage::default()));
    }
    let input = Input::read(name)?;
    let build = |(structure, config): &(&'static str, Config)| {
        let start = Instant::now();
        let blob = to_buffer(&input.soup.mesh(), config).map_err(|e| format!("{name}: {e}"))?;
        let seconds = Some(start.elapsed().as_secs_f64());
        Ok(Built { name: structure, blob, seconds })
    };
    Ok((structures.iter().map(build).collect::<Result<Vec<_>, Failure>>()?, input.stage))
}

/// Whatever a file is called, a blob is one.
fn begins_as_a_blob(path: &Path) -> bool {
    path.is_file() && file::read(path).is_ok_and(|bytes| bytes.get(..4) == Some(&MAGIC.to_le_bytes()[..]))
}

/// The name of a blob's structure.
fn called(scene: &Scene<'_>) -> &'static str {
    if scene.width() == Some(4) { "wide4" } else { scene.kind().name() }
}

/// Every instruction set in every mode.
fn ways<'a>(structure: &'static str, scene: &Scene<'a>) -> Vec<Way<'a>> {
    let modes =
        |scene: Scene<'a>, lanes| Mode::value_variants().iter().map(move |&mode| Way { structure, scene, mode, lanes });
    if scene.kind() == Kind::Wide {
        let of = |isa: Isa| modes(scene.with_isa(isa), Some(isa.name()));
        Isa::all().flat_map(of).collect()
    } else {
        modes(*scene, None).collect()
    }
}
