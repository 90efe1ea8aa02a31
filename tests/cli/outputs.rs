//! Where the command can not write, it says so and leaves nothing behind; where it can, it replaces files only.
use super::Folder;
use std::fs;

/// Every verb that writes a file.
const VERBS: [&str; 6] = [
    "build spd:balls:1 -o OUT",
    "rays cube.fray --count 10 -o OUT",
    "trace cube.fray --rays rays -o OUT",
    "render cube.fray --size 8x8 -o OUT",
    "emit cube.fray --as rust -o OUT",
    "emit cube.fray --as c -o OUT",
];

fn folder(name: &str) -> Folder {
    let folder = Folder::with_cube(name);
    folder.ok("rays cube.fray -o rays --count 10");
    folder
}

#[test]
fn places_that_can_not_be_written() {
    let folder = folder("out-bad");
    fs::create_dir(folder.path("folder")).expect("a folder");
    for verb in VERBS {
        folder.fails(&verb.replace("OUT", "nosuch/file"), &["flashray: nosuch/file", "No such file"]);
        folder.fails(&verb.replace("OUT", "cube.obj/file"), &["flashray: cube.obj/file", "Not a directory"]);
        folder.fails(&verb.replace("OUT", "folder"), &["flashray: folder: is a directory"]);
    }
    folder.fails("demo --rays 4 -o cube.obj", &["flashray: cube.obj: "]);
}

#[test]
fn an_old_file_is_replaced_and_nothing_stays_beside_it() {
    let folder = folder("out-old");
    for verb in VERBS {
        folder.ok(&verb.replace("OUT", "new"));
        let made = folder.get("new");
        folder.put("new", vec![b'x'; 100_000]);
        let before = folder.snapshot();
        folder.ok(&verb.replace("OUT", "new"));
        assert!(folder.get("new") == made, "{verb}");
        folder.put("new", vec![b'x'; 100_000]);
        folder.assert_is(&before, verb);
    }
}

#[cfg(unix)]
#[test]
fn links_stay_links_and_devices_stay_devices() {
    use std::os::unix::fs::symlink;
    let folder = folder("out-links");
    folder.put("target", "old");
    symlink("target", folder.path("link")).expect("a link");
    // To a file that is not there yet, by way of another link.
    symlink("there", folder.path("far")).expect("a link");
    symlink("new-target", folder.path("there")).expect("a link");
    // Through a link, so that a mistake costs the link and not the device.
    symlink("/dev/null", folder.path("null")).expect("a link");
    for verb in VERBS {
        folder.ok(&verb.replace("OUT", "plain"));
        let _ = fs::remove_file(folder.path("new-target"));
        for name in ["link", "null", "far"] {
            folder.ok(&verb.replace("OUT", name));
            assert!(folder.path(name).is_symlink(), "{verb}: {name} is no link any more");
        }
        if !verb.contains("--as c") {
            assert!(folder.get("target") == folder.get("plain"), "{verb}: the link was not followed");
            assert!(folder.get("new-target") == folder.get("plain"), "{verb}: the links were not followed");
        }
    }
    assert!(folder.path("there").is_symlink());
    symlink("circle", folder.path("circle")).expect("a link");
    folder.fails("build spd:balls:1 -o circle", &["flashray: circle: ", "links"]);
    assert!(!fs::metadata(folder.path("null")).expect("a device").is_file());
    let names = folder.snapshot().into_keys().filter(|path| path.to_string_lossy().contains(".part"));
    assert_eq!(names.count(), 0, "temporary files are left");
}

/// A folder with a copy of the command beside it where every user may enter: a checkout may be its owner's alone.
#[cfg(unix)]
struct Open(Folder);

#[cfg(unix)]
impl Open {
    fn new() -> Self {
        use std::os::unix::fs::PermissionsExt as _;
        let top = std::env::temp_dir().join(format!("flashray-permission-{}", std::process::id()));
        let folder = Folder::at(top.join("folder"));
        for path in [&top, &folder.0] {
            fs::set_permissions(path, fs::Permissions::from_mode(0o755)).expect("a folder of our own");
        }
        fs::copy(env!("CARGO_BIN_EXE_flashray"), top.join("flashray")).expect("a copy of the command");
        Self(folder)
    }

    /// The command as a user without rights, if we are the one with all rights: nothing stops that one from reading.
    fn without_rights(&self, args: &str) -> Option<std::process::Output> {
        use std::os::unix::process::CommandExt as _;
        let mut command = self.0.command_of(&self.0.0.with_file_name("flashray"), args);
        if fs::read(self.0.path("secret.fray")).is_ok() {
            command.uid(65534).gid(65534);
        }
        match command.output() {
            Ok(output) => Some(output),
            Err(error) => {
                let what = format!("files without permission, as another user can not run the command: {error}");
                let remedy = "set TMPDIR to a folder that every user may enter and run programs in";
                crate::common::tools::skip(&what, remedy);
                None
            }
        }
    }
}

#[cfg(unix)]
impl Drop for Open {
    fn drop(&mut self) {
        // Only litter stays where this fails, and no test is about it.
        let _ = self.0.0.parent().map(fs::remove_dir_all);
    }
}

#[cfg(unix)]
#[test]
fn files_without_permission() {
    use std::os::unix::fs::PermissionsExt as _;
    let open = Open::new();
    let folder = &open.0;
    folder.put_cube();
    folder.ok("rays cube.fray -o rays --count 10");
    for (from, to) in [("cube.obj", "secret.obj"), ("cube.fray", "secret.fray"), ("rays", "secret.rays")] {
        fs::copy(folder.path(from), folder.path(to)).expect(to);
        fs::set_permissions(folder.path(to), fs::Permissions::from_mode(0o000)).expect(to);
    }
    fs::create_dir(folder.path("locked")).expect("a folder");
    fs::set_permissions(folder.path("locked"), fs::Permissions::from_mode(0o555)).expect("a folder");
    let before = folder.snapshot();
    for (args, name) in [
        ("build secret.obj -o out", "secret.obj"),
        ("info secret.fray", "secret.fray"),
        ("check secret.fray", "secret.fray"),
        ("trace cube.fray --rays secret.rays -o out", "secret.rays"),
        ("build spd:balls:1 -o locked/out", "locked/out"),
    ] {
        let Some(output) = open.without_rights(args) else { return };
        let complaint = super::text(&output.stderr);
        assert_eq!((output.status.code(), complaint.lines().count()), (Some(1), 1), "{args}: {complaint}");
        assert!(complaint.starts_with(&format!("flashray: {name}: ")), "{complaint}");
        assert!(complaint.to_lowercase().contains("permission"), "{complaint}");
        folder.assert_is(&before, args);
    }
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let folder = folder("out-pipe");
    for verb in ["info cube.fray", "check cube.fray --json", "build spd:balls:1 -o new", "--help"] {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let output = folder.command(verb).stdout(writer).output().expect("the command starts");
        assert_eq!((output.status.code(), super::text(&output.stderr).as_str()), (Some(0), ""), "{verb}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_stdout_is_a_failure() {
    let folder = folder("out-full");
    for verb in ["info cube.fray", "info cube.fray --json", "check cube.fray", "build spd:balls:1 -o new"] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("Linux has /dev/full");
        let output = folder.command(verb).stdout(full).output().expect("the command starts");
        let complaint = super::text(&output.stderr);
        assert_eq!((output.status.code(), complaint.lines().count()), (Some(1), 1), "{verb}: {complaint}");
        assert!(complaint.starts_with("flashray: standard output: "), "{complaint}");
    }
}
