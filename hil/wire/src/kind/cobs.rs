//! Consistent overhead byte stuffing: no zero inside a frame, one zero behind it.

use super::{Cut, Cutter, Scratch, Seek};

/// Finds stretches of the right length before a zero.
///
/// The coded length of a frame is its length and one, since no frame here is long enough for a
/// second code byte of 255. So the last bytes before a zero are the only candidate, even when the
/// zero of the frame before was lost.
#[derive(Debug, Clone)]
pub(crate) struct Cobs {
    /// Bytes before the zero.
    coded: usize,
}

impl Cobs {
    pub(crate) const fn new(len: usize) -> Self {
        Self { coded: len + 1 }
    }
}

impl Cutter for Cobs {
    const DELIMITED: bool = true;

    fn cut<'a>(&self, bytes: &'a [u8], _: bool, scratch: &'a mut Scratch) -> Cut<'a> {
        let front = &bytes[..bytes.len().min(self.coded + 1)];
        match memchr::memchr(0, front) {
            Some(zero) if zero == self.coded && decode(&front[..zero], scratch) => {
                Cut::Whole { content: &scratch[..zero - 1], wire_len: zero + 1 }
            }
            Some(zero) => Cut::Broken { wire_len: zero + 1 },
            None if front.len() <= self.coded => Cut::Short,
            None => Cut::Broken { wire_len: 1 },
        }
    }

    fn seek(&self, bytes: &[u8], _: bool) -> Seek {
        let mut at = 0;
        while let Some(zero) = memchr::memchr(0, &bytes[at..]) {
            if zero >= self.coded {
                return Seek { skip: at + zero - self.coded, aligned: false };
            }
            at += zero + 1;
        }
        // Without a zero yet, the last bytes may still come before one.
        let skip = at.max(bytes.len().saturating_sub(self.coded));
        Seek { skip, aligned: false }
    }
}

/// Undoes the coding of `coded`, which holds no zero; false when it is none.
fn decode(coded: &[u8], content: &mut Scratch) -> bool {
    let mut code_at = 0;
    while let Some(code) = coded.get(code_at) {
        let next = code_at + usize::from(*code);
        if next > coded.len() {
            return false;
        }
        // The zero that the code byte stands for is the byte before its block, but for the first.
        if code_at > 0 {
            content[code_at - 1] = 0;
        }
        content[code_at..next - 1].copy_from_slice(&coded[code_at + 1..next]);
        code_at = next;
    }
    true
}

/// Appends `content`, shorter than 254 bytes, and its zero.
pub(super) fn emit(content: &[u8], out: &mut Vec<u8>) {
    for block in content.split(|byte| *byte == 0) {
        let code = u8::try_from(block.len() + 1).expect("frames are far shorter than 254 bytes");
        out.push(code);
        out.extend_from_slice(block);
    }
    out.push(0);
}
