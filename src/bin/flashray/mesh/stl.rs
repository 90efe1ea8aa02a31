//! STL, binary and text.
//!
//! Our own reader rather than `stl_io`, because `stl_io` takes a binary file that begins with
//! "solid " for text, stops at the first `endsolid` of a file with several solids, refuses `solid`
//! without a name and normals that are not numbers, and gives no line numbers in its errors.
//!
//! Corners with the same bits become one vertex. Normals are skipped.
use std::collections::HashMap;

use super::sink::Sink;
use super::text::{self, Lines};
use crate::soup::Soup;

/// Bytes before the first triangle of a binary file: a comment, then the number of triangles.
const HEADER: usize = 84;
/// Bytes of a triangle in a binary file: a normal, three corners, two bytes of attributes.
const RECORD: usize = 50;
/// Where the first corner starts in a triangle's bytes.
const CORNERS: usize = 12;

/// Reads the bytes of an STL file.
pub fn read(data: &[u8]) -> Result<Soup, String> {
    if is_text(data) && !has_exact_length(data) { read_text(data) } else { read_binary(data) }
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

/// Vertices by their bits.
struct Weld {
    sink: Sink,
    known: HashMap<[u32; 3], u32>,
}

impl Weld {
    /// No vertices yet.
    fn new() -> Self {
        Self { sink: Sink::new(), known: HashMap::new() }
    }

    /// The index of the vertex at `position`.
    fn vertex(&mut self, position: [f32; 3]) -> Result<u32, String> {
        let bits = position.map(f32::to_bits);
        if let Some(index) = self.known.get(&bits) {
            return Ok(*index);
        }
        let index = self.sink.vertex(position)?;
        self.known.insert(bits, index);
        Ok(index)
    }

    /// Adds the triangle with these corners.
    fn triangle(&mut self, corners: [[f32; 3]; 3]) -> Result<(), String> {
        let [a, b, c] = corners;
        let corners = [self.vertex(a)?, self.vertex(b)?, self.vertex(c)?];
        self.sink.triangle(corners)
    }
}

/// Reads the binary form.
fn read_binary(data: &[u8]) -> Result<Soup, String> {
    let have = data.len();
    let Some(count) = count(data) else {
        return Err(format!(
            "not an STL file: it does not start with \"solid\", and has {have} bytes where the \
             binary form needs at least {HEADER}"
        ));
    };
    let length = binary_length(count).ok_or("the number of triangles is too large")?;
    if u64::try_from(have).is_ok_and(|have| have < length) {
        return Err(format!("byte 80: {count} triangles need {length} bytes, the file has {have}"));
    }
    let mut weld = Weld::new();
    // The length was checked above; what follows the last triangle is padding.
    let take = usize::try_from(count).map_err(|_| "the file is too large")?;
    let records = data.get(HEADER..).unwrap_or_default().chunks_exact(RECORD).take(take);
    for (number, record) in records.enumerate() {
        corners(record)
            .and_then(|corners| weld.triangle(corners))
            .map_err(|why| format!("triangle {number} (byte {}): {why}", HEADER + number * RECORD))?;
    }
    Ok(weld.sink.finish())
}

/// The corners in a triangle's bytes.
fn corners(record: &[u8]) -> Result<[[f32; 3]; 3], String> {
    let mut corners = [[0.0; 3]; 3];
    let (values, _) = record.get(CORNERS..).unwrap_or_default().as_chunks();
    for (slot, bytes) in corners.as_flattened_mut().iter_mut().zip(values) {
        *slot = f32::from_le_bytes(*bytes);
    }
    match corners.iter().position(|corner| corner.iter().any(|value| !value.is_finite())) {
        Some(corner) => Err(format!("corner {corner} is not finite")),
        None => Ok(corners),
    }
}

/// Reads the text form.
fn read_text(data: &[u8]) -> Result<Soup, String> {
    let mut reader = TextReader { weld: Weld::new(), in_solid: false, facet: None };
    let mut lines = Lines::new(text::without_mark(data), 1);
    for (number, line) in lines.by_ref() {
        reader.line(line).map_err(|why| format!("line {number}: {why}"))?;
    }
    if reader.in_solid {
        let inside = if reader.facet.is_some() { "inside a facet" } else { "without endsolid" };
        return Err(format!("line {}: the file ends {inside}", lines.number() - 1));
    }
    Ok(reader.weld.sink.finish())
}

/// The state between lines of the text form.
struct TextReader {
    weld: Weld,
    in_solid: bool,
    /// The corners so far of the facet being read.
    facet: Option<Vec<[f32; 3]>>,
}

impl TextReader {
    /// Takes in one line.
    fn line(&mut self, line: &[u8]) -> Result<(), String> {
        let mut words = text::words(line);
        let Some(first) = words.next() else {
            return Ok(());
        };
        match (first.to_ascii_lowercase().as_slice(), &mut self.facet) {
            // The rest of these lines is a name or a normal.
            (b"solid", None) if !self.in_solid => self.in_solid = true,
            (b"endsolid", None) if self.in_solid => self.in_solid = false,
            (b"facet", facet @ None) if self.in_solid => *facet = Some(Vec::new()),
            (b"outer" | b"endloop", Some(_)) => {}
            (b"vertex", Some(corners)) if corners.len() < 3 => corners.push(text::point(words)?),
            (b"vertex", Some(_)) => return Err("a facet has 3 corners, this is a fourth".into()),
            (b"endfacet", Some(_)) => return self.end_facet(),
            _ => return Err(format!("{} does not belong here", text::quote(first))),
        }
        Ok(())
    }

    /// Adds the triangle of the facet that ends.
    fn end_facet(&mut self) -> Result<(), String> {
        let corners = self.facet.take().unwrap_or_default();
        let corners = <[_; 3]>::try_from(corners)
            .map_err(|corners| format!("a facet has 3 corners, this one has {}", corners.len()))?;
        self.weld.triangle(corners)
    }
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
            assert_eq!(error(&binary(b"", &broken)), "triangle 1 (byte 134): corner 2 is not finite");
        }
        assert!(read(&binary(b"", &[])).unwrap().triangles.is_empty());
    }

    #[test]
    fn text_faults() {
        let error = |text: &str| read(text.as_bytes()).unwrap_err();
        assert_eq!(error(&TEXT[..60]), "line 5: a vertex needs 3 coordinates, this line has 0");
        assert_eq!(error(&TEXT[..TEXT.len() - 14]), "line 15: the file ends without endsolid");
        assert_eq!(error("solid\nfacet"), "line 2: the file ends inside a facet");
        assert_eq!(error("solid\nfacet\nendfacet"), "line 3: a facet has 3 corners, this one has 0");
        assert_eq!(error("solid\n\nvertex 0 0 0"), "line 3: \"vertex\" does not belong here");
        assert_eq!(error("solid\nfacet\nvertex 0 inf 0"), "line 3: \"inf\" is not a finite f32");
        assert!(error("solid\nfacet\nvertex 0 1e999 0").contains("\"1e999\" is not a finite f32"));
        let four = "solid\nfacet\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0";
        assert_eq!(error(four), "line 6: a facet has 3 corners, this is a fourth");
        assert!(read(b"solid x\nendsolid x").unwrap().triangles.is_empty());
    }

    #[test]
    fn damaged_files_never_panic() {
        mutate::run(&[TEXT.as_bytes(), &binary(b"x", &PAIR), &binary(b"solid", &PAIR[..1])], read);
    }
}
