//! Broken glTF files and the errors they give.
use super::*;

/// The error after `from` becomes `to` in a sound file.
fn change(from: &str, to: &str) -> String {
    let good = model(&uri(), &format!("{NODES}{}", meshes(r#", "indices": 2"#)));
    assert!(parse(&good).is_ok() && good.contains(from), "{from}");
    parse(&good.replacen(from, to, 1)).unwrap_err()
}

/// [`change`], of an error in the primitive of node 1; gives what follows that place.
fn change_primitive(from: &str, to: &str) -> String {
    let error = change(from, to);
    error.strip_prefix("node 1: mesh 0, primitive 0: ").unwrap_or_else(|| panic!("{error}")).into()
}

#[test]
fn faults_of_positions_name_their_place() {
    let good = r#""bufferView": 0, "componentType": 5126, "count": 4"#;
    for (from, to, message) in [
        ("4", "9007199254740993", "9007199254740993 elements need 108086391056891916 bytes, bufferView 0 has 48"),
        ("5126", "5125", "its componentType is not one of positions"),
        ("5126", "5124", "componentType 5124 is not one of glTF"),
        ("View\": 0", "View\": 7", "bufferViews: index 7 is out of range (the file has 3)"),
        ("\"bufferView\": 0, ", "", "has no bufferView (is the mesh compressed?)"),
        ("View\": 0", "View\": -1", "bufferView is not a whole number of 0 or more"),
    ] {
        assert_eq!(change_primitive(good, &good.replace(from, to)), format!("accessor 0: {message}"));
    }
    for (from, to, message) in [
        (
            "\"byteLength\": 48",
            "\"byteLength\": 48, \"byteStride\": 4",
            "accessor 0: a byteStride of 4 for elements of 12 bytes",
        ),
        (
            "\"byteLength\": 48",
            "\"byteLength\": 89",
            "accessor 0: bufferView 0: needs 89 bytes of buffer 0, which has 88",
        ),
        (
            "\"byteLength\": 88",
            "\"byteLength\": 89",
            "accessor 0: bufferView 0: buffer 0: has 88 bytes, its byteLength is 89",
        ),
        (
            "\"byteOffset\": 48",
            "\"byteOffset\": 18446744073709551615",
            "accessor 2: bufferView 1: byteOffset and byteLength overflow",
        ),
        ("\"POSITION\"", "\"NORMAL\"", "it has no POSITION"),
    ] {
        assert_eq!(change_primitive(from, to), message);
    }
}

#[test]
fn faults_of_indices_name_their_place() {
    let good = r#""byteOffset": 8, "componentType": 5121, "count": 3"#;
    for (to, message) in [
        (r#""byteOffset": 8, "componentType": 5121, "count": 4"#, "4 corners are not a multiple of 3"),
        (
            r#""byteOffset": 8, "componentType": 5126, "count": 3"#,
            "accessor 2: its componentType is not one of indices",
        ),
        (
            r#""byteOffset": 18446744073709551615, "componentType": 5121, "count": 3"#,
            "accessor 2: 3 elements need 18446744073709551618 bytes, bufferView 1 has 28",
        ),
        (
            r#""byteOffset": 15, "componentType": 5125, "count": 3"#,
            "accessor 2: element 0: vertex index 256 is out of range (the primitive has 4 vertices)",
        ),
    ] {
        assert_eq!(change_primitive(good, to), message);
    }
    for (to, message) in [
        ("\"indices\": 9", "accessors: index 9 is out of range (the file has 5)"),
        ("\"indices\": 0", "accessor 0: its type is not SCALAR"),
        ("\"mode\": 7", "mode 7 is not one of glTF"),
    ] {
        assert_eq!(change_primitive("\"indices\": 2", to), message);
    }
}

#[test]
fn faults_of_the_scene_name_their_place() {
    assert_eq!(change("\"scene\": 1", "\"scene\": 2"), "scenes: index 2 is out of range (the file has 2)");
    assert_eq!(change("[3, 1]", "[3, 4]"), "nodes: index 4 is out of range (the file has 4)");
    assert_eq!(change("[3, 1]", "7"), "nodes is not a list");
    for child in ["0.5", "1", "3"] {
        assert!(change("\"children\": [2]", &format!("\"children\": [{child}]")).starts_with("node 1: "));
    }
    let list = change("[0, 0, 5]", "[0, 5]");
    assert_eq!(list, "node 1: translation is not a list of 3 numbers");
    let far = change_primitive("[0, 0, 5]", "[0, 0, 1e39]");
    assert_eq!(far, "vertex 0 is not a finite f32 where its node puts it");
    let matrix = "\"matrix\": [1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]";
    assert!(change("\"translation\": [0, 0, 5]", matrix).contains("last row"));
}

#[test]
fn faults_of_the_document() {
    assert!(change("\"2.0\"", "\"1.0\"").contains("version \"1.0\" is not 2.0"));
    assert!(change("asset", "assets").contains("no asset.version"));
    assert!(change("[0, 0, 5]", "[0, 0, 1e999]").starts_with("JSON: number out of range at line "));
    for (name, advice) in [
        ("KHR_draco_mesh_compression", "; save the model without compression"),
        ("EXT_meshopt_compression", "; save the model without compression"),
        ("X", ""),
    ] {
        let found = change("\"scene\"", &format!("\"extensionsRequired\": [\"{name}\"], \"scene\""));
        let message = format!("requires the extension \"{name}\", which is not supported{advice}");
        assert_eq!(found, message);
    }
    assert!(parse("{").unwrap_err().starts_with("JSON: EOF"));
    assert!(parse(&"[".repeat(100_000)).unwrap_err().starts_with("JSON: recursion limit"));
}

#[test]
fn positions_must_be_finite() {
    for bad in [f32::NAN, f32::INFINITY] {
        let mut chunk = bytes();
        // The last vertex, which no triangle uses.
        chunk[44..48].copy_from_slice(&bad.to_le_bytes());
        let file = binary(&model("", &meshes(r#", "indices": 2"#)), &chunk);
        let error = read_binary(&file, Path::new("")).unwrap_err();
        assert_eq!(error, "mesh 0, primitive 0: accessor 0: vertex 3 is not finite");
    }
}
