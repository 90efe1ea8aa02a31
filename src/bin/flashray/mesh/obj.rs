//! Wavefront OBJ: positions and polygons.
//!
//! Our own reader rather than tobj, because tobj multiplies unchecked indices of texture
//! coordinates and normals (it panics with overflow checks on, and may read wrong data without),
//! does not join continued lines, renumbers vertices, and gives no line numbers in its errors. Only
//! `v` and `f` statements matter here; points, lines, curves and attributes are skipped.
use super::sink::{Fan, Sink};
use super::text::{self, Lines};
use crate::soup::Soup;

/// Reads the text of an OBJ file.
pub fn read(data: &[u8]) -> Result<Soup, String> {
    let mut reader = Reader { sink: Sink::new(), forward: Vec::new() };
    let mut lines = Lines::new(text::without_mark(data), 1);
    let mut joined = Vec::new();
    while let Some((number, line)) = lines.next() {
        let line = join(line, &mut lines, &mut joined);
        reader.statement(number, line).map_err(|why| format!("line {number}: {why}"))?;
    }
    reader.finish()
}

/// `line` with the lines that continue it, assembled in `joined` if there are any.
///
/// Only in the statements this reader looks at, and not in comments: a material or a path that ends
/// in a backslash must not swallow the face after it.
fn join<'a>(line: &'a [u8], lines: &mut Lines, joined: &'a mut Vec<u8>) -> &'a [u8] {
    let (Some(mut part), Some(b"v" | b"f" | b"fo")) = (continued(line), text::words(line).next()) else {
        return line;
    };
    joined.clear();
    loop {
        joined.extend_from_slice(part);
        joined.push(b' ');
        let Some((_, line)) = lines.next() else { break };
        let Some(more) = continued(line) else {
            joined.extend_from_slice(line);
            break;
        };
        part = more;
    }
    joined
}

/// The part before the backslash of a line that the next line continues.
fn continued(line: &[u8]) -> Option<&[u8]> {
    let part = line.trim_ascii_end().strip_suffix(b"\\")?;
    (!part.contains(&b'#')).then_some(part)
}

/// The state between lines.
struct Reader {
    sink: Sink,
    /// Indices of vertices that were not there yet, with their lines: each one larger than all
    /// before it. The first that is still too large at the end is the first fault of the file.
    forward: Vec<(u64, i64)>,
}

impl Reader {
    /// Takes in one statement.
    fn statement(&mut self, number: u64, line: &[u8]) -> Result<(), String> {
        let line = line.split(|byte| *byte == b'#').next().unwrap_or_default();
        let mut words = text::words(line);
        match words.next() {
            // What follows the three coordinates is a weight or a colour.
            Some(b"v") => self.sink.vertex(text::point(words)?).map(drop),
            // `fo` is how old files spell `f`.
            Some(b"f" | b"fo") => {
                let mut fan = Fan::default();
                for word in words {
                    let index = self.index(number, word)?;
                    fan.corner(index, &mut self.sink)?;
                }
                fan.finish()
            }
            _ => Ok(()),
        }
    }

    /// The vertex that a corner such as `7`, `-1`, `7/2` or `7//3` names, counted from 0.
    fn index(&mut self, number: u64, word: &[u8]) -> Result<u32, String> {
        let word = word.split(|byte| *byte == b'/').next().unwrap_or_default();
        let index = text::whole(word, "a vertex index")?;
        let seen = i64::try_from(self.sink.vertices()).unwrap_or(i64::MAX);
        if index == 0 {
            return Err("vertex index 0 is out of range (indices start at 1)".into());
        }
        if index < 0 {
            // Relative to the vertices read so far: -1 is the last of them.
            return seen
                .checked_add(index)
                .and_then(|index| u32::try_from(index).ok())
                .ok_or_else(|| format!("vertex index {index} is out of range ({seen} vertices so far)"));
        }
        if index > seen && self.forward.last().is_none_or(|(_, largest)| index > *largest) {
            self.forward.push((number, index));
        }
        // One that does not fit in 32 bits is in `forward`, and too large at the end.
        Ok(u32::try_from(index - 1).unwrap_or(u32::MAX))
    }

    /// The mesh, if every vertex that a face names has come.
    fn finish(self) -> Result<Soup, String> {
        let vertices = self.sink.vertices();
        let is_missing = |index: i64| usize::try_from(index).map_or(true, |index| index > vertices);
        match self.forward.iter().find(|(_, index)| is_missing(*index)) {
            None => Ok(self.sink.finish()),
            Some((number, index)) => {
                Err(format!("line {number}: vertex index {index} is out of range (the file has {vertices} vertices)"))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::mutate;

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    /// The triangles of a square with the lines `rest` after it.
    fn triangles(rest: &str) -> Vec<[u32; 3]> {
        read(format!("{SQUARE}{rest}").as_bytes()).unwrap().triangles
    }

    /// The error of `text`.
    fn error(text: &str) -> String {
        read(text.as_bytes()).unwrap_err()
    }

    #[test]
    fn polygons_become_fans_in_file_order() {
        let found = triangles("o a\nf 4 3 2\nusemtl x\nf 1 2 3 4\no b\ng q\nf 2 3 4\n");
        assert_eq!(found, [[3, 2, 1], [0, 1, 2], [0, 2, 3], [1, 2, 3]]);
    }

    #[test]
    fn corners_of_every_spelling() {
        let faces = "f 1/1 2/2 3/3\nf 1//9 2//9 3//9\nf 1/2/3 2/2/3 +3/99999999999999999999/1\n";
        assert_eq!(triangles(faces), [[0, 1, 2]; 3]);
        assert_eq!(triangles("f -4 -3 -2\nv 9 9 9\nf -4 -3 -1\n"), [[0, 1, 2], [1, 2, 4]]);
        assert_eq!(triangles("f 1 1 1\nf 5 6 7\nv 1 1 1\nv 1 1 1\nv 2 2 2\n"), [[0, 0, 0], [4, 5, 6]]);
    }

    #[test]
    fn lines_of_every_kind() {
        let text = "\u{feff}# a\\\r\n\tv  1e-3 +.5 -2. 1.0\r\nv 1 2 3 .5 .5 .5 # w\r\nv\t4 5 \\\r\n 6\r\n\
            p 1\r\nl 1 2\r\nmtllib c:\\\r\nf 1 \\  \r\n2 \\\r\n3\r\nvn 0 0 x\r\ns off";
        let soup = read(text.as_bytes()).unwrap();
        assert_eq!(soup.positions, [[1e-3, 0.5, -2.0], [1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        assert_eq!(soup.triangles, [[0, 1, 2]]);
        assert_eq!(read(b"v 0 0 0\rv 0 0 1\rf 1 2 2 1\r").unwrap().triangles.len(), 2);
        assert_eq!(read(b"v 0 0 0\nf 1 1 1 \\").unwrap().triangles.len(), 1);
    }

    #[test]
    fn faults_name_their_line() {
        let range = "line 5: vertex index 40000 is out of range (the file has 4 vertices)";
        assert_eq!(error(&format!("{SQUARE}f 1 2 40000\nf 1 2 50000\n")), range);
        let many = format!("{SQUARE}f 5 5 5\nf 6 6 99\nf 100 1 1\nv 0 0 0\nv 0 0 0\n");
        assert_eq!(error(&many), "line 6: vertex index 99 is out of range (the file has 6 vertices)");
        let huge = error(&format!("{SQUARE}f 1 2 4294967297\n"));
        assert_eq!(huge, "line 5: vertex index 4294967297 is out of range (the file has 4 vertices)");
        assert!(error(&format!("{SQUARE}f 1 2 99999999999999999999")).starts_with("line 5: "));
        assert!(error(&format!("{SQUARE}f 1 2 -9223372036854775808")).starts_with("line 5: "));
        assert!(error("f 0 1 2").ends_with("(indices start at 1)"));
        assert!(error("v 1 1 1\nf -2 -1 -1").ends_with("(1 vertices so far)"));
        assert_eq!(error("\nv 1 2"), "line 2: a vertex needs 3 coordinates, this line has 2");
        assert_eq!(error("v 1 nan 2"), "line 1: \"nan\" is not a finite f32");
        assert_eq!(error("v 1 1e999 2"), "line 1: \"1e999\" is not a finite f32");
        assert_eq!(error("v 1 # 2 3"), "line 1: a vertex needs 3 coordinates, this line has 1");
        assert!(error("v 1 2 3\nf 1 1").ends_with("at least 3 corners, this one has 2"));
        assert!(error("v 1 2 3\nf 1 1 x").ends_with("\"x\" is not a vertex index"));
    }

    #[test]
    fn damaged_files_never_panic() {
        let seeds: [&[u8]; 3] = [
            b"v 0 0 0\nv 1 0 0 1\nv 0 1e-1 0\nf 1 2 3\n",
            b"v 1 2 3\r\nv 4 5 6\r\nv 7 8 \\\r\n9\r\nf -3/1 -2//2 -1/2/3\r\n",
            b"o a\nv 0 0 0\nf 1 2 3 4 5\nv 1 1 1\nv 2 2 2\nv 3 3 3\nv 4 4 4\nl 1 2\n",
        ];
        mutate::run(&seeds, read);
    }
}
