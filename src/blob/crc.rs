//! CRC-32 (ISO-HDLC, the one of zip and Ethernet): detects damage, not malice.

/// Remainders of the numbers of so many bits, each after so many bytes of 0.
const fn remainders<const N: usize>(bits: u32, zeros: u32) -> [u32; N] {
    let mut table = [0; N];
    let mut i = 0;
    while i < N {
        let mut r = crate::num::count(i);
        let mut bit = 0;
        while bit < bits + 8 * zeros {
            r = if r & 1 == 1 { (r >> 1) ^ 0xedb8_8320 } else { r >> 1 };
            bit += 1;
        }
        table[i] = r;
        i += 1;
    }
    table
}

/// The CRC-32 of `bytes`.
///
/// ```
/// assert_eq!(flashray::blob::crc32(b"123456789"), 0xcbf4_3926);
/// ```
#[must_use]
pub fn crc32(bytes: &[u8]) -> u32 {
    !rest(bytes, !0)
}

/// Half a byte at a time, by a table of 64 bytes rather than 1 KiB: this runs from flash, once per load.
#[cfg(not(feature = "std"))]
fn rest(bytes: &[u8], crc: u32) -> u32 {
    const TABLE: [u32; 16] = remainders(4, 0);
    bytes.iter().fold(crc, |crc, &byte| {
        let crc = crc ^ u32::from(byte);
        let crc = (crc >> 4) ^ TABLE[crate::num::index(crc & 15)];
        (crc >> 4) ^ TABLE[crate::num::index(crc & 15)]
    })
}

/// Sixteen bytes at a time (Kounavis and Berry, "A Systematic Approach to Building High Performance Software-based CRC
/// Generators", ISCC 2005), by tables of 16 KiB: for what a host builds and loads.
#[cfg(feature = "std")]
fn rest(bytes: &[u8], crc: u32) -> u32 {
    static TABLES: [[u32; 256]; 16] = {
        let mut tables = [[0; 256]; 16];
        let mut i = 0;
        while i < 16 {
            tables[i] = remainders(8, 15 - crate::num::count(i));
            i += 1;
        }
        tables
    };
    let (runs, rest) = bytes.as_chunks::<16>();
    let crc = runs.iter().fold(crc, |crc, run| {
        let mut run = *run;
        run.iter_mut().zip(crc.to_le_bytes()).for_each(|(byte, crc)| *byte ^= crc);
        TABLES.iter().zip(run).fold(0, |sum, (table, byte)| sum ^ table[usize::from(byte)])
    });
    let last = &TABLES[15];
    rest.iter().fold(crc, |crc, &byte| (crc >> 8) ^ last[usize::from(byte ^ crc.to_le_bytes()[0])])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_length_and_start_gives_the_remainder_bit_by_bit() {
        let bytes: [u8; 64] = core::array::from_fn(|i| (i * 37 + 11).to_le_bytes()[0]);
        for start in 0..9 {
            for end in start..64 {
                let slow = bytes[start..end].iter().fold(!0u32, |crc, &byte| {
                    (0..8).fold(crc ^ u32::from(byte), |r, _| (r >> 1) ^ (0xedb8_8320 & (r & 1).wrapping_neg()))
                });
                assert_eq!(crc32(&bytes[start..end]), !slow, "{start}..{end}");
            }
        }
    }
}
