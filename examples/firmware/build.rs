//! Hands the scene's module and the memory map to the program.
use std::path::{Path, PathBuf};
use std::{env, fs};

const HELP: &str = "\
FLASHRAY_SCENE must be the path of a scene's Rust module. Make one, in the repository's root:
    cargo run --release --features cli -- build spd:balls:2 -o balls.fray
    cargo run --release --features cli -- emit balls.fray --as rust -o balls.rs
    export FLASHRAY_SCENE=$PWD/balls.rs
For a blob of more than 3.5 MB, add `--section .xip` to `emit`.";

fn main() -> Result<(), String> {
    println!("cargo:rerun-if-changed=memory.x");
    println!("cargo:rerun-if-env-changed=FLASHRAY_SCENE");
    if env::var("CARGO_CFG_TARGET_ARCH").as_deref() == Ok("arm") {
        let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("cargo sets OUT_DIR")?);
        fs::copy("memory.x", out.join("memory.x")).map_err(|e| format!("memory.x: {e}"))?;
        println!("cargo:rustc-link-search={}", out.display());
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
    }
    if env::var_os("CARGO_FEATURE_SCENE").is_some() {
        scene();
    }
    Ok(())
}

/// Tells the program where the module is, or stops the build.
fn scene() {
    let path = env::var("FLASHRAY_SCENE").unwrap_or_default();
    match fs::canonicalize(Path::new(&path)) {
        Ok(path) => {
            println!("cargo:rerun-if-changed={}", path.display());
            println!("cargo:rustc-env=FLASHRAY_SCENE_MODULE={}", path.display());
        }
        Err(error) => {
            eprintln!("FLASHRAY_SCENE=\"{path}\": {error}\n{HELP}");
            std::process::exit(1);
        }
    }
}
