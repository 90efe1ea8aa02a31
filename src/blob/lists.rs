//! Lists of slots, one per cell, as the structures that part space have them.
//!
//! `starts[c] .. starts[c + 1]` is the list of cell `c`. Slots are numbered in the order in which they are first
//! listed, so one pass with a counter proves that each is, and each list ascends, so that a slot is found in it by
//! halving.
use super::prims::Prims;
use super::{Blob, BlobError, Rule, Section};
use crate::geom::Aabb;
use crate::num::{count, index};

/// Lists by cell.
#[derive(Clone, Copy, Debug)]
pub struct Lists<'a> {
    /// Where each list starts, and where the last one ends.
    pub starts: &'a [u32],
    /// The slots listed.
    pub slots: &'a [u32],
}

impl<'a> Lists<'a> {
    /// The two sections, O(1): rule 10.
    ///
    /// # Errors
    /// The rule, if it is broken.
    pub fn parse(blob: &Blob<'a>) -> Result<Self, BlobError> {
        Ok(Self { starts: blob.section(Section::CellStarts)?, slots: blob.section(Section::CellLists)? })
    }

    /// Number of lists.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether there is no list.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The list of a cell; `None` if there is no such cell, or its list is not in the section.
    #[inline(always)]
    #[must_use]
    pub fn get(&self, cell: u32) -> Option<&'a [u32]> {
        let at = index(cell);
        let first = *self.starts.get(at)?;
        let last = *self.starts.get(at.wrapping_add(1))?;
        self.slots.get(index(first)..index(last))
    }

    /// The full check of the lists alone, O(n): rules 26 and 27.
    ///
    /// # Errors
    /// The first rule that is broken, and where.
    pub fn check(&self, prims: &Prims<'_>) -> Result<(), BlobError> {
        check_starts(self.starts.iter().copied(), count(self.slots.len()), Section::CellStarts)?;
        let mut order = Order::new(Section::CellLists);
        for cell in 0..count(self.len()) {
            order.list(self.get(cell).unwrap_or(&[]).iter().copied())?;
        }
        order.end(prims.len)
    }

    /// Whether the list of `cell`, whose box is `bounds`, has the primitive in `slot` if it needs it: rule 28.
    ///
    /// # Errors
    /// The rule, if it is broken.
    pub fn check_listed(&self, cell: u32, bounds: &Aabb, slot: u32, prims: &Prims<'_>) -> Result<(), BlobError> {
        let found = self.get(cell).unwrap_or(&[]).binary_search(&slot).is_ok();
        complete(found, bounds, slot, prims, || BlobError::new(Rule::ListComplete, Section::CellStarts).at(cell))
    }
}

/// Rule 28: that a cell, whose box is `bounds`, has the primitive in `slot` if it needs it.
///
/// # Errors
/// `broken`, if it is.
pub fn complete(
    found: bool,
    bounds: &Aabb,
    slot: u32,
    prims: &Prims<'_>,
    broken: impl FnOnce() -> BlobError,
) -> Result<(), BlobError> {
    if found || !prims.get(slot).is_some_and(|p| p.overlaps(bounds)) { Ok(()) } else { Err(broken().needed(slot)) }
}

/// Rule 26: that starts ascend from 0 to the number of slots listed.
///
/// # Errors
/// The rule, if it is broken.
pub fn check_starts(starts: impl Iterator<Item = u32>, slots: u32, section: Section) -> Result<(), BlobError> {
    let broken = |at, found, needed| Err(BlobError::new(Rule::ListPlace, section).at(at).found(found).needed(needed));
    let (mut last, mut n) = (0, 0);
    for start in starts {
        if start < last || (n == 0 && start != 0) {
            return broken(n, start, last);
        }
        last = start;
        n = n.saturating_add(1);
    }
    if last == slots { Ok(()) } else { broken(n, last, slots) }
}

/// Rule 27 for lists in order.
#[derive(Clone, Copy, Debug)]
pub struct Order {
    next: u32,
    listed: u32,
    section: Section,
}

impl Order {
    /// Before the first list; the slots are in `section`.
    #[must_use]
    pub const fn new(section: Section) -> Self {
        Self { next: 0, listed: 0, section }
    }

    /// The next list.
    ///
    /// # Errors
    /// The rule, if it is broken.
    pub fn list(&mut self, slots: impl IntoIterator<Item = u32>) -> Result<(), BlobError> {
        let mut least = 0;
        for slot in slots {
            if slot < least || slot > self.next {
                let error = BlobError::new(Rule::ListOrder, self.section).at(self.listed);
                return Err(error.found(slot).needed(if slot < least { least } else { self.next }));
            }
            if slot == self.next {
                self.next = self.next.saturating_add(1);
            }
            least = slot.saturating_add(1);
            self.listed = self.listed.saturating_add(1);
        }
        Ok(())
    }

    /// After the last list: all `prims` slots were listed.
    ///
    /// # Errors
    /// The rule, if it is broken.
    pub fn end(&self, prims: u32) -> Result<(), BlobError> {
        if self.next == prims {
            return Ok(());
        }
        Err(BlobError::new(Rule::ListOrder, self.section).at(self.listed).found(self.next).needed(prims))
    }
}
