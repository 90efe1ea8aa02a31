//! What can not be meant is refused with exit code 2, and help names every option.
use super::Folder;

/// What can not be meant.
const WRONG: [&str; 64] = [
    "",
    "nosuch",
    "bench",
    "bench cube.obj --structure nosuch",
    "bench cube.obj --structure wide,,bvh",
    "bench cube.obj --rays 63",
    "bench cube.obj --rays 10000001",
    "bench cube.obj --rounds 0",
    "compare",
    "compare cube.obj extra",
    "compare cube.obj --rays 15",
    "compare cube.obj --rays 10000001",
    "compare cube.obj --rounds 0",
    "compare cube.obj --leaf 16",
    "compare cube.obj --quality 3",
    "compare cube.obj --slice w",
    "compare cube.obj --at 1.5",
    "compare cube.obj --at nan",
    "build cube.obj",
    "build -o out",
    "build cube.obj -o",
    "build cube.obj -o out --leaf 0",
    "build cube.obj -o out --leaf 16",
    "build cube.obj -o out --structure nosuch",
    "build cube.obj -o out --structure wide4",
    "build cube.obj -o out --structure wide --width 5",
    "build cube.obj -o out --structure bvh --width 4",
    "build cube.obj -o out --width 8",
    "build cube.obj -o out --rule nosuch",
    "build cube.obj -o out --quality best",
    "build cube.obj -o out --local 1,2",
    "build cube.obj -o out --local 1,2,3,4",
    "build cube.obj -o out --local 1,2,nan",
    "build cube.obj -o out --local 1,2,inf",
    "build cube.obj -o out --nosuch",
    "info",
    "info cube.fray extra",
    "check",
    "rays cube.fray",
    "rays cube.fray -o out --count -1",
    "rays cube.fray -o out --count 100000001",
    "rays cube.fray -o out --seed x",
    "rays cube.fray -o out --kind nosuch",
    "rays cube.fray -o out --kind camera --hostile",
    "trace cube.fray -o out",
    "trace cube.fray --rays rays",
    "trace cube.fray --rays rays -o out --mode packet --packet 5",
    "trace cube.fray --rays rays -o out --threads x",
    "trace cube.fray --rays rays -o out --threads 1025",
    "render cube.fray",
    "render cube.fray -o out --shade nosuch",
    "render cube.fray -o out --samples 0",
    "render cube.fray -o out --samples 9",
    "render cube.fray -o out --from 1,2",
    "render cube.fray -o out --fov 0",
    "render cube.fray -o out --fov 180",
    "render cube.fray -o out --fov nan",
    "emit cube.fray -o out",
    "emit cube.fray --as pascal -o out",
    "emit cube.fray --as rust",
    "emit cube.fray --as rust -o out --name 1st",
    "emit cube.fray --as rust -o out --name a-b",
    "emit cube.fray --as c -o out --section a\"b",
    "demo --rays 100000001",
];

#[test]
fn what_can_not_be_meant() {
    let folder = Folder::with_cube("usage");
    let before = folder.snapshot();
    for args in WRONG {
        refused(&folder, args);
    }
    for size in ["0x5", "5x0", "5", "x", "5x", "5x5x5", "-5x5", "16385x1", "1.5x2"] {
        refused(&folder, &format!("render cube.fray -o out --size {size}"));
    }
    folder.assert_is(&before, "with wrong usage");
}

/// Exit code 2, an explanation on stderr, nothing on stdout.
fn refused(folder: &Folder, args: &str) {
    let output = folder.run(args);
    let said = super::text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "flashray {args}: {said}");
    assert!(output.stdout.is_empty(), "flashray {args}");
    assert!(said.starts_with("error: ") || said.contains("Usage: flashray"), "flashray {args}: {said}");
}

/// Every verb with what its help must name.
const HELP: [(&str, &[&str]); 10] = [
    (
        "build",
        &[
            "-o",
            "--output",
            "--structure",
            "--cells",
            "--threshold",
            "--width",
            "list",
            "bvh",
            "--rule",
            "--quality",
            "seed",
            "sah",
            "--leaf",
            "--local",
            "--json",
        ],
    ),
    ("info", &["FILE", "--json"]),
    ("check", &["FILE", "--json"]),
    ("rays", &["FILE", "-o", "--output", "--count", "--hostile", "--kind", "camera", "chord", "--seed"]),
    (
        "trace",
        &[
            "--rays",
            "-o",
            "--output",
            "--any",
            "--mode",
            "single",
            "group",
            "packet",
            "--packet",
            "--threads",
            "--json",
            "0xffffffff",
        ],
    ),
    (
        "render",
        &[
            "-o",
            "--output",
            "--shade",
            "normals",
            "depth",
            "ids",
            "heat",
            "--size",
            "--samples",
            "--from",
            "--at",
            "--up",
            "--fov",
        ],
    ),
    (
        "compare",
        &[
            "IN",
            "-o",
            "--output",
            "--rays",
            "--rounds",
            "--leaf",
            "--quality",
            "--slice",
            "--at",
            "--json",
            "index.html",
        ],
    ),
    ("bench", &["FILE", "--structure", "wide", "wide4", "--rays", "--rounds", "--json"]),
    ("emit", &["--as", "rust", "c", "-o", "--output", "--name", "--section"]),
    ("demo", &["-o", "--output", "--rays", "--json"]),
];

#[test]
fn help_names_every_option() {
    let folder = Folder::new("help");
    let whole = folder.ok("--help");
    assert!(whole.contains("Exit codes: 0 done; 1 the input is bad"), "{whole}");
    for (verb, parts) in HELP {
        assert!(whole.lines().any(|line| line.trim_start().starts_with(verb)), "{verb}: {whole}");
        for help in [folder.ok(&format!("{verb} --help")), folder.ok(&format!("help {verb}"))] {
            for part in parts.iter().chain(&["--help"]) {
                assert!(help.contains(part), "{verb}: no `{part}` in {help}");
            }
        }
    }
    assert_eq!(folder.ok("--version"), format!("flashray {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn every_option_of_a_verb_is_known_here() {
    let folder = Folder::new("help-all");
    for (verb, parts) in HELP {
        let help = folder.ok(&format!("{verb} -h"));
        for word in help.split(|c: char| !(c.is_ascii_lowercase() || c == '-')).filter(|w| w.starts_with("--")) {
            assert!(word == "--help" || parts.contains(&word), "{verb} {word} is new: test it");
        }
    }
}
