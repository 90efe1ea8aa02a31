//! STL, binary and text, read by `stl_io`.
//!
//! Its own choice between the two forms would take a binary file that starts with "solid " for text, so the choice is
//! made here. And it stops at the first `endsolid`, is particular about the words after `solid`, about upper case and
//! about normals that are not numbers, so the text form becomes one plain solid with normals of zeros first.
//!
//! Corners with the same bits become one vertex. Normals are skipped.
use std::collections::HashMap;
use std::io::{self, Cursor};

use super::guard::guarded;
use super::text::{self, Lines};
use crate::soup::Soup;

/// Bytes before the first triangle of a binary file: a comment, then the number of triangles.
const HEADER: usize = 84;
/// Bytes of a triangle in a binary file.
const RECORD: usize = 50;

/// Reads the bytes of an STL file.
pub fn read(data: &[u8]) -> Result<Soup, String> {
    let is_text = is_text(data) && !has_exact_length(data);
    let plain = if is_text { plain_text(data)? } else { plain_binary(data)? };
    guarded(|| {
        let mut source = Cursor::new(plain);
        let triangles = stl_io::create_stl_reader(&mut source).map_err(|error| error.to_string())?;
        weld(triangles)
    })
}

/// True if `data` is as long as its number of triangles asks for: then it is a binary STL file,
/// whatever its comment says.
pub fn has_exact_length(data: &[u8]) -> bool {
    count(data).is_some_and(|count| binary_length(count) == u64::try_from(data.len()).ok())
}

/// True if `data` looks like the text form: it says so, and has no zero byte where a binary file
/// has its number of triangles.
pub fn is_text(data: &[u8]) -> bool {
    let start = text::without_mark(data).trim_ascii_start();
    let named = start.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let spaced = start.get(5).is_none_or(u8::is_ascii_whitespace);
    named && spaced && !data.iter().take(512).any(|byte| *byte == 0)
}

/// The number of triangles that a binary file claims.
fn count(data: &[u8]) -> Option<u32> {
    let bytes: &[u8; 4] = data.get(HEADER - 4..)?.first_chunk()?;
    Some(u32::from_le_bytes(*bytes))
}

/// The length of a binary file with `count` triangles.
fn binary_length(count: u32) -> Option<u64> {
    u64::try_from(RECORD).ok()?.checked_mul(u64::from(count))?.checked_add(u64::try_from(HEADER).ok()?)
}

/// The mesh of `triangles`; corners with the same bits become one vertex.
fn weld(triangles: impl Iterator<Item = io::Result<stl_io::Triangle>>) -> Result<Soup, String> {
    let mut soup = Soup::default();
    let mut known = HashMap::new();
    for (number, triangle) in triangles.enumerate() {
        let triangle = triangle.map_err(|why| format!("triangle {number}: {why}"))?;
        let mut corners = [0; 3];
        for (slot, corner) in corners.iter_mut().zip(triangle.vertices) {
            if corner.0.iter().any(|value| !value.is_finite()) {
                return Err(format!("triangle {number}: a corner is not finite"));
            }
            let next = u32::try_from(soup.positions.len()).map_err(|_| "too many vertices")?;
            *slot = *known.entry(corner.0.map(f32::to_bits)).or_insert(next);
            if *slot == next {
                soup.positions.push(corner.0);
            }
        }
        soup.triangles.push(corners);
    }
    Ok(soup)
}

/// A binary file of sound length, with a comment that does not look like text.
fn plain_binary(data: &[u8]) -> Result<Vec<u8>, String> {
    let have = data.len();
    let Some(count) = count(data) else {
        return Err(format!(
            "not an STL file: it does not start with \"solid\", and has {have} bytes where the binary form needs at \
             least {HEADER}"
        ));
    };
    // More bytes than that are padding.
    if let Some(needed) = binary_length(count).filter(|needed| u64::try_from(have).is_ok_and(|have| have < *needed)) {
        return Err(format!("byte 80: {count} triangles need {needed} bytes, the file has {have}"));
    }
    let mut plain = data.to_vec();
    plain.iter_mut().take(1).for_each(|byte| *byte = b'\n');
    Ok(plain)
}

/// A text file with all its facets in one solid.
fn plain_text(data: &[u8]) -> Result<Vec<u8>, String> {
    let mut plain = b"solid all\n".to_vec();
    let mut is_open = false;
    let mut lines = Lines::new(text::without_mark(data));
    for (number, line) in lines.by_ref() {
        let line = line.to_ascii_lowercase();
        match text::words(&line).next() {
            None => {}
            Some(b"solid") if !is_open => is_open = true,
            Some(b"endsolid") if is_open => is_open = false,
            Some(b"facet") if is_open => plain.extend(b"facet normal 0 0 0"),
            Some(_) if is_open => plain.extend(&line),
            Some(word) => return Err(format!("line {number}: {} is outside of a solid", text::quote(word))),
        }
        plain.push(b'\n');
    }
    if is_open {
        return Err(format!("line {}: the file ends without endsolid", lines.number() - 1));
    }
    plain.extend(b"endsolid\n");
    Ok(plain)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::mutate;

    const TEXT: &str = "solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
        vertex 0 1 0\nendloop\nendfacet\nfacet normal nan nan nan\n outer loop\n  vertex 1 0 0\n  \
        vertex 0 1 0\n  vertex 1e0 +1. .0\n endloop\nendfacet\nendsolid a b\n";

    /// A binary file with `header` as its comment.
    fn binary(header: &[u8], triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
        let mut data = header.to_vec();
        data.resize(80, b' ');
        data.extend(u32::try_from(triangles.len()).unwrap().to_le_bytes());
        for triangle in triangles {
            data.extend([0; 12]);
            data.extend(triangle.as_flattened().iter().flat_map(|value| value.to_le_bytes()));
            data.extend([0; 2]);
        }
        data
    }

    const PAIR: [[[f32; 3]; 3]; 2] =
        [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]];

    #[test]
    fn both_forms_agree() {
        let expected = [[0, 1, 2], [1, 2, 3]];
        let text = read(TEXT.as_bytes()).unwrap();
        assert_eq!(text.triangles, expected);
        assert_eq!(text.positions.len(), 4);
        let upper = TEXT.to_uppercase().replace('\n', "\r\n");
        assert_eq!(read(upper.as_bytes()).unwrap().triangles, expected);
        for header in [b"".as_slice(), b"solid", b"solid facet normal", b"ply\n", b"glTF", b"{"] {
            let found = read(&binary(header, &PAIR)).unwrap();
            assert_eq!((found.triangles.as_slice(), &found.positions), (&expected[..], &text.positions));
        }
    }

    #[test]
    fn several_solids_and_padding() {
        let both = format!("{TEXT}\n{}", TEXT.replace("solid a b", "solid"));
        assert_eq!(read(both.as_bytes()).unwrap().triangles.len(), 4);
        let mut padded = binary(b"solid x", &PAIR);
        padded.extend([0; 7]);
        assert_eq!(read(&padded).unwrap().triangles.len(), 2);
        let same = [[[1.0; 3]; 3]; 3];
        assert_eq!(read(&binary(b"", &same)).unwrap().triangles, [[0; 3]; 3]);
    }

    #[test]
    fn binary_faults() {
        let error = |data: &[u8]| read(data).unwrap_err();
        let mut liar = binary(b"", &PAIR);
        liar[80..84].copy_from_slice(&[0xff; 4]);
        let message = "byte 80: 4294967295 triangles need 214748364834 bytes, the file has 184";
        assert_eq!(error(&liar), message);
        let whole = binary(b"solid x", &PAIR);
        assert!(error(&whole[..183]).starts_with("byte 80: 2 triangles need 184 bytes"));
        assert!(error(&whole[8..83]).contains("has 75 bytes where the binary form needs at least 84"));
        for bad in [f32::NAN, f32::INFINITY] {
            let mut broken = PAIR;
            broken[1][2][1] = bad;
            assert_eq!(error(&binary(b"", &broken)), "triangle 1: a corner is not finite");
        }
        assert!(read(&binary(b"", &[])).unwrap().triangles.is_empty());
    }

    #[test]
    fn text_faults() {
        let error = |text: &str| read(text.as_bytes()).unwrap_err();
        assert_eq!(error(&TEXT[..TEXT.len() - 14]), "line 15: the file ends without endsolid");
        assert_eq!(error(&TEXT[..60]), "line 5: the file ends without endsolid");
        let inside = |lines: &str| error(&format!("solid\n{lines}\nendsolid"));
        assert_eq!(inside("facet"), "triangle 0: expected [\"outer\", \"loop\"], got [\"endsolid\"]");
        assert_eq!(inside("facet\nendfacet"), "triangle 0: expected [\"outer\", \"loop\"], got [\"endfacet\"]");
        assert_eq!(inside("vertex 0 0 0"), "triangle 0: invalid facet header: [\"vertex\", \"0\", \"0\", \"0\"]");
        assert_eq!(error("\nsolid\nendsolid\nfacet"), "line 4: \"facet\" is outside of a solid");
        for (bad, why) in [("inf", "finite"), ("nan", "finite"), ("1e999", "finite"), ("x", "invalid float")] {
            let message = error(&TEXT.replace("+1.", bad));
            assert!(message.starts_with("triangle 1: ") && message.contains(why), "{message}");
        }
        let four = TEXT.replacen("vertex 0 1 0\n", "vertex 0 1 0\nvertex 0 1 0\n", 1);
        assert!(error(&four).starts_with("triangle 0: expected [\"endloop\"]"));
        assert!(read(b"solid x\nendsolid x").unwrap().triangles.is_empty());
    }

    #[test]
    fn damaged_files_never_panic() {
        mutate::run(&[TEXT.as_bytes(), &binary(b"x", &PAIR), &binary(b"solid", &PAIR[..1])], read);
    }
}
