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

/// Writes a file: a reader sees the old one or all of the new one.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    write_all(&[(path, bytes)])
}

/// Writes several files; none of them changes before all are on the disk.
pub fn write_all(files: &[(&Path, &[u8])]) -> Result<(), Failure> {
    let parts: Vec<Part<'_>> = files.iter().map(|(path, bytes)| Part::new(path, bytes)).collect::<Result<_, _>>()?;
    parts.iter().try_for_each(Part::finish)
}

/// A line or more for stdout.
pub fn say(text: &str) -> Result<(), Failure> {
    match writeln!(std::io::stdout(), "{text}") {
        // Whoever read the other end has read enough.
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(failure(Path::new("standard output"), &e)),
        _ => Ok(()),
    }
}

/// A file under a temporary name beside its own, removed unless it gets that.
struct Part<'a> {
    path: &'a Path,
    /// The temporary name and the one to come; none for what can only be written in place.
    names: Option<(PathBuf, PathBuf)>,
}

impl<'a> Part<'a> {
    fn new(path: &'a Path, bytes: &[u8]) -> Result<Self, Failure> {
        let name = path.file_name().ok_or(format!("{}: not the name of a file", path.display()))?;
        let goal = match fs::metadata(path) {
            Ok(meta) if meta.is_dir() => return Err(format!("{}: is a directory", path.display())),
            // A link stays a link.
            Ok(meta) if meta.is_file() => fs::canonicalize(path).map_err(|e| failure(path, &e))?,
            // A device or a pipe: renaming would put a file in its place.
            Ok(_) => return fs::write(path, bytes).map(|()| Self { path, names: None }).map_err(|e| failure(path, &e)),
            Err(_) => path.to_path_buf(),
        };
        let mut hidden = std::ffi::OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}.part", std::process::id()));
        let part = Self { path, names: Some((goal.with_file_name(hidden), goal)) };
        part.store(bytes).map_err(|e| failure(path, &e))?;
        Ok(part)
    }

    fn store(&self, bytes: &[u8]) -> std::io::Result<()> {
        let Some((temporary, _)) = &self.names else { return Ok(()) };
        let mut file = fs::File::create(temporary)?;
        file.write_all(bytes)?;
        file.sync_all()
    }

    fn finish(&self) -> Result<(), Failure> {
        let Some((temporary, goal)) = &self.names else { return Ok(()) };
        fs::rename(temporary, goal).map_err(|e| failure(self.path, &e))
    }
}

impl Drop for Part<'_> {
    fn drop(&mut self) {
        if let Some((temporary, _)) = &self.names {
            // Gone already if it got its name; that it can not be removed is no further news.
            let _ = fs::remove_file(temporary);
        }
    }
}
