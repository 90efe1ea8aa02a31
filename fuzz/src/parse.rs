//! Arbitrary bytes as a blob.
//!
//! Data: a mode, two rays, the rest. By mode the rest is a blob as it is; a blob whose magic, version, length and
//! checksum are put right; or the contents of sections, under a header and a table that fit them: flags, the structure
//! by its place among `KINDS`, five counts of primitives, perhaps bounds, the primitives, perhaps references and
//! numbers; then for each section of the structure's own its length in words (2 bytes) and its bytes.
use crate::judge::{Judge, survive, survive_group};
use crate::rays::{Spec, specs};
use crate::seal;
use arbitrary::{Result, Unstructured};
use flashray::blob::prims::REF_BITS;
use flashray::blob::write::{Facts, Layout};
use flashray::blob::{Buffer, KINDS, Section};
use flashray::{Aabb, Kind, Scene};

/// Rays of one run.
pub const RAYS: usize = 2;
/// The primitive sections and their entries' sizes, in the order of a reference's kinds.
pub const PRIMS: [(Section, usize); 5] = [
    (Section::Triangles, 36),
    (Section::Spheres, 16),
    (Section::Boxes, 24),
    (Section::Cylinders, 32),
    (Section::Cones, 36),
];

/// Bits of the flags before the sections.
pub mod flags {
    /// There is a section of the caller's numbers.
    pub const IDS: u8 = 2;
    /// References come from the data; otherwise the kinds follow each other.
    pub const REFS: u8 = 4;
    /// Bounds come from the data; otherwise they are those of the primitives.
    pub const BOUNDS: u8 = 8;
    /// Stack and steps are left wrong.
    pub const LIMITS: u8 = 16;
}

/// One run.
pub fn run(data: &[u8]) {
    let _ = attempt(&mut Unstructured::new(data));
}

fn attempt(u: &mut Unstructured<'_>) -> Result<()> {
    let mode = u.arbitrary::<u8>()? % 3;
    let rays = specs(u, RAYS)?;
    let blob = match mode {
        2 => sections(u)?,
        _ => {
            let mut blob = Buffer::from(upto(u, usize::MAX));
            if mode == 1 {
                seal::seal(&mut blob);
            }
            blob
        }
    };
    load(&blob, &rays);
    Ok(())
}

/// So many bytes, or as many as there are.
fn upto<'a>(u: &mut Unstructured<'a>, n: usize) -> &'a [u8] {
    u.bytes(n.min(u.len())).unwrap_or(&[])
}

/// Both ways to load bytes, and the promises of each.
pub fn load(blob: &[u8], rays: &[Spec]) {
    let checked = Scene::from_bytes(blob);
    if let Ok(scene) = checked {
        let judge = Judge::new(scene, blob);
        rays.iter().for_each(|spec| judge.judge(&spec.ray(&scene)));
        rays.iter().for_each(|spec| judge.judge_group(&spec.ray(&scene)));
    }
    match Scene::trust(blob) {
        Ok(scene) => rays.iter().map(|spec| spec.ray(&scene)).for_each(|ray| {
            survive(&scene, &ray);
            survive_group(&scene, &ray);
        }),
        Err(error) => assert!(checked.is_err(), "accepted by the full check, refused by the cheap one: {error}"),
    }
}

/// Contents of sections, under a header and a table that fit them.
fn sections(u: &mut Unstructured<'_>) -> Result<Buffer> {
    let flags = u.arbitrary::<u8>()?;
    let (kind, _) = KINDS[usize::from(u.arbitrary::<u8>()?) % KINDS.len()];
    let counts: [u8; 5] = u.arbitrary()?;
    let bounds = if flags & flags::BOUNDS == 0 { [0; 6] } else { u.arbitrary()? };
    let mut parts: Vec<(Section, Vec<u8>)> = Vec::new();
    let (mut prims, mut refs) = (0, Vec::new());
    for (kind, (&(section, size), &n)) in (0u32..).zip(PRIMS.iter().zip(&counts)) {
        let bytes = upto(u, usize::from(n) * size);
        let n = (bytes.len() / size) as u32;
        prims += n;
        refs.extend((0..n).flat_map(|at| (kind << REF_BITS | at).to_le_bytes()));
        parts.push((section, bytes[..n as usize * size].to_vec()));
    }
    if parts[0].1.len() == prims as usize * 36 {
        refs.clear();
    } else if flags & flags::REFS != 0 {
        refs = filled(u, prims);
    }
    parts.push((Section::Refs, refs));
    parts.push((Section::Ids, if flags & flags::IDS == 0 { Vec::new() } else { filled(u, prims) }));
    for &section in kind.sections() {
        let words = usize::from(u.arbitrary::<u16>()?);
        let bytes = upto(u, words * 4);
        parts.push((section, bytes[..bytes.len() / 4 * 4].to_vec()));
    }
    let [a, b, c, d, e, f] = bounds.map(f32::from_bits);
    Ok(assemble(kind, flags, prims, Aabb { min: [a, b, c], max: [d, e, f] }, &parts))
}

/// A word for each primitive, zeros where the data end.
fn filled(u: &mut Unstructured<'_>, prims: u32) -> Vec<u8> {
    let n = prims as usize * 4;
    let mut bytes = upto(u, n).to_vec();
    bytes.resize(n, 0);
    bytes
}

fn assemble(kind: Kind, flags: u8, prims: u32, bounds: Aabb, parts: &[(Section, Vec<u8>)]) -> Buffer {
    let table: Vec<_> = parts.iter().map(|(section, bytes)| (*section, bytes.len() as u32, 1)).collect();
    let layout = Layout::new(&table).expect("a small blob");
    let mut out = Buffer::zeroed(layout.len());
    let facts = Facts { kind, prims, stack: 0, steps: prims, bounds, local: [0.0; 3], longest: 0.0 };
    let mut writer = layout.start(&mut out, &facts).expect("a buffer of the layout's length");
    for (section, bytes) in parts {
        writer.section(*section, bytes.iter().copied());
    }
    let _ = writer.finish();
    if flags & flags::BOUNDS == 0 {
        seal::tighten(&mut out);
    }
    if flags & flags::LIMITS == 0 {
        seal::mend(&mut out);
    }
    seal::seal(&mut out);
    out
}
