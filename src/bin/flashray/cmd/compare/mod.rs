//! `flashray compare`: every structure on one scene, in numbers and in pictures.
mod chart;
mod measure;
mod objects;
mod page;
mod picture;
mod slice;
mod table;
mod trail;

use crate::kinds::{self, Input, Order, Rays};
use crate::{Failure, file};
use clap::ValueEnum;
use flashray::blob::Buffer;
use flashray::{Kind, Scene};
use serde_json::{Map, Value, json};
use slice::Plane;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(clap::Args)]
pub struct Args {
    /// An OBJ, PLY, STL, glTF or GLB file, or spd:NAME[:SIZE]
    #[arg(value_name = "IN")]
    input: String,
    /// A folder for index.html and the slice pictures as SVG; made if it is not there
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Rays of each kind: camera, diffuse, shadow, chord; from 16 to 10000000
    #[arg(long, default_value_t = 50_000, value_parser = clap::value_parser!(u32).range(16..=10_000_000))]
    rays: u32,
    /// Speeds are medians of so many rounds, from 1 to 1000
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Most primitives of a leaf, in structures and by rules that have such a limit: see `build`
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=15))]
    leaf: u32,
    /// How much time building by the surface-area heuristic may take: see `build`
    #[arg(long, value_enum, default_value = "default")]
    quality: super::build::Effort,
    /// The axis that the plane of the pictures is square to
    #[arg(long, value_enum, default_value = "z")]
    slice: Axis,
    /// Where it lies: 0 at the least, 1 at the greatest coordinate. A little beside the middle, where many structures
    /// have a plane of their own
    #[arg(long, value_name = "SHARE", value_parser = share, default_value = "0.48")]
    at: f32,
    /// Print one JSON object instead of tables
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Axis {
    X,
    Y,
    Z,
}

fn share(text: &str) -> Result<f32, String> {
    let share = text.parse().ok().filter(|s| (0.0..=1.0).contains(s));
    share.ok_or(format!("`{text}` is not a number from 0 to 1"))
}

/// A structure as built by one rule.
struct Built {
    kind: Kind,
    /// The rule's name; empty for the list.
    rule: &'static str,
    blob: Buffer,
    seconds: f64,
}

impl Built {
    /// What it is called in messages and files.
    fn name(&self) -> String {
        format!("{} {}", self.kind.name(), self.rule).trim_end().replace(' ', "-")
    }
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let input = Input::read(&args.input)?;
    let steps = flashray::blob::KINDS.len() as u64 * 2 - 1;
    let bar = super::progress("comparing", steps * (u64::from(args.rounds) + 2));
    let built = measure::build_all(args, &input.soup.mesh(), &bar)?;
    let (mut scenes, mut rows) = (Vec::new(), Vec::new());
    for built in &built {
        let start = Instant::now();
        let scene = Scene::from_bytes(&built.blob).map_err(|e| format!("{}: {}: {e}", args.input, built.name()))?;
        rows.push(measure::facts(built, &scene, start.elapsed().as_secs_f64())?);
        scenes.push(scene);
    }
    // Not before the input proved good, and not after all the work.
    if let Some(folder) = &args.output {
        if folder.exists() && !folder.is_dir() {
            return Err(format!("{}: is not a folder", folder.display()));
        }
        std::fs::create_dir_all(folder).map_err(|e| file::failure(folder, &e))?;
    }
    let find = |kind| scenes.iter().rfind(|scene| scene.kind() == kind).ok_or("a structure is missing");
    let (list, bvh) = (find(Kind::List)?, find(Kind::Bvh)?);
    let rays = Rays::new(&input.stage, bvh, args.rays as usize, Order::Rows);
    let truth = measure::Truth::new(list, bvh, &rays);
    for (row, scene) in rows.iter_mut().zip(&scenes) {
        row["wrong"] = json!(truth.wrong(scene, &rays));
        measure::count(row, scene, &rays);
        bar.inc(1);
    }
    measure::time(&mut rows, &scenes, &rays, args.rounds as usize, &bar);
    bar.finish_and_clear();
    let wrong: u64 = rows.iter().filter_map(|row| row["wrong"].as_u64()).sum();
    let mut facts = summary(args, &rays, truth.listed, &rows);
    if let Some(folder) = &args.output {
        let plane = Plane::new(args.slice as usize, args.at, &bvh.bounds());
        facts["page"] = json!(write(folder, &facts, &built, &scenes, &plane, bvh)?);
    }
    file::say(&if args.json { facts.to_string() } else { table::report(&facts) })?;
    if wrong == 0 { Ok(()) } else { Err(format!("{}: {wrong} answers differ from the list's", args.input)) }
}

fn summary(args: &Args, rays: &Rays, listed: usize, rows: &[Value]) -> Value {
    let counts: Map<String, Value> =
        kinds::KINDS.iter().zip(&rays.kinds).map(|(kind, rays)| ((*kind).to_owned(), json!(rays.len()))).collect();
    let all: usize = rays.kinds.iter().map(Vec::len).sum();
    let list = rows.first().map_or(0, |row| row["limits"]["steps"].as_u64().unwrap_or(0));
    json!({
        "scene": args.input, "primitives": list, "leaf": args.leaf, "rounds": args.rounds, "rays": counts,
        "rays_compared": all, "rays_compared_with_list": listed, "structures": rows,
    })
}

/// Writes the page and the pictures, all or none, and says where the page is.
fn write(
    folder: &Path,
    facts: &Value,
    built: &[Built],
    scenes: &[Scene<'_>],
    plane: &Plane,
    reference: &Scene<'_>,
) -> Result<String, Failure> {
    let ray = trail::choose(reference, plane);
    let objects = objects::Objects::new(reference, plane);
    let draw = |(built, scene): (&Built, &Scene<'_>)| {
        let picture = picture::draw(scene, plane, &objects, &ray, built.rule);
        (built.name(), picture)
    };
    let pictures: Vec<(String, picture::Picture)> = built.iter().zip(scenes).map(draw).collect();
    let page = page::write(facts, &pictures);
    let index = folder.join("index.html");
    let mut files = vec![(index.clone(), page)];
    files.extend(pictures.into_iter().map(|(name, picture)| (folder.join(name + ".svg"), picture.svg)));
    let files: Vec<(&Path, &[u8])> = files.iter().map(|(path, text)| (path.as_path(), text.as_bytes())).collect();
    file::write_all(&files)?;
    Ok(index.display().to_string())
}
