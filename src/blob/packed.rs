//! Numbers of few bits, end to end in words.
//!
//! Number `i` of `b` bits each begins at bit `i * b`, counted from the least of the first word, and may go on in the
//! next word. One word of 0 follows the last, so that a read is always of two words and needs no branch.
use super::lists::check_starts;
use super::{BlobError, Rule, Section};
use crate::num::{count, index};

/// Bits that the numbers from 0 to `most` take, at least 1.
#[must_use]
pub const fn width(most: u32) -> u32 {
    if most == 0 { 1 } else { u32::BITS - most.leading_zeros() }
}

/// Words that `len` numbers of `bits` bits take, with the last one of 0; `u32::MAX` if there are too many.
#[must_use]
pub const fn words(len: u32, bits: u32) -> u32 {
    let part = ((len & 31) * bits).div_ceil(32) + 1;
    (len >> 5).saturating_mul(bits).saturating_add(part)
}

/// Packed numbers.
#[derive(Clone, Copy, Debug)]
pub struct Packed<'a> {
    words: &'a [u32],
    bits: u32,
    mask: u32,
    len: u32,
}

impl<'a> Packed<'a> {
    /// `len` numbers from 0 to `most`, at the start of `words`, and the words after them.
    ///
    /// `None` if there are not as many words.
    #[must_use]
    pub fn split(words: &'a [u32], len: u32, most: u32) -> Option<(Self, &'a [u32])> {
        let bits = width(most);
        let (words, rest) = words.split_at_checked(index(self::words(len, bits)))?;
        Some((Self { words, bits, mask: u32::MAX >> (u32::BITS - bits), len }, rest))
    }

    /// The same where these words are all there are.
    #[must_use]
    pub fn whole(words: &'a [u32], len: u32, most: u32) -> Option<Self> {
        Self::split(words, len, most).and_then(|(packed, rest)| rest.is_empty().then_some(packed))
    }

    /// How many numbers there are.
    #[must_use]
    pub const fn len(&self) -> u32 {
        self.len
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Number `i`; `None` if there are not as many.
    #[inline(always)]
    #[must_use]
    pub fn get(&self, i: u32) -> Option<u32> {
        if i >= self.len {
            return None;
        }
        let bit = (i & 31).wrapping_mul(self.bits);
        let at = index((i >> 5).wrapping_mul(self.bits).wrapping_add(bit >> 5));
        let &[low, high] = self.words.get(at..)?.first_chunk()?;
        let shift = bit & 31;
        Some(((low >> shift) | (high << 1 << (31 ^ shift))) & self.mask)
    }

    /// The numbers from `first` up to `last`, as far as there are any.
    pub fn range(self, first: u32, last: u32) -> impl Iterator<Item = u32> + use<'a> {
        (first..last).map_while(move |i| self.get(i))
    }

    /// Where a number stands among `first..last`, which ascend.
    #[inline]
    #[must_use]
    pub fn find(&self, (mut first, mut last): (u32, u32), number: u32) -> Option<u32> {
        while first < last {
            let middle = first + (last - first) / 2;
            let found = self.get(middle)?;
            if found == number {
                return Some(middle);
            }
            (first, last) = if found < number { (middle + 1, last) } else { (first, middle) };
        }
        None
    }

    /// That all bits after the last number are 0: rule 34.
    ///
    /// # Errors
    /// The rule, if it is broken.
    pub fn check_end(&self, section: Section) -> Result<(), BlobError> {
        let bit = (self.len & 31).wrapping_mul(self.bits);
        let at = index((self.len >> 5).wrapping_mul(self.bits).wrapping_add(bit >> 5));
        let mut rest = self.words.get(at..).unwrap_or(&[]).iter();
        let clean = rest.next().is_none_or(|word| word >> (bit & 31) == 0) && rest.all(|&word| word == 0);
        if clean { Ok(()) } else { Err(BlobError::new(Rule::PackedEnd, section).at(count(at))) }
    }
}

/// Lists of slots end to end, as [`super::lists::Lists`] has them, of packed numbers.
#[derive(Clone, Copy, Debug)]
pub struct PackedLists<'a> {
    /// Where each list starts, and where the last one ends.
    pub starts: Packed<'a>,
    /// The slots listed.
    pub slots: Packed<'a>,
}

impl PackedLists<'_> {
    /// Where list `i` starts and ends; `None` if there is no such list.
    #[inline(always)]
    #[must_use]
    pub fn place(&self, i: u32) -> Option<(u32, u32)> {
        Some((self.starts.get(i)?, self.starts.get(i.wrapping_add(1))?))
    }

    /// The slots of list `i`; none if there is no such list.
    pub fn list(&self, i: u32) -> impl Iterator<Item = u32> + use<'_> {
        let (first, last) = self.place(i).unwrap_or((0, 0));
        self.slots.range(first, last)
    }

    /// The full check of the lists alone, O(n): rules 26, 27 and 34.
    ///
    /// # Errors
    /// The first rule that is broken, and where.
    pub fn check(&self, prims: u32, (starts, slots): (Section, Section)) -> Result<(), BlobError> {
        self.starts.check_end(starts)?;
        self.slots.check_end(slots)?;
        check_starts(self.starts.range(0, self.starts.len), self.slots.len, starts)?;
        let mut order = super::lists::Order::new(slots);
        for i in 0..self.starts.len.saturating_sub(1) {
            order.list(self.list(i))?;
        }
        order.end(prims)
    }
}

/// Packs the first `len` of `words` where they stand, each of which is `most` at most. Returns how many words that
/// takes: one more than `len` at most, and there must be as many. None may be above 2^31.
#[cfg(feature = "build")]
pub fn pack(words: &mut [u32], len: u32, most: u32) -> usize {
    let bits = width(most);
    let needed = index(self::words(len, bits));
    // What is written never overtakes what is read, because a number takes a word at most.
    let (mut at, mut word, mut filled) = (0, 0, 0);
    for i in 0..index(len) {
        let number = words.get(i).copied().unwrap_or(0);
        word |= number << filled;
        filled += bits;
        if filled >= 32 {
            filled -= 32;
            if let Some(place) = words.get_mut(at) {
                *place = word;
            }
            at += 1;
            // The bits that did not fit.
            word = if filled == 0 { 0 } else { number >> (bits - filled) };
        }
    }
    if let Some(rest) = words.get_mut(at..needed) {
        rest.fill(0);
        if let Some(place) = rest.first_mut() {
            *place = word;
        }
    }
    needed
}
