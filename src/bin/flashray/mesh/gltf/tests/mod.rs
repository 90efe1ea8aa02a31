//! Tests of the glTF reader.
mod faults;

use super::*;
use crate::mesh::mutate;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

/// Four corners of a square, then the indices 0 1 2 3 as `u16`, `u8` and `u32`, then 9 as `f32`s.
fn bytes() -> Vec<u8> {
    let corners = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let mut data: Vec<u8> = corners.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
    data.extend([0u16, 1, 2, 3].iter().flat_map(|value| value.to_le_bytes()));
    data.extend([0u8, 1, 2, 3]);
    data.extend([0u32, 1, 2, 3].iter().flat_map(|value| value.to_le_bytes()));
    data.extend([9.0f32; 3].iter().flat_map(|value| value.to_le_bytes()));
    data
}

/// The buffer of [`bytes`] as a data URI.
fn uri() -> String {
    format!("\"uri\": \"data:application/octet-stream;base64,{}\", ", STANDARD.encode(bytes()))
}

/// A file with the square as accessor 0, its indices as accessors 1 to 3, and `rest`.
fn model(uri: &str, rest: &str) -> String {
    format!(
        r#"{{"asset": {{"version": "2.0"}},
"buffers": [{{{uri}"byteLength": 88}}],
"bufferViews": [{{"buffer": 0, "byteLength": 48}},
  {{"buffer": 0, "byteOffset": 48, "byteLength": 28}}, {{"buffer": 0, "byteOffset": 76, "byteLength": 12}}],
"accessors": [{{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}},
  {{"bufferView": 1, "componentType": 5123, "count": 4, "type": "SCALAR"}},
  {{"bufferView": 1, "byteOffset": 8, "componentType": 5121, "count": 3, "type": "SCALAR"}},
  {{"bufferView": 1, "byteOffset": 16, "componentType": 5125, "count": 3, "type": "SCALAR"}},
  {{"componentType": 5126, "count": 4, "type": "VEC3", "sparse": {{"count": 1,
    "indices": {{"bufferView": 1, "byteOffset": 10, "componentType": 5121}}, "values": {{"bufferView": 2}}}}}}],
{rest}}}"#
    )
}

/// A mesh with one primitive that has `fields` besides the square's positions.
fn meshes(fields: &str) -> String {
    format!(r#""meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}{fields}}}]}}]"#)
}

/// What is read from `text`.
fn parse(text: &str) -> Result<Soup, String> {
    read(text.as_bytes(), Path::new("/nowhere"))
}

/// The triangles of a primitive with these `fields`.
fn triangles(fields: &str) -> Vec<[u32; 3]> {
    parse(&model(&uri(), &meshes(fields))).unwrap().triangles
}

/// A GLB file with this JSON and chunk.
fn binary(json: &str, chunk: &[u8]) -> Vec<u8> {
    let mut data = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    let json = format!("{json}{}", " ".repeat(json.len().next_multiple_of(4) - json.len()));
    for (name, content) in [(b"JSON", json.as_bytes()), (b"BIN\0", chunk)] {
        data.extend(u32::try_from(content.len()).unwrap().to_le_bytes());
        data.extend(name);
        data.extend(content);
    }
    let length = u32::try_from(data.len()).unwrap();
    data[8..12].copy_from_slice(&length.to_le_bytes());
    data
}

/// Scenes with nodes that move, turn and share the mesh.
const NODES: &str = r#""scene": 1, "scenes": [{"nodes": [0]}, {"nodes": [3, 1]}], "nodes": [{"mesh": 0},
  {"mesh": 0, "translation": [0, 0, 5], "children": [2]},
  {"mesh": 0, "scale": [2, 2, 2], "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476]},
  {"translation": [1, 1, 1]}], "#;

#[test]
fn modes_and_types_of_indices() {
    assert_eq!(triangles(r#", "mode": 5, "indices": 1"#), [[0, 1, 2], [1, 3, 2]]);
    assert_eq!(triangles(r#", "mode": 6, "indices": 1"#), [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(triangles(r#", "mode": 5"#), [[0, 1, 2], [1, 3, 2]]);
    assert_eq!(triangles(r#", "indices": 2"#), [[0, 1, 2]]);
    assert_eq!(triangles(r#", "mode": 4, "indices": 3"#), [[0, 1, 2]]);
    assert!(triangles(r#", "mode": 1, "indices": 1"#).is_empty());
    let soup = parse(&model(&uri(), &meshes(r#", "indices": 2"#))).unwrap();
    assert_eq!(soup.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
}

#[test]
fn only_vertices_in_use_are_kept() {
    let later = model(&uri(), &meshes(r#", "indices": 2"#))
        .replace(r#""byteOffset": 8, "componentType": 5121"#, r#""byteOffset": 9, "componentType": 5121"#);
    let soup = parse(&later).unwrap();
    assert_eq!(soup.triangles, [[0, 1, 2]]);
    assert_eq!(soup.positions, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]);
}

#[test]
fn nodes_in_order_with_their_transforms() {
    let fields = r#", "mode": 6, "indices": 1"#;
    let soup = parse(&model(&uri(), &format!("{NODES}{}", meshes(fields)))).unwrap();
    assert_eq!(soup.triangles, [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]);
    assert_eq!(soup.positions[..2], [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0]]);
    assert!((soup.positions[5][1] - 2.0).abs() < 1e-6 && soup.positions[5][0].abs() < 1e-6);
    let no_default = NODES.replace(r#""scene": 1, "#, "");
    assert_eq!(parse(&model(&uri(), &format!("{no_default}{}", meshes(fields)))).unwrap().triangles.len(), 6);
    let no_scenes = no_default.replace(r#""scenes": [{"nodes": [0]}, {"nodes": [3, 1]}], "#, "");
    assert_eq!(parse(&model(&uri(), &format!("{no_scenes}{}", meshes(fields)))).unwrap().triangles.len(), 6);
}

#[test]
fn a_deep_chain_of_nodes() {
    let chain: Vec<String> = (1..50_000).map(|child| format!(r#"{{"children": [{child}]}}"#)).collect();
    let nodes = format!(r#""nodes": [{}, {{"mesh": 0}}], {}"#, chain.join(","), meshes(r#", "indices": 2"#));
    assert_eq!(parse(&model(&uri(), &nodes)).unwrap().triangles.len(), 1);
}

#[test]
fn a_mesh_repeated_very_often_fails_at_once() {
    let nodes = vec![r#"{"mesh": 0}"#; 60_000].join(",");
    let primitives = vec![r#"{"attributes": {"POSITION": 0}, "mode": 6}"#; 20_000].join(",");
    let text = model(&uri(), &format!(r#""nodes": [{nodes}], "meshes": [{{"primitives": [{primitives}]}}]"#));
    assert_eq!(parse(&text).unwrap_err(), "more than 268435455 triangles, the most a mesh may have");
    let huge = model(&uri(), &meshes("")).replacen("\"count\": 4", "\"count\": 4000000000", 1);
    assert_eq!(parse(&huge).unwrap_err(), too_many());
}

#[test]
fn faults_that_leave_the_geometry_alone() {
    let rest = format!(r#"{}, "textures": [{{"source": 7}}]"#, meshes(r#", "indices": 2"#));
    let text = model(&uri(), &rest).replace(r#""POSITION": 0"#, r#""POSITION": 0, "_ID": 1, "NORMAL": 0"#);
    assert_eq!(parse(&text).unwrap().triangles.len(), 1);
}

#[test]
fn buffers_in_the_file() {
    let rest = meshes(r#", "indices": 2"#);
    let json = model("", &rest);
    let mut chunk = bytes();
    chunk.extend([0; 3]);
    let nowhere = Path::new("/nowhere");
    assert_eq!(read_binary(&binary(&json, &chunk), nowhere).unwrap().triangles.len(), 1);
    let short = read_binary(&binary(&json, &chunk[..80]), nowhere).unwrap_err();
    assert_eq!(short, "buffer 0: has 80 bytes, its byteLength is 88");
    let whole = binary(&json, &chunk);
    assert_eq!(read_binary(&[whole.as_slice(), b"after"].concat(), nowhere).unwrap().triangles.len(), 1);
    for end in 0..whole.len() {
        assert!(read_binary(&whole[..end], nowhere).is_err());
    }
    let error = |uri: &str| parse(&model(uri, &rest)).unwrap_err();
    assert!(error("").ends_with("there is no GLB chunk for it"));
    assert!(error("\"uri\": 7, ").starts_with("JSON: invalid type: integer `7`, expected a string"));
    assert!(error("\"uri\": \"data:text/plain,abc\", ").ends_with("not in base64"));
    assert!(error("\"uri\": \"data:;base64\", ").ends_with("no comma"));
    assert!(error("\"uri\": \"data:;base64,A-\", ").contains("its data URI: "));
}

#[test]
fn buffers_next_to_the_file() {
    let folder = std::env::temp_dir().join(format!("flashray-gltf-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("a b.bin"), bytes()).unwrap();
    let parse = |name: &str| {
        let rest = meshes(r#", "indices": 2"#);
        read(model(&format!(r#""uri": "{name}", "#), &rest).as_bytes(), &folder)
    };
    assert_eq!(parse("a%20b.bin").unwrap().triangles.len(), 1);
    assert!(parse("no.bin").unwrap_err().ends_with("\"no.bin\": no such file"));
    for name in ["../a%20b.bin", "https://example.org/a.bin", "/etc/hostname"] {
        assert!(parse(name).unwrap_err().ends_with("not the name of a file in the model's folder"));
    }
    std::fs::write(folder.join("a b.bin"), &bytes()[..50]).unwrap();
    assert!(parse("a%20b.bin").unwrap_err().ends_with("\"a%20b.bin\": has 50 bytes, 88 are needed"));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn sparse_positions() {
    let good = model(&uri(), &meshes(r#", "mode": 5"#).replace("\"POSITION\": 0", "\"POSITION\": 4"));
    assert_eq!(parse(&good).unwrap().positions, [[0.0; 3], [0.0; 3], [9.0; 3], [0.0; 3]]);
    let error = |from: &str, to: &str| parse(&good.replace(from, to)).unwrap_err();
    assert!(
        error("\"count\": 1", "\"count\": 2")
            .contains("2 elements of 12 bytes from byte 0 on are not inside bufferView 2")
    );
    let many = error("\"count\": 4", "\"count\": 4000");
    assert!(many.contains("4000 elements without a bufferView"), "{many}");
    // The crate would pass over these two.
    let wide = error("Offset\": 10, \"componentType\": 5121", "Offset\": 3, \"componentType\": 5123");
    assert!(wide.ends_with("sparse index 512 is out of order, or out of range (4 elements)"));
    // As bytes, the indices of 16 bits are 0 0 1 0 ...
    let back = good.replace("\"count\": 1", "\"count\": 2").replace("\"byteOffset\": 10", "\"byteOffset\": 0");
    let back = parse(&back.replace("\"values\": {\"bufferView\": 2}", "\"values\": {\"bufferView\": 0}")).unwrap_err();
    assert!(back.ends_with("sparse index 0 is out of order, or out of range (4 elements)"));
}

#[test]
fn quantized_positions_with_a_stride() {
    let bytes = model(&uri(), &format!(r#""extensionsRequired": ["KHR_mesh_quantization"], {}"#, meshes("")))
        .replace(
            r#""bufferView": 0, "componentType": 5126, "count": 4"#,
            r#""bufferView": 1, "byteOffset": 9, "componentType": 5121, "normalized": true, "count": 3"#,
        )
        .replace(r#""byteLength": 28"#, r#""byteLength": 28, "byteStride": 8"#);
    let soup = parse(&bytes).unwrap();
    assert_eq!(soup.positions[0], [1.0f64, 2.0, 3.0].map(|value| (value / 255.0) as f32));
}

#[test]
fn damaged_files_never_panic() {
    let nowhere = Path::new("/nowhere");
    let text = model(&uri(), &format!("{NODES}{}", meshes(r#", "mode": 6, "indices": 1"#)));
    let sparse = model(&uri(), &meshes(r#", "mode": 5"#).replace("\"POSITION\": 0", "\"POSITION\": 4"));
    mutate::run(&[text.as_bytes(), sparse.as_bytes()], |data| read(data, nowhere));
    let indexed = binary(&model("", &meshes(r#", "indices": 3"#)), &bytes());
    let nodes = binary(&model("", &format!("{NODES}{}", meshes(r#", "indices": 2"#))), &bytes());
    mutate::run(&[&indexed, &nodes], |data| read_binary(data, nowhere));
}
