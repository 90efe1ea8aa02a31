//! What the tests share.
pub mod meshes;
pub mod rays;
pub mod tools;

use crate::soup::Soup;
use flashray::blob::Buffer;
use flashray::build::{Config, Quality, Rule, to_vec};
use flashray::{Hit, Kind};
use std::path::PathBuf;

/// Every structure with every rule that makes sense for it, the list first.
pub fn configs() -> Vec<Config> {
    vec![
        Config::new(Kind::List),
        Config::new(Kind::Bvh),
        Config::new(Kind::Bvh).quality(Quality::Fast),
        Config::new(Kind::Bvh).rule(Rule::Seed),
        Config::new(Kind::Bvh).leaf(1),
        Config::new(Kind::Bvh).quality(Quality::High),
        Config::new(Kind::Grid),
        Config::new(Kind::Grid).rule(Rule::Seed),
        Config::new(Kind::Grid).cells(37),
        Config::new(Kind::Voxel),
        Config::new(Kind::Voxel).rule(Rule::Seed),
        Config::new(Kind::Voxel).cells(37),
        Config::new(Kind::Nested),
        Config::new(Kind::Nested).rule(Rule::Seed),
        Config::new(Kind::Nested).cells(3),
        Config::new(Kind::Nested).rule(Rule::Seed).threshold(1),
        Config::new(Kind::Octree),
        Config::new(Kind::Octree).rule(Rule::Seed),
        Config::new(Kind::Octree).leaf(1).rule(Rule::Seed),
        Config::new(Kind::Bsp),
        Config::new(Kind::Bsp).rule(Rule::Seed),
        Config::new(Kind::Bsp).rule(Rule::Seed).leaf(1),
        Config::new(Kind::Sphere),
        Config::new(Kind::Sphere).quality(Quality::Fast),
        Config::new(Kind::Sphere).rule(Rule::Seed),
        Config::new(Kind::Sphere).leaf(1),
        Config::new(Kind::Wide),
        Config::new(Kind::Wide).quality(Quality::Fast),
        Config::new(Kind::Wide).rule(Rule::Seed),
        Config::new(Kind::Wide).leaf(1),
        Config::new(Kind::Wide).quality(Quality::High),
        Config::new(Kind::Wide).width(4),
        Config::new(Kind::Wide).width(4).rule(Rule::Seed).leaf(1),
    ]
}

pub fn build(soup: &Soup, config: &Config) -> Buffer {
    Buffer::from(&to_vec(&soup.mesh(), config).expect("a good mesh builds")[..])
}

/// A hit as comparable bits.
pub fn bits(hit: Option<Hit>) -> [u32; 4] {
    hit.map_or([f32::INFINITY.to_bits(), 0, 0, u32::MAX], |h| [h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.prim])
}

/// A mesh of ../shared/meshes; the project also has to pass without them, so a test that wants one says what it skips.
pub fn shared_mesh(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/meshes").join(name);
    if path.exists() {
        return Some(path);
    }
    tools::say_skipped(&format!("what needs {}", path.display()), "the meshes are too large for the repository");
    None
}
