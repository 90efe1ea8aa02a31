//! What the builders of structures that part space have in common.
use super::Ref;
use crate::blob::Section;
use crate::num::{count, index};

/// A finished structure as words: its sections, and which primitive stands in which slot.
#[derive(Clone, Debug, Default)]
pub struct Parts<'p> {
    /// The caller's number of the primitive in each slot.
    pub order: &'p [u32],
    /// Each section with its words and the words of an entry.
    pub sections: heapless::Vec<(Section, &'p [u32], usize), 6>,
    /// Deepest stack of a walk.
    pub stack: u32,
    /// Most steps of a walk.
    pub steps: u32,
}

impl<'p> Parts<'p> {
    /// No section yet.
    #[must_use]
    pub fn new(order: &'p [u32], stack: u32, steps: u32) -> Self {
        Self { order, stack, steps, ..Self::default() }
    }

    /// Adds a section, in ascending order of number; one of no words is left out.
    pub fn push(&mut self, section: Section, words: &'p [u32], entry: usize) {
        let pushed = self.sections.push((section, words, entry));
        debug_assert!(pushed.is_ok(), "no structure has more sections");
    }
}

/// Turns lists of primitives into lists of slots, and returns the primitive in each slot.
///
/// `starts[c] .. starts[c + 1]` of `listed` is a list. Slots are numbered in the order in which lists name them, and
/// each list then ascends. The references are used up: their memory holds the two tables.
pub fn number_slots<'p>(starts: &[u32], listed: &mut [u32], refs: &'p mut [Ref]) -> &'p [u32] {
    let n = refs.len();
    let words: &mut [u32] = bytemuck::cast_slice_mut(refs);
    let (slot_of, rest) = words.split_at_mut(n);
    let order = rest.get_mut(..n).unwrap_or(&mut []);
    slot_of.fill(u32::MAX);
    let mut next = 0;
    for ends in starts.windows(2) {
        let Some(list) = listed.get_mut(index(ends[0])..index(ends[1])) else { continue };
        for item in list.iter_mut() {
            let Some(slot) = slot_of.get_mut(index(*item)) else { continue };
            if *slot == u32::MAX {
                *slot = next;
                if let Some(place) = order.get_mut(index(next)) {
                    *place = *item;
                }
                next += 1;
            }
            *item = *slot;
        }
        list.sort_unstable();
    }
    debug_assert_eq!(next, count(n), "every primitive has a part in a cell");
    order
}
