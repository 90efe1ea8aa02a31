//! Ray queries straight from flash.
//!
//! An acceleration structure is built offline into one *blob*: a run of bytes without pointers. The runtime checks it
//! once and traverses it where it lies, with no heap, no panic and no standard library: in firmware, in WebAssembly,
//! on a host. The same blob gives the same bits of answer everywhere.
//!
//! # When not to use it
//! Scenes that move or change every frame: there is no refitting and no insertion. Scenes that do not fit in 4 GiB.
//! Big-endian machines. Double precision. Rendering: this finds hits and shades nothing.
//!
//! # Example
//! ```
//! # #[cfg(feature = "alloc")] {
//! use flashray::build::{Config, Mesh, to_vec};
//! use flashray::{Kind, Ray, Scene};
//!
//! // Offline: a tetrahedron becomes a blob.
//! let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
//! let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
//! let blob = to_vec(&Mesh::new(&positions, &triangles), &Config::new(Kind::Bvh))?;
//!
//! // On the device: check once, then ask.
//! let scene = Scene::from_bytes(&blob)?;
//! let ray = Ray::new([0.1, 0.2, -1.0], [0.0, 0.0, 1.0]);
//! let hit = scene.closest_hit(&ray).ok_or("the ray should hit")?;
//! assert_eq!((hit.t, hit.prim), (1.0, 0));
//! assert!(!scene.any_hit(&Ray::new([2.0, 2.0, -1.0], [0.0, 0.0, 1.0])));
//! # }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Reading order
//! [`geom`] states the contract that every answer keeps, and holds the tests of a ray against one primitive. [`blob`]
//! is the container and its checks. [`walk`] is what all walks share. The structures: [`list`], the oracle; [`bvh`] and
//! [`sphere`], which part the primitives; [`grid`], [`voxel`], [`nested`], [`octree`] and [`bsp`], which part space. Of
//! each, layout and check are in `mod.rs`, the loop in `walk.rs` and the builder in `build`. [`Scene`] joins them.
//! [`mod@build`] is the way from a mesh to a blob.
//!
//! # Features
//! - `std` (default): the host's own square root, the fastest instructions found at run time, and on Linux huge pages for
//!   what is built into a buffer. No query needs it, and no answer depends on it.
//! - `build`: builders into memory that the caller lends. Still no heap.
//! - `alloc`: builders that size themselves and return a `Vec<u8>`.
//! - `parallel`: those on all cores, by rayon. The same bytes.
//! - `cli`: the `flashray` command.
#![cfg_attr(not(feature = "std"), no_std)]
#![warn(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::as_conversions)]

#[cfg(feature = "alloc")]
extern crate alloc;

pub mod blob;
pub mod bsp;
#[cfg(feature = "build")]
pub mod build;
pub mod bvh;
pub mod geom;
pub mod grid;
pub mod list;
pub mod nested;
mod num;
pub mod octree;
mod scene;
pub mod sphere;
mod structure;
pub mod voxel;
pub mod walk;
pub mod wide;

pub use blob::{BlobError, Kind};
pub use geom::{Aabb, Cone, Cylinder, Hit, Ray, Sphere, Triangle};
pub use scene::{Limits, Scene};
pub use walk::{Steps, Stop};
