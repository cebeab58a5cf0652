//! The bytes of one sample on their way out, each knowing where it comes from.

use struna_kernel::RandomStream;

/// Bytes to be sent, and for each its place in the stream that a sound gyro would have sent. An
/// inserted byte has the place of the one before which it stands.
#[derive(Debug, Clone, Default)]
pub(super) struct Packet {
    pub(super) bytes: Vec<u8>,
    pub(super) origins: Vec<u64>,
}

impl Packet {
    /// Starts over with a clean frame whose first byte has the place `origin`.
    pub(super) fn fill(&mut self, frame: &[u8], origin: u64) {
        self.clear();
        self.bytes.extend_from_slice(frame);
        self.origins.extend((0..frame.len() as u64).map(|k| origin + k));
    }

    /// Puts `next` behind what is there.
    pub(super) fn follow(&mut self, next: Self) {
        self.bytes.extend(next.bytes);
        self.origins.extend(next.origins);
    }

    pub(super) fn clear(&mut self) {
        self.bytes.clear();
        self.origins.clear();
    }

    pub(super) fn len(&self) -> usize {
        self.bytes.len()
    }

    pub(super) fn truncate(&mut self, len: usize) {
        self.bytes.truncate(len);
        self.origins.truncate(len);
    }

    pub(super) fn remove(&mut self, at: usize) {
        self.bytes.remove(at);
        self.origins.remove(at);
    }

    pub(super) fn insert(&mut self, at: usize, byte: u8, origin: u64) {
        self.bytes.insert(at, byte);
        self.origins.insert(at, origin);
    }

    /// First byte that comes from `origin`.
    pub(super) fn find(&self, origin: u64) -> Option<usize> {
        self.origins.iter().position(|found| *found == origin)
    }
}

/// A number below `n`, which is not 0.
pub(super) fn below(stream: &mut RandomStream, n: usize) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "not negative and below n"
    )]
    let drawn = (stream.uniform() * n as f64) as usize;
    drawn.min(n.saturating_sub(1))
}

/// Any byte.
pub(super) fn any_byte(stream: &mut RandomStream) -> u8 {
    below(stream, 256).to_le_bytes()[0]
}

/// Any byte but `byte`.
pub(super) fn other_byte(stream: &mut RandomStream, byte: u8) -> u8 {
    byte ^ (below(stream, 255) + 1).to_le_bytes()[0]
}
