//! Writes seed corpora for all targets: `cargo run --example seeds [OUT [GOLDEN]]`.
//!
//! They come from the blobs of `flashray_fuzz::good` and from `tests/golden`, and are the same on every run.
use arbitrary::Unstructured;
use flashray::blob::prims::Prims;
use flashray::blob::{Blob, Buffer, KINDS};
use flashray_fuzz::good::{self, Random};
use flashray_fuzz::parse::{RAYS, flags};
use flashray_fuzz::rays::specs;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// Longer blobs only slow the fuzzer down.
const LONGEST: usize = 16 * 1024;
/// Random inputs per target and size.
const RANDOM: usize = 24;

fn main() -> io::Result<()> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut args = env::args_os().skip(1).map(PathBuf::from);
    let out = args.next().unwrap_or_else(|| here.join("corpus"));
    let golden = args.next().unwrap_or_else(|| here.join("../tests/golden"));
    let mut blobs: Vec<_> = good::all().iter().map(|g| (g.name.clone(), g.bytes.clone())).collect();
    blobs.extend(files(&golden)?);
    let mut random = Random(0);
    for (name, bytes) in &blobs {
        for mode in 0..3 {
            let mut seed = vec![mode];
            seed.extend(rays(&mut random));
            match mode {
                2 => seed.extend(sections(bytes).unwrap_or_default()),
                _ => seed.extend_from_slice(bytes),
            }
            save(&out.join("parse"), &format!("{name}-{mode}"), &seed)?;
        }
    }
    for which in 0..good::all().len() {
        for (target, tail) in [("trace", 8), ("damage", 3)] {
            for edits in 0..3 {
                let mut seed = vec![which as u8, edits as u8 & 1];
                seed.extend(rays(&mut random));
                seed.extend(bytes(&mut random, edits * tail));
                save(&out.join(target), &format!("{which}-{edits}"), &seed)?;
            }
        }
    }
    for i in 0..RANDOM {
        let seed = bytes(&mut random, 64 << (i % 5));
        save(&out.join("build_then_agree"), &i.to_string(), &seed)?;
    }
    Ok(())
}

fn save(folder: &Path, name: &str, bytes: &[u8]) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    fs::write(folder.join(name), bytes)
}

/// The blobs of a folder, if there is one.
fn files(folder: &Path) -> io::Result<Vec<(String, Buffer)>> {
    let mut files = Vec::new();
    let Ok(entries) = fs::read_dir(folder) else { return Ok(files) };
    for entry in entries {
        let path = entry?.path();
        if path.extension().is_some_and(|e| e == "fray") {
            let bytes = fs::read(&path)?;
            if bytes.len() <= LONGEST {
                files.push((
                    path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
                    Buffer::from(&bytes[..]),
                ));
            }
        }
    }
    Ok(files)
}

fn bytes(random: &mut Random, n: usize) -> Vec<u8> {
    (0..n).map(|_| random.word() as u8).collect()
}

/// Data that make exactly the rays that `parse`, `trace` and `damage` read.
fn rays(random: &mut Random) -> Vec<u8> {
    let mut data = bytes(random, 256);
    let mut u = Unstructured::new(&data);
    let _ = specs(&mut u, RAYS);
    let rest = u.len();
    data.truncate(256 - rest);
    data
}

/// A blob as the contents of its sections, as `parse` reads them; `None` if a count takes more than a byte.
fn sections(bytes: &[u8]) -> Option<Vec<u8>> {
    let blob = Blob::parse(bytes).ok()?;
    let prims = Prims::parse(&blob).ok()?;
    let kind = blob.header().kind()?;
    let place = KINDS.iter().position(|&(k, _)| k == kind)?;
    let mut seed = vec![0, u8::try_from(place).ok()?];
    let mut flag = |on: bool, bit: u8| seed[0] |= if on { bit } else { 0 };
    flag(!prims.ids.is_empty(), flags::IDS);
    flag(!prims.refs.is_empty(), flags::REFS);
    let counts =
        [prims.triangles.len(), prims.spheres.len(), prims.boxes.len(), prims.cylinders.len(), prims.cones.len()];
    for n in counts {
        seed.push(u8::try_from(n).ok()?);
    }
    // Sections stand in the blob in the order in which `parse` reads them; the structure's own have their lengths with
    // them, even where they are not there.
    let content = |length: u32, offset: u32| bytes.get(offset as usize..)?.get(..length as usize);
    let own = |section: u32| kind.sections().iter().any(|s| s.number() == section);
    for entry in blob.entries().iter().filter(|e| !own(e.section)) {
        seed.extend_from_slice(content(entry.length, entry.offset)?);
    }
    for section in kind.sections() {
        let entry = blob.entries().iter().find(|e| e.section == section.number());
        let (length, offset) = entry.map_or((0, 0), |e| (e.length, e.offset));
        seed.extend(u16::try_from(length / 4).ok()?.to_le_bytes());
        seed.extend_from_slice(content(length, offset)?);
    }
    Some(seed)
}
