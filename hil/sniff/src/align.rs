//! Cuts a stream of frames of one length into frames, through lost and inserted bytes.
//!
//! Each column of the frame has a histogram of its byte values; the cheapest path of columns
//! through the bytes (Viterbi), where a slip costs bits, says which byte is which column. The
//! path trains the histograms, and they the next path.

/// A cost is held in 16 bits, so that eight are compared at once: 1/32 bit is the unit, times
/// four, and the two lowest bits say which move was the cheapest.
const UNIT: f32 = 32.0;
const MOVE_BITS: u32 = 2;
const MOVE_MASK: i16 = 3;
/// A lost or inserted byte costs 8 bits: one in some hundred bytes.
const SLIP: i16 = bits(8);
/// The value of an inserted byte, which no column explains.
const FOREIGN: i16 = bits(8);
/// Starting anew at any column costs more than two slips and less than a frame of noise.
const JUMP: i16 = bits(22);
/// Bits that a byte never seen in a column costs at most.
const UNSEEN_BITS: f32 = 12.0;
/// Weight of a value not yet seen in a column, in sightings.
const PRIOR: f32 = 0.05;

const ADVANCED: i16 = 0;
const DROPPED: i16 = 1;
const INSERTED: i16 = 2;
const JUMPED: i16 = 3;
/// The column of a byte that belongs to none.
const NO_COLUMN: u8 = u8::MAX;

const fn bits(bits: i16) -> i16 {
    (bits * 32) << MOVE_BITS
}

/// What values each column takes, as costs in bits.
#[derive(Debug, Clone)]
pub(crate) struct Template {
    len: usize,
    /// 256 rows of `len`: the cost of a byte in each column.
    cost: Vec<i16>,
}

impl Template {
    /// From counts, `len` rows of 256.
    fn from_counts(len: usize, counts: &[u32]) -> Self {
        let mut cost = vec![0; 256 * len];
        for (column, counts) in counts.chunks_exact(256).enumerate() {
            let total = as_f32(counts.iter().sum::<u32>()) + 256.0 * PRIOR;
            for (byte, count) in counts.iter().enumerate() {
                let bits = (total / (as_f32(*count) + PRIOR)).log2();
                cost[byte * len + column] = packed(bits.min(UNSEEN_BITS));
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

    fn row(&self, byte: u8) -> &[i16] {
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
        let mut last = vec![0i16; len + 2];
        let mut next = vec![0i16; len + 2];
        for ((byte, moves), jump) in block.iter().zip(moves.chunks_exact_mut(len)).zip(&mut jumps) {
            let least = last.iter().copied().min().unwrap_or(0);
            *jump = place_of(&last[2..], least);
            step(self.row(*byte), &last, least, &mut next[2..], moves);
            (next[0], next[1]) = (next[len], next[len + 1]);
            std::mem::swap(&mut last, &mut next);
        }
        let least = last.iter().copied().min().unwrap_or(0);
        trace_back(len, &moves, &jumps, place_of(&last[2..], least))
    }
}

/// Costs of standing at each column after one more byte, relative to the least before it.
fn step(emit: &[i16], last: &[i16], least: i16, next: &mut [i16], moves: &mut [u8]) {
    let (two_back, one_back, here) = (last, &last[1..], &last[2..]);
    let columns = next.iter_mut().zip(moves).zip(emit).zip(two_back).zip(one_back).zip(here);
    for (((((next, taken), emit), two_back), one_back), here) in columns {
        let advanced = one_back + emit + ADVANCED;
        let dropped = two_back + emit + (SLIP + DROPPED);
        let inserted = here + (SLIP + FOREIGN + INSERTED);
        let jumped = least + emit + (JUMP + JUMPED);
        let best = advanced.min(dropped).min(inserted.min(jumped));
        *taken = (best & MOVE_MASK).to_le_bytes()[0];
        *next = (best & !MOVE_MASK) - least;
    }
}

/// The first column that costs this.
fn place_of(costs: &[i16], least: i16) -> u8 {
    let at = costs.iter().position(|cost| *cost == least).unwrap_or(0);
    u8::try_from(at).unwrap_or(0)
}

fn trace_back(len: usize, moves: &[u8], jumps: &[u8], end: u8) -> Vec<u8> {
    let mut columns = vec![NO_COLUMN; jumps.len()];
    let mut at = usize::from(end);
    for k in (0..jumps.len()).rev() {
        let taken = i16::from(moves[k * len + at]);
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

/// A cost in bits as it is held.
#[expect(clippy::cast_possible_truncation, reason = "at most UNSEEN_BITS")]
fn packed(bits: f32) -> i16 {
    ((bits * UNIT).round() as i16) << MOVE_BITS
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
