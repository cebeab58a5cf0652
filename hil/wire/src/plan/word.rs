//! Words that hold a whole frame.

use std::ops::{BitAnd, BitOr, BitXor};

/// Bytes of the largest word.
pub(crate) const WORD_LEN: usize = 16;

/// An unsigned word of eight or sixteen bytes.
pub(crate) trait Word: Copy + Default + PartialEq
where
    Self: BitAnd<Output = Self> + BitOr<Output = Self> + BitXor<Output = Self>,
{
    /// Its bytes.
    const LEN: usize;

    /// The first `LEN` bytes, the first of them highest if `big` and lowest if not.
    fn load(front: &[u8; WORD_LEN], big: bool) -> Self;

    /// Appends the lowest `len` bytes to `out`, the lowest first.
    fn append(self, len: usize, out: &mut Vec<u8>);

    /// The lowest 64 bits of those from `shift` on; `shift` is less than the bits there are.
    fn low_from(self, shift: u32) -> u64;

    /// The word of which only bit `shift` is set.
    fn unit(shift: u32) -> Self;

    /// The word with `bits` where `unit` is set, and on.
    fn with_bits(bits: u64, unit: Self) -> Self;
}

macro_rules! word {
    ($word:ty) => {
        impl Word for $word {
            const LEN: usize = size_of::<$word>();

            #[inline(always)]
            fn load(front: &[u8; WORD_LEN], big: bool) -> Self {
                let bytes = front.first_chunk().expect("no word is longer than the largest");
                let word = Self::from_le_bytes(*bytes);
                if big { word.swap_bytes() } else { word }
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
            fn unit(shift: u32) -> Self {
                1 << (shift % Self::BITS)
            }

            // A shift by a distance that is not known takes three steps, a multiplication one.
            #[inline(always)]
            fn with_bits(bits: u64, unit: Self) -> Self {
                Self::from(bits).wrapping_mul(unit)
            }
        }
    };
}

word!(u64);
word!(u128);
