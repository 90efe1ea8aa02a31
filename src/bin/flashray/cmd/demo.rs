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
    /// Rays of each scene that are compared with the list
    #[arg(long, default_value_t = 20_000)]
    rays: usize,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

const TILE: (u32, u32) = (320, 320);
const COLUMNS: u32 = 4;
const GAP: u32 = 6;

/// What the demo found of one scene.
struct Row {
    name: String,
    facts: Value,
    wrong: usize,
    line: String,
}

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
    report(args, &rows, &path.display().to_string());
    match rows.iter().map(|r| r.wrong).sum() {
        0 => Ok(()),
        wrong => Err(format!("{wrong} answers differ from the list's")),
    }
}

/// Builds a scene, writes the blob, loads it back, compares it with the list, and renders it.
fn scene(args: &Args, name: &str) -> Result<(Row, Picture), Failure> {
    let spd = spd::scene(name)?;
    let build = |kind| to_vec(&spd.soup.mesh(), &Config::new(kind)).map_err(|e| format!("spd:{name}: {e}"));
    let path = args.output.join(format!("{name}.fray"));
    let start = Instant::now();
    let blob = build(Kind::Bvh)?;
    let seconds = start.elapsed().as_secs_f64();
    file::write(&path, &blob)?;
    let bytes = file::read(&path)?;
    let scene = file::scene(&path, &bytes)?;
    let list = Buffer::from(&build(Kind::List)?[..]);
    let list = file::scene(&path, &list)?;
    let rays = rays(args, &spd, &scene);
    let (slow, list_hits) = time(&rays, |ray| list.closest_hit(ray));
    let (fast, hits) = time(&rays, |ray| scene.closest_hit(ray));
    let wrong = hits.iter().zip(&list_hits).filter(|(a, b)| encode_hit(a) != encode_hit(b)).count();
    let shape = Shape::new(&scene);
    let per_prim = bytes.len() as f64 / f64::from(scene.len());
    let line = format!(
        "{name:<9}{:>7}{:>10}{per_prim:>7.1}{:>8}{:>6}{:>8.1}{seconds:>8.3}{fast:>9.2}{:>10.0}x{:>8}{wrong:>6}",
        scene.len(),
        bytes.len(),
        shape.nodes,
        shape.depth,
        shape.sah_cost,
        fast / slow,
        rays.len()
    );
    let facts = json!({
        "scene": name, "primitives": scene.len(), "bytes": bytes.len(), "bytes_per_primitive": per_prim,
        "nodes": shape.nodes, "depth": shape.depth, "sah_cost": shape.sah_cost, "build_seconds": seconds,
        "mrays_per_second": fast, "list_mrays_per_second": slow, "rays": rays.len(), "wrong": wrong,
    });
    let picture = render(&scene, &camera(&spd), Shade::Normals, TILE, 2, &indicatif::ProgressBar::hidden());
    Ok((Row { name: name.into(), facts, wrong, line }, picture))
}

fn camera(spd: &Spd) -> Camera {
    let single = |v: [f64; 3]| v.map(|x| x as f32);
    Camera::look(single(spd.view.from), single(spd.view.at), single(spd.view.up), spd.view.fov as f32, 1.0)
}

/// Half from the scene's own view, half of the mixed sample.
fn rays(args: &Args, spd: &Spd, scene: &Scene<'_>) -> Vec<Ray> {
    let side = ((args.rays / 2) as f64).sqrt().max(2.0) as u32;
    let view = spd.view.rays(side).map(|(origin, dir)| Ray::new(origin, dir));
    let sample = super::rays::sample(scene, args.rays.saturating_sub((side * side) as usize), 1);
    view.chain(sample).collect()
}

/// Millions of rays a second on one thread, and the answers, which all cores help to find.
fn time<T: Send + Copy>(rays: &[Ray], ask: impl Fn(&Ray) -> T + Sync) -> (f64, Vec<T>) {
    let answers = rays.par_iter().map(&ask).collect();
    // One thread, on as many rays as take a moment: the list would take minutes for all.
    let (start, mut done) = (Instant::now(), 0);
    for ray in rays.iter().step_by(7).cycle() {
        std::hint::black_box(ask(ray));
        done += 1;
        if done % 32 == 0 && start.elapsed().as_millis() > 150 {
            break;
        }
    }
    (super::millions_per_second(done, start.elapsed().as_secs_f64()), answers)
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

fn report(args: &Args, rows: &[Row], path: &str) {
    if args.json {
        let scenes: Vec<&Value> = rows.iter().map(|r| &r.facts).collect();
        println!("{}", json!({ "picture": path, "scenes": scenes }));
        return;
    }
    println!(
        "{:<9}{:>7}{:>10}{:>7}{:>8}{:>6}{:>8}{:>8}{:>9}{:>11}{:>8}{:>6}",
        "scene",
        "prims",
        "bytes",
        "B/prim",
        "nodes",
        "depth",
        "SAH",
        "build s",
        "Mrays/s",
        "over list",
        "rays",
        "wrong"
    );
    for row in rows {
        println!("{}", row.line);
    }
    let names: Vec<&str> = rows.iter().map(|r| r.name.as_str()).collect();
    println!("bvh, closest hits, one thread; every answer compared with the list's, bit by bit.");
    println!("{path}: {}", names.join(", "));
}
