//! The command's own random numbers and hostile rays.
use crate::hostile::Targets;
pub use crate::random::Random;
use flashray::{Ray, Scene};

/// Hostile rays at the primitives of the first scene and the cells of all.
pub fn hostile(scenes: &[Scene<'_>], count: usize, seed: u64) -> Vec<Ray> {
    Targets::new(scenes).rays(count, seed)
}
