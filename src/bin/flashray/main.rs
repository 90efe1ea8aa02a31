//! The `flashray` command: builds blobs, looks into them, traces and renders with them.
#![forbid(unsafe_code)]
// Pixels, percentages and random numbers: none of these casts reaches an answer.
#![allow(clippy::cast_possible_truncation, clippy::cast_precision_loss, clippy::cast_sign_loss)]

mod args;
mod camera;
mod cmd;
mod columns;
mod file;
mod hostile;
mod input;
mod kinds;
mod mesh;
mod normal;
mod random;
mod soup;
mod spd;

use clap::Parser;
use std::process::ExitCode;

/// One line that says what is wrong with the input: which file, where, why.
type Failure = String;

fn main() -> ExitCode {
    match args::Args::parse().command.run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // A message is one line, whatever went into it.
            eprintln!("flashray: {}", failure.replace(['\n', '\r'], " "));
            ExitCode::from(1)
        }
    }
}
