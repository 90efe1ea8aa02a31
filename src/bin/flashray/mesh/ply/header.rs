//! The header: which elements follow, with which properties.
use super::super::text::{self, quote};

/// How the values after the header are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    Text,
    Little,
    Big,
}

/// The type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    /// The type that a header calls `name`.
    fn named(name: &[u8]) -> Result<Self, String> {
        Ok(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return Err(format!("{} is not a type of PLY", quote(name))),
        })
    }

    /// Its bytes in a binary file.
    pub const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// True for the types without fractions.
    pub const fn is_whole(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

/// A value, or a list of values, in each row of an element.
#[derive(Debug)]
pub struct Property {
    pub name: String,
    /// The type of the value, or of the list's items.
    pub kind: Kind,
    /// The type of the list's length, if it is a list.
    pub list: Option<Kind>,
}

/// A table in the file.
#[derive(Debug)]
pub struct Element {
    pub name: String,
    /// The number of rows that the header claims.
    pub count: u64,
    pub properties: Vec<Property>,
}

impl Element {
    /// The fewest bytes of a row: a number in text is at least one byte, a list may be empty.
    pub fn least_row(&self, is_text: bool) -> u64 {
        let least = |property: &Property| match property.list.unwrap_or(property.kind).size() {
            _ if is_text => 1,
            size => u64::try_from(size).unwrap_or(u64::MAX),
        };
        self.properties.iter().map(least).fold(0, u64::saturating_add)
    }
}

/// What a header says.
#[derive(Debug)]
pub struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Its length in bytes.
    pub length: usize,
    /// Its length in lines.
    pub lines: u64,
}

impl Header {
    /// Reads the header that `data` starts with.
    pub fn parse(data: &[u8]) -> Result<Self, String> {
        let after = data.strip_prefix(b"ply").unwrap_or_default();
        // The first line shows how lines end. This must be known, because a byte of binary data
        // after a header that ends lines with CR alone may look like LF.
        let is_blank = |byte: &&u8| matches!(byte, b' ' | b'\t');
        let blanks = after.iter().take_while(is_blank).count();
        let end_of_line = match after.get(blanks..).unwrap_or_default() {
            [b'\n', ..] | [b'\r', b'\n', ..] => b'\n',
            [b'\r', ..] => b'\r',
            _ => return Err("not a PLY file: its first line is not \"ply\"".into()),
        };
        let mut header = Self { encoding: Encoding::Text, elements: Vec::new(), length: 0, lines: 0 };
        let mut encoding = None;
        for line in data.split_inclusive(|byte| *byte == end_of_line) {
            header.length += line.len();
            header.lines += 1;
            if header.lines == 1 {
                continue;
            }
            let is_end = header.line(line, &mut encoding).map_err(|why| format!("line {}: {why}", header.lines))?;
            if is_end {
                header.encoding = encoding.ok_or("the header has no format line")?;
                return Ok(header);
            }
        }
        Err(format!("line {}: the file ends inside the header (no end_header)", header.lines))
    }

    /// The element with this name.
    pub fn element(&self, name: &str) -> Option<&Element> {
        self.elements.iter().find(|element| element.name == name)
    }

    /// Takes in one line; true if it is the last.
    fn line(&mut self, line: &[u8], encoding: &mut Option<Encoding>) -> Result<bool, String> {
        let words: Vec<&[u8]> = text::words(line).collect();
        match words.as_slice() {
            [] | [b"comment" | b"obj_info", ..] => {}
            [b"end_header"] => return Ok(true),
            [b"format", name, version] => *encoding = Some(encoding_named(name, version)?),
            [b"element", name, count] => self.add_element(name, count)?,
            [b"property", b"list", length, kind, name] => {
                let length = Kind::named(length)?;
                if !length.is_whole() {
                    return Err("the length of a list is not a whole number".into());
                }
                self.add_property(name, Kind::named(kind)?, Some(length))?;
            }
            [b"property", kind, name] => self.add_property(name, Kind::named(kind)?, None)?,
            _ => {
                return Err(format!("{} is not a line of a PLY header", quote(line.trim_ascii())));
            }
        }
        Ok(false)
    }

    /// Adds an element.
    fn add_element(&mut self, name: &[u8], count: &[u8]) -> Result<(), String> {
        let name = String::from_utf8_lossy(name).into_owned();
        if self.element(&name).is_some() {
            return Err(format!("a second element {}", quote(name.as_bytes())));
        }
        let count = text::whole(count, "a number of elements")?;
        let count = u64::try_from(count).map_err(|_| format!("{count} elements are less than none"))?;
        self.elements.push(Element { name, count, properties: Vec::new() });
        Ok(())
    }

    /// Adds a property to the last element.
    fn add_property(&mut self, name: &[u8], kind: Kind, list: Option<Kind>) -> Result<(), String> {
        let element = self.elements.last_mut().ok_or("a property before the first element")?;
        let name = String::from_utf8_lossy(name).into_owned();
        element.properties.push(Property { name, kind, list });
        Ok(())
    }
}

/// The encoding that a format line names.
fn encoding_named(name: &[u8], version: &[u8]) -> Result<Encoding, String> {
    if version != b"1.0" {
        return Err(format!("version {} is not 1.0", quote(version)));
    }
    match name {
        b"ascii" => Ok(Encoding::Text),
        b"binary_little_endian" => Ok(Encoding::Little),
        b"binary_big_endian" => Ok(Encoding::Big),
        _ => Err(format!("{} is not a format of PLY", quote(name))),
    }
}
