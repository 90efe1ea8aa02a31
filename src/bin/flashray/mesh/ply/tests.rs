//! Tests of the PLY reader.
use super::*;
use crate::mesh::mutate;

/// A header with `format`, a square of `float` vertices and `faces` faces.
fn header(format: &str, faces: usize) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment made by hand\nobj_info x\nelement vertex 4\n\
         property float x\nproperty float y\nproperty float z\nproperty uchar red\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

/// The square as text.
fn text() -> String {
    header("ascii", 2) + "0 0 0 255\n1 0 0 1\n1e0 +1.0 0 7\n0 1 0 0\n4 0 1 2 3\n3 3 2 1\n"
}

/// The square as bytes.
fn binary(is_big: bool) -> Vec<u8> {
    let mut data = header(if is_big { "binary_big_endian" } else { "binary_little_endian" }, 2).into_bytes();
    for [x, y] in [[0.0f32, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
        for value in [x, y, 0.0] {
            data.extend(if is_big { value.to_be_bytes() } else { value.to_le_bytes() });
        }
        data.push(200);
    }
    for face in [[0i32, 1, 2, 3].as_slice(), &[3, 2, 1]] {
        data.push(u8::try_from(face.len()).unwrap());
        for value in face {
            data.extend(if is_big { value.to_be_bytes() } else { value.to_le_bytes() });
        }
    }
    data
}

/// The length of the header that `data` starts with.
fn length_of_header(data: &[u8]) -> usize {
    let end = b"end_header\n";
    data.windows(end.len()).position(|window| window == end).unwrap() + end.len()
}

/// The error of a file with these bytes.
fn error(data: impl AsRef<[u8]>) -> String {
    read(data.as_ref()).unwrap_err()
}

#[test]
fn every_encoding_agrees() {
    let square = read(text().as_bytes()).unwrap();
    assert_eq!(square.positions, [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]]);
    assert_eq!(square.triangles, [[0, 1, 2], [0, 2, 3], [3, 2, 1]]);
    let lines = text();
    for data in [
        binary(false),
        binary(true),
        lines.replace('\n', "\r\n").into_bytes(),
        lines.replace('\n', " \t\n").into_bytes(),
        lines.replace('\n', "\r").into_bytes(),
        lines.replace("made by", "\u{e4}").into_bytes().into_iter().filter(|byte| *byte != 0xc3).collect(),
        lines.replace('\n', "\n\n").replacen("ply\n\n", "ply\n", 1).into_bytes(),
        lines.replace("vertex_indices", "vertex_index").replace(' ', "\t").into_bytes(),
    ] {
        let found = read(&data).unwrap();
        assert_eq!((&found.positions, &found.triangles), (&square.positions, &square.triangles));
    }
}

#[test]
fn a_header_with_cr_alone_before_binary_data() {
    let data = binary(false);
    let length = length_of_header(&data);
    let mut other = String::from_utf8(data[..length].to_vec()).unwrap().replace('\n', "\r").into_bytes();
    other.extend(&data[length..]);
    assert_eq!(read(&other).unwrap().triangles.len(), 3);
}

#[test]
fn every_type_of_number() {
    let kinds = ["char", "uint8", "int16", "ushort", "int", "uint32", "float32", "double"];
    for (place, kind) in kinds.iter().enumerate() {
        for length in ["uchar", "int8", "short", "uint16", "int32", "uint"] {
            let index = kinds[place % 6];
            let lines = format!(
                "element vertex 3\nproperty {kind} z\nproperty {kind} y\nproperty {kind} x\n\
                 property list {length} {kind} extra\nelement other 1\nproperty {kind} x\nelement none 9\n\
                 element face 1\nproperty {kind} q\nproperty list {length} {index} vertex_index\nend_header\n"
            );
            let rows = ["3 2 1 0", "6 5 4 1 9", "9 8 7 2 9 9", "5", "7 3 2 1 0"];
            let ascii = format!("ply\nformat ascii 1.0\n{lines}{}\n", rows.join("\n"));
            let mut bytes = format!("ply\nformat binary_big_endian 1.0\n{lines}").into_bytes();
            for (row, words) in rows.iter().enumerate() {
                for (column, word) in words.split(' ').enumerate() {
                    let kind = match (row, column) {
                        (0..=2, 3) | (4, 1) => length,
                        (4, 2..) => index,
                        _ => kind,
                    };
                    put(&mut bytes, kind, word.parse().unwrap());
                }
            }
            for soup in [read(ascii.as_bytes()).unwrap(), read(&bytes).unwrap()] {
                assert_eq!(soup.positions, [[1., 2., 3.], [4., 5., 6.], [7., 8., 9.]]);
                assert_eq!(soup.triangles, [[2, 1, 0]]);
            }
        }
    }
}

/// Writes `value` as the big-endian `kind`.
fn put(bytes: &mut Vec<u8>, kind: &str, value: u8) {
    match kind {
        "float32" => bytes.extend(f32::from(value).to_be_bytes()),
        "double" => bytes.extend(f64::from(value).to_be_bytes()),
        "char" | "uchar" | "int8" | "uint8" => bytes.push(value),
        "short" | "ushort" | "int16" | "uint16" => bytes.extend(u16::from(value).to_be_bytes()),
        _ => bytes.extend(u32::from(value).to_be_bytes()),
    }
}

#[test]
fn doubles_are_rounded_once() {
    // Just above the middle between 1 and the next f32: by way of f64 it would fall to 1.
    let middle = "1.000000059604644775390625000001";
    let lines = text().replace("float", "double").replacen("1 0 0 1\n", &format!("{middle} 0 0 1\n"), 1);
    let soup = read(lines.as_bytes()).unwrap();
    assert_eq!(soup.positions[1][0].to_bits(), 1.0f32.to_bits() + 1);
}

#[test]
fn no_count_is_believed() {
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        for count in ["4000000000", "9223372036854775807"] {
            let many = header(format, 2).replace("vertex 4", &format!("vertex {count}"));
            assert!(error(many).starts_with("vertex 0 ("));
        }
        let mut none = header(format, 0).replace("vertex 4", "vertex 0");
        none = none.replace("element face", "element none 9223372036854775807\nelement face");
        assert!(read(none.as_bytes()).unwrap().triangles.is_empty());
    }
    assert!(error(header("ascii", 2).replace("vertex 4", "vertex 99999999999999999999")).starts_with("line 5: "));
    assert!(error(header("ascii", 2).replace("vertex 4", "vertex -4")).starts_with("line 5: "));
    let mut list = binary(false);
    let at = list.len() - 13;
    list[at] = 255;
    let message = format!("face 1 (byte {}): Couldn't find a list element at index 3.", list.len());
    assert!(error(&list).starts_with(&message));
}

#[test]
fn faults_name_their_place() {
    let square = text();
    let change = |from: &str, to: &str| error(square.replacen(from, to, 1));
    let range = "vertex index 9 is out of range (the file has 4 vertices)";
    assert_eq!(change("3 3 2 1\n", "3 3 2 9\n"), format!("face 1 (line 18): {range}"));
    assert_eq!(change("3 3 2 1\n", "3 3 2 -1\n"), "face 1 (line 18): a corner is not a whole number of 0 or more");
    assert!(change("3 3 2 1\n", "3 3 2 1.5\n").starts_with("face 1 (line 18): Couldn't parse element at index 2"));
    assert!(change("3 3 2 1\n", "-3 3 2 1\n").starts_with("face 1 (line 18): Parse error. Value: '-3'"));
    assert!(change("3 3 2 1\n", "2 3 2\n").ends_with("at least 3 corners, this one has 2"));
    assert_eq!(change("3 3 2 1\n", "3 3 2\n"), "face 1 (line 18): Expected 3 list elements, but found only 2.");
    assert_eq!(change("3 3 2 1\n", ""), "face 1 (line 17): the file ends here");
    assert_eq!(change("1e0", "1e999"), "vertex 2 (line 15): x, y or z is not a finite f32");
    // The crate's numbers are digits with digits after the point, if there is one.
    for bad in ["nan", "inf", ".5", "1."] {
        assert!(change("1e0", bad).starts_with("vertex 2 (line 15): Couldn't parse element line."));
    }
}

#[test]
fn faults_of_binary_files_name_their_place() {
    let whole = binary(true);
    let length = length_of_header(&whole);
    for at in length..whole.len() {
        let message = error(&whole[..at]);
        assert!(message.contains("(byte ") && message.ends_with("failed to fill whole buffer"), "{message}");
    }
    for bits in [f32::NAN, f32::NEG_INFINITY] {
        let mut broken = whole.clone();
        broken[length + 13..length + 17].copy_from_slice(&bits.to_be_bytes());
        let message = format!("vertex 1 (byte {}): x, y or z is not a finite f32", length + 26);
        assert_eq!(error(&broken), message);
    }
}

#[test]
fn faults_of_the_header() {
    let square = text();
    let change = |from: &str, to: &str| error(square.replacen(from, to, 1));
    assert!(error("plyx\n").starts_with("not a PLY file"));
    assert!(error("v 1 2 3\n").starts_with("not a PLY file"));
    assert!(error(&square[..40]).starts_with("line 4: Unexpected end of file while reading header"));
    assert_eq!(change("format ascii 1.0\n", ""), "No format line found.");
    assert!(change("ascii 1.0", "ascii 2.0").contains("version 2.0 is not 1.0"));
    assert!(change("ascii", "utf8") == "line 2: Couldn't parse line. String: 'format utf8 1.0 '");
    assert!(change("float x", "half x").starts_with("line 6: Couldn't parse line."));
    assert!(change("float x", "float").starts_with("line 6: Couldn't parse line."));
    assert!(change("element vertex 4\n", "").contains("found without preceding element"));
    assert!(change("element vertex 4", "element point 4").contains("no element vertex with the property x"));
    assert!(change("float z", "float w").contains("no element vertex with the property z"));
    assert!(change("float z", "list uchar float z").starts_with("vertex 0 (line 13): "));
    assert!(change("list uchar int", "list uchar float").contains("a corner is not a whole number"));
    assert!(change("vertex_indices", "corners").contains("no list vertex_indices"));
    assert!(change("element face", "element vertex").contains("with the same name"));
    assert!(change("uchar red", "uchar x").contains("with the same name"));
    assert!(change("element face", "element tristrips").contains("triangle strips"));
    assert!(read(square.replace("element face", "element edge").as_bytes()).unwrap().triangles.is_empty());
}

#[test]
fn damaged_files_never_panic() {
    mutate::run(&[text().as_bytes(), &binary(false), &binary(true)], read);
}
