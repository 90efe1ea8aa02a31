//! Lines, words and numbers of the text formats.

/// The lines of a text with their numbers from 1; a line ends with LF, CR LF or CR.
pub struct Lines<'a> {
    /// What follows the lines read so far.
    pub rest: &'a [u8],
    next: u64,
}

impl<'a> Lines<'a> {
    /// The lines of `text`.
    pub const fn new(text: &'a [u8]) -> Self {
        Self { rest: text, next: 1 }
    }

    /// The number of the line that comes next.
    pub const fn number(&self) -> u64 {
        self.next
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (u64, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
        let (line, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        self.rest = rest.strip_prefix(b"\r\n").or_else(|| rest.get(1..)).unwrap_or_default();
        let number = self.next;
        self.next += 1;
        Some((number, line))
    }
}

/// The words of a line, which blanks and tabs separate.
pub fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// A finite number, rounded once to `f32`.
pub fn real(word: &[u8]) -> Result<f32, String> {
    let value: Option<f32> = str::from_utf8(word).ok().and_then(|word| word.parse().ok());
    match value {
        None => Err(format!("{} is not a number", quote(word))),
        Some(value) if !value.is_finite() => Err(format!("{} is not a finite f32", quote(word))),
        Some(value) => Ok(value),
    }
}

/// The three coordinates that `words` starts with.
pub fn point<'a>(words: impl Iterator<Item = &'a [u8]>) -> Result<[f32; 3], String> {
    let mut position = [0.0; 3];
    let mut found = 0;
    for (coordinate, word) in position.iter_mut().zip(words) {
        *coordinate = real(word)?;
        found += 1;
    }
    if found < 3 {
        return Err(format!("a vertex needs 3 coordinates, this line has {found}"));
    }
    Ok(position)
}

/// A whole number; `what` says what it should have been.
pub fn whole(word: &[u8], what: &str) -> Result<i64, String> {
    str::from_utf8(word).ok().and_then(|word| word.parse().ok()).ok_or_else(|| format!("{} is not {what}", quote(word)))
}

/// A word in quotation marks, cut short if it is long.
pub fn quote(word: &[u8]) -> String {
    const LONGEST: usize = 32;
    let cut = word.get(..LONGEST).unwrap_or(word);
    let dots = if cut.len() < word.len() { "..." } else { "" };
    format!("\"{}{dots}\"", String::from_utf8_lossy(cut))
}

/// `text` without the byte order mark that some editors put before it.
pub fn without_mark(text: &[u8]) -> &[u8] {
    text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_end_counts_once() {
        let lines: Vec<_> = Lines::new(b"a\r\nb\rc\n\nd").collect();
        let expected: [(u64, &[u8]); 5] = [(1, b"a"), (2, b"b"), (3, b"c"), (4, b""), (5, b"d")];
        assert_eq!(lines, expected);
        assert_eq!(Lines::new(b"\r\n").count(), 1);
        assert_eq!(Lines::new(b"").count(), 0);
    }

    #[test]
    fn numbers_of_every_spelling() {
        for (word, value) in [("1e-3", 1e-3), ("+.5", 0.5), ("-2.", -2.0), ("7", 7.0), ("1E2", 1e2)] {
            assert_eq!(real(word.as_bytes()), Ok(value));
        }
        for word in ["", "x", "1e", "0x1", "1,5", "nan", "inf", "-infinity", "1e999", "\u{665}"] {
            assert!(real(word.as_bytes()).is_err(), "{word}");
        }
        assert_eq!(real(b"1e999").unwrap_err(), "\"1e999\" is not a finite f32");
    }

    #[test]
    fn long_words_are_cut() {
        assert_eq!(quote(b"abc"), "\"abc\"");
        assert_eq!(quote(&[b'z'; 99]).len(), 32 + 5);
        assert!(quote(b"\xff").contains('\u{fffd}'));
    }
}
