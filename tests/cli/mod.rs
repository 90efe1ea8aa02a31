//! The command as its users run it: a fresh folder for each test, and all that it says and writes is looked at.
mod bench;
mod broken;
mod broken_blobs;
mod compare;
mod demo;
mod emit;
mod info;
mod inputs;
mod outputs;
mod render;
mod round;
mod usage;

use flashray::Ray;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A cube from -1 to 1 of six quads, the front (z = 1) first: triangles 0 and 1.
const CUBE: &str = "v -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\nv -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\n\
    f 1 2 3 4\nf 6 5 8 7\nf 2 6 7 3\nf 5 1 4 8\nf 4 3 7 8\nf 5 6 2 1\n";

/// What a miss looks like in a file of hits: t is +inf, u and v are 0, prim is all ones.
const MISS: [u8; 16] = [0, 0, 0x80, 0x7f, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 0xff, 0xff];

/// The folder that a test works in. The command runs inside it, so that arguments are plain names.
struct Folder(PathBuf);

impl Folder {
    /// An empty folder.
    fn new(name: &str) -> Self {
        Self::at(Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli").join(name))
    }

    /// An empty folder at a place of the test's choice.
    fn at(path: PathBuf) -> Self {
        // That there is none to remove is the usual case; what stays would show in the snapshots.
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).expect("a folder for the test");
        Self(path)
    }

    /// A folder with `cube.obj` and a hierarchy of it, `cube.fray`.
    fn with_cube(name: &str) -> Self {
        let folder = Self::new(name);
        folder.put_cube();
        folder
    }

    fn put_cube(&self) {
        self.put("cube.obj", CUBE);
        self.ok("build cube.obj -o cube.fray --leaf 1");
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn put(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).expect(name);
    }

    fn get(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).expect(name)
    }

    fn put_rays(&self, name: &str, rays: &[Ray]) {
        let words = rays.iter().flat_map(|r| {
            let ([ox, oy, oz], [dx, dy, dz]) = (r.origin, r.dir);
            [ox, oy, oz, r.t_min, dx, dy, dz, r.t_max]
        });
        self.put(name, words.flat_map(f32::to_le_bytes).collect::<Vec<u8>>());
    }

    /// The command with arguments that have spaces between.
    fn command(&self, args: &str) -> Command {
        self.command_of(Path::new(env!("CARGO_BIN_EXE_flashray")), args)
    }

    /// The same of a copy of the program.
    fn command_of(&self, program: &Path, args: &str) -> Command {
        let mut command = Command::new(program);
        command.current_dir(&self.0).stdin(Stdio::null()).args(args.split_whitespace());
        command
    }

    fn run(&self, args: &str) -> Output {
        self.command(args).output().expect("the command starts")
    }

    /// Runs what must succeed without complaint; what it says on stdout.
    fn ok(&self, args: &str) -> String {
        let output = self.run(args);
        let complaint = text(&output.stderr);
        assert_eq!((output.status.code(), complaint.as_str()), (Some(0), ""), "flashray {args}");
        text(&output.stdout)
    }

    /// Runs what must print one JSON object on one line.
    fn json(&self, args: &str) -> Value {
        let said = self.ok(args);
        assert_eq!(said.lines().count(), 1, "flashray {args}: {said}");
        let value: Value = serde_json::from_str(&said).unwrap_or_else(|e| panic!("flashray {args}: {e}: {said}"));
        assert!(value.is_object(), "flashray {args}: {said}");
        value
    }

    /// Runs what must fail because of its input: exit code 1, one line with all of `says`, nothing changed on disk,
    /// neither without a file `out` nor with an old one. The line.
    fn fails(&self, args: &str, says: &[&str]) -> String {
        self.fails_once(args, says);
        self.put("out", "what was there before");
        let line = self.fails_once(args, says);
        fs::remove_file(self.path("out")).expect("the old file is still there");
        line
    }

    fn fails_once(&self, args: &str, says: &[&str]) -> String {
        let before = self.snapshot();
        let output = self.run(args);
        let complaint = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "flashray {args}: {complaint}");
        assert!(complaint.lines().count() == 1 && complaint.ends_with('\n'), "flashray {args}: {complaint}");
        assert!(complaint.starts_with("flashray: "), "flashray {args}: {complaint}");
        for part in says {
            assert!(complaint.contains(part), "flashray {args}: no `{part}` in: {complaint}");
        }
        assert!(!args.starts_with("check") || args.contains("--json") || output.stdout.is_empty(), "flashray {args}");
        self.assert_is(&before, args);
        complaint
    }

    /// Every path below the folder, with the content of those that are files.
    fn snapshot(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let (mut all, mut folders) = (BTreeMap::new(), vec![self.0.clone()]);
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).expect("a folder of the test") {
                let path = entry.expect("an entry of a folder").path();
                // A file without read permission has content that can not change either.
                all.insert(path.clone(), fs::read(&path).unwrap_or_default());
                if path.is_dir() {
                    folders.push(path);
                }
            }
        }
        all
    }

    /// Nothing below the folder is new, gone or different.
    fn assert_is(&self, before: &BTreeMap<PathBuf, Vec<u8>>, what: &str) {
        let after = self.snapshot();
        let names = |all: &BTreeMap<PathBuf, Vec<u8>>| all.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&after), names(before), "flashray {what}: files came or went");
        for (path, content) in before {
            assert!(after[path] == *content, "flashray {what}: {} has changed", path.display());
        }
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("the command speaks UTF-8")
}
