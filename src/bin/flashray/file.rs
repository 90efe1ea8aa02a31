//! Files: read whole, written whole or not at all.
use crate::Failure;
use flashray::blob::Buffer;
use flashray::{BlobError, Scene};
use std::fs;
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};

/// A sentence for an error of the operating system, with the path in front.
pub fn failure(path: &Path, error: &std::io::Error) -> Failure {
    format!("{}: {error}", path.display())
}

/// The most that is read of what has no length of its own, as a pipe, and so may have no end: no blob is longer.
const MOST: u64 = u32::MAX as u64;

/// The bytes of a file, at an address that suits a blob.
pub fn read(path: &Path) -> Result<Buffer, Failure> {
    // The kind is asked before opening, which may have effects of its own on a device.
    let meta = fs::metadata(path).map_err(|e| failure(path, &e))?;
    if meta.is_dir() {
        return Err(format!("{}: is a directory", path.display()));
    }
    if is_device(&meta) {
        return Err(format!("{}: is a device, which may have no end", path.display()));
    }
    let bytes = if meta.is_file() { fs::read(path) } else { read_stream(path) };
    Ok(Buffer::from(&bytes.map_err(|e| failure(path, &e))?[..]))
}

fn read_stream(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut stream = fs::File::open(path)?.take(MOST);
    stream.read_to_end(&mut bytes)?;
    if stream.limit() > 0 { Ok(bytes) } else { Err(std::io::Error::other(format!("no end within {MOST} bytes"))) }
}

/// Whether this is read character by character: a terminal, or one of those that never end.
fn is_device(meta: &fs::Metadata) -> bool {
    #[cfg(unix)]
    return std::os::unix::fs::FileTypeExt::is_char_device(&meta.file_type());
    #[cfg(not(unix))]
    return false;
}

/// A scene in a file's bytes, fully checked while a spinner turns.
pub fn scene<'a>(path: &Path, bytes: &'a [u8]) -> Result<Scene<'a>, Failure> {
    let spinner = crate::cmd::spinner("checking");
    let scene = checked(path, bytes);
    spinner.finish_and_clear();
    scene
}

/// The same for those who show something else meanwhile.
pub fn checked<'a>(path: &Path, bytes: &'a [u8]) -> Result<Scene<'a>, Failure> {
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

/// Where a path leads that leads to no file yet: to the end of a chain of links, or to itself.
fn target(path: &Path) -> Result<PathBuf, Failure> {
    let mut target = path.to_path_buf();
    // As many as Linux follows.
    for _ in 0..40 {
        match fs::read_link(&target) {
            Ok(next) => target = target.parent().unwrap_or(Path::new("")).join(next),
            Err(_) => return Ok(target),
        }
    }
    Err(format!("{}: too many links that lead to each other", path.display()))
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
            Err(_) => target(path)?,
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
