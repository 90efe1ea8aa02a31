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
        ("4", "5", "5 elements of 12 bytes from byte 0 on are not inside bufferView 0"),
        ("4", "0", "0 elements of 12 bytes from byte 0 on are not inside bufferView 0"),
        ("5126", "5125", "its componentType is not one of positions"),
    ] {
        assert_eq!(change_primitive(good, &good.replace(from, to)), format!("accessor 0: {message}"));
    }
    for (from, to, message) in [
        ("5126", "5124", "accessors[0].componentType: Invalid value"),
        ("View\": 0", "View\": 7", "accessors[0].bufferView: Index out of bounds"),
        ("\"bufferView\": 0, ", "", "accessors[0].bufferView: Missing data"),
        (
            "View\": 0",
            "View\": -1",
            "JSON: invalid type: integer `-1`, expected index into child of root at line 5 column 31",
        ),
    ] {
        assert_eq!(change(good, &good.replace(from, to)), message);
    }
    let all = "4 elements of 12 bytes from byte 0 on are not inside bufferView 0";
    for to in ["\"byteLength\": 48, \"byteStride\": 4", "\"byteLength\": 89", "\"byteLength\": 47"] {
        assert_eq!(change_primitive("\"byteLength\": 48", to), format!("accessor 0: {all}"));
    }
    let far = change_primitive("\"byteOffset\": 48", "\"byteOffset\": 18446744073709551615");
    assert_eq!(far, "accessor 2: 3 elements of 1 bytes from byte 8 on are not inside bufferView 1");
    let length = change("\"byteLength\": 88", "\"byteLength\": 89");
    assert_eq!(length, "buffer 0: has 88 bytes, its byteLength is 89");
    let unknown = "meshes[0].primitives[0].attributes[\"POSITION\"]: Index out of bounds";
    assert_eq!(change("\"POSITION\": 0", "\"POSITION\": 9"), unknown);
    let missing = "meshes[0].primitives[0].attributes[\"POSITION\"]: Missing data";
    assert_eq!(change("\"POSITION\"", "\"NORMAL\""), missing);
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
            r#""byteOffset": 26, "componentType": 5121, "count": 3"#,
            "accessor 2: 3 elements of 1 bytes from byte 26 on are not inside bufferView 1",
        ),
        (
            r#""byteOffset": 18446744073709551615, "componentType": 5121, "count": 3"#,
            "accessor 2: 3 elements of 1 bytes from byte 18446744073709551615 on are not inside bufferView 1",
        ),
        (
            r#""byteOffset": 15, "componentType": 5125, "count": 3"#,
            "accessor 2: vertex index 256 is out of range (the primitive has 4 vertices)",
        ),
    ] {
        assert_eq!(change_primitive(good, to), message);
    }
    assert_eq!(change_primitive("\"indices\": 2", "\"indices\": 0"), "accessor 0: its type is not Scalar");
    for (to, message) in [
        ("\"indices\": 9", "meshes[0].primitives[0].indices: Index out of bounds"),
        ("\"mode\": 7", "meshes[0].primitives[0].mode: Invalid value"),
    ] {
        assert_eq!(change("\"indices\": 2", to), message);
    }
}

#[test]
fn faults_of_the_scene_name_their_place() {
    assert_eq!(change("\"scene\": 1", "\"scene\": 2"), "scene: Index out of bounds");
    assert_eq!(change("[3, 1]", "[3, 4]"), "scenes[1].nodes[1]: Index out of bounds");
    assert!(change("[3, 1]", "7").starts_with("JSON: invalid type: integer `7`, expected a sequence at line "));
    for child in ["1", "3"] {
        assert!(change("\"children\": [2]", &format!("\"children\": [{child}]")).starts_with("node 1: "));
    }
    assert!(change("[0, 0, 5]", "[0, 5]").starts_with("JSON: invalid length 2, expected an array of length 3"));
    let far = change_primitive("[0, 0, 5]", "[0, 0, 1e39]");
    assert_eq!(far, "vertex 0 is not a finite f32 where its node puts it");
    let matrix = "\"matrix\": [1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]";
    assert!(change("\"translation\": [0, 0, 5]", matrix).contains("last row"));
}

#[test]
fn faults_of_the_document() {
    assert!(change("\"2.0\"", "\"1.0\"").contains("version \"1.0\" is not 2.0"));
    assert!(change("asset", "assets").starts_with("JSON: missing field `asset`"));
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
    assert!(parse(&"[".repeat(100_000)).unwrap_err().starts_with("JSON: "));
    let deep = format!("\"min\": {}, \"count\"", "[".repeat(100_000));
    assert!(change("\"count\"", &deep).starts_with("JSON: recursion limit"));
}

#[test]
fn positions_must_be_finite() {
    for bad in [f32::NAN, f32::INFINITY] {
        let mut chunk = bytes();
        chunk[44..48].copy_from_slice(&bad.to_le_bytes());
        let read = |fields: &str| read_binary(&binary(&model("", &meshes(fields)), &chunk), Path::new(""));
        let error = read(r#", "mode": 5"#).unwrap_err();
        assert_eq!(error, "mesh 0, primitive 0: vertex 3 is not a finite f32 where its node puts it");
        // This uses the other three only.
        assert_eq!(read(r#", "indices": 2"#).unwrap().triangles.len(), 1);
    }
}
