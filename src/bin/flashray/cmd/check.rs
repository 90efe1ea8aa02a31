//! `flashray check`.
use crate::{Failure, file};
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Args {
    /// The blob
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Print one JSON object instead of a sentence
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let bytes = file::read(&args.file)?;
    let result = file::scene(&args.file, &bytes);
    if args.json {
        let error = result.as_ref().err();
        file::say(&serde_json::json!({ "ok": error.is_none(), "bytes": bytes.len(), "error": error }).to_string())?;
    }
    let scene = result?;
    if !args.json {
        let (path, kind, prims) = (args.file.display(), scene.kind().name(), scene.len());
        file::say(&format!("{path}: ok: {kind}, {prims} primitives, {} bytes", bytes.len()))?;
    }
    Ok(())
}
