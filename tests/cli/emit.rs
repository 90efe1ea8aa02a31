//! Source made from a blob compiles, is aligned, and holds the blob's bytes.
use super::Folder;
use crate::common::tools::{has_program, succeed};
use std::process::Command;

/// rustc, in the test's folder.
fn rustc(folder: &Folder, args: &str) {
    let rustc = std::env::var_os("RUSTC").unwrap_or("rustc".into());
    let args = args.split_whitespace();
    succeed(Command::new(rustc).current_dir(&folder.0).args(["--edition", "2024", "-D", "warnings"]).args(args));
}

#[test]
fn the_rust_module_is_the_blob() {
    let folder = Folder::new("emit-rust");
    folder.ok("build spd:balls:2 -o balls.fray");
    let said = folder.ok("emit balls.fray --as rust -o scene.rs");
    assert_eq!(said, format!("scene.rs: {} bytes\n", folder.get("balls.fray").len()));
    assert!(super::text(&folder.get("scene.rs")).contains("#[repr(C, align(64))]"));
    folder.put(
        "main.rs",
        "mod scene;\nfn main() {\n    let bytes: &'static [u8] = &scene::SCENE.0;\n    \
         assert_eq!(bytes.as_ptr() as usize % 64, 0);\n    assert!(bytes == include_bytes!(\"balls.fray\"));\n}\n",
    );
    rustc(&folder, "--crate-type lib --emit metadata scene.rs");
    rustc(&folder, "main.rs -o main");
    succeed(&mut Command::new(folder.path("main")));
}

#[test]
fn the_rust_static_has_the_name_and_section_asked_for() {
    let folder = Folder::with_cube("emit-rust-names");
    folder.ok("emit cube.fray --as rust -o cube.rs --name THE_CUBE --section .fray.cube");
    let source = super::text(&folder.get("cube.rs"));
    assert!(source.contains("#[unsafe(link_section = \".fray.cube\")]\npub static THE_CUBE: Aligned<"), "{source}");
    if cfg!(target_os = "linux") {
        rustc(&folder, "--crate-type lib cube.rs -o libcube.rlib");
    }
    folder.ok("emit cube.fray --as rust -o plain.rs");
    assert!(!super::text(&folder.get("plain.rs")).contains("link_section"));
}

/// Compiles `main.c` with the array's file, as strictly as can be, and runs it; what it writes to stdout.
fn compile_and_run(folder: &Folder, array: &str) -> Vec<u8> {
    let flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-o", "main", "main.c", array];
    succeed(Command::new("cc").current_dir(&folder.0).args(flags));
    succeed(&mut Command::new(folder.path("main"))).stdout
}

/// A C program that writes the bytes of the array, if that is aligned and its limits are as given.
fn program(header: &str, name: &str, stack: u64, steps: u64) -> String {
    let upper = name.to_uppercase();
    format!(
        "#include \"{header}\"\n#include \"{header}\"\n#include <stdio.h>\nint main(void) {{\n    \
         if ((uintptr_t){name} % 64 != 0) return 3;\n    if (sizeof {name} < {upper}_BYTES) return 4;\n    \
         if ({upper}_STACK != {stack}u || {upper}_STEPS != {steps}u) return 5;\n    \
         return fwrite({name}, 1, {upper}_BYTES, stdout) != {upper}_BYTES;\n}}\n"
    )
}

#[test]
fn the_c_array_is_the_blob() {
    let folder = Folder::with_cube("emit-c");
    let limits = folder.json("info cube.fray --json")["limits"].clone();
    let number = |key: &str| limits[key].as_u64().expect("a number");
    let section = if cfg!(target_os = "linux") { "--section .fray" } else { "" };
    for (output, header, name, options) in [
        ("scene.c", "scene.h", "scene", String::new()),
        ("data.c", "data.h", "the_cube", format!("--name the_cube {section}")),
    ] {
        folder.ok(&format!("emit cube.fray --as c -o {output} {options}"));
        let (array, declaration) = (super::text(&folder.get(output)), super::text(&folder.get(header)));
        assert!(array.contains(&format!("#include \"{header}\"")) && array.contains("aligned(64)"), "{array}");
        assert!(declaration.contains(&format!("extern const uint32_t {name}[")), "{declaration}");
        assert!(section.is_empty() || array.contains("section(\".fray\")") == options.contains("--section"), "{array}");
        if has_program("cc", "a C compiler") {
            folder.put("main.c", program(header, name, number("stack"), number("steps")));
            assert!(
                compile_and_run(&folder, output) == folder.get("cube.fray"),
                "{output}: other bytes than the blob's"
            );
        }
    }
}

#[test]
fn the_c_array_and_its_header_come_together_or_not_at_all() {
    let folder = Folder::with_cube("emit-c-both");
    folder.fails("emit cube.fray --as c -o out.h", &["out.h: ", ".c"]);
    std::fs::create_dir(folder.path("array.c")).expect("a folder");
    folder.fails("emit cube.fray --as c -o array.c", &["array.c: is a directory"]);
    std::fs::create_dir(folder.path("other.h")).expect("a folder");
    folder.fails("emit cube.fray --as c -o other.c", &["other.h: is a directory"]);
}
