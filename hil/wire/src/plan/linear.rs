//! What a number makes of a frame, byte by byte.

use super::Word;
use std::sync::Arc;

/// What each value of a byte turns in a frame's word.
type Table<W> = [W; 256];

/// A function of numbers to words that is linear: the word of `a ^ b` is that of `a` and that of
/// `b`, one exclusive or the other.
///
/// One table for each byte of the number, so a word takes one look-up for each and none waits for
/// another. A number has at most `LOW + HIGH` bytes; the low ones are always looked up, for to ask
/// whether they are there takes as long, and the high ones only where the number has any of them.
/// Copies share their tables.
#[derive(Clone)]
pub(super) struct Linear<W, const LOW: usize, const HIGH: usize> {
    low: Arc<[Table<W>; LOW]>,
    high: Option<Arc<[Table<W>; HIGH]>>,
}

impl<W, const LOW: usize, const HIGH: usize> std::fmt::Debug for Linear<W, LOW, HIGH> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Linear").field("is_long", &self.high.is_some()).finish_non_exhaustive()
    }
}

impl<W: Word, const LOW: usize, const HIGH: usize> Linear<W, LOW, HIGH> {
    /// The function of numbers of so many bits, from what it makes of each bit.
    pub(super) fn of_bits(bits: u32, of_bit: impl Fn(u32) -> W) -> Self {
        let mut tables = (0..).step_by(8).map(|first| {
            let of_bit = |bit| if bit < bits { of_bit(bit) } else { W::default() };
            table([0, 1, 2, 3, 4, 5, 6, 7].map(|bit| of_bit(first + bit)))
        });
        let low = Arc::new(first_of(&mut tables));
        let is_long = bits as usize > 8 * LOW;
        Self { low, high: is_long.then(|| Arc::new(first_of(&mut tables))) }
    }

    /// The word of a number.
    #[inline(always)]
    pub(super) fn word_of(&self, number: u64) -> W {
        let low = self.word_of_low(number);
        match &self.high {
            Some(high) => low ^ word_of(high, number >> (8 * LOW)),
            None => low,
        }
    }

    /// Whether its numbers have no bytes but the low ones.
    pub(super) const fn is_low(&self) -> bool {
        self.high.is_none()
    }

    /// The word of a number that has none but those.
    #[inline(always)]
    pub(super) fn word_of_low(&self, number: u64) -> W {
        word_of(&self.low, number)
    }
}

/// As many tables as there is room for.
fn first_of<W: Word, const N: usize>(tables: &mut impl Iterator<Item = Table<W>>) -> [Table<W>; N] {
    let mut first = [[W::default(); 256]; N];
    first.iter_mut().zip(tables).for_each(|(to, table)| *to = table);
    first
}

/// The table of a byte, from what each bit of it turns.
fn table<W: Word>(bits: [W; 8]) -> Table<W> {
    let mut table = [W::default(); 256];
    for (k, of_bit) in bits.into_iter().enumerate() {
        // The values with bit `k` on top, each beside the one without it.
        let (below, above) = table.split_at_mut(1 << k);
        above.iter_mut().zip(below).for_each(|(with, without)| *with = *without ^ of_bit);
    }
    table
}

/// The word of the lowest `N` bytes of a number.
#[inline(always)]
fn word_of<W: Word, const N: usize>(tables: &[Table<W>; N], number: u64) -> W {
    let (mut word, mut rest) = (W::default(), number);
    for table in tables {
        let [byte, ..] = rest.to_le_bytes();
        word = word ^ table[usize::from(byte)];
        rest >>= u8::BITS;
    }
    word
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_word_is_what_the_bits_of_its_number_make(
            of_bits in any::<[u64; 32]>(),
            bits in 0_u32..=32,
            number in any::<u32>(),
        ) {
            let number = u64::from(number) & !(u64::MAX << bits);
            let of_bit = |bit: u32| of_bits[bit as usize];
            let set = (0..bits).filter(|bit| number >> bit & 1 == 1);
            let expected = set.fold(0, |word, bit| word ^ of_bit(bit));
            let linear = Linear::<u64, 2, 2>::of_bits(bits, of_bit);
            prop_assert_eq!(linear.word_of(number), expected);
            prop_assert_eq!(linear.is_low(), bits <= 16);
            prop_assert_eq!(linear.word_of_low(number & 0xFFFF), linear.word_of(number & 0xFFFF));
            prop_assert_eq!(Linear::<u64, 1, 3>::of_bits(bits, of_bit).word_of(number), expected);
        }
    }
}
