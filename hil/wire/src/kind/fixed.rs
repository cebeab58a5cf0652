//! A sync word and a fixed length.

use super::{Cut, Cutter, Scratch, Seek};
use crate::MAX_SYNC_LEN;
use crate::place::word;

/// Finds sync words, of which some bits may belong to fields.
#[derive(Debug, Clone)]
pub(crate) struct Fixed {
    /// The sync word, its first byte lowest, and the bits of it that count.
    word: u64,
    mask: u64,
    len: usize,
}

impl Fixed {
    /// An empty `mask` stands for all bits.
    pub(crate) fn new(sync: &[u8], mask: &[u8], len: usize) -> Self {
        let mut bits = [0; MAX_SYNC_LEN];
        bits[..sync.len()].fill(0xFF);
        bits[..mask.len()].copy_from_slice(mask);
        Self { word: word(sync), mask: u64::from_le_bytes(bits), len }
    }

    /// Whether `bytes` agree with the sync word as far as they go.
    #[inline]
    fn agrees(&self, bytes: &[u8]) -> bool {
        let differ = (word(bytes) ^ self.word) & self.mask;
        if bytes.len() >= MAX_SYNC_LEN {
            return differ == 0;
        }
        let known = !(u64::MAX << (8 * bytes.len()));
        differ & known == 0
    }

    /// Distance to the next byte that could be the first of a sync word.
    #[inline]
    fn to_first(&self, bytes: &[u8]) -> Option<usize> {
        let [first, ..] = self.word.to_le_bytes();
        let [mask, ..] = self.mask.to_le_bytes();
        if mask == 0xFF {
            return memchr::memchr(first, bytes);
        }
        bytes.iter().position(|byte| byte & mask == first)
    }
}

impl Cutter for Fixed {
    const DELIMITED: bool = false;

    #[inline]
    fn cut<'a>(&self, bytes: &'a [u8], _: bool, _: &'a mut Scratch) -> Cut<'a> {
        if !self.agrees(bytes) {
            return Cut::Broken { wire_len: 1 };
        }
        match bytes.get(..self.len) {
            Some(content) => Cut::Whole { content, wire_len: self.len },
            None => Cut::Short,
        }
    }

    #[inline]
    fn seek(&self, bytes: &[u8], _: bool) -> Seek {
        let mut at = 0;
        while let Some(step) = self.to_first(&bytes[at..]) {
            at += step;
            if self.agrees(&bytes[at..]) {
                return Seek { skip: at, aligned: false };
            }
            at += 1;
        }
        Seek { skip: bytes.len(), aligned: false }
    }
}
