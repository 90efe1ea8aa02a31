//! One file per verb.
pub mod bench;
pub mod build;
pub mod check;
pub mod compare;
pub mod cost;
pub mod demo;
pub mod emit;
pub mod info;
pub mod overlap;
pub mod rays;
pub mod render;
pub mod trace;

use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};

/// A progress bar on a terminal's stderr, and nothing elsewhere; it appears after a moment.
fn progress(what: &'static str, len: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg} [{bar:40}] {percent}% {eta}");
    let bar = ProgressBar::new(len).with_message(what).with_finish(ProgressFinish::AndClear);
    match style {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// The same for work whose length nobody knows.
pub fn spinner(what: &'static str) -> ProgressBar {
    let bar = ProgressBar::new_spinner().with_message(what).with_finish(ProgressFinish::AndClear);
    bar.enable_steady_tick(std::time::Duration::from_millis(250));
    bar
}

/// Seconds and a number of things as millions of things a second.
fn millions_per_second(n: usize, seconds: f64) -> f64 {
    n as f64 / seconds.max(1e-9) / 1e6
}

/// The middle one of some numbers, the lower of two.
fn median(numbers: &mut [f64]) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len().saturating_sub(1) / 2).copied().unwrap_or(0.0)
}
