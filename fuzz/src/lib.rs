//! What the fuzz targets do, as plain functions of bytes.
//!
//! Each target is a module with a `run`. They share: [`rays`] makes hostile rays, [`good`] makes blobs to damage,
//! [`seal`] puts right what a header says about its bytes, and [`judge`] holds the promises against a scene.
#![forbid(unsafe_code)]

pub mod build_then_agree;
pub mod damage;
pub mod good;
pub mod judge;
pub mod parse;
pub mod rays;
pub mod seal;
pub mod trace;
