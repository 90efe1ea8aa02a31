//! PLY, text and binary of either byte order: the vertices and the faces, read by ply-rs-bw.
//!
//! The crate reads the header and each row; the rows are asked for one by one, so that no count is believed and errors
//! can say where they are. Before that, comments are blanked, because it refuses those that are not UTF-8, and names
//! that come twice are refused, because it keeps the second only and would read all rows after it wrongly.
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType, Version,
};

use super::fan;
use super::guard::{guarded, short};
use super::text::{self, Lines};
use crate::soup::Soup;

/// Reads the bytes of a PLY file.
pub fn read(data: &[u8]) -> Result<Soup, String> {
    let mut lines = Lines::new(data);
    if lines.next().is_none_or(|(_, line)| line.trim_ascii_end() != b"ply") {
        return Err("not a PLY file: its first line is not \"ply\"".into());
    }
    let header = header(&mut lines)?;
    check(&header)?;
    let mut rows = Rows { encoding: header.encoding, lines, size: data.len() };
    guarded(|| {
        let mut soup = Soup::default();
        let vertices = header.elements.get("vertex").map_or(0, |vertex| vertex.count);
        // The rows of an element without properties have no bytes, but may be any number.
        for element in header.elements.values().filter(|element| !element.properties.is_empty()) {
            for number in 0..element.count {
                let row = rows.next(element).and_then(|row| row.take(&element.name, vertices, &mut soup));
                row.map_err(|why| format!("{} {number} ({}): {why}", element.name, rows.place()))?;
            }
        }
        Ok::<_, String>(soup)
    })
}

/// Reads the header, whose first line is read already.
fn header(lines: &mut Lines) -> Result<Header, String> {
    let (mut plain, mut stated) = ("ply\n".to_string(), 0);
    for (_, line) in lines.by_ref() {
        let name = text::words(line).next();
        match name {
            None | Some(b"comment" | b"obj_info") => plain.push_str("comment"),
            _ => plain.push_str(&String::from_utf8_lossy(line)),
        }
        plain.push('\n');
        match name {
            Some(b"element" | b"property") => stated += 1,
            Some(b"end_header") => break,
            _ => {}
        }
    }
    let parser = Parser::<Row>::new();
    let mut header = guarded(|| parser.read_header(&mut Reader::new(plain.as_bytes()))).map_err(|why| {
        let plain = why.split(" Error: ParseError").next().unwrap_or_default();
        plain.replacen("Line ", "line ", 1)
    })?;
    if header.elements.values().map(|element| 1 + element.properties.len()).sum::<usize>() != stated {
        return Err("the header has two elements, or two properties of an element, with the same name".into());
    }
    if header.encoding == Encoding::Ascii {
        // By way of f64 a number would be rounded twice.
        let properties = header.elements.values_mut().flat_map(|element| element.properties.values_mut());
        for property in properties.filter(|property| property.data_type == PropertyType::Scalar(ScalarType::Double)) {
            property.data_type = PropertyType::Scalar(ScalarType::Float);
        }
    }
    Ok(header)
}

/// Refuses a header that does not say where the triangles are.
fn check(header: &Header) -> Result<(), String> {
    let has = |element: &str, name: &str| {
        header.elements.get(element).is_some_and(|element| element.properties.contains_key(name))
    };
    if header.version != (Version { major: 1, minor: 0 }) {
        return Err(format!("version {} is not 1.0", header.version));
    }
    if let Some(axis) = ["x", "y", "z"].iter().find(|axis| !has("vertex", axis)) {
        return Err(format!("the header has no element vertex with the property {axis}"));
    }
    if header.elements.contains_key("face") {
        if !has("face", "vertex_indices") && !has("face", "vertex_index") {
            return Err("the face element has no list vertex_indices or vertex_index".into());
        }
    } else if header.elements.contains_key("tristrips") {
        return Err("has triangle strips (tristrips) only; save it with faces".into());
    }
    Ok(())
}

/// The rows after the header.
struct Rows<'a> {
    encoding: Encoding,
    lines: Lines<'a>,
    /// The length of the file.
    size: usize,
}

impl Rows<'_> {
    /// Reads the next row, which is one of `element`.
    fn next(&mut self, element: &ElementDef) -> Result<Row, String> {
        let parser = Parser::new();
        let row = match self.encoding {
            Encoding::Ascii => {
                let line = self.lines.find(|(_, line)| !line.trim_ascii().is_empty());
                let (_, line) = line.ok_or("the file ends here")?;
                parser.read_ascii_element(str::from_utf8(line).map_err(|_| "not a line of text")?, element)
            }
            Encoding::BinaryBigEndian => parser.read_big_endian_element(&mut self.lines.rest, element),
            Encoding::BinaryLittleEndian => parser.read_little_endian_element(&mut self.lines.rest, element),
        };
        row.map_err(short)
    }

    /// Where the last row was, or ended.
    fn place(&self) -> String {
        match self.encoding {
            Encoding::Ascii => format!("line {}", self.lines.number() - 1),
            _ => format!("byte {}", self.size - self.lines.rest.len()),
        }
    }
}

/// What counts in a row of any element.
struct Row {
    position: [f32; 3],
    corners: Option<Vec<u32>>,
}

impl Row {
    /// Adds the row of `element` to `soup`; the file has this number of `vertices`.
    fn take(self, element: &str, vertices: usize, soup: &mut Soup) -> Result<(), String> {
        match element {
            "vertex" if self.position.iter().all(|value| value.is_finite()) => soup.positions.push(self.position),
            "vertex" => return Err("x, y or z is not a finite f32".into()),
            "face" => {
                let corners = self.corners.ok_or("a corner is not a whole number of 0 or more")?;
                let is_known = |index: u32| usize::try_from(index).is_ok_and(|index| index < vertices);
                if let Some(index) = corners.iter().find(|index| !is_known(**index)) {
                    return Err(format!("vertex index {index} is out of range (the file has {vertices} vertices)"));
                }
                if corners.len() < 3 {
                    return Err(format!("a face needs at least 3 corners, this one has {}", corners.len()));
                }
                soup.triangles.extend(fan(&corners));
            }
            _ => {}
        }
        Ok(())
    }
}

impl PropertyAccess for Row {
    fn new() -> Self {
        Self { position: [f32::NAN; 3], corners: None }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let [x, y, z] = &mut self.position;
        let axis = match name {
            "x" => x,
            "y" => y,
            "z" => z,
            "vertex_indices" | "vertex_index" => {
                self.corners = property.to_u32_list();
                return PropertyAccessResult::Set;
            }
            _ => return PropertyAccessResult::Ignored,
        };
        *axis = property.to_f32_lossy().unwrap_or(f32::NAN);
        PropertyAccessResult::Set
    }
}

#[cfg(test)]
mod tests;
