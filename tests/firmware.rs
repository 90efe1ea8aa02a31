//! The firmware: the same answers on a Cortex-M as on the host, and no way to panic on any bare-metal target.
use crate::common::tools::{FIXTURES, Facts, Fixture, cargo, has_program, has_target, nested, succeed, succeed_within};
use flashray::blob::KINDS;
use std::path::PathBuf;
use std::process::Command;

const M4F: &str = "thumbv7em-none-eabihf";
const M0: &str = "thumbv6m-none-eabi";
const RISCV: &str = "riscv32imac-unknown-none-elf";

/// The scenes of one image.
fn scenes(image: &str) -> Vec<&'static Fixture> {
    FIXTURES.iter().filter(|f| f.image == image).collect()
}

/// Builds the firmware with scenes in it. A panic that is left would stop the linker; ask the symbols as well.
fn build(fixtures: &[&Fixture], target: &str) -> PathBuf {
    let modules = std::env::join_paths(fixtures.iter().map(|f| &f.module)).expect("paths without colons");
    let mut build = cargo("examples/firmware", "firmware");
    succeed(build.args(["build", "--release", "--locked", "--target", target]).env("FLASHRAY_SCENE", modules));
    let elf = nested("firmware").join(target).join("release/flashray-firmware");
    let bytes = std::fs::read(&elf).expect("the firmware's ELF");
    let holds = |text: &[u8]| bytes.windows(text.len()).any(|w| w == text);
    assert!(holds(b"flashray"), "{target}: no symbols to ask");
    // In a symbol a name stands behind its length.
    assert!(!holds(b"9panicking"), "{target}: core::panicking in {}", elf.display());
    elf
}

/// Runs the firmware under QEMU; returns what it says of each scene.
fn run(elf: &PathBuf, machine: &str) -> Vec<Facts> {
    let mut qemu = Command::new("qemu-system-arm");
    qemu.args(["-M", machine, "-nographic", "-semihosting-config", "enable=on,target=native"]);
    Facts::parts(&succeed_within(120, qemu.args(["-icount", "shift=0", "-kernel"]).arg(elf)), "blob_bytes")
}

/// The scenes of one image on a machine.
fn judge_all(image: &str, target: &str, machine: &str) {
    let fixtures = scenes(image);
    if fixtures.is_empty() {
        return;
    }
    let facts = run(&build(&fixtures, target), machine);
    assert_eq!(facts.len(), fixtures.len(), "{image}: a report for each scene");
    fixtures.iter().zip(&facts).for_each(|(fixture, facts)| judge(fixture, facts));
}

/// The host's answer, and bounds on what it took: generous, since they only catch what went wrong altogether.
fn judge(fixture: &Fixture, facts: &Facts) {
    eprintln!("{}: {facts:#?}", fixture.name);
    assert_eq!(facts.answer(), fixture.answer, "{}: firmware against host", fixture.name);
    assert_eq!(facts.number("static_ram_bytes"), 0);
    for stack in ["check_stack_bytes", "query_stack_bytes"] {
        // Six grids' walks at once, on a machine whose compiler spills most, are the deepest.
        assert!((1..5120).contains(&facts.number(stack)), "{stack}={}", facts.number(stack));
    }
    for count in ["camera_instructions_per_ray", "chords_instructions_per_ray", "start_instructions"] {
        assert!(facts.number(count) > 0, "{count}: the clock stands still");
    }
}

#[test]
fn cortex_m4f_answers_as_the_host() {
    if !has_target(M4F) || !has_program("qemu-system-arm", "QEMU's Arm system emulator (qemu-system-arm)") {
        return;
    }
    for image in ["balls", "teapot", "xip", "bunny"] {
        judge_all(image, M4F, "mps2-an386");
    }
}

#[test]
fn software_floats_answer_as_the_host() {
    if !has_target(M0) || !has_program("qemu-system-arm", "QEMU's Arm system emulator (qemu-system-arm)") {
        return;
    }
    judge_all("balls", M0, "mps2-an385");
}

#[test]
fn risc_v_links_without_panics() {
    if !has_target(RISCV) {
        return;
    }
    build(&scenes("balls"), RISCV);
}

#[test]
fn each_structure_links_alone() {
    if !has_target(M4F) {
        return;
    }
    let module = &scenes("balls")[0].module;
    for kind in KINDS.iter().map(|(_, kind)| *kind).chain(["wide4"]) {
        let mut build = cargo("examples/firmware", "firmware");
        build.args(["build", "--release", "--locked", "--target", M4F, "--features", "only", "--bin", "only"]);
        succeed(build.env("FLASHRAY_SCENE", module).env("FLASHRAY_ONLY", kind));
    }
}

#[test]
fn a_firmware_without_a_scene_says_what_to_do() {
    if !has_target(M4F) {
        return;
    }
    let mut build = cargo("examples/firmware", "firmware");
    build.args(["build", "--release", "--locked", "--target", M4F]).env_remove("FLASHRAY_SCENE");
    let output = build.output().expect("cargo runs");
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && text.contains("emit balls.fray --as rust"), "{text}");
}
