//! `flashray info`.
use super::cost::Cost;
use super::overlap;
use crate::{Failure, file};
use flashray::blob::{Blob, Section};
use flashray::{Aabb, Kind, Scene};
use serde_json::json;
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Args {
    /// The blob
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// What the nodes of a structure add up to.
pub struct Shape {
    pub nodes: usize,
    /// Inner nodes on the longest way from the root to a leaf.
    pub depth: u32,
    /// Expected node visits and primitive tests of a ray that meets the bounds, each counted as 1.
    pub sah_cost: f64,
    pub leaves: usize,
    /// References from leaves or cells to primitives.
    pub listed: u64,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let bytes = file::read(&args.file)?;
    let scene = file::scene(&args.file, &bytes)?;
    let blob = Blob::parse(&bytes).map_err(|e| format!("{}: {e}", args.file.display()))?;
    let (shape, limits) = (Shape::new(&scene), scene.limits());
    let prims = f64::from(scene.len().max(1));
    let per_prim = bytes.len() as f64 / prims;
    let sections: Vec<_> = blob.entries().iter().map(|e| (name(e.section), e.length)).collect();
    let bounds = scene.bounds();
    // Of what parts space, and of the list, there are no boxes around what is below them.
    let hierarchy = matches!(scene.kind(), Kind::Bvh | Kind::Sphere | Kind::Wide);
    let (overlap, cost) = (hierarchy.then(|| overlap::end_points(&scene)), Cost::new(&scene));
    if args.json {
        let sections: serde_json::Map<_, _> = sections.iter().map(|(n, l)| ((*n).to_owned(), json!(l))).collect();
        let facts = json!({
            "kind": scene.kind().name(), "version": blob.header().version, "bytes": bytes.len(), "width": scene.width(),
            "checksum": format!("{:08x}", blob.header().checksum),
            "primitives": scene.len(), "bytes_per_primitive": per_prim,
            "nodes": shape.nodes, "leaves": shape.leaves, "references": shape.listed, "depth": shape.depth, "sah_cost": shape.sah_cost,
            "end_point_overlap": overlap, "ray_cost": cost.json(),
            "limits": { "stack": limits.stack, "steps": limits.steps },
            "bounds": { "min": bounds.min, "max": bounds.max }, "local_origin": scene.local_origin(),
            "sections": sections,
        });
        return file::say(&facts.to_string());
    }
    let mut lines = vec![
        format!("kind         {}, format version {}", scene.kind().name(), blob.header().version),
        format!("checksum     {:08x}", blob.header().checksum),
        format!("bytes        {} ({per_prim:.2} a primitive)", bytes.len()),
        format!("primitives   {}", scene.len()),
    ];
    let share = |length: u32| f64::from(length) / prims;
    lines.extend(sections.iter().map(|(name, n)| format!("  {name:<10} {n} ({:.2} a primitive)", share(*n))));
    lines.extend(scene.width().map(|most| format!("width        {most} children of a node at most")));
    lines.extend([
        format!("nodes        {} with {} leaves or cells, depth {}", shape.nodes, shape.leaves, shape.depth),
        format!("references   {} ({:.2} a primitive)", shape.listed, shape.listed as f64 / prims),
        format!("SAH cost     {:.2}", shape.sah_cost),
    ]);
    lines.extend(overlap.map(|x| format!("EPO          {x:.3}, sampled at {} points", overlap::POINTS)));
    lines.extend(cost.lines());
    lines.extend([
        format!("worst case   stack {} entries, {} steps", limits.stack, limits.steps),
        format!("bounds       {:?} .. {:?}", bounds.min, bounds.max),
        format!("local origin {:?}", scene.local_origin()),
    ]);
    file::say(&lines.join("\n"))
}

fn name(section: u32) -> &'static str {
    Section::LISTED.iter().find(|s| s.number() == section).map_or("?", |s| s.name())
}

impl Shape {
    pub fn new(scene: &Scene<'_>) -> Self {
        let mut shape = Self { nodes: 0, depth: 0, sah_cost: 0.0, leaves: 0, listed: 0 };
        let whole = area(&scene.bounds());
        scene.parts(|part| {
            // Of a scene without area nothing can be said but that a ray may meet all of it.
            let share = if whole > 0.0 { area(&part.bounds) / whole } else { 1.0 };
            // A hierarchy of bounds knows from the parent whether a leaf is met; a cell is a step of its own.
            let bounds = matches!(scene.kind(), Kind::List | Kind::Bvh | Kind::Sphere | Kind::Wide);
            let step = if part.listed.is_none() || !bounds { 1.0 } else { 0.0 };
            shape.sah_cost += share * (step + f64::from(part.listed.unwrap_or(0)));
            shape.nodes += usize::from(part.listed.is_none());
            shape.leaves += usize::from(part.listed.is_some());
            shape.listed += u64::from(part.listed.unwrap_or(0));
            shape.depth = shape.depth.max(part.level);
        });
        shape
    }
}

fn area(b: &Aabb) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|k| f64::from(b.max[k]) - f64::from(b.min[k]));
    x * y + y * z + z * x
}
