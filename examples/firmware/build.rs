//! Hands the scenes' modules and the memory map to the program.
use std::fmt::Write;
use std::path::PathBuf;
use std::{env, fs};

const HELP: &str = "\
FLASHRAY_SCENE must be the path of a scene's Rust module, or of several, as in PATH. Make one, in the repository's root:
    cargo run --release --features cli -- build spd:balls:2 -o balls.fray
    cargo run --release --features cli -- emit balls.fray --as rust -o balls.rs
    export FLASHRAY_SCENE=$PWD/balls.rs
For a blob of more than 3.5 MB, add `--section .xip` to `emit`.";

fn main() -> Result<(), String> {
    println!("cargo:rerun-if-changed=memory.x");
    println!("cargo:rerun-if-env-changed=FLASHRAY_SCENE");
    println!("cargo:rerun-if-env-changed=FLASHRAY_ONLY");
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("cargo sets OUT_DIR")?);
    if env::var("CARGO_CFG_TARGET_ARCH").as_deref() == Ok("arm") {
        fs::copy("memory.x", out.join("memory.x")).map_err(|e| format!("memory.x: {e}"))?;
        println!("cargo:rustc-link-search={}", out.display());
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
    }
    if env::var_os("CARGO_FEATURE_SCENE").is_some() {
        fs::write(out.join("scenes.rs"), scenes()).map_err(|e| format!("scenes.rs: {e}"))?;
        fs::write(out.join("only.rs"), only()).map_err(|e| format!("only.rs: {e}"))?;
    }
    Ok(())
}

/// A module for each scene and a table of their blobs; or stops the build.
fn scenes() -> String {
    let list = env::var_os("FLASHRAY_SCENE").unwrap_or_default();
    let (mut modules, mut blobs, mut count) = (String::new(), String::new(), 0);
    for path in env::split_paths(&list) {
        let path = match fs::canonicalize(&path) {
            Ok(path) => path,
            Err(error) => stop(&format!("FLASHRAY_SCENE has \"{}\": {error}", path.display())),
        };
        println!("cargo:rerun-if-changed={}", path.display());
        let _ = writeln!(modules, "mod scene{count} {{ include!({path:?}); }}");
        let _ = write!(blobs, "&scene{count}::SCENE.0, ");
        count += 1;
    }
    format!("{modules}/// Every blob.\npub static SCENES: [&[u8]; {count}] = [{blobs}];\n")
}

/// The walk of the structure that FLASHRAY_ONLY names: a function of its module, or a method of its view.
fn only() -> String {
    let kind = env::var("FLASHRAY_ONLY").unwrap_or_default();
    let parse = format!("let view = flashray::{kind}::View::parse(blob)?;");
    let body = match kind.as_str() {
        "" => String::from("let _ = black_box((blob, prims, ray, best, fuel, none)); Ok(Ok(false))"),
        "list" => String::from("let _ = (blob, none); Ok(flashray::list::walk::<false>(prims, ray, best, fuel))"),
        "bvh" => format!("{parse} let _ = none; Ok(flashray::bvh::walk::<false>(&view, prims, ray, best, fuel))"),
        "wide" | "wide4" => {
            let width = if kind == "wide" { 8 } else { 4 };
            let parse = format!("let view = flashray::wide::View::<{width}>::parse(blob)?;");
            format!("{parse} let _ = none; Ok(view.walk::<false>(prims, ray, best, fuel))")
        }
        "sphere" => format!("{parse} let _ = none; Ok(view.walk::<false>(prims, ray, best, fuel))"),
        _ => format!("{parse} Ok(view.walk::<false>(prims, ray, best, fuel, none))"),
    };
    let blob = "blob: &Blob<'_>, prims: &Prims<'_>, ray: &Prepared";
    let state = "best: &mut Best, fuel: &mut Fuel, none: &mut NoMailbox";
    format!("fn walk({blob}, {state}) -> Walked {{ {body} }}\n")
}

fn stop(why: &str) -> ! {
    eprintln!("{why}\n{HELP}");
    std::process::exit(1);
}
