//! Buffers: bytes in the file itself, in its URIs, or in files next to it.
use std::path::{Component, Path, PathBuf};

use base64::Engine as _;
use base64::alphabet::STANDARD;
use base64::engine::DecodePaddingMode::Indifferent;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use gltf::Document;
use gltf::buffer::Source;

use super::super::file_bytes;
use super::super::text::quote;

/// Some writers leave out the padding at the end.
const BASE64: GeneralPurpose =
    GeneralPurpose::new(&STANDARD, GeneralPurposeConfig::new().with_decode_padding_mode(Indifferent));

/// The bytes of all buffers; `chunk` is the binary chunk of a GLB file.
pub fn load(document: &Document, mut chunk: Option<Vec<u8>>, folder: &Path) -> Result<Vec<Vec<u8>>, String> {
    let mut bytes_of = |buffer: &gltf::Buffer| {
        let length = buffer.length();
        let mut bytes = match buffer.source() {
            Source::Uri(uri) => fetch(uri, length, folder)?,
            Source::Bin => chunk.take().ok_or("has no uri, and there is no GLB chunk for it")?,
        };
        if bytes.len() < length {
            return Err(format!("has {} bytes, its byteLength is {length}", bytes.len()));
        }
        bytes.truncate(length);
        Ok(bytes)
    };
    let buffers = document.buffers();
    buffers.map(|buffer| bytes_of(&buffer).map_err(|why| format!("buffer {}: {why}", buffer.index()))).collect()
}

/// The bytes that `uri` holds or names, at least `length` if it names a file.
fn fetch(uri: &str, length: usize, folder: &Path) -> Result<Vec<u8>, String> {
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
    let length = u64::try_from(length).ok();
    file_bytes(&folder.join(path), length).map_err(|why| format!("{name}: {why}"))
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
