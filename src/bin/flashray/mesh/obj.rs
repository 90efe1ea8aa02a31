//! Wavefront OBJ: positions and polygons, read by tobj.
//!
//! tobj gets the `v` and `f` statements only, in plain form: continued lines joined, comments cut, the `/vt/vn` parts
//! of corners and all after the three coordinates of a vertex left out. tobj refuses the first two, panics on some of
//! the third, and divides by a weight. Without objects and materials it makes one mesh, in the order of the file, and
//! faces may use vertices that come later. As its errors have no line numbers, numbers are checked here on the way.
use super::guard::guarded;
use super::text::{self, Lines};
use crate::soup::Soup;

/// Reads the text of an OBJ file.
pub fn read(data: &[u8]) -> Result<Soup, String> {
    let plain = plain(text::without_mark(data))?;
    let options = tobj::LoadOptions { triangulate: true, ..tobj::LoadOptions::default() };
    let no_materials = |_: &std::path::Path| Ok(Default::default());
    let (models, _) = guarded(|| tobj::load_obj_buf(&mut plain.as_slice(), &options, no_materials))?;
    let mut soup = Soup::default();
    for tobj::Model { mesh, .. } in models {
        let base = u32::try_from(soup.positions.len()).map_err(|_| "too many vertices")?;
        let (corners, _) = mesh.indices.as_chunks();
        soup.triangles.extend(corners.iter().map(|corners| corners.map(|index| base + index)));
        soup.positions.extend(mesh.positions.as_chunks().0);
    }
    Ok(soup)
}

/// The vertices and faces of `data` in plain form.
fn plain(data: &[u8]) -> Result<Vec<u8>, String> {
    let is_vertex = |(_, words): &(u64, Vec<&[u8]>)| words.first() == Some(&b"v".as_slice());
    let count = Statements(Lines::new(data)).filter(is_vertex).count();
    let vertices = u32::try_from(count).map_err(|_| format!("{count} vertices are too many"))?;
    let (mut plain, mut seen) = (Vec::new(), 0);
    for (number, words) in Statements(Lines::new(data)) {
        let (name, kept) = match words.as_slice() {
            [b"v", values @ ..] => {
                seen += 1;
                (b'v', text::point(values.iter().copied()).map(|_| values.iter().copied().take(3).collect()))
            }
            // `fo` is how old files spell `f`.
            [b"f" | b"fo", corners @ ..] => (b'f', face(corners, seen, vertices.into())),
            _ => continue,
        };
        let kept: Vec<&[u8]> = kept.map_err(|why| format!("line {number}: {why}"))?;
        plain.push(name);
        plain.extend(kept.into_iter().flat_map(|word| b" ".iter().chain(word)));
        plain.push(b'\n');
    }
    Ok(plain)
}

/// The vertex indices in `corners`, which are spelled like `7`, `-1`, `7/2` or `7//3`.
fn face<'a>(corners: &[&'a [u8]], seen: i64, vertices: i64) -> Result<Vec<&'a [u8]>, String> {
    let index = |corner: &&'a [u8]| {
        let word = corner.split(|byte| *byte == b'/').next().unwrap_or_default();
        match text::whole(word, "a vertex index")? {
            0 => Err("vertex index 0 is out of range (indices start at 1)".into()),
            index if index > vertices => {
                Err(format!("vertex index {index} is out of range (the file has {vertices} vertices)"))
            }
            // Relative to the vertices read so far: -1 is the last of them.
            index if index < -seen => Err(format!("vertex index {index} is out of range ({seen} vertices so far)")),
            _ => Ok(word),
        }
    };
    let corners: Vec<&[u8]> = corners.iter().map(index).collect::<Result<_, String>>()?;
    if corners.len() < 3 {
        return Err(format!("a face needs at least 3 corners, this one has {}", corners.len()));
    }
    Ok(corners)
}

/// The words of each statement, with the number of its first line.
struct Statements<'a>(Lines<'a>);

impl<'a> Iterator for Statements<'a> {
    type Item = (u64, Vec<&'a [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        let (number, mut line) = self.0.next()?;
        let mut words = Vec::new();
        loop {
            // A comment that ends in a backslash goes on no more than the name of a material does.
            let part = line.trim_ascii_end().strip_suffix(b"\\").filter(|part| !part.contains(&b'#'));
            let text = part.unwrap_or(line).split(|byte| *byte == b'#').next().unwrap_or_default();
            words.extend(text::words(text));
            if part.is_none() || !matches!(words.first(), Some(&(b"v" | b"f" | b"fo"))) {
                break;
            }
            let Some((_, next)) = self.0.next() else { break };
            line = next;
        }
        Some((number, words))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::mutate;

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    /// The corners of all triangles of `text`, as positions: tobj numbers the vertices by their first use.
    fn corners(text: &str) -> Vec<[[f32; 3]; 3]> {
        let Soup { positions, triangles, .. } = read(text.as_bytes()).unwrap();
        triangles.iter().map(|corners| corners.map(|index| positions[index as usize])).collect()
    }

    /// The triangles of a square with the lines `rest` after it, as numbers of vertices in the file: later vertices
    /// must have theirs as z.
    fn triangles(rest: &str) -> Vec<[u32; 3]> {
        let number = |position: [f32; 3]| match position {
            [0.0, 0.0, 0.0] => 0,
            [1.0, 0.0, 0.0] => 1,
            [1.0, 1.0, 0.0] => 2,
            [0.0, 1.0, 0.0] => 3,
            [_, _, z] => z as u32,
        };
        let found = corners(&format!("{SQUARE}{rest}"));
        found.iter().map(|corners| corners.map(number)).collect()
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
        assert_eq!(triangles("f -4 -3 -2\nv 9 9 4\nf -4 -3 -1\n"), [[0, 1, 2], [1, 2, 4]]);
        assert_eq!(triangles("f 1 1 1\nf 5 6 7\nv 1 1 4\nv 1 1 5\nv 2 2 6\n"), [[0, 0, 0], [4, 5, 6]]);
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
