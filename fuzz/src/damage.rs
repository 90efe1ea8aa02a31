//! Flips in a good blob: refused, or the same limits hold.
//!
//! Data: which blob, what happens to it, two rays, then up to eight flips.
use crate::rays::specs;
use crate::{good, parse, seal};
use arbitrary::{Result, Unstructured};
use flashray::Scene;
use flashray::blob::Buffer;

/// Most flips of one run.
const FLIPS: usize = 8;
/// CRC-32 finds any three flipped bits in blobs up to this length: its Hamming distance is 4 up to 91607 bits. In
/// longer ones it finds any two: a word repeats after 2^32 - 1 bits, for the polynomial is primitive.
const SURE: usize = 11_000;

/// One run.
pub fn run(data: &[u8]) {
    let _ = attempt(&mut Unstructured::new(data));
}

fn attempt(u: &mut Unstructured<'_>) -> Result<()> {
    let good = good::pick(u.arbitrary()?);
    let what = u.arbitrary::<u8>()?;
    let rays = specs(u, parse::RAYS)?;
    let mut blob = good.bytes.clone();
    for _ in 0..FLIPS {
        if u.is_empty() {
            break;
        }
        let (at, mask): (u16, u8) = u.arbitrary()?;
        let at = usize::from(at) % blob.len();
        blob[at] ^= mask;
    }
    let blob = resize(&blob, what, u.arbitrary()?);
    refused(&good.bytes, &blob);
    parse::load(&blob, &rays);
    if what & 1 == 1 {
        let mut sealed = blob.clone();
        seal::seal(&mut sealed);
        parse::load(&sealed, &rays);
    }
    Ok(())
}

/// By bits 1 and 2 of `what`: as it is, cut, or extended.
fn resize(blob: &[u8], what: u8, by: u16) -> Buffer {
    let by = usize::from(by);
    match what >> 1 & 3 {
        1 => Buffer::from(&blob[..by % (blob.len() + 1)]),
        2 => {
            let mut longer = Buffer::zeroed(blob.len() + by % 256);
            longer[..blob.len()].copy_from_slice(blob);
            longer
        }
        _ => Buffer::from(blob),
    }
}

/// A changed blob with its old checksum is refused: surely for few bits, and else unless the checksum fits by chance.
fn refused(good: &[u8], blob: &[u8]) {
    if good == blob {
        assert!(Scene::from_bytes(blob).is_ok(), "a good blob is accepted");
        return;
    }
    let Ok(_) = Scene::from_bytes(blob) else { return };
    let bits: u32 = good.iter().zip(blob).map(|(a, b)| (a ^ b).count_ones()).sum();
    assert_eq!(good.len(), blob.len(), "a blob of another length was accepted");
    assert_eq!(good[..seal::CHECKSUM], blob[..seal::CHECKSUM], "another magic, version or length was accepted");
    assert_eq!(seal::sum(blob), seal::word(blob, seal::CHECKSUM), "a wrong checksum was accepted");
    let found = if blob.len() < SURE { 3 } else { 2 };
    assert!(bits > found, "{bits} flipped bits were accepted");
}
