//! Not testing a primitive twice: the seed's ray signatures.
//!
//! Where a primitive is listed in several cells, a ray may meet it in each (Arnaldi, Priol and Bouatouch, "A new space
//! subdivision method for ray tracing CSG modelled scenes", The Visual Computer 3, 1987; Amanatides and Woo 1987). A
//! mailbox remembers which were tested. It belongs to the caller and not to the blob, which stays read-only and can be
//! shared; and it only saves work: the best hit is kept wherever it lies, so an answer never depends on what a mailbox
//! remembers.
//!
//! Plain queries take none: a mailbox is asked about every primitive listed, also where most are met once, and in grids
//! that lost on some scenes as much time as it saved on others. `docs/structures.md` has the table, `benches/mailbox.rs`
//! measures it.

/// What remembers the primitives that a ray was tested against.
pub trait Mailbox {
    /// Whether the primitive in this slot was tested against this ray for certain; notes that it is now.
    fn seen(&mut self, slot: u32) -> bool;
    /// Another ray begins.
    fn clear(&mut self);
}

/// No mailbox: primitives are tested as often as they are met.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoMailbox;

impl Mailbox for NoMailbox {
    #[inline(always)]
    fn seen(&mut self, _: u32) -> bool {
        false
    }

    #[inline(always)]
    fn clear(&mut self) {}
}

/// The last 8 slots tested (Havran, "Mailboxing, Yea or Nay?", Ray Tracing News 15(1), 2002, measures small ones).
#[derive(Clone, Copy, Debug)]
pub struct Last8 {
    slots: [u32; 8],
    next: usize,
}

impl Default for Last8 {
    fn default() -> Self {
        Self { slots: [u32::MAX; 8], next: 0 }
    }
}

impl Mailbox for Last8 {
    #[inline(always)]
    fn seen(&mut self, slot: u32) -> bool {
        // All 8 at once, without a branch for each.
        #[allow(clippy::needless_bitwise_bool)]
        let seen = self.slots.iter().fold(false, |seen, &s| seen | (s == slot));
        if !seen {
            self.slots[self.next & 7] = slot;
            self.next = self.next.wrapping_add(1);
        }
        seen
    }

    #[inline(always)]
    fn clear(&mut self) {
        *self = Self::default();
    }
}

/// A word of the caller's for each slot: the number of the last ray that was tested against it.
///
/// With fewer words than slots the last slots are never remembered.
#[derive(Debug)]
pub struct Signatures<'a> {
    words: &'a mut [u32],
    ray: u32,
}

impl<'a> Signatures<'a> {
    /// A mailbox in `words`, one per primitive; clears them.
    #[must_use]
    pub fn new(words: &'a mut [u32]) -> Self {
        words.fill(0);
        Self { words, ray: 1 }
    }
}

impl Mailbox for Signatures<'_> {
    #[inline(always)]
    fn seen(&mut self, slot: u32) -> bool {
        self.words.get_mut(crate::num::index(slot)).is_some_and(|word| core::mem::replace(word, self.ray) == self.ray)
    }

    #[inline(always)]
    fn clear(&mut self) {
        self.ray = self.ray.wrapping_add(1);
        if self.ray == 0 {
            // Numbers repeat after 2^32 rays: forget the old ones first.
            self.words.fill(0);
            self.ray = 1;
        }
    }
}
