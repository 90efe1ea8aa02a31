//! The values after the header, as words of text or as bytes.
use super::super::sink::narrow;
use super::super::text::{self, Lines};
use super::{Element, Kind};

/// Where the values come from.
pub trait Source {
    /// Checks that the rows of `element` can be there at all, before any of them is read.
    fn claim(&self, element: &Element) -> Result<(), String>;
    /// Goes to the next row.
    fn row(&mut self) -> Result<(), String>;
    /// The next number as a finite coordinate.
    fn real(&mut self, kind: Kind) -> Result<f32, String>;
    /// The next number as a whole one.
    fn whole(&mut self, kind: Kind) -> Result<i64, String>;
    /// Skips `count` numbers.
    fn skip(&mut self, count: u64, kind: Kind) -> Result<(), String>;
    /// The length of a list of `items`, if that many can follow.
    fn length(&mut self, length: Kind, items: Kind) -> Result<u64, String>;
    /// Where the reader is.
    fn place(&self) -> String;
}

/// A length read from the file, which must not be negative.
fn not_negative(length: i64) -> Result<u64, String> {
    u64::try_from(length).map_err(|_| format!("a list of {length} items"))
}

/// The error of an element whose rows cannot be there.
fn check_claim(element: &Element, is_text: bool, remain: usize) -> Result<(), String> {
    let needed = u128::from(element.least_row(is_text)) * u128::from(element.count);
    if u128::try_from(remain).is_ok_and(|remain| remain < needed) {
        let Element { name, count, .. } = element;
        return Err(format!("element {name}: {count} rows need at least {needed} bytes, {remain} remain"));
    }
    Ok(())
}

/// Values as text: one row a line.
pub struct Text<'a> {
    lines: Lines<'a>,
    length: usize,
    number: u64,
    rest: &'a [u8],
}

impl<'a> Text<'a> {
    /// The rows in `lines`, which have `length` bytes together.
    pub const fn new(lines: Lines<'a>, length: usize) -> Self {
        Self { lines, length, number: 0, rest: &[] }
    }

    /// The next word of the row.
    fn word(&mut self) -> Result<&'a [u8], String> {
        let line = self.rest.trim_ascii_start();
        let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
        let (word, rest) = line.split_at(end);
        self.rest = rest;
        if word.is_empty() {
            return Err("the line has too few numbers".into());
        }
        Ok(word)
    }
}

impl Source for Text<'_> {
    fn claim(&self, element: &Element) -> Result<(), String> {
        check_claim(element, true, self.length)
    }

    fn row(&mut self) -> Result<(), String> {
        for (number, line) in self.lines.by_ref() {
            self.number = number;
            self.rest = line.trim_ascii();
            if !self.rest.is_empty() {
                return Ok(());
            }
        }
        self.number = self.lines.number();
        Err("the file ends here".into())
    }

    /// Straight from the text, so that it is rounded once also if the header says `double`.
    fn real(&mut self, _: Kind) -> Result<f32, String> {
        text::real(self.word()?)
    }

    fn whole(&mut self, _: Kind) -> Result<i64, String> {
        text::whole(self.word()?, "a whole number")
    }

    fn skip(&mut self, count: u64, _: Kind) -> Result<(), String> {
        (0..count).try_for_each(|_| self.word().map(drop))
    }

    fn length(&mut self, length: Kind, _: Kind) -> Result<u64, String> {
        // A list that is too long ends with the line.
        self.whole(length).and_then(not_negative)
    }

    fn place(&self) -> String {
        format!("line {}", self.number)
    }
}

/// Values as bytes.
pub struct Binary<'a> {
    data: &'a [u8],
    at: usize,
    is_big: bool,
}

impl<'a> Binary<'a> {
    /// The values from the byte `at` on.
    pub const fn new(data: &'a [u8], at: usize, is_big: bool) -> Self {
        Self { data, at, is_big }
    }

    /// The bytes not read yet.
    fn remain(&self) -> usize {
        self.data.len().saturating_sub(self.at)
    }

    /// The next `N` bytes as in a little-endian file.
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let rest = self.data.get(self.at..).unwrap_or_default();
        let mut bytes = *rest
            .first_chunk::<N>()
            .ok_or_else(|| format!("the file ends: {N} bytes are needed, {} remain", self.remain()))?;
        self.at += N;
        if self.is_big {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// The next number: `f64` holds those of every type.
    fn number(&mut self, kind: Kind) -> Result<f64, String> {
        Ok(match kind {
            Kind::I8 => i8::from_le_bytes(self.bytes()?).into(),
            Kind::U8 => u8::from_le_bytes(self.bytes()?).into(),
            Kind::I16 => i16::from_le_bytes(self.bytes()?).into(),
            Kind::U16 => u16::from_le_bytes(self.bytes()?).into(),
            Kind::I32 => i32::from_le_bytes(self.bytes()?).into(),
            Kind::U32 => u32::from_le_bytes(self.bytes()?).into(),
            Kind::F32 => f32::from_le_bytes(self.bytes()?).into(),
            Kind::F64 => f64::from_le_bytes(self.bytes()?),
        })
    }
}

impl Source for Binary<'_> {
    fn claim(&self, element: &Element) -> Result<(), String> {
        check_claim(element, false, self.remain())
    }

    fn row(&mut self) -> Result<(), String> {
        Ok(())
    }

    fn real(&mut self, kind: Kind) -> Result<f32, String> {
        let value = self.number(kind)?;
        narrow(value).ok_or_else(|| format!("{value:e} is not a finite f32"))
    }

    fn whole(&mut self, kind: Kind) -> Result<i64, String> {
        Ok(match kind {
            Kind::I8 => i8::from_le_bytes(self.bytes()?).into(),
            Kind::U8 => u8::from_le_bytes(self.bytes()?).into(),
            Kind::I16 => i16::from_le_bytes(self.bytes()?).into(),
            Kind::U16 => u16::from_le_bytes(self.bytes()?).into(),
            Kind::I32 => i32::from_le_bytes(self.bytes()?).into(),
            Kind::U32 => u32::from_le_bytes(self.bytes()?).into(),
            Kind::F32 | Kind::F64 => return Err("a whole number is needed".into()),
        })
    }

    fn skip(&mut self, count: u64, kind: Kind) -> Result<(), String> {
        let remain = self.remain();
        let bytes = usize::try_from(count).ok().and_then(|count| count.checked_mul(kind.size()));
        let Some(bytes) = bytes.filter(|bytes| *bytes <= remain) else {
            let size = kind.size();
            return Err(format!("{count} numbers of {size} bytes are needed, {remain} bytes remain"));
        };
        self.at += bytes;
        Ok(())
    }

    fn length(&mut self, length: Kind, items: Kind) -> Result<u64, String> {
        let count = self.whole(length).and_then(not_negative)?;
        let (size, remain) = (items.size(), self.remain());
        let fits = usize::try_from(count).is_ok_and(|count| count <= remain / size);
        if !fits {
            return Err(format!("a list of {count} items of {size} bytes, {remain} bytes remain"));
        }
        Ok(count)
    }

    fn place(&self) -> String {
        format!("byte {}", self.at)
    }
}
