//! Owned bytes at an address that suits a blob.
#[cfg(all(feature = "std", target_os = "linux"))]
use super::pages::Pages;
use alloc::vec::Vec;
use bytemuck::allocation::{try_zeroed_vec, zeroed_vec};
use bytemuck::{Pod, Zeroable};
use core::ops::{Deref, DerefMut};

#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Line([u8; 64]);

/// Bytes that start at a multiple of 64, the alignment at which a blob is fastest.
///
/// They are on the heap. On Linux, with the feature `std`, those of 2 MiB or more are in a mapping of their own instead,
/// for which huge pages are asked, and take up to 2 MiB more: a ray goes from one end of a blob to the other, and with
/// small pages the processor does not keep the addresses of all of a large one at hand. `docs/performance.md` has what
/// that costs. A system that has no huge pages, or that is told to give none, gives small ones.
///
/// ```
/// use flashray::blob::Buffer;
/// let buffer = Buffer::from(&b"FRAY"[..]);
/// assert_eq!(&*buffer, b"FRAY");
/// assert_eq!(buffer.as_ptr() as usize % 64, 0);
/// ```
#[derive(Debug)]
pub struct Buffer(Place);

#[derive(Debug)]
enum Place {
    /// The lines, and how many of their bytes count.
    Heap(Vec<Line>, usize),
    #[cfg(all(feature = "std", target_os = "linux"))]
    Pages(Pages),
}

impl Buffer {
    /// So many bytes, all 0.
    #[must_use]
    pub fn zeroed(len: usize) -> Self {
        Self::in_pages(len).unwrap_or_else(|| Self(Place::Heap(zeroed_vec(len.div_ceil(64)), len)))
    }

    /// The same; `None` if there is no memory for so many.
    pub(crate) fn try_zeroed(len: usize) -> Option<Self> {
        Self::in_pages(len).or_else(|| Some(Self(Place::Heap(try_zeroed_vec(len.div_ceil(64)).ok()?, len))))
    }

    #[cfg(all(feature = "std", target_os = "linux"))]
    fn in_pages(len: usize) -> Option<Self> {
        Pages::zeroed(len).map(|pages| Self(Place::Pages(pages)))
    }

    #[cfg(not(all(feature = "std", target_os = "linux")))]
    const fn in_pages(_: usize) -> Option<Self> {
        None
    }
}

impl Default for Buffer {
    fn default() -> Self {
        Self::zeroed(0)
    }
}

impl Clone for Buffer {
    fn clone(&self) -> Self {
        Self::from(&**self)
    }
}

impl From<&[u8]> for Buffer {
    fn from(bytes: &[u8]) -> Self {
        let mut buffer = Self::zeroed(bytes.len());
        buffer.copy_from_slice(bytes);
        buffer
    }
}

impl Deref for Buffer {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match &self.0 {
            Place::Heap(lines, len) => {
                let bytes: &[u8] = bytemuck::cast_slice(lines);
                bytes.get(..*len).unwrap_or(bytes)
            }
            #[cfg(all(feature = "std", target_os = "linux"))]
            Place::Pages(pages) => pages.bytes(),
        }
    }
}

impl DerefMut for Buffer {
    fn deref_mut(&mut self) -> &mut [u8] {
        match &mut self.0 {
            Place::Heap(lines, len) => {
                let bytes: &mut [u8] = bytemuck::cast_slice_mut(lines);
                let len = (*len).min(bytes.len());
                bytes.split_at_mut(len).0
            }
            #[cfg(all(feature = "std", target_os = "linux"))]
            Place::Pages(pages) => pages.bytes_mut(),
        }
    }
}
