//! Memory of Linux in huge pages.
use memmap2::{Advice, MmapMut};
use std::ops::Range;

/// Bytes of a huge page: of x86-64, and of 64-bit Arm whose small pages are of 4 KiB. Elsewhere the advice is of no use
/// and does no harm.
const HUGE: usize = 2 << 20;

/// Zeros in pages of their own, asked of the system as huge ones.
#[derive(Debug)]
pub struct Pages {
    map: MmapMut,
    /// From a multiple of [`HUGE`] on: a mapping may start at any small page.
    range: Range<usize>,
}

impl Pages {
    /// So many bytes; `None` where they are less than a huge page, or can not be had.
    pub fn zeroed(len: usize) -> Option<Self> {
        let whole = len.checked_next_multiple_of(HUGE).filter(|_| len >= HUGE)?;
        // What is never touched, as the ends, takes no memory.
        let map = MmapMut::map_anon(whole.checked_add(HUGE)?).ok()?;
        let address = map.as_ptr().addr();
        let start = address.next_multiple_of(HUGE) - address;
        // Before a byte is touched. A system that has none to give leaves them small.
        let _ = map.advise_range(Advice::HugePage, start, whole);
        Some(Self { map, range: start..start + len })
    }

    pub fn bytes(&self) -> &[u8] {
        self.map.get(self.range.clone()).unwrap_or(&[])
    }

    pub fn bytes_mut(&mut self) -> &mut [u8] {
        self.map.get_mut(self.range.clone()).unwrap_or(&mut [])
    }
}
