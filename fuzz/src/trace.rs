//! Good blobs, edited word by word, and arbitrary rays.
//!
//! Data: which blob, how to close it up again, two rays, then edits. Whatever the full check still accepts must
//! answer as the list over its own primitives does; whatever the cheap one accepts must answer.
use crate::rays::specs;
use crate::{good, parse, seal};
use arbitrary::{Arbitrary, Result, Unstructured};
use flashray::blob::{Blob, Buffer};

/// Most edits of one run.
const EDITS: usize = 12;

/// One change of one word.
#[derive(Arbitrary, Clone, Copy, Debug)]
struct Edit {
    /// The section, or the header.
    section: u8,
    /// The word in it.
    word: u16,
    /// What is done.
    how: u8,
    /// With what.
    value: u32,
}

/// One run.
pub fn run(data: &[u8]) {
    let _ = attempt(&mut Unstructured::new(data));
}

fn attempt(u: &mut Unstructured<'_>) -> Result<()> {
    let good = good::pick(u.arbitrary()?);
    let close = u.arbitrary::<u8>()?;
    let rays = specs(u, parse::RAYS)?;
    let mut blob = good.bytes.clone();
    let places = places(&blob);
    for _ in 0..EDITS {
        if u.is_empty() {
            break;
        }
        edit(&mut blob, &places, u.arbitrary()?);
    }
    // Stack and steps are put right unless asked not to, so that edits of the tree's shape can be accepted.
    if close & 1 == 0 {
        seal::mend(&mut blob)
    } else {
        seal::seal(&mut blob)
    }
    parse::load(&blob, &rays);
    Ok(())
}

/// First byte and number of words of the header and of each section, before anything is changed.
fn places(blob: &[u8]) -> Vec<(usize, usize)> {
    let entries = Blob::parse(blob).map(|b| b.entries().to_vec()).unwrap_or_default();
    // Of the header what the edits can change without being refused at once: kind, counts, limits, bounds, origin.
    let mut places = vec![(16, 13)];
    places.extend(entries.iter().map(|e| (e.offset as usize, (e.length / 4).max(1) as usize)));
    places.push((seal::HEADER, entries.len() * 3 + 1));
    places
}

fn edit(blob: &mut Buffer, places: &[(usize, usize)], edit: Edit) {
    let (first, words) = places[usize::from(edit.section) % places.len()];
    let at = |word: usize| first + word % words * 4;
    let place = at(usize::from(edit.word));
    let old = seal::word(blob, place);
    let other = at(edit.value as usize);
    let new = match edit.how % 12 {
        0 => edit.value,
        1 => old ^ (1 << (edit.value % 32)),
        2 => old.wrapping_add(1),
        3 => old.wrapping_sub(1),
        // The neighbouring node or slot, in a child's word.
        4 => old.wrapping_add(16),
        5 => old.wrapping_sub(16),
        6 | 7 => seal::word(blob, other),
        8 => {
            let new = seal::word(blob, other);
            seal::put(blob, other, old);
            new
        }
        9 => f32::from(edit.value as i8).to_bits(),
        10 => (f32::from_bits(old) * if edit.value & 1 == 0 { 2.0 } else { 0.5 }).to_bits(),
        _ => old & 0xffff_ff00 | edit.value & 0xff,
    };
    seal::put(blob, place, new);
}
