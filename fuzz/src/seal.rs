//! Puts right what a header says about its bytes, so that a mutation reaches what the checksum would hide.
use flashray::Scene;
use flashray::blob::prims::Prims;
use flashray::blob::{Blob, Rule, crc32};

/// Offsets in the header, as `docs/format.md` has them.
pub const LENGTH: usize = 8;
pub const CHECKSUM: usize = 12;
pub const STACK: usize = 24;
pub const STEPS: usize = 28;
pub const BOUNDS: usize = 32;
/// Bytes of the header.
pub const HEADER: usize = 80;

/// Writes a word, if it is within the bytes.
pub fn put(bytes: &mut [u8], at: usize, word: u32) {
    if let Some(place) = bytes.get_mut(at..).and_then(|b| b.get_mut(..4)) {
        place.copy_from_slice(&word.to_le_bytes());
    }
}

/// Reads a word; 0 beyond the bytes.
pub fn word(bytes: &[u8], at: usize) -> u32 {
    bytes.get(at..).and_then(|b| b.first_chunk()).map_or(0, |b| u32::from_le_bytes(*b))
}

/// What the checksum of the bytes should be.
pub fn sum(bytes: &[u8]) -> u32 {
    crc32(bytes.get(CHECKSUM + 4..).unwrap_or(&[]))
}

/// Magic, version, length and checksum.
pub fn seal(bytes: &mut [u8]) {
    let length = bytes.len() as u32;
    put(bytes, 0, flashray::blob::MAGIC);
    put(bytes, 4, flashray::blob::VERSION);
    put(bytes, LENGTH, length);
    let sum = sum(bytes);
    put(bytes, CHECKSUM, sum);
}

/// The true steps too, and the true stack where the structure is sound enough to have one: whatever the structure, the
/// refusal itself says what is true.
pub fn mend(bytes: &mut [u8]) {
    seal(bytes);
    for (rule, place) in [(Rule::StepsTrue, STEPS), (Rule::StackTrue, STACK)] {
        let Err(error) = Scene::from_bytes(bytes) else { return };
        if error.rule == rule {
            put(bytes, place, error.needed);
            seal(bytes);
        }
    }
}

/// The bounds of the primitives, where these have any.
pub fn tighten(bytes: &mut [u8]) {
    let Some(prims) = Blob::parse(bytes).ok().and_then(|blob| Prims::parse(&blob).ok()) else { return };
    let bounds = prims.bounds(0, prims.len);
    if bounds.is_valid() {
        for (k, x) in bounds.min.into_iter().chain(bounds.max).enumerate() {
            put(bytes, BOUNDS + 4 * k, x.to_bits());
        }
    }
}
