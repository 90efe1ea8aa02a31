//! Tools beside cargo, programs with a time limit, and the scenes that firmware and web are tried on.
use flashray::blob::{Buffer, KINDS};
use flashray::voxel::{BLOCKS, FLAT};
use flashray::{Kind, Scene};
use std::collections::{BTreeSet, HashMap};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

/// Bytes from which a blob does not fit into the firmware's internal flash.
const INTERNAL_FLASH: u64 = 3_500_000;
/// What is built in every structure by both rules: all kinds of primitives, and triangles alone.
pub const INPUTS: [(&str, &str); 2] = [("balls", "spd:balls:2"), ("teapot", "spd:teapot:4")];

/// Says what is left out, even in a test that passes: the harness keeps what the macros print, and shows it only when
/// the test fails.
pub fn say_skipped(what: &str, remedy: &str) {
    // One write, so that lines of two tests do not mix; a standard error that is closed is no failure of the test.
    let _ = std::io::stderr().write_all(format!("skipped: {what}; {remedy}\n").as_bytes());
}

/// Says that a test can not be run. Under `CI=true` that is a failure, so that nothing is skipped there unseen.
pub fn skip(what: &str, remedy: &str) {
    assert!(std::env::var("CI").as_deref() != Ok("true"), "skipped: {what}; {remedy}");
    say_skipped(what, remedy);
}

/// Whether a program is there; otherwise [`skip`]s.
pub fn has_program(name: &str, package: &str) -> bool {
    let found = Command::new(name).arg("--version").stdin(Stdio::null()).output().is_ok_and(|o| o.status.success());
    if !found {
        skip(&format!("no program `{name}`"), &format!("install {package}"));
    }
    found
}

/// Whether rustc can build for a target; otherwise [`skip`]s.
pub fn has_target(target: &str) -> bool {
    let rustc = std::env::var_os("RUSTC").unwrap_or("rustc".into());
    let libs = Command::new(rustc).args(["--print", "target-libdir", "--target", target]).output();
    let found = libs.is_ok_and(|o| Path::new(String::from_utf8_lossy(&o.stdout).trim()).is_dir());
    if !found {
        skip(&format!("no Rust target `{target}`"), &format!("run `rustup target add {target}`"));
    }
    found
}

/// Where a nested cargo builds: beside the outer one's files, so that neither waits for the other's lock.
pub fn nested(name: &str) -> PathBuf {
    let tmp = Path::new(env!("CARGO_TARGET_TMPDIR"));
    tmp.parent().unwrap_or(tmp).join("nested").join(name)
}

/// A nested cargo in a folder of the repository, which builds in [`nested`]`(name)`. Flags meant for this machine's
/// processor stay behind.
pub fn cargo(folder: &str, name: &str) -> Command {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)).env("CARGO_TARGET_DIR", nested(name));
    for key in ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_TARGET"] {
        cargo.env_remove(key);
    }
    cargo
}

/// Runs a program to its end; panics with all it said if it fails.
pub fn succeed(command: &mut Command) -> Output {
    let output = command.stdin(Stdio::null()).output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    assert!(output.status.success(), "{command:?}: {}\n{}", output.status, said(&output));
    output
}

/// The same for a program of few words that might hang.
pub fn succeed_within(seconds: u64, command: &mut Command) -> Output {
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    let end = Instant::now() + Duration::from_secs(seconds);
    while child.try_wait().expect("a child's state").is_none() {
        if Instant::now() > end {
            child.kill().expect("a child can be ended");
            let output = child.wait_with_output().expect("a child's output");
            panic!("{command:?} did not end within {seconds} s\n{}", said(&output));
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let output = child.wait_with_output().expect("a child's output");
    assert!(output.status.success(), "{command:?}: {}\n{}", output.status, said(&output));
    output
}

/// Both streams of a program.
fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// The `key=value` lines among what a program said.
#[derive(Debug, Default)]
pub struct Facts(HashMap<String, String>);

impl Facts {
    /// Reads both streams: QEMU's guests write to the second.
    pub fn of(output: &Output) -> Self {
        let pair = |line: &str| line.trim_end().split_once('=').map(|(k, v)| (k.into(), v.into()));
        Self(said(output).lines().filter_map(pair).collect())
    }

    /// One for each part of what a program said; a part begins with the line of `key`.
    pub fn parts(output: &Output, key: &str) -> Vec<Self> {
        let mut parts = Vec::new();
        for line in said(output).lines() {
            let Some((k, v)) = line.trim_end().split_once('=') else { continue };
            if k == key {
                parts.push(Self::default());
            }
            if let Some(Self(facts)) = parts.last_mut() {
                facts.insert(k.into(), v.into());
            }
        }
        parts
    }

    /// The value of a key.
    pub fn text(&self, key: &str) -> &str {
        self.0.get(key).unwrap_or_else(|| panic!("no `{key}` in {self:?}"))
    }

    /// The value of a key as a number.
    pub fn number(&self, key: &str) -> u32 {
        self.text(key).parse().unwrap_or_else(|e| panic!("{key}={}: {e}", self.text(key)))
    }

    /// What must be the same everywhere: checksum and number of hits.
    pub fn answer(&self) -> (String, u32) {
        assert_eq!(self.text("check"), "ok");
        (self.text("crc").into(), self.number("hits"))
    }
}

/// A scene: its blob, the blob as a Rust module, and the answer that every machine must give.
pub struct Fixture {
    /// For messages.
    pub name: String,
    /// Scenes of one image have the same.
    pub image: &'static str,
    /// Path of the blob.
    pub blob: PathBuf,
    /// Path of the module for the firmware.
    pub module: PathBuf,
    /// Checksum and number of hits, as the host says in a debug and in a release build.
    pub answer: (String, u32),
}

/// All scenes, made once: two inputs in every structure by both rules (voxels have a form for each) and in nodes of four,
/// a blob in external flash, and bunny where its mesh is.
pub static FIXTURES: LazyLock<Vec<Fixture>> = LazyLock::new(|| {
    let bunny = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/meshes/bunny.obj");
    let mut fixtures = Vec::new();
    for (image, input) in INPUTS {
        for (kind, name) in KINDS {
            // The list knows no rule.
            let rules = if *kind == Kind::List { &["sah"][..] } else { &["seed", "sah"] };
            fixtures.extend(rules.iter().map(|rule| blob(image, input, [name, rule], None)));
        }
        fixtures.push(blob(image, input, ["wide4", "sah"], None));
        assert_both_forms(image, &fixtures);
    }
    fixtures.push(blob("xip", "spd:balls:2", ["bvh", "sah"], Some(".xip")));
    match bunny.to_str() {
        Some(path) if bunny.is_file() => fixtures.push(blob("bunny", path, ["bvh", "sah"], None)),
        _ => say_skipped(
            "scene bunny-bvh-sah",
            &format!("there is no {}, a mesh too large for the repository", bunny.display()),
        ),
    }
    let (debug, release) = (checksums(&fixtures, &[]), checksums(&fixtures, &["--release"]));
    assert_eq!((debug.len(), release.len()), (fixtures.len(), fixtures.len()), "an answer for each scene");
    for (fixture, (debug, release)) in fixtures.iter_mut().zip(debug.into_iter().zip(release)) {
        assert_eq!(release, debug, "{}: host, release against debug", fixture.name);
        assert!(debug.1 > 0, "{}: no ray hits", fixture.name);
        fixture.answer = debug;
    }
    for (image, _) in INPUTS {
        let mut same = fixtures.iter().filter(|f| f.image == image).map(|f| &f.answer);
        let first = same.next();
        assert!(same.all(|answer| Some(answer) == first), "{image}: structures differ");
    }
    fixtures
});

/// Makes one scene, by structure, or wide4 for nodes of four, and rule; its answer comes later.
fn blob(image: &'static str, input: &str, [structure, rule]: [&str; 2], section: Option<&str>) -> Fixture {
    let tmp = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let name = format!("{image}-{structure}-{rule}");
    let (blob, module) = (tmp.join(&name).with_extension("fray"), tmp.join(&name).with_extension("rs"));
    let flashray = || Command::new(env!("CARGO_BIN_EXE_flashray"));
    let (structure, width) = if structure == "wide4" { ("wide", &["--width", "4"][..]) } else { (structure, &[][..]) };
    let build = ["build", input, "--structure", structure, "--rule", rule, "-o"];
    succeed(flashray().args(build).arg(&blob).args(width));
    let size = blob.metadata().expect("a blob's size").len();
    let section = section.or((size > INTERNAL_FLASH).then_some(".xip"));
    let section = section.map_or(vec![], |s| vec!["--section", s]);
    succeed(flashray().arg("emit").arg(&blob).args(["--as", "rust", "-o"]).arg(&module).args(section));
    Fixture { name, image, blob, module, answer: (String::new(), 0) }
}

/// Voxels are walked by other code in each of their forms: both must be in an image.
fn assert_both_forms(image: &str, fixtures: &[Fixture]) {
    let form = |fixture: &Fixture| {
        let blob = Buffer::from(&std::fs::read(&fixture.blob).expect("a blob")[..]);
        let voxels = Scene::trust(&blob).expect("a good blob").voxel()?.voxels?;
        Some(voxels.table.form)
    };
    let forms: BTreeSet<u32> = fixtures.iter().filter(|f| f.image == image).filter_map(form).collect();
    assert_eq!(forms, BTreeSet::from([FLAT, BLOCKS]), "{image}: forms of voxels");
}

/// The probe on the host, for each scene.
fn checksums(fixtures: &[Fixture], profile: &[&str]) -> Vec<(String, u32)> {
    let mut run = cargo(".", "host");
    run.args(["run", "--quiet", "--example", "checksum", "--features", "alloc"]).args(profile).arg("--");
    let output = succeed(run.args(fixtures.iter().map(|f| &f.blob)));
    Facts::parts(&output, "file").iter().map(Facts::answer).collect()
}
