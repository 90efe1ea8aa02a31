//! The chunks of a GLB file.

/// Bytes of the file's header, and of each chunk's.
const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// The JSON of a GLB file, and its binary chunk if it has one.
pub fn split(data: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    if !data.starts_with(b"glTF") {
        return Err("not a binary glTF file: it does not start with \"glTF\"".into());
    }
    let truncated = |needed: usize, have: usize| {
        format!("the file ends inside its header: {needed} bytes are needed, it has {have}")
    };
    let (Some(version), Some(length)) = (word(data, 4), word(data, 8)) else {
        return Err(truncated(HEADER, data.len()));
    };
    if version != 2 {
        return Err(format!("byte 4: GLB version {version} is not 2"));
    }
    // Bytes after the stated length do not belong to the model.
    let Some(data) = usize::try_from(length).ok().and_then(|length| data.get(..length)) else {
        let have = data.len();
        return Err(format!("byte 8: the length is {length} bytes, the file has {have}"));
    };
    let (name, json, next) = chunk(data, HEADER)?.ok_or("the file has no JSON chunk")?;
    if name != *b"JSON" {
        return Err(format!("byte {}: the first chunk is not JSON", HEADER + 4));
    }
    let mut at = next;
    while let Some((name, content, next)) = chunk(data, at)? {
        if name == *b"BIN\0" {
            return Ok((json, Some(content)));
        }
        at = next;
    }
    Ok((json, None))
}

/// The little-endian number at byte `at`.
fn word(data: &[u8], at: usize) -> Option<u32> {
    data.get(at..)?.first_chunk().copied().map(u32::from_le_bytes)
}

/// The name and content of a chunk, and where the next one starts.
type Chunk<'a> = ([u8; 4], &'a [u8], usize);

/// The chunk at byte `at`; none at the end of the file.
fn chunk(data: &[u8], at: usize) -> Result<Option<Chunk<'_>>, String> {
    let rest = data.get(at..).unwrap_or_default();
    if rest.is_empty() {
        return Ok(None);
    }
    let (Some(length), Some(name)) = (word(rest, 0), rest.get(4..).and_then(<[u8]>::first_chunk)) else {
        return Err(format!("byte {at}: the file ends inside a chunk's header"));
    };
    let end = usize::try_from(length).ok().and_then(|length| length.checked_add(CHUNK_HEADER));
    let Some(content) = end.and_then(|end| rest.get(CHUNK_HEADER..end)) else {
        let have = rest.len() - CHUNK_HEADER;
        return Err(format!("byte {at}: a chunk of {length} bytes, {have} remain"));
    };
    Ok(Some((*name, content, at + CHUNK_HEADER + content.len())))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file with these chunks.
    fn file(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
        let mut data = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
        for (name, content) in chunks {
            data.extend(u32::try_from(content.len()).unwrap().to_le_bytes());
            data.extend(*name);
            data.extend(*content);
        }
        let length = u32::try_from(data.len()).unwrap();
        data[8..12].copy_from_slice(&length.to_le_bytes());
        data
    }

    #[test]
    fn chunks_are_found() {
        let mut data = file(&[(b"JSON", b"{}  "), (b"OTHR", b"xyz!"), (b"BIN\0", &[1, 2, 3, 4])]);
        data.extend(b"after");
        assert_eq!(split(&data), Ok((b"{}  ".as_slice(), Some([1, 2, 3, 4].as_slice()))));
        assert_eq!(split(&file(&[(b"JSON", b"{}")])), Ok((b"{}".as_slice(), None)));
    }

    #[test]
    fn faults_name_their_byte() {
        let error = |data: &[u8]| split(data).unwrap_err();
        let whole = file(&[(b"JSON", b"{}  "), (b"BIN\0", &[0; 8])]);
        assert!(error(b"{}").starts_with("not a binary glTF file"));
        assert!(error(&whole[..11]).ends_with("12 bytes are needed, it has 11"));
        assert_eq!(error(&whole[..39]), "byte 8: the length is 40 bytes, the file has 39");
        assert_eq!(error(&file(&[])), "the file has no JSON chunk");
        assert_eq!(error(&file(&[(b"BIN\0", b"")])), "byte 16: the first chunk is not JSON");
        let mut version = whole.clone();
        version[4] = 1;
        assert_eq!(error(&version), "byte 4: GLB version 1 is not 2");
        let mut long = whole.clone();
        long[12..16].copy_from_slice(&[0xff; 4]);
        assert_eq!(error(&long), "byte 12: a chunk of 4294967295 bytes, 20 remain");
        let mut short = whole;
        short.truncate(30);
        short[8] = 30;
        assert_eq!(error(&short), "byte 24: the file ends inside a chunk's header");
    }
}
