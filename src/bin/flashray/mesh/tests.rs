//! Tests of the choice of a reader, and of the errors that all formats share.
use std::fs;
use std::io::Write as _;
use std::path::PathBuf;

use super::*;

/// A folder for the files of one test, removed at its end.
struct Folder(PathBuf);

impl Folder {
    /// A new folder for the test `name`.
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("flashray-mesh-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    /// What [`read`] makes of a file with this name and content; errors without the folder.
    fn read(&self, name: &str, content: impl AsRef<[u8]>) -> Result<Soup, String> {
        fs::write(self.0.join(name), content).unwrap();
        self.read_only(name)
    }

    /// What [`read`] makes of this name.
    fn read_only(&self, name: &str) -> Result<Soup, String> {
        read(&self.0.join(name)).map_err(|error| {
            assert!(!error.contains('\n'), "{error}");
            let folder = format!("{}/", self.0.display());
            error.strip_prefix(&folder).unwrap_or_else(|| panic!("{error}")).to_string()
        })
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        drop(fs::remove_dir_all(&self.0));
    }
}

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
    property float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n3 0 0 0\n";
const STL: &str = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
    endloop\nendfacet\nendsolid\n";
const GLTF: &str = r#"{"asset": {"version": "2.0"}}"#;

#[test]
fn the_extension_chooses() {
    let folder = Folder::new("choice");
    for (name, content) in [("a.obj", OBJ), ("b.OBJ", OBJ), ("c.Ply", PLY), ("d.e.stl", STL)] {
        assert_eq!(folder.read(name, content).unwrap().triangles.len(), 1);
    }
    let known = "(known: .obj .ply .stl .gltf .glb)";
    assert_eq!(folder.read_only("a.off").unwrap_err(), format!("a.off: unknown extension .off {known}"));
    assert_eq!(folder.read_only("obj").unwrap_err(), format!("obj: the name has no extension {known}"));
}

#[test]
fn content_of_another_format() {
    let folder = Folder::new("content");
    for (name, content, found) in [
        ("a.obj", PLY, "PLY"),
        ("a.obj", "glTF\x02\0\0\0", "binary glTF"),
        ("a.obj", STL, "STL"),
        ("a.obj", GLTF, "JSON (glTF)"),
        ("a.ply", STL, "STL"),
        ("a.stl", PLY, "PLY"),
        ("a.stl", GLTF, "JSON (glTF)"),
        ("a.gltf", "glTF\x02\0\0\0", "binary glTF"),
        ("a.gltf", PLY, "PLY"),
        ("a.glb", GLTF, "JSON (glTF)"),
    ] {
        let ending = &name[1..];
        let message = format!("{name}: the content is {found}, but the name ends in {ending}");
        assert_eq!(folder.read(name, content).unwrap_err(), message);
    }
    for (name, start) in [
        ("a.ply", "a.ply: not a PLY file: "),
        ("a.stl", "a.stl: not an STL file: "),
        ("a.gltf", "a.gltf: JSON: "),
        ("a.glb", "a.glb: not a binary glTF file: "),
    ] {
        assert!(folder.read(name, OBJ).unwrap_err().starts_with(start));
    }
}

#[test]
fn files_without_triangles() {
    let folder = Folder::new("empty");
    for name in ["a.obj", "a.ply", "a.stl", "a.gltf", "a.glb"] {
        assert_eq!(folder.read(name, "").unwrap_err(), format!("{name}: the file is empty (0 bytes)"));
    }
    let points = PLY.replace("face 1", "face 0").replace("3 0 0 0\n", "");
    for (name, content) in
        [("a.obj", "v 0 0 0\n"), ("a.ply", points.as_str()), ("a.stl", "solid\nendsolid\n"), ("a.gltf", GLTF)]
    {
        assert_eq!(folder.read(name, content).unwrap_err(), format!("{name}: no triangles"));
    }
}

#[test]
fn what_is_not_a_readable_file() {
    let folder = Folder::new("files");
    assert_eq!(folder.read_only("no.obj").unwrap_err(), "no.obj: no such file");
    fs::create_dir(folder.0.join("sub.obj")).unwrap();
    assert_eq!(folder.read_only("sub.obj").unwrap_err(), "sub.obj: is a directory, not a mesh file");
    assert!(folder.read_only("no.obj/x.obj").is_err());
    #[cfg(unix)]
    {
        use std::os::unix::fs::{PermissionsExt, symlink};
        symlink("/dev/zero", folder.0.join("zero.obj")).unwrap();
        assert_eq!(folder.read_only("zero.obj").unwrap_err(), "zero.obj: is not a regular file");
        let locked = folder.0.join("locked.obj");
        fs::write(&locked, OBJ).unwrap();
        fs::set_permissions(&locked, fs::Permissions::from_mode(0o000)).unwrap();
        // The superuser may read it all the same.
        if let Err(error) = folder.read_only("locked.obj") {
            assert_eq!(error, "locked.obj: no permission to read it");
        }
    }
}

#[test]
fn errors_are_one_line() {
    assert_eq!(one_line("a\nb\tc\u{85}\u{7f}d"), "a\\nb\\tc\\u{85}\\u{7f}d");
    let folder = Folder::new("line");
    let error = folder.read("a\nb.obj", "f 1\x0b2\r\n").unwrap_err();
    assert_eq!(error, "a\\nb.obj: line 1: \"1\\u{b}2\" is not a vertex index");
}

/// The real meshes next to the project, if they are there.
#[test]
fn real_meshes() {
    let folder = Path::new("../shared/meshes");
    if !folder.is_dir() {
        // Past the harness, which would keep what a macro prints to itself.
        let _ = io::stderr().write_all(b"skipped: real meshes; there is no ../shared/meshes\n");
        return;
    }
    for (name, count) in [
        ("suzanne", 968),
        ("spot", 5_856),
        ("cow", 5_804),
        ("teapot", 6_320),
        ("homer", 12_000),
        ("fandisk", 12_946),
        ("bunny", 69_451),
        ("nefertiti", 99_938),
        ("kitchen", 56_939),
    ] {
        let soup = read(&folder.join(name).with_extension("obj")).unwrap();
        assert_eq!(soup.triangles.len(), count, "{name}");
    }
}
