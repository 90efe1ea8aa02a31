//! The WebAssembly module: the same answers as on the host, and nothing imported.
use crate::common::tools::{FIXTURES, Facts, cargo, has_program, has_target, nested, succeed, succeed_within};
use std::path::Path;
use std::process::Command;

const TARGET: &str = "wasm32-unknown-unknown";

/// Every fixture in the module that is built with some flags, beside what is built with others.
fn answers_as_the_host(name: &str, flags: &str) {
    if !has_target(TARGET) || !has_program("node", "Node.js 18 or later") {
        return;
    }
    let mut build = cargo("examples/web", name);
    succeed(build.args(["build", "--release", "--locked", "--target", TARGET]).env("RUSTFLAGS", flags));
    let module = nested(name).join(TARGET).join("release/flashray_web.wasm");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/web/run.mjs");
    for fixture in FIXTURES.iter() {
        let facts = Facts::of(&succeed_within(120, Command::new("node").arg(&script).arg(&module).arg(&fixture.blob)));
        eprintln!("{}: {facts:?}", fixture.name);
        assert_eq!(facts.answer(), fixture.answer, "{}: WebAssembly against host", fixture.name);
        assert_eq!(facts.number("imports"), 0, "a panic handler's call into nowhere would be an import");
        assert_eq!(facts.number("misses"), 2, "rays that meet nothing");
    }
}

#[test]
fn web_assembly_answers_as_the_host() {
    answers_as_the_host("web", "");
}

#[test]
fn web_assembly_with_simd_answers_as_the_host() {
    answers_as_the_host("web-simd128", "-C target-feature=+simd128");
}
