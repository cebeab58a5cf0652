//! One marker byte with bit 7 set, and seven bits in each byte behind it.

use super::{Cut, Cutter, Scratch, Seek};

/// Finds markers.
#[derive(Debug, Clone)]
pub(crate) struct Septet {
    marker: u8,
    len: usize,
}

impl Septet {
    pub(crate) const fn new(marker: u8, len: usize) -> Self {
        Self { marker, len }
    }
}

impl Cutter for Septet {
    const DELIMITED: bool = false;

    #[inline]
    fn cut<'a>(&self, bytes: &'a [u8], _: bool, _: &'a mut Scratch) -> Cut<'a> {
        if bytes.first().is_some_and(|first| *first != self.marker) {
            return Cut::Broken { wire_len: 1 };
        }
        let Some(content) = bytes.get(..self.len) else { return Cut::Short };
        if content[1..].iter().fold(0, |any, byte| any | byte) & 0x80 != 0 {
            return Cut::Broken { wire_len: 1 };
        }
        Cut::Whole { content, wire_len: self.len }
    }

    #[inline]
    fn seek(&self, bytes: &[u8], _: bool) -> Seek {
        let skip = memchr::memchr(self.marker, bytes).unwrap_or(bytes.len());
        Seek { skip, aligned: false }
    }
}
