//! Cuts a stream of frames of one length into frames, through lost and inserted bytes.
//!
//! Each column of the frame has a histogram of its byte values; the cheapest path of columns
//! through the bytes (Viterbi), where a slip costs bits, says which byte is which column. The
//! path trains the histograms, and they the next path.

/// Costs are 16-bit numbers in 1/128 bit, and so many are compared at once.
const UNIT: f32 = 128.0;
const LANES: usize = 8;
/// A lost or inserted byte costs 8 bits: one in some hundred bytes.
const DROPPED: i16 = bits(8);
/// An inserted byte has, besides, a value that no column explains: 8 bits more.
const INSERTED: i16 = bits(16);
/// Starting anew at any column costs more than two slips and less than a frame of noise.
const JUMP: i16 = bits(22);
/// Bits that a byte never seen in a column costs at most.
const UNSEEN_BITS: f32 = 12.0;
/// What fills rows up to whole lanes, so dear that no path leads there.
const NOWHERE: i16 = bits(96);
/// Weight of a value not yet seen in a column, in sightings.
const PRIOR: f32 = 0.05;
/// The column of a byte that belongs to none.
const NO_COLUMN: u8 = u8::MAX;

const fn bits(bits: i16) -> i16 {
    bits << 7
}

/// What values each column takes, as costs in bits.
#[derive(Debug, Clone)]
pub(crate) struct Template {
    len: usize,
    /// 256 rows of whole lanes: the cost of a byte in each column.
    cost: Vec<i16>,
}

/// The least cost of standing at each column after each byte, and before the first.
#[derive(Default)]
struct Costs {
    /// Rows of one lane of margin and the columns, less the least of the row before. The last two
    /// entries of the margin repeat the last two columns: the frame is a circle.
    rows: Vec<i16>,
    /// The least of each row.
    least: Vec<i16>,
}

impl Template {
    /// From counts, `len` rows of 256.
    fn from_counts(len: usize, counts: &[u32]) -> Self {
        let width = len.next_multiple_of(LANES);
        let mut cost = vec![NOWHERE; 256 * width];
        for (column, counts) in counts.chunks_exact(256).enumerate() {
            let total = as_f32(counts.iter().sum::<u32>()) + 256.0 * PRIOR;
            let bits = |count: u32| (total / (as_f32(count) + PRIOR)).log2().min(UNSEEN_BITS);
            let unseen = packed(bits(0));
            for (byte, count) in counts.iter().enumerate() {
                let seen = *count > 0;
                cost[byte * width + column] = if seen { packed(bits(*count)) } else { unseen };
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

    fn width(&self) -> usize {
        self.len.next_multiple_of(LANES)
    }

    fn row(&self, byte: u8) -> &[i16] {
        &self.cost[usize::from(byte) * self.width()..][..self.width()]
    }

    /// Frames in `blocks` of `bytes`, and the template that they teach.
    pub(crate) fn frames(&self, bytes: &[u8], blocks: &[(usize, usize)]) -> (Vec<usize>, Self) {
        let (len, mut starts, mut counts) = (self.len, Vec::new(), vec![0; 256 * self.len]);
        let mut costs = Costs::default();
        for (from, to) in blocks {
            let block = &bytes[*from..*to];
            self.walk(block, &mut costs);
            let columns = self.trace_back(block, &costs);
            for (byte, column) in block.iter().zip(&columns) {
                if *column != NO_COLUMN {
                    counts[usize::from(*column) * 256 + usize::from(*byte)] += 1;
                }
            }
            starts.extend(whole_frames(&columns, len).map(|start| from + start));
        }
        (starts, Self::from_counts(len, &counts))
    }

    fn walk(&self, block: &[u8], costs: &mut Costs) {
        let (len, stride) = (self.len, LANES + self.width());
        costs.rows.resize((block.len() + 1) * stride, 0);
        costs.rows[..LANES + len].fill(0);
        costs.rows[LANES + len..stride].fill(NOWHERE);
        costs.least.clear();
        let mut least = 0;
        let mut rows = costs.rows.chunks_exact_mut(stride);
        let Some(mut last) = rows.next() else { return };
        for (byte, next) in block.iter().zip(rows) {
            costs.least.push(least);
            least = step(self.row(*byte), last, least, &mut next[LANES..]);
            next.copy_within(LANES + len - 2..LANES + len, LANES - 2);
            last = next;
        }
        costs.least.push(least);
    }

    /// The column of each byte on the cheapest path.
    fn trace_back(&self, block: &[u8], costs: &Costs) -> Vec<u8> {
        let (len, stride) = (self.len, LANES + self.width());
        let cheapest = |k: usize| {
            let row = &costs.rows[k * stride + LANES..][..len];
            row.iter().position(|cost| *cost == costs.least[k]).unwrap_or(0)
        };
        let mut columns = vec![NO_COLUMN; block.len()];
        let mut at = cheapest(block.len());
        for (k, byte) in block.iter().enumerate().rev() {
            // Entries LANES - 2 and LANES - 1 stand for the columns before the first.
            let last = &costs.rows[k * stride + LANES - 2..][..len + 2];
            let cost = costs.rows[(k + 1) * stride + LANES + at] + costs.least[k];
            let emit = self.row(*byte)[at];
            let advanced = last[at + 1] + emit == cost;
            let dropped = last[at] + DROPPED + emit == cost;
            if !advanced && !dropped && last[at + 2] + INSERTED == cost {
                continue;
            }
            columns[k] = u8::try_from(at).unwrap_or(NO_COLUMN);
            at = match (advanced, dropped) {
                (true, _) => (at + len - 1) % len,
                (_, true) => (at + len - 2) % len,
                _ => cheapest(k),
            };
        }
        columns
    }
}

/// Costs of standing at each column after one more byte, less the least before it; returns the
/// least of them.
fn step(emit: &[i16], last: &[i16], least: i16, next: &mut [i16]) -> i16 {
    let lanes = |back: usize| last[LANES - back..].as_chunks::<LANES>().0;
    let before = lanes(2).iter().zip(lanes(1)).zip(lanes(0));
    let columns = next.as_chunks_mut::<LANES>().0.iter_mut().zip(emit.as_chunks::<LANES>().0);
    let anew = [least + JUMP; LANES];
    let mut lows = [i16::MAX; LANES];
    for ((next, emit), ((two_back, one_back), here)) in columns.zip(before) {
        let came = min(min(*one_back, add(*two_back, DROPPED)), anew);
        let came = each(came, *emit, i16::wrapping_add);
        *next = add(min(came, add(*here, INSERTED)), -least);
        lows = min(lows, *next);
    }
    lows.into_iter().min().unwrap_or(0)
}

type Lanes = [i16; LANES];

#[inline(always)]
fn each(a: Lanes, b: Lanes, with: impl Fn(i16, i16) -> i16) -> Lanes {
    let mut out = [0; LANES];
    for k in 0..LANES {
        out[k] = with(a[k], b[k]);
    }
    out
}

#[inline(always)]
fn min(a: Lanes, b: Lanes) -> Lanes {
    each(a, b, Ord::min)
}

/// Nothing here comes near the largest cost; a check for it would take longer than the sum.
#[inline(always)]
fn add(lanes: Lanes, cost: i16) -> Lanes {
    each(lanes, [cost; LANES], i16::wrapping_add)
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
    (bits * UNIT + 0.5) as i16
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
