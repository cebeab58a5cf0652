//! Checks that every byte of a frame adds to by itself.

use super::{Run, Word, Words};
use crate::CheckSpec;
use crate::check::Algorithm;

/// A CRC or an exclusive or over bytes of a frame.
///
/// Both are linear but for a constant: the check is the exclusive or of what each byte makes of it
/// where it stands. One table for each place, so no look-up waits for the one before.
#[derive(Clone)]
pub(super) struct Check {
    stored: Run,
    /// Lowest bit of the first byte covered.
    shift: u32,
    /// What the check is when all bytes are zero.
    of_zeros: u32,
    tables: Box<[[u32; 256]]>,
}

impl std::fmt::Debug for Check {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Check").field("stored", &self.stored).finish_non_exhaustive()
    }
}

impl Check {
    /// Nothing when no such check is in the frame, `None` when another one is.
    #[expect(clippy::option_option, reason = "whether it can be planned, and whether there is one")]
    pub(super) fn of<W: Word>(spec: &CheckSpec) -> Option<Option<Self>> {
        match spec.algorithm {
            Algorithm::None => return Some(None),
            Algorithm::Sum { .. } | Algorithm::Parity { .. } => return None,
            Algorithm::Crc(_) | Algorithm::Xor => (),
        }
        let mut bytes = vec![0; spec.last - spec.first + 1];
        let of_zeros = spec.of_covered(&bytes);
        let mut tables = vec![[0; 256]; bytes.len()].into_boxed_slice();
        for (k, table) in tables.iter_mut().enumerate() {
            for (byte, slot) in (0..=u8::MAX).zip(table) {
                bytes[k] = byte;
                *slot = spec.of_covered(&bytes) ^ of_zeros;
            }
            bytes[k] = 0;
        }
        let (stored, shift) = (Run::of::<W>(&spec.place)?, u32::try_from(8 * spec.first).ok()?);
        Some(Some(Self { stored, shift, of_zeros, tables }))
    }

    #[inline(always)]
    fn value<W: Word>(&self, little: W) -> u64 {
        let mut sum = self.of_zeros;
        let mut shift = self.shift;
        for table in &self.tables {
            let [byte, ..] = little.low_from(shift).to_le_bytes();
            sum ^= table[usize::from(byte)];
            shift += 8;
        }
        u64::from(sum)
    }

    /// Whether the check of a whole frame is right.
    #[inline(always)]
    pub(super) fn holds<W: Word>(&self, words: Words<W>) -> bool {
        self.value(words.little) == self.stored.read(words)
    }

    /// Completes a frame that has everything else in it.
    #[inline(always)]
    pub(super) fn put<W: Word>(&self, words: &mut Words<W>) {
        let (whole, _) = W::both(&W::bytes(words.little, words.big));
        self.stored.put(self.value(whole), words);
    }
}
