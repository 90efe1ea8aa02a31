//! CRC-32 (ISO-HDLC, the one of zip and Ethernet): detects damage, not malice.

/// Remainders of the sixteen half-bytes. A table of 64 bytes rather than 1 KiB: this runs from flash, once per load.
const TABLE: [u32; 16] = {
    let mut table = [0; 16];
    let mut i = 0;
    while i < 16 {
        let mut r = crate::num::count(i);
        let mut bit = 0;
        while bit < 4 {
            r = if r & 1 == 1 { (r >> 1) ^ 0xedb8_8320 } else { r >> 1 };
            bit += 1;
        }
        table[i] = r;
        i += 1;
    }
    table
};

/// The CRC-32 of `bytes`.
///
/// ```
/// assert_eq!(flashray::blob::crc32(b"123456789"), 0xcbf4_3926);
/// ```
#[must_use]
pub fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, &byte| {
        let crc = crc ^ u32::from(byte);
        let crc = (crc >> 4) ^ TABLE[crate::num::index(crc & 15)];
        (crc >> 4) ^ TABLE[crate::num::index(crc & 15)]
    })
}
