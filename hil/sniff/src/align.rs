//! Cuts a stream of frames of one length into frames, through lost and inserted bytes.
//!
//! Each column of the frame has a histogram of its byte values; the cheapest path of columns
//! through the bytes (Viterbi), where a slip costs bits, says which byte is which column. The
//! path trains the histograms, and they the next path.

/// Bits that a lost or inserted byte costs: one in some hundred bytes.
const SLIP_BITS: f32 = 8.0;
/// Bits that starting anew at any column costs: more than two slips, less than a frame of noise.
const JUMP_BITS: f32 = 22.0;
/// Bits that a byte never seen in a column costs at most.
const UNSEEN_BITS: f32 = 12.0;
/// Weight of a value not yet seen in a column, in sightings.
const PRIOR: f32 = 0.05;

const DROPPED: u8 = 1;
const INSERTED: u8 = 2;
const JUMPED: u8 = 3;
/// The column of a byte that belongs to none.
const NO_COLUMN: u8 = u8::MAX;

/// What values each column takes, as costs in bits.
#[derive(Debug, Clone)]
pub(crate) struct Template {
    len: usize,
    /// 256 rows of `len`: the cost of a byte in each column.
    cost: Vec<f32>,
}

impl Template {
    /// From counts, `len` rows of 256.
    fn from_counts(len: usize, counts: &[u32]) -> Self {
        let mut cost = vec![0.0; 256 * len];
        for (column, counts) in counts.chunks_exact(256).enumerate() {
            let total = as_f32(counts.iter().sum::<u32>()) + 256.0 * PRIOR;
            for (byte, count) in counts.iter().enumerate() {
                let bits = (total / (as_f32(*count) + PRIOR)).log2();
                cost[byte * len + column] = bits.min(UNSEEN_BITS);
            }
        }
        Self { len, cost }
    }

    /// From a stretch of bytes that is taken to be whole frames, whatever its first column.
    pub(crate) fn from_window(len: usize, window: &[u8]) -> Self {
        let mut counts = vec![0; 256 * len];
        for (k, byte) in window.iter().enumerate() {
            counts[(k % len) * 256 + usize::from(*byte)] += 1;
        }
        Self::from_counts(len, &counts)
    }

    fn row(&self, byte: u8) -> &[f32] {
        &self.cost[usize::from(byte) * self.len..][..self.len]
    }

    /// Frames in `blocks` of `bytes`, and the template that they teach.
    pub(crate) fn frames(&self, bytes: &[u8], blocks: &[(usize, usize)]) -> (Vec<usize>, Self) {
        let (len, mut starts, mut counts) = (self.len, Vec::new(), vec![0; 256 * self.len]);
        for (from, to) in blocks {
            let block = &bytes[*from..*to];
            let columns = self.columns(block);
            for (byte, column) in block.iter().zip(&columns) {
                if *column != NO_COLUMN {
                    counts[usize::from(*column) * 256 + usize::from(*byte)] += 1;
                }
            }
            starts.extend(whole_frames(&columns, len).map(|start| from + start));
        }
        (starts, Self::from_counts(len, &counts))
    }

    /// The column of each byte on the cheapest path.
    fn columns(&self, block: &[u8]) -> Vec<u8> {
        let len = self.len;
        let mut moves = vec![0; block.len() * len];
        let mut jumps = vec![0; block.len()];
        // Two entries before column 0 repeat the last two columns: the frame is a circle.
        let mut last = vec![0.0f32; len + 2];
        let mut next = vec![0.0f32; len + 2];
        for ((byte, moves), jump) in block.iter().zip(moves.chunks_exact_mut(len)).zip(&mut jumps) {
            let (from, least) = least_of(&last[2..]);
            *jump = from;
            self.step(*byte, &last, least, &mut next[2..], moves);
            (next[0], next[1]) = (next[len], next[len + 1]);
            std::mem::swap(&mut last, &mut next);
        }
        trace_back(len, &moves, &jumps, least_of(&last[2..]).0)
    }

    /// Costs of standing at each column after one more byte, relative to the least before it.
    fn step(&self, byte: u8, last: &[f32], least: f32, next: &mut [f32], moves: &mut [u8]) {
        let emit = self.row(byte);
        for column in 0..self.len {
            let (mut best, mut taken) = (last[column + 1] + emit[column], 0);
            let dropped = last[column] + emit[column] + SLIP_BITS;
            if dropped < best {
                (best, taken) = (dropped, DROPPED);
            }
            let inserted = last[column + 2] + SLIP_BITS + 8.0;
            if inserted < best {
                (best, taken) = (inserted, INSERTED);
            }
            let jumped = least + JUMP_BITS + emit[column];
            if jumped < best {
                (best, taken) = (jumped, JUMPED);
            }
            next[column] = best - least;
            moves[column] = taken;
        }
    }
}

fn least_of(costs: &[f32]) -> (u8, f32) {
    let (mut at, mut least) = (0, f32::INFINITY);
    for (k, cost) in (0u8..).zip(costs) {
        if *cost < least {
            (at, least) = (k, *cost);
        }
    }
    (at, least)
}

fn trace_back(len: usize, moves: &[u8], jumps: &[u8], end: u8) -> Vec<u8> {
    let mut columns = vec![NO_COLUMN; jumps.len()];
    let mut at = usize::from(end);
    for k in (0..jumps.len()).rev() {
        let taken = moves[k * len + at];
        if taken != INSERTED {
            columns[k] = u8::try_from(at).unwrap_or(NO_COLUMN);
        }
        at = match taken {
            DROPPED => (at + len - 2) % len,
            INSERTED => at,
            JUMPED => usize::from(jumps[k]),
            _ => (at + len - 1) % len,
        };
    }
    columns
}

/// Starts of frames that nothing interrupts.
fn whole_frames(columns: &[u8], len: usize) -> impl Iterator<Item = usize> {
    let is_frame = move |k: &usize| {
        columns[*k..*k + len].iter().enumerate().all(|(c, column)| usize::from(*column) == c)
    };
    (0..(columns.len() + 1).saturating_sub(len)).filter(is_frame)
}

#[expect(clippy::cast_precision_loss, reason = "counts of bytes in a capture, far below 2^24")]
fn as_f32(count: u32) -> f32 {
    count as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_found_on_both_sides_of_a_slip() {
        let frame = |k: u8| [0xA5, 0x5A, k, 7, k.wrapping_mul(91)];
        let mut bytes: Vec<u8> = (0..200).flat_map(frame).collect();
        bytes.remove(502); // a byte lost in frame 100
        bytes.insert(251, 0x33); // one too many in frame 50
        let template = Template::from_window(5, &bytes[..60]);
        let (starts, template) = template.frames(&bytes, &[(0, bytes.len())]);
        let (again, _) = template.frames(&bytes, &[(0, bytes.len())]);
        assert_eq!(starts.len(), 198);
        assert_eq!(starts, again);
        let whole = |start: &usize| bytes[*start..].starts_with(&[0xA5, 0x5A]);
        assert!(starts.iter().all(whole));
    }
}
