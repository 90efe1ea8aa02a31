//! Owned bytes at an address that suits a blob.
use alloc::vec::Vec;
use bytemuck::allocation::{try_zeroed_vec, zeroed_vec};
use bytemuck::{Pod, Zeroable};
use core::ops::{Deref, DerefMut};

#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Line([u8; 64]);

/// Bytes on the heap that start at a multiple of 64, the alignment at which a blob is fastest.
///
/// ```
/// use flashray::blob::Buffer;
/// let buffer = Buffer::from(&b"FRAY"[..]);
/// assert_eq!(&*buffer, b"FRAY");
/// assert_eq!(buffer.as_ptr() as usize % 64, 0);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Buffer {
    lines: Vec<Line>,
    len: usize,
}

impl Buffer {
    /// So many bytes, all 0.
    #[must_use]
    pub fn zeroed(len: usize) -> Self {
        Self { lines: zeroed_vec(len.div_ceil(64)), len }
    }

    /// The same; `None` if there is no memory for so many.
    pub(crate) fn try_zeroed(len: usize) -> Option<Self> {
        Some(Self { lines: try_zeroed_vec(len.div_ceil(64)).ok()?, len })
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
        let bytes: &[u8] = bytemuck::cast_slice(&self.lines);
        bytes.get(..self.len).unwrap_or(bytes)
    }
}

impl DerefMut for Buffer {
    fn deref_mut(&mut self) -> &mut [u8] {
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut self.lines);
        let len = self.len.min(bytes.len());
        bytes.split_at_mut(len).0
    }
}
