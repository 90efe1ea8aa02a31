//! What the command line means.
use crate::{Failure, cmd};
use clap::builder::styling::Styles;
use clap::{CommandFactory, Parser, Subcommand};

/// Ray queries straight from flash: build a blob offline, check it, trace it where it lies.
///
/// Exit codes: 0 done; 1 the input is bad (one line on stderr says which file, where, why); 2 usage.
#[derive(Parser)]
#[command(version, styles = Styles::plain(), max_term_width = 100)]
pub struct Args {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand)]
pub enum Command {
    /// Build a blob from meshes
    Build(cmd::build::Args),
    /// Say what is in a blob
    Info(cmd::info::Args),
    /// Check a blob against every rule of its format
    Check(cmd::check::Args),
    /// Make a file of sample rays for a blob
    Rays(cmd::rays::Args),
    /// Trace a file of rays through a blob
    Trace(cmd::trace::Args),
    /// Render a blob to a PNG picture
    Render(cmd::render::Args),
    /// Compare every structure on one scene: speed, size, and pictures of how each parts it
    Compare(cmd::compare::Args),
    /// Measure the speed of queries: each structure, instruction set and mode on four kinds of rays
    Bench(cmd::bench::Args),
    /// Turn a blob into source: a Rust module or a C array
    Emit(cmd::emit::Args),
    /// Build, check, trace and render the procedural scenes, and compare every answer with the list
    Demo(cmd::demo::Args),
}

impl Command {
    pub fn run(self) -> Result<(), Failure> {
        match self {
            Self::Build(args) => cmd::build::run(&args),
            Self::Info(args) => cmd::info::run(&args),
            Self::Check(args) => cmd::check::run(&args),
            Self::Rays(args) => cmd::rays::run(&args),
            Self::Trace(args) => cmd::trace::run(&args),
            Self::Render(args) => cmd::render::run(&args),
            Self::Compare(args) => cmd::compare::run(&args),
            Self::Bench(args) => cmd::bench::run(&args),
            Self::Emit(args) => cmd::emit::run(&args),
            Self::Demo(args) => cmd::demo::run(&args),
        }
    }
}

/// Three numbers with commas between, as in `1,2.5,-3`.
pub fn triple(text: &str) -> Result<[f32; 3], String> {
    let numbers: Vec<f32> = text.split(',').map_while(|part| part.trim().parse().ok()).collect();
    let wanted = format!("`{text}` is not three finite numbers such as 1,2.5,-3");
    if text.split(',').count() != 3 {
        return Err(wanted);
    }
    <[f32; 3]>::try_from(numbers).ok().filter(|n| n.iter().all(|x| x.is_finite())).ok_or(wanted)
}

/// Ends with what is wrong about the command line, and exit code 2.
pub fn usage(what: &str) -> ! {
    Args::command().error(clap::error::ErrorKind::ArgumentConflict, what).exit()
}
