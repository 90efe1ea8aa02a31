//! PLY, text and binary of either byte order: the vertices and the faces.
//!
//! Our own reader rather than ply-rs-bw, because its number grammar refuses `.5` and `1.`, its
//! header grammar refuses names with a dot, comments that are not UTF-8 and lines that end in CR
//! alone, and it reads two elements of the same name as one.
mod header;
mod rows;

use super::sink::{Fan, Sink};
use super::text::Lines;
use crate::soup::Soup;
use header::{Element, Encoding, Header, Kind, Property};
use rows::{Binary, Source, Text};

/// Reads the bytes of a PLY file.
pub fn read(data: &[u8]) -> Result<Soup, String> {
    let header = Header::parse(data)?;
    let payload = data.get(header.length..).unwrap_or_default();
    let mut reader = Reader::new(&header)?;
    match header.encoding {
        Encoding::Text => {
            let lines = Lines::new(payload, header.lines + 1);
            reader.payload(&header, &mut Text::new(lines, payload.len()))
        }
        Encoding::Little => reader.payload(&header, &mut Binary::new(data, header.length, false)),
        Encoding::Big => reader.payload(&header, &mut Binary::new(data, header.length, true)),
    }?;
    Ok(reader.sink.finish())
}

/// What is read so far, and where in a row the values are that count.
struct Reader {
    sink: Sink,
    /// The number of vertices that the header states: faces may come before them.
    vertices: u64,
    /// Which properties of a vertex are x, y and z.
    axes: [usize; 3],
    /// Which property of a face is the list of its corners.
    corners: Option<usize>,
}

impl Reader {
    /// Finds the properties that are needed.
    fn new(header: &Header) -> Result<Self, String> {
        let vertex = header.element("vertex").ok_or("the header has no vertex element")?;
        let mut axes = [0; 3];
        for (axis, name) in axes.iter_mut().zip(["x", "y", "z"]) {
            *axis = vertex
                .properties
                .iter()
                .position(|property| property.name == name && property.list.is_none())
                .ok_or_else(|| format!("the vertex element has no number {name}"))?;
        }
        let corners = match header.element("face") {
            Some(face) => Some(corners_of(face)?),
            None if header.element("tristrips").is_some() => {
                return Err("has triangle strips (tristrips) only; save it with faces".into());
            }
            None => None,
        };
        Ok(Self { sink: Sink::new(), vertices: vertex.count, axes, corners })
    }

    /// Reads all elements, also those that do not count: a file that ends early is an error.
    fn payload(&mut self, header: &Header, source: &mut impl Source) -> Result<(), String> {
        for element in header.elements.iter().filter(|element| !element.properties.is_empty()) {
            source.claim(element)?;
            for number in 0..element.count {
                self.row(element, source)
                    .map_err(|why| format!("{} {number} ({}): {why}", element.name, source.place()))?;
            }
        }
        Ok(())
    }

    /// Reads a row.
    fn row(&mut self, element: &Element, source: &mut impl Source) -> Result<(), String> {
        source.row()?;
        match element.name.as_str() {
            "vertex" => self.vertex(element, source),
            "face" => self.face(element, source),
            _ => element.properties.iter().try_for_each(|property| skip(property, source)),
        }
    }

    /// Reads a vertex.
    fn vertex(&mut self, element: &Element, source: &mut impl Source) -> Result<(), String> {
        let mut position = [0.0; 3];
        for (index, property) in element.properties.iter().enumerate() {
            let axis = self.axes.iter().position(|axis| *axis == index);
            match axis.and_then(|axis| position.get_mut(axis)) {
                Some(coordinate) => *coordinate = source.real(property.kind)?,
                None => skip(property, source)?,
            }
        }
        self.sink.vertex(position).map(drop)
    }

    /// Reads a face.
    fn face(&mut self, element: &Element, source: &mut impl Source) -> Result<(), String> {
        for (index, property) in element.properties.iter().enumerate() {
            match property.list {
                Some(length) if self.corners == Some(index) => {
                    let count = source.length(length, property.kind)?;
                    let mut fan = Fan::default();
                    for _ in 0..count {
                        let corner = self.index(source.whole(property.kind)?)?;
                        fan.corner(corner, &mut self.sink)?;
                    }
                    fan.finish()?;
                }
                _ => skip(property, source)?,
            }
        }
        Ok(())
    }

    /// A corner's index, if there is such a vertex.
    fn index(&self, index: i64) -> Result<u32, String> {
        let known = u64::try_from(index).is_ok_and(|index| index < self.vertices);
        u32::try_from(index).ok().filter(|_| known).ok_or_else(|| {
            let vertices = self.vertices;
            format!("vertex index {index} is out of range (the file has {vertices} vertices)")
        })
    }
}

/// Which property of `face` lists its corners.
fn corners_of(face: &Element) -> Result<usize, String> {
    let is_corners = |property: &Property| {
        property.list.is_some() && matches!(property.name.as_str(), "vertex_indices" | "vertex_index")
    };
    let (index, property) = face
        .properties
        .iter()
        .enumerate()
        .find(|(_, property)| is_corners(property))
        .ok_or("the face element has no list vertex_indices or vertex_index")?;
    if !property.kind.is_whole() {
        return Err(format!("the list {} of the face element is not of whole numbers", property.name));
    }
    Ok(index)
}

/// Skips a property.
fn skip(property: &Property, source: &mut impl Source) -> Result<(), String> {
    let count = match property.list {
        Some(length) => source.length(length, property.kind)?,
        None => 1,
    };
    source.skip(count, property.kind)
}

#[cfg(test)]
mod tests;
