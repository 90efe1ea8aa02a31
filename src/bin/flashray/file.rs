//! Files: read whole, written whole or not at all.
use crate::Failure;
use flashray::blob::Buffer;
use flashray::{BlobError, Scene};
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// A sentence for an error of the operating system, with the path in front.
pub fn failure(path: &Path, error: &std::io::Error) -> Failure {
    format!("{}: {error}", path.display())
}

/// The bytes of a file, at an address that suits a blob.
pub fn read(path: &Path) -> Result<Buffer, Failure> {
    if path.is_dir() {
        return Err(format!("{}: is a directory", path.display()));
    }
    let bytes = fs::read(path).map_err(|e| failure(path, &e))?;
    Ok(Buffer::from(&bytes[..]))
}

/// A scene in a file's bytes, fully checked.
pub fn scene<'a>(path: &Path, bytes: &'a [u8]) -> Result<Scene<'a>, Failure> {
    Scene::from_bytes(bytes).map_err(|e: BlobError| format!("{}: {e}", path.display()))
}

/// Writes a file under a temporary name beside it, then renames: a reader sees the old file or all of the new one.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let name = path.file_name().ok_or(format!("{}: not the name of a file", path.display()))?;
    let mut hidden = std::ffi::OsString::from(".");
    hidden.push(name);
    hidden.push(format!(".{}.part", std::process::id()));
    let part: PathBuf = path.with_file_name(hidden);
    let written = fs::File::create(&part)
        .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()))
        .and_then(|()| fs::rename(&part, path));
    written.map_err(|e| {
        // What is left of a failed attempt is of no use; that it can not be removed is no further news.
        let _ = fs::remove_file(&part);
        failure(path, &e)
    })
}
