//! Compiles the C++ shim around tinybvh. The header is the one that ships inside the registry package
//! `tinybvh-rs` (found through `cargo metadata`); nothing is copied into this project.
use std::{env, path::PathBuf, process::Command};

fn main() {
    let cargo = env::var("CARGO").unwrap_or("cargo".into());
    let out =
        Command::new(cargo).args(["metadata", "--format-version", "1", "--offline"]).output().expect("cargo metadata");
    let meta: serde_json::Value = serde_json::from_slice(&out.stdout).expect("cargo metadata output");
    let manifest = meta["packages"]
        .as_array()
        .unwrap()
        .iter()
        .find(|p| p["name"] == "tinybvh-rs")
        .expect("package tinybvh-rs")["manifest_path"]
        .as_str()
        .unwrap()
        .to_string();
    let header_dir = PathBuf::from(manifest).parent().unwrap().join("ffi/tinybvh");
    cc::Build::new()
        .cpp(true)
        .std("c++20")
        .opt_level(3)
        .flag("-march=native")
        .flag_if_supported("-Wno-unused-parameter")
        .warnings(false)
        .include(header_dir)
        .file("shim/tiny_shim.cpp")
        .compile("tiny_shim");
    println!("cargo:rerun-if-changed=shim/tiny_shim.cpp");
    println!("cargo:rerun-if-changed=build.rs");
}
