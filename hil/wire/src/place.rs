//! Where a number lies in a frame, down to the bit.

use crate::Endian;
use crate::MAX_FRAME_LEN;

/// A run of bits inside a run of bytes.
///
/// Bytes of a septet frame give seven bits each, all others eight. A column of a text line has
/// been turned into eight bytes before anything is read from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) at: usize,
    /// Bytes of the container, at most eight.
    pub(crate) bytes: usize,
    /// Lowest bit in the container.
    pub(crate) shift: u32,
    pub(crate) bits: u32,
    pub(crate) endian: Endian,
    /// Bits that each byte gives: 8, or 7 in a septet frame.
    pub(crate) byte_bits: u32,
}

impl Place {
    /// Whole bytes: one to four, or eight.
    pub(crate) const fn whole(at: usize, bytes: usize, endian: Endian) -> Self {
        let bits = match bytes {
            1 => 8,
            2 => 16,
            3 => 24,
            4 => 32,
            _ => 64,
        };
        Self { at, bytes, shift: 0, bits, endian, byte_bits: 8 }
    }

    /// The low `bits` bits set.
    #[inline]
    pub(crate) const fn mask(&self) -> u64 {
        u64::MAX >> (64 - self.bits)
    }

    /// The number at this place of a whole frame.
    #[inline]
    pub(crate) fn read(&self, frame: &[u8]) -> u64 {
        // Eight bytes around the container, or all that there are, the first lowest.
        let from = self.at.min(frame.len().saturating_sub(8));
        let before = self.at - from;
        let (word, below) = match self.endian {
            Endian::Big => (word(&frame[from..]).swap_bytes(), 8 - before - self.bytes),
            Endian::Little => (word(&frame[from..]), before),
        };
        let word = if self.byte_bits == 7 { without_top_bits(word) } else { word };
        (word >> (self.byte_bits as usize * below + self.shift as usize)) & self.mask()
    }

    /// Puts the low bits of `code` there and leaves all other bits as they are.
    #[inline]
    pub(crate) fn write(&self, code: u64, frame: &mut [u8]) {
        match frame[self.at..].first_chunk_mut() {
            Some(front) if self.byte_bits == 8 => self.write_in_word(code, front),
            _ => self.write_by_bytes(code, frame),
        }
    }

    /// The same in the eight bytes that begin with the container.
    #[inline]
    fn write_in_word(&self, code: u64, front: &mut [u8; 8]) {
        let (set, clear) = ((code & self.mask()) << self.shift, self.mask() << self.shift);
        match self.endian {
            Endian::Little => {
                *front = ((u64::from_le_bytes(*front) & !clear) | set).to_le_bytes();
            }
            Endian::Big => {
                let below = 8 * (8 - self.bytes);
                let word = u64::from_be_bytes(*front);
                *front = ((word & !(clear << below)) | (set << below)).to_be_bytes();
            }
        }
    }

    fn write_by_bytes(&self, code: u64, frame: &mut [u8]) {
        let (mut set, mut clear) = ((code & self.mask()) << self.shift, self.mask() << self.shift);
        let byte_mask = (1_u64 << self.byte_bits) - 1;
        for k in 0..self.bytes {
            let byte = &mut frame[self.byte(k)];
            let [keep, put] = [!(clear & byte_mask), set & byte_mask].map(|v| v.to_le_bytes()[0]);
            *byte = (*byte & keep) | put;
            (set, clear) = (set >> self.byte_bits, clear >> self.byte_bits);
        }
    }

    /// Offset of the `k`th byte, counted from the least significant one.
    const fn byte(&self, k: usize) -> usize {
        match self.endian {
            Endian::Big => self.at + self.bytes - 1 - k,
            Endian::Little => self.at + k,
        }
    }

    /// The bits of the frame that it takes, as a mask over the frame's bytes.
    pub(crate) fn footprint(&self) -> [u8; MAX_FRAME_LEN] {
        let mut mask = [0; MAX_FRAME_LEN];
        self.write(u64::MAX, &mut mask);
        mask
    }
}

/// The first eight bytes as a number, the first lowest; zeros follow fewer.
#[inline]
pub(crate) fn word(bytes: &[u8]) -> u64 {
    if let Some(front) = bytes.first_chunk() {
        return u64::from_le_bytes(*front);
    }
    if let (Some(front), Some(back)) = (bytes.first_chunk(), bytes.last_chunk()) {
        // Where they overlap they agree.
        let [front, back] = [front, back].map(|half| u64::from(u32::from_le_bytes(*half)));
        return front | back << (8 * (bytes.len() - 4));
    }
    bytes.iter().rev().fold(0, |word, byte| (word << 8) | u64::from(*byte))
}

/// Bit 7 of each byte left out and the rest moved together: 56 bits.
#[inline]
const fn without_top_bits(word: u64) -> u64 {
    let pairs = (word & 0x007F_007F_007F_007F) | ((word & 0x7F00_7F00_7F00_7F00) >> 1);
    let fours = (pairs & 0x0000_3FFF_0000_3FFF) | ((pairs & 0x3FFF_0000_3FFF_0000) >> 2);
    (fours & 0x0FFF_FFFF) | ((fours & 0x0FFF_FFFF_0000_0000) >> 4)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn place() -> impl Strategy<Value = Place> {
        (1_usize..=5, any::<bool>(), any::<bool>(), 0_u32..40, 1_u32..=32).prop_map(
            |(bytes, little, septet, shift, bits)| {
                let byte_bits = if septet { 7 } else { 8 };
                let room = byte_bits * u32::try_from(bytes).unwrap();
                let bits = bits.min(room);
                let endian = if little { Endian::Little } else { Endian::Big };
                Place { at: 1, bytes, shift: shift % (room - bits + 1), bits, endian, byte_bits }
            },
        )
    }

    #[test]
    fn bits_are_where_a_data_sheet_counts_them() {
        // The 16-bit word 0 0 A1 A0 D11..D0, high byte first.
        let channel =
            Place { at: 0, bytes: 1, shift: 4, bits: 2, endian: Endian::Big, byte_bits: 8 };
        let value =
            Place { at: 0, bytes: 2, shift: 0, bits: 12, endian: Endian::Big, byte_bits: 8 };
        assert_eq!((channel.read(&[0x1A, 0xBC]), value.read(&[0x1A, 0xBC])), (1, 0xABC));
        // Five septets, lowest first: bit 7 of each byte is not there.
        let septets =
            Place { at: 0, bytes: 5, shift: 0, bits: 32, endian: Endian::Little, byte_bits: 7 };
        let mut frame = [0; 5];
        septets.write(0xFFFF_FFFF, &mut frame);
        assert_eq!(frame, [0x7F, 0x7F, 0x7F, 0x7F, 0x0F]);
        assert_eq!(septets.read(&frame), 0xFFFF_FFFF);
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_and_nothing_else_moves(
            place in place(), code in any::<u64>(), paper in any::<[u8; 7]>(),
        ) {
            let limit = if place.byte_bits == 7 { 0x7F } else { 0xFF };
            let before = paper.map(|byte| byte & limit);
            let mut frame = before;
            place.write(code, &mut frame);
            prop_assert_eq!(place.read(&frame), code & place.mask());
            // With room behind it is written another way.
            let mut long = [0x55; 16];
            long[..7].copy_from_slice(&before);
            place.write(code, &mut long);
            prop_assert_eq!(&long[..7], &frame);
            prop_assert_eq!(&long[7..], &[0x55; 9]);
            let mine = place.footprint();
            for k in 0..7 {
                prop_assert_eq!((frame[k] ^ before[k]) & !mine[k], 0);
            }
            let ones: u32 = mine.iter().map(|byte| byte.count_ones()).sum();
            prop_assert_eq!(ones, place.bits);
        }
    }
}
