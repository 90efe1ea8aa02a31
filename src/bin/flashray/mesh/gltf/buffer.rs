//! Buffers: bytes in the file itself, in its URIs, or in files next to it.
use std::borrow::Cow;
use std::cell::OnceCell;
use std::path::{Component, Path, PathBuf};

use base64::Engine as _;
use base64::alphabet::STANDARD;
use base64::engine::DecodePaddingMode::Indifferent;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use serde_json::Value;

use super::super::file_bytes;
use super::super::text::quote;
use super::json;

/// Some writers leave out the padding at the end.
const BASE64: GeneralPurpose =
    GeneralPurpose::new(&STANDARD, GeneralPurposeConfig::new().with_decode_padding_mode(Indifferent));

/// The buffers of a file, each read when it is first needed.
pub struct Buffers<'a> {
    root: &'a Value,
    chunk: Option<&'a [u8]>,
    folder: &'a Path,
    loaded: Vec<OnceCell<Cow<'a, [u8]>>>,
}

impl<'a> Buffers<'a> {
    /// The buffers of `root`; `chunk` is the binary chunk of a GLB file.
    pub fn new(root: &'a Value, chunk: Option<&'a [u8]>, folder: &'a Path) -> Result<Self, String> {
        let loaded = json::list(root, "buffers")?.iter().map(|_| OnceCell::new()).collect();
        Ok(Self { root, chunk, folder, loaded })
    }

    /// The bytes of a buffer view, and the distance between its elements if it states one.
    pub fn view(&self, index: usize) -> Result<(&[u8], Option<u64>), String> {
        let view = json::item(self.root, "bufferViews", index)?;
        self.slice(view).map_err(|why| format!("bufferView {index}: {why}"))
    }

    /// The bytes of `view`, and its stride.
    fn slice(&self, view: &Value) -> Result<(&[u8], Option<u64>), String> {
        let buffer = json::index(view, "buffer")?.ok_or("buffer is missing")?;
        let bytes = self.get(buffer)?;
        let start = json::number(view, "byteOffset")?.unwrap_or(0);
        let length = json::needed(view, "byteLength")?;
        let end = start.checked_add(length).ok_or("byteOffset and byteLength overflow")?;
        let range = usize::try_from(start).ok().zip(usize::try_from(end).ok());
        let slice = range
            .and_then(|(start, end)| bytes.get(start..end))
            .ok_or_else(|| format!("needs {end} bytes of buffer {buffer}, which has {}", bytes.len()))?;
        Ok((slice, json::number(view, "byteStride")?))
    }

    /// The bytes of a buffer.
    fn get(&self, index: usize) -> Result<&[u8], String> {
        let buffer = json::item(self.root, "buffers", index)?;
        let cell = self.loaded.get(index).ok_or("no such buffer")?;
        if cell.get().is_none() {
            let bytes = self.load(index, buffer).map_err(|why| format!("buffer {index}: {why}"))?;
            // It was empty a moment ago, and nothing else fills it.
            drop(cell.set(bytes));
        }
        cell.get().map(Cow::as_ref).ok_or_else(|| "no such buffer".into())
    }

    /// Reads a buffer.
    fn load(&self, index: usize, buffer: &Value) -> Result<Cow<'a, [u8]>, String> {
        let stated = json::needed(buffer, "byteLength")?;
        let bytes = match (buffer.get("uri"), self.chunk) {
            (None, Some(chunk)) if index == 0 => Cow::Borrowed(chunk),
            (None, _) => return Err("has no uri, and there is no GLB chunk for it".into()),
            (Some(Value::String(uri)), _) => Cow::Owned(self.fetch(uri, stated)?),
            (Some(_), _) => return Err("its uri is not a string".into()),
        };
        let have = bytes.len();
        let length = usize::try_from(stated).ok().filter(|length| *length <= have);
        let length = length.ok_or_else(|| format!("has {have} bytes, its byteLength is {stated}"))?;
        Ok(match bytes {
            Cow::Borrowed(bytes) => Cow::Borrowed(bytes.get(..length).unwrap_or(bytes)),
            Cow::Owned(mut bytes) => {
                bytes.truncate(length);
                Cow::Owned(bytes)
            }
        })
    }

    /// The bytes that `uri` holds or names, at least `length` if it names a file.
    fn fetch(&self, uri: &str, length: u64) -> Result<Vec<u8>, String> {
        if uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:")) {
            let (kind, content) = uri.split_once(',').ok_or("its data URI has no comma")?;
            if !kind.to_ascii_lowercase().ends_with(";base64") {
                return Err("its data URI is not in base64".into());
            }
            return BASE64.decode(content).map_err(|error| format!("its data URI: {error}"));
        }
        let name = quote(uri.as_bytes());
        let path =
            local_path(uri).ok_or_else(|| format!("its uri {name} is not the name of a file in the model's folder"))?;
        file_bytes(&self.folder.join(path), Some(length)).map_err(|why| format!("{name}: {why}"))
    }
}

/// The path that `uri` names, if it stays in the folder: a model must not choose to read any file
/// of the machine.
fn local_path(uri: &str) -> Option<PathBuf> {
    if uri.split('/').next()?.contains(':') {
        return None;
    }
    let path = PathBuf::from(decode_percent(uri)?);
    let is_inside = |part: Component| matches!(part, Component::Normal(_) | Component::CurDir);
    let is_named = path.file_name().is_some();
    (is_named && path.components().all(is_inside)).then_some(path)
}

/// `uri` with its `%20` and the like decoded; none if they are broken.
fn decode_percent(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut parts = uri.split('%');
    bytes.extend(parts.next()?.bytes());
    for part in parts {
        let (digits, rest) = part.split_at_checked(2)?;
        let is_hex = digits.bytes().all(|digit| digit.is_ascii_hexdigit());
        bytes.push(u8::from_str_radix(digits, 16).ok().filter(|_| is_hex)?);
        bytes.extend(rest.bytes());
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_are_decoded_and_kept_in_the_folder() {
        assert_eq!(local_path("a%20b/c.bin"), Some(PathBuf::from("a b/c.bin")));
        assert_eq!(local_path("./%c3%a4.bin"), Some(PathBuf::from("./\u{e4}.bin")));
        for uri in ["", "/etc/passwd", "../a", "a/../../b", "%2e%2e/a", "http://x/a", "c:/a", "a%2", "a%+1"] {
            assert_eq!(local_path(uri), None, "{uri}");
        }
    }
}
