//! Words that hold a whole frame.

use std::ops::{BitAnd, BitOr, BitXor, Not};

/// Bytes of the largest word.
pub(crate) const WORD_LEN: usize = 16;

/// An unsigned word of eight or sixteen bytes.
pub(crate) trait Word: Copy + Default + PartialEq
where
    Self: BitAnd<Output = Self> + BitOr<Output = Self> + BitXor<Output = Self> + Not<Output = Self>,
{
    /// Its bytes.
    const LEN: usize;

    /// At most `LEN` bytes, the first lowest, and zeros behind them.
    fn of_little(bytes: &[u8]) -> Self;

    /// The first `LEN` bytes, the first lowest.
    fn little(front: &[u8; WORD_LEN]) -> Self;

    /// The word with its bytes the other way round.
    fn swapped(self) -> Self;

    /// Appends the `len` lowest bytes to `out`, the lowest first.
    fn append(self, len: usize, out: &mut Vec<u8>);

    /// The lowest 64 bits of those from `shift` on; `shift` is less than the bits there are.
    fn low_from(self, shift: u32) -> u64;

    /// The word with `bits` from `shift` on.
    fn with_low(bits: u64, shift: u32) -> Self;
}

macro_rules! word {
    ($word:ty) => {
        impl Word for $word {
            const LEN: usize = size_of::<$word>();

            fn of_little(bytes: &[u8]) -> Self {
                let byte = |word: Self, byte: &u8| (word << 8) | Self::from(*byte);
                bytes.iter().rev().fold(0, byte)
            }

            #[inline(always)]
            fn little(front: &[u8; WORD_LEN]) -> Self {
                let bytes = front.first_chunk().expect("no word is longer than the largest");
                Self::from_le_bytes(*bytes)
            }

            #[inline(always)]
            fn swapped(self) -> Self {
                self.swap_bytes()
            }

            #[inline(always)]
            fn append(self, len: usize, out: &mut Vec<u8>) {
                let end = out.len() + len;
                // A length that is known makes it one store; what is too much goes again.
                out.extend_from_slice(&self.to_le_bytes());
                out.truncate(end);
            }

            #[inline(always)]
            fn low_from(self, shift: u32) -> u64 {
                let bytes = (self >> (shift % Self::BITS)).to_le_bytes();
                u64::from_le_bytes(*bytes.first_chunk().expect("no word is shorter than 64 bits"))
            }

            #[inline(always)]
            fn with_low(bits: u64, shift: u32) -> Self {
                Self::from(bits) << (shift % Self::BITS)
            }
        }
    };
}

word!(u64);
word!(u128);
