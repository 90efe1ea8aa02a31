//! Mesh files: OBJ, PLY, STL and glTF become one [`Soup`].
//!
//! The crates tobj, ply-rs-bw, `stl_io` and gltf read them. Each reader here does what its crate does not: it brings
//! the file into a form that the crate does not refuse or lose a part of, calls it under the [`guard`], because hostile
//! files make some of them panic, and checks what comes back: every coordinate finite, every index in range. Errors say
//! where in the file the fault is, as far as that is known.
mod gltf;
mod guard;
mod obj;
mod ply;
mod stl;
mod text;

#[cfg(test)]
mod mutate;
#[cfg(test)]
mod tests;

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use crate::soup::Soup;

/// The greatest number of triangles in one mesh: numbers of primitives have 28 bits.
const MAX_TRIANGLES: usize = (1 << 28) - 1;

/// Reads the mesh file at `path`, by the reader that its extension asks for.
///
/// # Errors
/// One line: which file, where in it, why.
pub fn read(path: &Path) -> Result<Soup, String> {
    load(path).map_err(|why| one_line(&format!("{}: {why}", path.display())))
}

/// [`read`] without the file name in its errors.
fn load(path: &Path) -> Result<Soup, String> {
    if path.is_dir() {
        return Err("is a directory, not a mesh file".into());
    }
    let format = Format::of(path)?;
    let bytes = file_bytes(path, None)?;
    if bytes.is_empty() {
        return Err("the file is empty (0 bytes)".into());
    }
    if let Some(found) = Format::found_in(&bytes).filter(|found| *found != format) {
        let (found, ending) = (found.name(), format.ending());
        return Err(format!("the content is {found}, but the name ends in {ending}"));
    }
    let soup = parse(format, &bytes, path.parent().unwrap_or(Path::new("")))?;
    match soup.triangles.len() {
        0 => Err("no triangles".into()),
        1..=MAX_TRIANGLES => Ok(soup),
        _ => Err(too_many()),
    }
}

/// The error of a mesh with too many triangles.
fn too_many() -> String {
    format!("more than {MAX_TRIANGLES} triangles, the most a mesh may have")
}

/// The triangles of a polygon, as a fan from its first corner.
fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    let (first, rest) = corners.split_first().map_or((0, corners), |(first, rest)| (*first, rest));
    rest.array_windows().map(move |&[b, c]| [first, b, c])
}

/// Reads `bytes` as `format`; `folder` is where a glTF file looks for its buffers.
fn parse(format: Format, bytes: &[u8], folder: &Path) -> Result<Soup, String> {
    match format {
        Format::Obj => obj::read(bytes),
        Format::Ply => ply::read(bytes),
        Format::Stl => stl::read(bytes),
        Format::Gltf => gltf::read(bytes, folder),
        Format::Glb => gltf::read_binary(bytes, folder),
    }
}

/// The formats this module reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Obj,
    Ply,
    Stl,
    Gltf,
    Glb,
}

impl Format {
    /// Every format, in the order in which errors list them.
    const ALL: [Self; 5] = [Self::Obj, Self::Ply, Self::Stl, Self::Gltf, Self::Glb];

    /// The format that the name of the file asks for.
    fn of(path: &Path) -> Result<Self, String> {
        let ending = path.extension().unwrap_or_default().to_string_lossy();
        Self::ALL
            .into_iter()
            .find(|format| format.ending().trim_start_matches('.').eq_ignore_ascii_case(&ending))
            .ok_or_else(|| {
                let known = Self::ALL.map(Self::ending).join(" ");
                if ending.is_empty() {
                    format!("the name has no extension (known: {known})")
                } else {
                    format!("unknown extension .{ending} (known: {known})")
                }
            })
    }

    /// The format that the first bytes plainly show, if they do.
    fn found_in(bytes: &[u8]) -> Option<Self> {
        let start = text::without_mark(bytes).trim_ascii_start();
        if stl::has_exact_length(bytes) {
            Some(Self::Stl)
        } else if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
            Some(Self::Ply)
        } else if bytes.starts_with(b"glTF") {
            Some(Self::Glb)
        } else if start.starts_with(b"{") {
            Some(Self::Gltf)
        } else if stl::is_text(bytes) {
            Some(Self::Stl)
        } else {
            None
        }
    }

    /// The extension, with its dot.
    const fn ending(self) -> &'static str {
        match self {
            Self::Obj => ".obj",
            Self::Ply => ".ply",
            Self::Stl => ".stl",
            Self::Gltf => ".gltf",
            Self::Glb => ".glb",
        }
    }

    /// What people call the format.
    const fn name(self) -> &'static str {
        match self {
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
            Self::Stl => "STL",
            Self::Gltf => "JSON (glTF)",
            Self::Glb => "binary glTF",
        }
    }
}

/// The first `needed` bytes of a file, or all of them.
///
/// Only regular files: a device or a pipe might never end.
fn file_bytes(path: &Path, needed: Option<u64>) -> Result<Vec<u8>, String> {
    let why = |error: io::Error| match error.kind() {
        io::ErrorKind::NotFound => "no such file".to_string(),
        io::ErrorKind::PermissionDenied => "no permission to read it".to_string(),
        _ => format!("cannot be read: {error}"),
    };
    // The kind is asked before opening, because opening a pipe waits for its writer.
    let meta = std::fs::metadata(path).map_err(why)?;
    if !meta.is_file() {
        return Err("is not a regular file".into());
    }
    if let Some(needed) = needed.filter(|needed| *needed > meta.len()) {
        return Err(format!("has {} bytes, {needed} are needed", meta.len()));
    }
    let mut bytes = Vec::new();
    let size = usize::try_from(needed.unwrap_or(meta.len())).map_err(|_| "is too large")?;
    bytes.try_reserve_exact(size).map_err(|_| format!("{size} bytes do not fit in memory"))?;
    let file = File::open(path).map_err(why)?;
    file.take(needed.unwrap_or(u64::MAX)).read_to_end(&mut bytes).map_err(why)?;
    Ok(bytes)
}

/// `message` with its control characters escaped: names and words of a file may hold line breaks.
fn one_line(message: &str) -> String {
    let mut line = String::with_capacity(message.len());
    for c in message.chars() {
        if c.is_control() {
            line.extend(c.escape_default());
        } else {
            line.push(c);
        }
    }
    line
}
