//! What a number makes of a frame, byte by byte.

use super::Word;
use std::sync::Arc;

/// What each value of a byte turns in a frame's word.
type Table<W> = [W; 256];

/// A function of numbers to words that is linear: the word of `a ^ b` is that of `a` and that of
/// `b`, one exclusive or the other.
///
/// One table for each byte of the number, so a word takes one look-up for each and none waits for
/// another. The first `N` are there whether the number has so many bytes or not: no run-time
/// question is asked about them. Copies share their tables.
#[derive(Clone)]
pub(super) struct Linear<W, const N: usize> {
    low: Arc<[Table<W>; N]>,
    high: Arc<[Table<W>]>,
}

impl<W, const N: usize> std::fmt::Debug for Linear<W, N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Linear").field("bytes", &(N + self.high.len())).finish_non_exhaustive()
    }
}

impl<W: Word, const N: usize> Linear<W, N> {
    /// The function of numbers of so many bits, from what it makes of each bit.
    pub(super) fn of_bits(bits: u32, of_bit: impl Fn(u32) -> W) -> Self {
        let table = |byte: u32| {
            let of_bit =
                |bit| if 8 * byte + bit < bits { of_bit(8 * byte + bit) } else { W::default() };
            let basis: [W; 8] = [0, 1, 2, 3, 4, 5, 6, 7].map(of_bit);
            let mut table = [W::default(); 256];
            for (k, of_bit) in basis.into_iter().enumerate() {
                // The values with bit `k` on top, each beside the one without it.
                let (below, above) = table.split_at_mut(1 << k);
                above.iter_mut().zip(below).for_each(|(with, without)| *with = *without ^ of_bit);
            }
            table
        };
        let mut tables = (0_u32..).map(table);
        let mut low = [[W::default(); 256]; N];
        low.iter_mut().zip(&mut tables).for_each(|(to, table)| *to = table);
        let others = (bits.div_ceil(8) as usize).saturating_sub(N);
        Self { low: Arc::new(low), high: tables.take(others).collect() }
    }

    /// Whether its numbers have no bytes but the first `N`.
    pub(super) fn is_low(&self) -> bool {
        self.high.is_empty()
    }

    /// The word of a number.
    #[inline]
    pub(super) fn word_of(&self, number: u64) -> W {
        let bytes = number.to_le_bytes().into_iter().skip(N);
        let high = self.high.iter().zip(bytes);
        high.fold(self.word_of_low(number), |word, (table, byte)| word ^ table[usize::from(byte)])
    }

    /// The word of the first `N` bytes of a number.
    #[inline(always)]
    pub(super) fn word_of_low(&self, number: u64) -> W {
        let (mut word, mut rest) = (W::default(), number);
        for table in self.low.iter() {
            let [byte, ..] = rest.to_le_bytes();
            word = word ^ table[usize::from(byte)];
            rest >>= u8::BITS;
        }
        word
    }
}
