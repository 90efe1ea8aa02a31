//! `flashray info`.
use crate::{Failure, file};
use flashray::blob::{Blob, Section};
use flashray::{Aabb, Scene};
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
    if args.json {
        let sections: serde_json::Map<_, _> = sections.iter().map(|(n, l)| ((*n).to_owned(), json!(l))).collect();
        let facts = json!({
            "kind": scene.kind().name(), "version": blob.header().version, "bytes": bytes.len(),
            "checksum": format!("{:08x}", blob.header().checksum),
            "primitives": scene.len(), "bytes_per_primitive": per_prim,
            "nodes": shape.nodes, "leaves": shape.leaves, "depth": shape.depth, "sah_cost": shape.sah_cost,
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
    lines.extend(sections.iter().map(|(name, n)| format!("  {name:<11}{n} ({:.2} a primitive)", share(*n))));
    lines.extend([
        format!("nodes        {} with {} leaves, depth {}", shape.nodes, shape.leaves, shape.depth),
        format!("SAH cost     {:.2}", shape.sah_cost),
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
        let Some(view) = scene.bvh().filter(|v| !v.nodes.is_empty()) else {
            let (leaves, sah_cost) = (usize::from(!scene.is_empty()), f64::from(scene.len()));
            return Self { nodes: 0, depth: 0, sah_cost, leaves };
        };
        let whole = area(&scene.bounds());
        let (mut cost, mut leaves) = (1.0, 0);
        for node in view.nodes {
            for side in 0..2 {
                let child = node.child[side];
                leaves += usize::from(!child.is_node());
                // Of a scene without area nothing can be said but that a ray may meet all of it.
                let share = if whole > 0.0 { area(&node.bounds(side)) / whole } else { 1.0 };
                cost += share * f64::from(child.len().max(1));
            }
        }
        Self { nodes: view.nodes.len(), depth: scene.limits().stack, sah_cost: cost, leaves }
    }
}

fn area(b: &Aabb) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|k| f64::from(b.max[k]) - f64::from(b.min[k]));
    x * y + y * z + z * x
}
