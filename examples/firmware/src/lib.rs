//! A consumer of `flashray` for every bare-metal target: it checks a blob and asks 8,192 questions.
//!
//! `cargo build --lib --no-default-features --target TARGET` needs no blob. The program beside it, for Cortex-M, adds
//! what only a board has: a clock, a stack, a place for its output.
#![no_std]

#[path = "../../probe.rs"]
pub mod probe;

use flashray::{BlobError, Scene};
use probe::Answer;

/// Checks a blob and traces the probe's rays.
///
/// # Errors
/// The first rule that the blob breaks.
pub fn answer(blob: &[u8]) -> Result<Answer, BlobError> {
    Ok(probe::run(&Scene::from_bytes(blob)?, &mut ()))
}
