//! `flashray demo`: the whole way, on the procedural scenes, with every answer held against the list.
use super::info::Shape;
use super::render::{Picture, Shade, render};
use super::trace::encode_hit;
use crate::camera::Camera;
use crate::spd::{self, Spd};
use crate::{Failure, file};
use flashray::blob::Buffer;
use flashray::build::{Config, to_vec};
use flashray::{Kind, Ray, Scene};
use rayon::prelude::*;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::time::Instant;

#[derive(clap::Args)]
pub struct Args {
    /// The folder for the contact sheet and the blobs; made if it is not there
    #[arg(short, long, value_name = "DIR", default_value = "flashray-demo")]
    output: PathBuf,
    /// Rays of each scene that are compared with the list, up to 100000000
    #[arg(long, default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(..=super::rays::MOST))]
    rays: u32,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

const TILE: (u32, u32) = (320, 320);
const COLUMNS: u32 = 4;
const GAP: u32 = 6;

pub fn run(args: &Args) -> Result<(), Failure> {
    std::fs::create_dir_all(&args.output).map_err(|e| file::failure(&args.output, &e))?;
    let bar = super::progress("demo", spd::NAMES.len() as u64);
    let (mut rows, mut tiles) = (Vec::new(), Vec::new());
    for name in spd::NAMES {
        let (row, tile) = scene(args, name)?;
        rows.push(row);
        tiles.push(tile);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let path = args.output.join("contact-sheet.png");
    let png = sheet(&tiles).png().map_err(|e| format!("{}: {e}", path.display()))?;
    file::write(&path, &png)?;
    file::say(&report(args, &rows, &path.display().to_string()))?;
    match rows.iter().filter_map(|row| row["wrong"].as_u64()).sum() {
        0 => Ok(()),
        wrong => Err(format!("{wrong} answers differ from the list's")),
    }
}

/// Builds a scene, writes the blob, loads it back, compares it with the list, and renders it.
fn scene(args: &Args, name: &str) -> Result<(Value, Picture), Failure> {
    let spd = spd::scene(name)?;
    let build = |kind| to_vec(&spd.soup.mesh(), &Config::new(kind)).map_err(|e| format!("spd:{name}: {e}"));
    let path = args.output.join(format!("{name}.fray"));
    let start = Instant::now();
    let blob = build(Kind::Bvh)?;
    let seconds = start.elapsed().as_secs_f64();
    file::write(&path, &blob)?;
    let bytes = file::read(&path)?;
    let scene = file::checked(&path, &bytes)?;
    let list = Buffer::from(&build(Kind::List)?[..]);
    let list = file::checked(&path, &list)?;
    let mut facts = compare(&scene, &list, &rays(args, &spd, &scene));
    let shape = Shape::new(&scene);
    facts["scene"] = json!(format!("{}:{}", spd.name, spd.size));
    facts["primitives"] = json!(scene.len());
    facts["bytes"] = json!(bytes.len());
    facts["bytes_per_primitive"] = json!(bytes.len() as f64 / f64::from(scene.len()));
    facts["nodes"] = json!(shape.nodes);
    facts["depth"] = json!(shape.depth);
    facts["sah_cost"] = json!(shape.sah_cost);
    facts["build_seconds"] = json!(seconds);
    facts["primary"] = primary(&spd, &scene);
    let light = spd.lights.first().map(|light| light.map(|x| x as f32));
    let hidden = indicatif::ProgressBar::hidden();
    Ok((facts, render(&scene, &camera(&spd), Shade::Normals, TILE, 2, light, &hidden)))
}

/// How many answers differ from the list's in any bit, and how fast both are.
fn compare(scene: &Scene<'_>, list: &Scene<'_>, rays: &[Ray]) -> Value {
    let truth: Vec<_> = rays.par_iter().map(|ray| list.closest_hit(ray)).collect();
    let hits: Vec<_> = rays.par_iter().map(|ray| scene.closest_hit(ray)).collect();
    let [slow, fast] = time(rays, [list, scene]);
    let wrong = hits.iter().zip(&truth).filter(|&(&a, &b)| encode_hit(a) != encode_hit(b)).count();
    json!({ "rays": rays.len(), "wrong": wrong, "mrays_per_second": fast, "list_mrays_per_second": slow })
}

/// Hits and mean distance over the 513 x 513 rays for which counts are published.
fn primary(spd: &Spd, scene: &Scene<'_>) -> Value {
    let rays: Vec<Ray> = spd.view.rays(513).map(|(origin, dir)| Ray::new(origin, dir)).collect();
    let hits: Vec<f64> = rays.par_iter().filter_map(|ray| scene.closest_hit(ray)).map(|hit| f64::from(hit.t)).collect();
    let mean = hits.iter().sum::<f64>() / hits.len() as f64;
    let anchor =
        spd.anchor.map(|a| json!({ "f64": a.hits_ours, "published": a.hits_published, "mean_t_f64": a.mean_t }));
    json!({ "hits": hits.len(), "mean_t": mean, "reference": anchor })
}

fn camera(spd: &Spd) -> Camera {
    let single = |v: [f64; 3]| v.map(|x| x as f32);
    Camera::look(single(spd.view.from), single(spd.view.at), single(spd.view.up), spd.view.fov as f32, 1.0)
}

/// Half from the scene's own view, half of the mixed sample.
fn rays(args: &Args, spd: &Spd, scene: &Scene<'_>) -> Vec<Ray> {
    let side = f64::from(args.rays / 2).sqrt().max(2.0) as u32;
    let view = spd.view.rays(side).map(|(origin, dir)| Ray::new(origin, dir));
    let sample = super::rays::sample(scene, args.rays.saturating_sub(side * side) as usize, 1);
    view.chain(sample).collect()
}

/// Times that each scene is timed; the median counts.
const ROUNDS: usize = 5;
/// Seconds that one round of one scene is to take.
const ROUND: f64 = 0.03;
/// Rays of a first look at how many make a round. A round of that many, not counted, looks again and warms the caches.
const FIRST: usize = 64;

/// Millions of closest hits a second on one thread: the median of rounds, in which the scenes take turns, so that a
/// slow moment of the machine is one for both.
fn time(rays: &[Ray], scenes: [&Scene<'_>; 2]) -> [f64; 2] {
    let rounds = scenes.map(|scene| {
        let round = |rate: f64| Round::new(rays.len(), (rate * 1e6 * ROUND) as usize);
        let guess = Round::new(rays.len(), FIRST).rate(scene, rays, 0);
        round(round(guess).rate(scene, rays, 0))
    });
    let mut rates = [[0.0; ROUNDS]; 2];
    for turn in 0..ROUNDS {
        for ((round, scene), rates) in rounds.iter().zip(scenes).zip(&mut rates) {
            rates[turn] = round.rate(scene, rays, turn);
        }
    }
    rates.map(|mut rates| {
        rates.sort_by(f64::total_cmp);
        rates[ROUNDS / 2]
    })
}

/// What is traced in a round: every so many-th of all rays, or all of them several times.
struct Round {
    stride: usize,
    passes: usize,
}

impl Round {
    /// For about `wanted` of `all` rays. The stride is odd, lest it take the same columns of each row of pixels.
    fn new(all: usize, wanted: usize) -> Self {
        Self { stride: (all / wanted.max(1)) | 1, passes: (wanted / all.max(1)).max(1) }
    }

    /// Millions of rays a second, begun at another ray each turn.
    fn rate(&self, scene: &Scene<'_>, rays: &[Ray], turn: usize) -> f64 {
        let (start, mut done) = (Instant::now(), 0);
        for _ in 0..self.passes {
            for ray in rays.iter().skip(turn * self.stride.min(rays.len()) / ROUNDS).step_by(self.stride) {
                std::hint::black_box(scene.closest_hit(ray));
                done += 1;
            }
        }
        super::millions_per_second(done, start.elapsed().as_secs_f64())
    }
}

/// The tiles, in rows, with gaps.
fn sheet(tiles: &[Picture]) -> Picture {
    let rows = (tiles.len() as u32).div_ceil(COLUMNS);
    let (width, height) = (COLUMNS * (TILE.0 + GAP) + GAP, rows * (TILE.1 + GAP) + GAP);
    let mut pixels = vec![24; width as usize * height as usize * 3];
    for (i, tile) in tiles.iter().enumerate() {
        let (column, row) = (i as u32 % COLUMNS, i as u32 / COLUMNS);
        let (left, top) = (GAP + column * (TILE.0 + GAP), GAP + row * (TILE.1 + GAP));
        for (y, line) in tile.pixels.chunks_exact(tile.width as usize * 3).enumerate() {
            let start = ((top as usize + y) * width as usize + left as usize) * 3;
            if let Some(place) = pixels.get_mut(start..start + line.len()) {
                place.copy_from_slice(line);
            }
        }
    }
    Picture { width, height, pixels }
}

/// Heading, width, decimals and place of each column.
const TABLE: [(&str, usize, usize, &str); 15] = [
    ("scene", 12, 0, "/scene"),
    ("prims", 7, 0, "/primitives"),
    ("bytes", 9, 0, "/bytes"),
    ("B/prim", 8, 1, "/bytes_per_primitive"),
    ("nodes", 7, 0, "/nodes"),
    ("depth", 7, 0, "/depth"),
    ("SAH", 8, 2, "/sah_cost"),
    ("build s", 9, 3, "/build_seconds"),
    ("Mrays/s", 9, 2, "/mrays_per_second"),
    ("list", 9, 4, "/list_mrays_per_second"),
    ("rays", 8, 0, "/rays"),
    ("wrong", 7, 0, "/wrong"),
    ("hits", 8, 0, "/primary/hits"),
    ("f64", 8, 0, "/primary/reference/f64"),
    ("publ.", 8, 0, "/primary/reference/published"),
];

fn report(args: &Args, rows: &[Value], path: &str) -> String {
    if args.json {
        return json!({ "picture": path, "scenes": rows }).to_string();
    }
    let line = |cell: &dyn Fn(usize, usize, &str, &str) -> String| {
        let cells: Vec<String> =
            TABLE.iter().map(|&(head, width, decimals, at)| cell(width, decimals, head, at)).collect();
        cells.concat() + "\n"
    };
    let mut text = line(&|width, _, head, _| format!("{head:>width$}"));
    for row in rows {
        text += &line(&|width, decimals, _, at| match row.pointer(at) {
            Some(Value::String(text)) => format!("{text:>width$}"),
            Some(number) => number.as_f64().map_or(format!("{:>width$}", "-"), |x| format!("{x:>width$.decimals$}")),
            None => format!("{:>width$}", "-"),
        });
    }
    text += "bvh; Mrays/s are closest hits on one thread, beside the list's; wrong: answers that differ from the \
             list's in\nany bit; hits: of the 513 x 513 primary rays, beside those of the f64 reference and the \
             published ones.\n";
    text + path
}
