//! SHA-256 that runs while the program is compiled.
//!
//! The instantiation token must stand in the shared library as plain bytes, so that packaging can
//! look for it and refuse a library built from an older variable table. No hash crate offers a
//! `const fn`; this one is held to the `sha2` crate by its tests.

/// A 256-bit digest.
pub(crate) type Digest = [u8; 32];

const BLOCK_LEN: usize = 64;

/// Fractional parts of the cube roots of the first 64 primes.
const ROUND_CONSTANTS: [u32; 64] = [
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2,
];

/// Fractional parts of the square roots of the first 8 primes.
const START: [u32; 8] = [
    0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a, 0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19,
];

/// A digest in the making.
pub(crate) struct Sha256 {
    state: [u32; 8],
    block: [u8; BLOCK_LEN],
    filled: usize,
    length_bytes: u64,
}

impl Sha256 {
    pub(crate) const fn new() -> Self {
        Self { state: START, block: [0; BLOCK_LEN], filled: 0, length_bytes: 0 }
    }

    /// The digest of `bytes` alone.
    pub(crate) const fn of(bytes: &[u8]) -> Digest {
        Self::new().with(bytes).finish()
    }

    /// Takes `bytes` in.
    pub(crate) const fn with(mut self, bytes: &[u8]) -> Self {
        let mut i = 0;
        while i < bytes.len() {
            self.push(bytes[i]);
            i += 1;
        }
        self.length_bytes += bytes.len() as u64;
        self
    }

    /// Pads and gives the digest.
    pub(crate) const fn finish(mut self) -> Digest {
        let length_bits = (self.length_bytes * 8).to_be_bytes();
        self.push(0x80);
        while self.filled != BLOCK_LEN - length_bits.len() {
            self.push(0);
        }
        let mut i = 0;
        while i < length_bits.len() {
            self.push(length_bits[i]);
            i += 1;
        }
        let mut digest = [0; 32];
        let mut k = 0;
        while k < digest.len() {
            digest[k] = self.state[k / 4].to_be_bytes()[k % 4];
            k += 1;
        }
        digest
    }

    const fn push(&mut self, byte: u8) {
        self.block[self.filled] = byte;
        self.filled += 1;
        if self.filled == BLOCK_LEN {
            self.compress();
            self.filled = 0;
        }
    }

    const fn compress(&mut self) {
        let w = schedule(&self.block);
        let [mut a, mut b, mut c, mut d, mut e, mut f, mut g, mut h] = self.state;
        let mut i = 0;
        while i < 64 {
            let s1 = e.rotate_right(6) ^ e.rotate_right(11) ^ e.rotate_right(25);
            let choice = (e & f) ^ (!e & g);
            let t1 = h.wrapping_add(s1).wrapping_add(choice);
            let t1 = t1.wrapping_add(ROUND_CONSTANTS[i]).wrapping_add(w[i]);
            let s0 = a.rotate_right(2) ^ a.rotate_right(13) ^ a.rotate_right(22);
            let majority = (a & b) ^ (a & c) ^ (b & c);
            (h, g, f, e) = (g, f, e, d.wrapping_add(t1));
            (d, c, b, a) = (c, b, a, t1.wrapping_add(s0).wrapping_add(majority));
            i += 1;
        }
        let mixed = [a, b, c, d, e, f, g, h];
        let mut k = 0;
        while k < 8 {
            self.state[k] = self.state[k].wrapping_add(mixed[k]);
            k += 1;
        }
    }
}

/// The 64 words of one block's message schedule.
const fn schedule(block: &[u8; BLOCK_LEN]) -> [u32; 64] {
    let mut w = [0; 64];
    let mut i = 0;
    while i < 64 {
        w[i] = if i < 16 {
            let b = 4 * i;
            u32::from_be_bytes([block[b], block[b + 1], block[b + 2], block[b + 3]])
        } else {
            let (x, y) = (w[i - 15], w[i - 2]);
            let s0: u32 = u32::rotate_right(x, 7) ^ u32::rotate_right(x, 18) ^ (x >> 3);
            let s1: u32 = u32::rotate_right(y, 17) ^ u32::rotate_right(y, 19) ^ (y >> 10);
            s0.wrapping_add(s1).wrapping_add(w[i - 16]).wrapping_add(w[i - 7])
        };
        i += 1;
    }
    w
}

/// `digest` as 64 lower-case hexadecimal digits.
pub(crate) const fn hex(digest: &Digest) -> [u8; 64] {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    let mut text = [0; 64];
    let mut i = 0;
    while i < digest.len() {
        text[2 * i] = DIGITS[(digest[i] >> 4) as usize];
        text[2 * i + 1] = DIGITS[(digest[i] & 15) as usize];
        i += 1;
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use sha2::Digest as _;

    #[test]
    fn every_length_around_the_block_border_agrees_with_the_sha2_crate() {
        // Two blocks and a bit: padding changes form at 55, 56, 63 and 64 bytes.
        let message: Vec<u8> = (0..140_u8).collect();
        for length in 0..=message.len() {
            let expected: Digest = sha2::Sha256::digest(&message[..length]).into();
            assert_eq!(Sha256::of(&message[..length]), expected, "{length} bytes");
        }
    }

    #[test]
    fn taking_bytes_in_pieces_changes_nothing() {
        let whole = Sha256::of(b"one string, two gyros");
        assert_eq!(Sha256::new().with(b"one string,").with(b" two gyros").finish(), whole);
    }

    #[test]
    fn hexadecimal_digits_stand_high_nibble_first() {
        let mut digest = [0; 32];
        digest[0] = 0x0a;
        digest[31] = 0xf1;
        let text = hex(&digest);
        assert_eq!((&text[..2], &text[62..]), (&b"0a"[..], &b"f1"[..]));
    }
}
