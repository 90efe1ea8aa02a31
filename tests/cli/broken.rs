//! Meshes that are no good are refused with a line that says why.
use super::{CUBE, Folder};

/// A glTF file of one triangle, with its positions in `a.bin`.
pub const GLTF: &str = r#"{"asset": {"version": "2.0"}, "buffers": [{"uri": "a.bin", "byteLength": 36}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}],
    "scene": 0}"#;

/// The corners of a triangle, the first one at x.
pub fn triangle(x: f32) -> Vec<u8> {
    [x, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|v: &f32| v.to_le_bytes()).collect()
}

/// [`GLTF`] and its buffer as one binary file.
pub fn glb(buffer: &[u8]) -> Vec<u8> {
    let mut json = GLTF.replace(r#""uri": "a.bin", "#, "").into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend((28 + json.len() as u32 + buffer.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json[..]), (b"BIN\0", buffer)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}

/// A PLY file of one triangle, with its first vertex and the number of its last one.
pub fn ply(vertex: &str, last: u32) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         element face 1\nproperty list uchar int vertex_index\nend_header\n{vertex}\n1 0 0\n0 1 0\n3 0 1 {last}\n"
    )
}

/// A binary STL file of one triangle.
pub fn stl(corners: &[u8]) -> Vec<u8> {
    let mut file = vec![b' '; 80];
    file.extend(1u32.to_le_bytes());
    file.extend([0; 12]);
    file.extend(corners);
    file.extend([0; 2]);
    file
}

#[test]
fn files_that_end_too_early() {
    let folder = Folder::new("broken-truncated");
    folder.put("cut.obj", &CUBE[..CUBE.len() - 4]);
    folder.put("vertex.obj", "v 0 0 0\nv 1 0 0\nv 0 1");
    let text = ply("0 0 0", 2);
    folder.put("header.ply", &text[..60]);
    folder.put("body.ply", &text[..text.len() - 3]);
    let whole = stl(&triangle(0.0));
    folder.put("cut.stl", &whole[..whole.len() - 20]);
    folder.put("cut.gltf", &GLTF[..GLTF.len() / 2]);
    folder.put("a.gltf", GLTF);
    folder.put("a.bin", &triangle(0.0)[..30]);
    let whole = glb(&triangle(0.0));
    folder.put("cut.glb", &whole[..whole.len() - 10]);
    folder.put("start.glb", &whole[..10]);
    for (name, why) in [
        ("cut.obj", "line 14"),
        ("vertex.obj", "line 3"),
        ("header.ply", "header"),
        ("body.ply", "face"),
        ("cut.stl", "the file has 114"),
        ("cut.gltf", "JSON"),
        ("a.gltf", "a.bin"),
        ("cut.glb", "cut short: its header says"),
        ("start.glb", "cut short: a binary glTF header has 12 bytes"),
    ] {
        folder.fails(&format!("build {name} -o out"), &[&format!("flashray: {name}: "), why]);
    }
    std::fs::remove_file(folder.path("a.bin")).expect("the buffer");
    folder.fails("build a.gltf -o out", &["flashray: a.gltf: ", "a.bin", "no such file"]);
}

#[test]
fn coordinates_that_are_not_finite() {
    let folder = Folder::new("broken-nan");
    for (bad, number) in [("nan", f32::NAN), ("inf", f32::INFINITY)] {
        folder.put("bad.obj", CUBE.replacen("v 1 1 1", &format!("v {bad} 1 1"), 1));
        folder.put("bad.ply", ply(&format!("{bad} 0 0"), 2));
        folder.put("bad.stl", stl(&triangle(number)));
        folder.put("bad.glb", glb(&triangle(number)));
        for (name, place, why) in [
            ("bad.obj", "line 3", "finite"),
            ("bad.ply", "line 10", "nan 0 0".replace("nan", bad).as_str()),
            ("bad.stl", "0", "finite"),
            ("bad.glb", "0", "finite"),
        ] {
            folder.fails(&format!("build {name} -o out"), &[&format!("flashray: {name}: "), place, why]);
        }
    }
}

#[test]
fn indices_out_of_range() {
    let folder = Folder::new("broken-index");
    folder.put("bad.obj", CUBE.replace("f 5 1 4 8", "f 5 1 4 9"));
    folder.fails("build bad.obj -o out", &["flashray: bad.obj: ", "line 12", "9"]);
    folder.put("zero.obj", CUBE.replace("f 5 1 4 8", "f 5 1 4 0"));
    folder.fails("build zero.obj -o out", &["flashray: zero.obj: ", "line 12"]);
    folder.put("bad.ply", ply("0 0 0", 3));
    folder.fails("build bad.ply -o out", &["flashray: bad.ply: ", "3"]);
    // The indices are the first bytes of the positions: 0, 0 and 0x3f800000.
    let indexed = GLTF
        .replace(
            r#""max": [1, 1, 0]}"#,
            r#""max": [1, 1, 0]}, {"bufferView": 0, "componentType": 5125, "count": 6, "type": "SCALAR"}"#,
        )
        .replace(r#"{"POSITION": 0}"#, r#"{"POSITION": 0}, "indices": 1"#);
    folder.put("bad.gltf", indexed);
    folder.put("a.bin", triangle(0.0));
    folder.fails("build bad.gltf -o out", &["flashray: bad.gltf: ", "1065353216"]);
}

#[test]
fn names_that_lead_to_no_mesh() {
    let folder = Folder::with_cube("broken-names");
    std::fs::create_dir(folder.path("folder.obj")).expect("a folder");
    folder.put("cube.off", CUBE);
    folder.put("cube", CUBE);
    folder.put("cube.ply", CUBE);
    folder.put("really.obj", ply("0 0 0", 2));
    folder.put("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    for (name, why) in [
        ("nosuch.obj", "no such file"),
        ("nosuch/cube.obj", "no such file"),
        ("folder.obj", "is a directory"),
        (".", "is a directory"),
        ("cube.off", "unknown extension .off"),
        ("cube", "no extension"),
        ("cube.fray", "unknown extension .fray"),
        ("cube.ply", "not a PLY file"),
        ("really.obj", "the content is PLY"),
        ("points.obj", "no triangles"),
    ] {
        folder.fails(&format!("build {name} -o out"), &[&format!("flashray: {name}: "), why]);
    }
    for ending in ["obj", "ply", "stl", "gltf", "glb"] {
        folder.put(&format!("empty.{ending}"), "");
        folder.fails(&format!("build empty.{ending} -o out"), &[&format!("flashray: empty.{ending}: "), "empty"]);
    }
}

#[test]
fn scenes_that_are_not_there() {
    let folder = Folder::new("broken-spd");
    let line = folder.fails("build spd:nosuch -o out", &["spd:nosuch: no such scene"]);
    assert!(crate::spd::NAMES.iter().all(|name| line.contains(name)), "{line}");
    for size in ["99", "8", "-1", "x", "", "2:2"] {
        let spec = format!("spd:balls:{size}");
        folder.fails(&format!("build {spec} -o out"), &[&format!("flashray: {spec}: size must be 0 to 7")]);
    }
}

#[test]
fn the_bad_one_of_several_inputs_is_named() {
    let folder = Folder::with_cube("broken-several");
    folder.put("bad.obj", CUBE.replace("f 5 1 4 8", "f 5 1 4 9"));
    folder.fails("build cube.obj spd:balls:1 bad.obj cube.obj -o out", &["flashray: bad.obj: ", "line 12"]);
}
