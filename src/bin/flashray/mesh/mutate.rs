//! Damage for tests: small files with a few random edits.
use crate::soup::Soup;

/// Inputs for each format.
const INPUTS: u64 = 20_000;

/// A generator of random numbers (`SplitMix64`) that gives the same ones on every machine.
struct Random(u64);

impl Random {
    /// A number below `end`, which is not 0.
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        usize::try_from((z ^ (z >> 31)) % u64::try_from(end).unwrap()).unwrap()
    }

    /// One edit of `data`.
    fn edit(&mut self, data: &mut Vec<u8>) {
        if data.is_empty() {
            return;
        }
        let at = self.below(data.len());
        match self.below(8) {
            0 => data.truncate(at),
            1 => drop(data.remove(at)),
            2 => data.insert(at, b"0123456789-+.e/\\ \n\r\t\"[]{},:"[self.below(27)]),
            3 => data[at] = [0, 0xff, 0x7f, 0x80][self.below(4)],
            4 => data[at] ^= 1 << self.below(8),
            5 => data[at] = u8::try_from(self.below(256)).unwrap(),
            6 if data[at].is_ascii_digit() => {
                data[at] = b'0' + u8::try_from(self.below(10)).unwrap();
            }
            _ => {
                let end = data.len().min(at + 1 + self.below(8));
                let copy = data[at..end].to_vec();
                drop(data.splice(at..at, copy));
            }
        }
    }
}

/// Calls `read` with damaged copies of `seeds`, which themselves must be sound.
///
/// What it reads must be sound too, and an error must be one short line once its control
/// characters are escaped.
pub fn run(seeds: &[&[u8]], read: impl Fn(&[u8]) -> Result<Soup, String>) {
    let mut random = Random(0x6d65_7368);
    let mut accepted = 0;
    for (number, seed) in seeds.iter().enumerate() {
        read(seed).unwrap_or_else(|error| panic!("seed {number}: {error}"));
    }
    for _ in 0..INPUTS {
        let mut data = seeds[random.below(seeds.len())].to_vec();
        for _ in 0..=random.below(4) {
            random.edit(&mut data);
        }
        match read(&data) {
            Ok(soup) => {
                accepted += 1;
                assert!(soup.positions.iter().flatten().all(|value| value.is_finite()));
                let vertices = u32::try_from(soup.positions.len()).unwrap();
                assert!(soup.triangles.iter().flatten().all(|index| *index < vertices));
            }
            Err(error) => assert!(error.len() < 600, "{error}"),
        }
    }
    assert!(accepted > 0, "every damaged file was refused: the seeds test little");
}
