//! One binary, so that it links once: every structure against the list, the format's rules, the command, the targets.
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    clippy::cast_possible_wrap
)]

#[path = "../src/bin/flashray/camera.rs"]
#[allow(dead_code)]
mod camera;
#[path = "../src/bin/flashray/hostile.rs"]
mod hostile;
#[path = "../src/bin/flashray/mesh/mod.rs"]
#[allow(dead_code)]
mod mesh;
#[path = "../src/bin/flashray/normal.rs"]
mod normal;
#[path = "../src/bin/flashray/random.rs"]
mod random;
#[path = "../src/bin/flashray/soup.rs"]
mod soup;
#[path = "../src/bin/flashray/spd/mod.rs"]
#[allow(dead_code)]
mod spd;
#[path = "../benches/whitted.rs"]
mod whitted;

mod agree;
mod blobs;
mod bsp;
mod builds;
mod cli;
mod common;
mod dda;
mod docs;
mod edges;
mod firmware;
mod geometry;
mod grid;
mod groups;
mod many;
mod nested;
mod octree;
mod parts;
mod reinsert;
#[path = "spd.rs"]
mod spd_hits;
mod sphere;
mod voxel;
mod watertight;
mod web;
mod wide;
