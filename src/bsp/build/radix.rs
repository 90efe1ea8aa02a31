//! Words in ascending order, in time linear in their number.
//!
//! Digit after digit, the lowest first, words go from one array to another in the order of the digit (Knuth, "The Art
//! of Computer Programming" 3, section 5.2.5). Few words are sorted by comparisons, a bounded number of them for each.
use crate::num::index;

/// Bits of a digit: three digits are a word.
const DIGIT: u32 = 11;
/// Digits there are.
const DIGITS: usize = 1 << DIGIT;
/// So many words comparisons sort as fast; with a hundred times as many they take three times as long.
const FEW: usize = 1024;

/// Sorts words, with as many to spare. Returns the sorted ones and the others.
pub fn sort<'w>(mut words: &'w mut [u32], mut spare: &'w mut [u32]) -> (&'w mut [u32], &'w mut [u32]) {
    if words.len() <= FEW || spare.len() != words.len() {
        words.sort_unstable();
        return (words, spare);
    }
    for shift in [0, DIGIT, 2 * DIGIT] {
        by_digit(words, spare, shift);
        (words, spare) = (spare, words);
    }
    (words, spare)
}

/// Copies words in the order of the digit that begins at bit `shift`; those of one digit stay in order.
fn by_digit(words: &[u32], sorted: &mut [u32], shift: u32) {
    let digit = |word: u32| index(word >> shift) % DIGITS;
    // Where the next word of each digit goes.
    let mut places = [0u32; DIGITS];
    for &word in words {
        places[digit(word)] += 1;
    }
    let mut end = 0;
    for place in &mut places {
        (*place, end) = (end, end + *place);
    }
    for &word in words {
        let next = &mut places[digit(word)];
        if let Some(place) = sorted.get_mut(index(*next)) {
            *place = word;
        }
        *next += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::{FEW, sort};

    /// Numbers that look random (Marsaglia, "Xorshift RNGs", 2003).
    fn words<const N: usize>(change: impl Fn(u32) -> u32) -> [u32; N] {
        let mut state = 1u32;
        [(); N].map(|()| {
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            change(state)
        })
    }

    fn sorts_as_comparisons_do<const N: usize>(change: impl Fn(u32) -> u32) {
        let mut words = words::<N>(change);
        let mut expected = words;
        expected.sort_unstable();
        let mut spare = [0; N];
        let (sorted, _) = sort(&mut words, &mut spare);
        assert!(*sorted == expected, "{N} words");
    }

    #[test]
    fn words_are_sorted_whatever_digits_they_have() {
        const MANY: usize = FEW * 9;
        sorts_as_comparisons_do::<0>(|x| x);
        sorts_as_comparisons_do::<1>(|x| x);
        sorts_as_comparisons_do::<FEW>(|x| x);
        sorts_as_comparisons_do::<{ FEW + 1 }>(|x| x);
        sorts_as_comparisons_do::<MANY>(|x| x);
        sorts_as_comparisons_do::<MANY>(|_| 7);
        sorts_as_comparisons_do::<MANY>(|x| x & 1);
        sorts_as_comparisons_do::<MANY>(|x| x & 1 << 31 | 5);
        sorts_as_comparisons_do::<MANY>(|x| x & 0x00ff_0000);
        // Two digits alone, and one that most have.
        sorts_as_comparisons_do::<MANY>(|x| x & 0x8000_0fff);
        sorts_as_comparisons_do::<MANY>(|x| if x & 0xffc == 0 { x } else { x & 0xff | 0x3f00_0000 });
        sorts_as_comparisons_do::<MANY>(|x| u32::MAX - (x >> 20));
    }
}
