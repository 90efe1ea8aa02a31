//! One file per verb.
pub mod build;
pub mod check;
pub mod demo;
pub mod emit;
pub mod info;
pub mod rays;
pub mod render;
pub mod trace;

use indicatif::{ProgressBar, ProgressStyle};

/// A progress bar on a terminal's stderr, and nothing elsewhere; it appears after a moment.
fn progress(what: &'static str, len: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg} [{bar:40}] {percent}% {eta}");
    let bar = ProgressBar::new(len).with_message(what);
    match style {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// Seconds and a number of things as millions of things a second.
fn millions_per_second(n: usize, seconds: f64) -> f64 {
    n as f64 / seconds.max(1e-9) / 1e6
}
