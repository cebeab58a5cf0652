//! Checks that every byte of a frame adds to by itself.

use super::{Word, shift_of};
use crate::check::Algorithm;
use crate::crc::lower_half;
use crate::{CheckSpec, Endian};

/// A CRC or an exclusive or over bytes of a frame.
///
/// Both are linear but for a constant: the check is the exclusive or of what each byte makes of it
/// where it stands. One table for each place, so no look-up waits for the one before. All is kept
/// as it is stored, so the order of the stored bytes is settled in the tables.
#[derive(Clone)]
pub(super) struct Check {
    /// Lowest bit of what is stored, and a mask over it.
    stored_shift: u32,
    stored_mask: u32,
    /// Lowest bit of what is covered.
    shift: u32,
    /// For the bytes from there on, by fours. Those not covered any more add nothing.
    first: Box<Tables>,
    rest: Box<[Tables]>,
}

/// As many as 32 bits.
const FOUR: usize = 4;
/// What each value of each of four bytes adds.
type Tables = [[u32; 256]; FOUR];

impl std::fmt::Debug for Check {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Check").field("shift", &self.shift).finish_non_exhaustive()
    }
}

impl Check {
    /// Nothing when no such check is in the frame, `None` when another one is.
    #[expect(clippy::option_option, reason = "whether it can be planned, and whether there is one")]
    pub(super) fn of<W: Word>(spec: &CheckSpec, big: bool) -> Option<Option<Self>> {
        match spec.algorithm {
            Algorithm::None => return Some(None),
            Algorithm::Sum { .. } | Algorithm::Parity { .. } => return None,
            Algorithm::Crc(_) | Algorithm::Xor => (),
        }
        let (first, rest) = tables(spec, big);
        Some(Some(Self {
            stored_shift: shift_of::<W>(spec.place.at, spec.place.bytes, big)?,
            stored_mask: lower_half(spec.place.mask()),
            shift: shift_of::<W>(spec.first, spec.last - spec.first + 1, big)?,
            first,
            rest,
        }))
    }

    /// What is to be stored over a frame.
    #[inline(always)]
    fn value<W: Word>(&self, word: W) -> u32 {
        let mut sum = of_four(&self.first, word.low_from(self.shift));
        let mut shift = self.shift;
        for tables in &self.rest {
            shift += u32::BITS;
            sum ^= of_four(tables, word.low_from(shift));
        }
        sum
    }

    /// Whether the check of a whole frame is right.
    #[inline(always)]
    pub(super) fn holds<W: Word>(&self, word: W) -> bool {
        self.value(word) == lower_half(word.low_from(self.stored_shift)) & self.stored_mask
    }
}

#[inline(always)]
fn of_four([first, second, third, fourth]: &Tables, bytes: u64) -> u32 {
    let [a, b, c, d, ..] = bytes.to_le_bytes().map(usize::from);
    first[a] ^ second[b] ^ third[c] ^ fourth[d]
}

fn tables(spec: &CheckSpec, big: bool) -> (Box<Tables>, Box<[Tables]>) {
    let mut bytes = vec![0; spec.last - spec.first + 1];
    let is_swapped = big != (spec.place.endian == Endian::Big);
    let stored = |bytes: &[u8]| match spec.of_covered(bytes) {
        value if is_swapped => value.swap_bytes() >> (32 - spec.place.bits),
        value => value,
    };
    let of_zeros = stored(&bytes);
    let len = bytes.len();
    let mut first = Box::new([[0; 256]; FOUR]);
    let mut rest = vec![[[0; 256]; FOUR]; len.div_ceil(FOUR) - 1].into_boxed_slice();
    let all = first.iter_mut().chain(rest.as_flattened_mut());
    for (k, table) in all.take(len).enumerate() {
        let at = if big { len - 1 - k } else { k };
        // What all of them make of zeros is the first one's to add.
        let constant = if k == 0 { 0 } else { of_zeros };
        for (byte, slot) in (0..=u8::MAX).zip(table) {
            bytes[at] = byte;
            *slot = stored(&bytes) ^ constant;
        }
        bytes[at] = 0;
    }
    (first, rest)
}
