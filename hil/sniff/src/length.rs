//! The length of the frame: the period at which bytes resemble themselves and columns save bits.

use crate::align::Template;
use crate::frames::Frames;

/// Lengths tried. A frame shorter than three bytes has no room for anything but a number.
pub(crate) const LEN_MIN: usize = 3;
pub(crate) const LEN_MAX: usize = 64;
/// Lengths with the best resemblance that are looked at closely, with their divisors.
const KEPT: usize = 6;
/// Bytes from which the length is judged.
const JUDGED: (usize, usize) = (4, 3 << 10);
/// Bytes that are cut into frames once the length is known.
const CUT: (usize, usize) = (12, 6 << 10);
/// A shorter length is taken when it saves at least this part of the bits of the best.
const NEAR_BEST: f64 = 0.85;
/// Bytes one true length apart resemble each other as those two lengths apart do; a part of a
/// length with less than this share of its resemblance is none.
const ALIKE: f64 = 0.7;

/// A capture cut into frames at an unknown phase.
#[derive(Debug, Clone)]
pub(crate) struct Framing {
    pub(crate) len: usize,
    /// Where clean frames start, ascending. Two are neighbours when `len` lies between them.
    pub(crate) starts: Vec<usize>,
    /// Share of the bytes in clean frames.
    pub(crate) coverage: f64,
    /// Bits saved per byte by knowing the columns.
    pub(crate) saved: f64,
}

impl Framing {
    /// The same frames once only these `parts` of the bytes are left, one behind the other.
    pub(crate) fn within(&self, parts: &[(usize, usize)]) -> Self {
        let mut starts = Vec::new();
        let mut left = 0;
        for (from, to) in parts {
            let inside = self.starts.iter().filter(|s| *s >= from && **s + self.len <= *to);
            starts.extend(inside.map(|start| start - from + left));
            left += to - from;
        }
        Self { starts, ..*self }
    }
}

/// `count` blocks of `size` bytes spread over a capture of `total`; the whole when it is smaller.
fn blocks(total: usize, (count, size): (usize, usize)) -> Vec<(usize, usize)> {
    if total <= count * size {
        return vec![(0, total)];
    }
    let from = |k: usize| k * (total - size) / (count - 1);
    (0..count).map(|k| (from(k), from(k) + size)).collect()
}

/// Lengths at which the capture may be framed, the likeliest first: a handful.
pub(crate) fn candidates(bytes: &[u8]) -> Vec<Framing> {
    let blocks = blocks(bytes.len(), JUDGED);
    let alike: Vec<f64> = (0..=LEN_MAX).map(|len| resemblance(bytes, &blocks, len)).collect();
    let mut lengths: Vec<(f64, usize)> = (LEN_MIN..=LEN_MAX).map(|len| (alike[len], len)).collect();
    lengths.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut tried: Vec<usize> = Vec::new();
    for (most, len) in lengths.iter().take(KEPT) {
        let divisors = (1..=7).filter(|d| len % d == 0).map(|d| len / d);
        tried.extend(divisors.filter(|len| *len >= LEN_MIN && alike[*len] >= ALIKE * most));
    }
    tried.sort_unstable();
    tried.dedup();
    let framed: Vec<Framing> =
        tried.into_iter().filter_map(|len| framing(bytes, &blocks, len)).collect();
    let best = framed.iter().map(|framing| framing.saved).fold(0.0, f64::max);
    if best <= 0.0 {
        return Vec::new();
    }
    let (mut near, mut far): (Vec<_>, Vec<_>) =
        framed.into_iter().partition(|framing| framing.saved >= NEAR_BEST * best);
    // A ramp within the frame repeats at any distance, but only the frame has a sync word.
    let without_sync = |framing: &Framing| {
        let rows = Frames::new(bytes, framing.len, framing.starts.clone(), 8, false);
        !rows.constant(None).contains(&true)
    };
    near.sort_by_cached_key(|framing| (without_sync(framing), framing.len));
    far.sort_by(|a, b| b.saved.total_cmp(&a.saved));
    near.into_iter().chain(far).collect()
}

/// The same length on more bytes.
pub(crate) fn widen(bytes: &[u8], len: usize) -> Option<Framing> {
    framing(bytes, &blocks(bytes.len(), CUT), len)
}

/// Whether a part of a length resembles itself enough to be the length.
pub(crate) fn may_be(bytes: &[u8], part: usize, len: usize) -> bool {
    let blocks = blocks(bytes.len(), JUDGED);
    resemblance(bytes, &blocks, part) >= ALIKE * resemblance(bytes, &blocks, len)
}

/// How well the best length explains the bytes, 0 to 8 bits per byte. A wrong baud rate scores
/// low at every length.
#[must_use]
pub fn length_score(bytes: &[u8]) -> f64 {
    candidates(bytes).first().map_or(0.0, |framing| framing.saved)
}

/// Half equal bytes, half equal bits, at a distance; 0 for noise, 1 for a constant.
fn resemblance(bytes: &[u8], blocks: &[(usize, usize)], len: usize) -> f64 {
    let (mut pairs, mut equal, mut bits) = (0u32, 0u32, 0u32);
    for (from, to) in blocks {
        let block = &bytes[*from..*to];
        for (a, b) in block.iter().zip(block.iter().skip(len)) {
            pairs += 1;
            equal += u32::from(a == b);
            bits += (a ^ b).count_ones();
        }
    }
    let per_pair = |count: u32| f64::from(count) / f64::from(pairs.max(1));
    0.5 * per_pair(equal) + 0.5 * (1.0 - 2.0 * per_pair(bits) / 8.0)
}

fn framing(bytes: &[u8], blocks: &[(usize, usize)], len: usize) -> Option<Framing> {
    let window = calmest_window(bytes, blocks, len)?;
    let mut template = Template::from_window(len, window);
    let mut starts = Vec::new();
    for _ in 0..3 {
        (starts, template) = template.frames(bytes, blocks);
    }
    if starts.len() < 8 {
        return None;
    }
    let total = as_f64(blocks.iter().map(|(from, to)| to - from).sum());
    let coverage = as_f64(starts.len() * len) / total;
    let saved = saved_bits(bytes, &starts, len) / total;
    Some(Framing { len, starts, coverage, saved })
}

/// The stretch of a few frames whose bytes repeat best at this length.
fn calmest_window<'a>(bytes: &'a [u8], blocks: &[(usize, usize)], len: usize) -> Option<&'a [u8]> {
    let size = len * if len > 24 { 8 } else { 12 };
    let mut best: Option<(usize, usize)> = None;
    for (from, to) in blocks {
        if to - from < size + len {
            continue;
        }
        let same = |k: usize| usize::from(bytes[k] == bytes[k + len]);
        let mut matches: usize = (*from..*from + size).map(same).sum();
        for start in *from..to - size - len {
            if best.is_none_or(|(most, _)| matches > most) {
                best = Some((matches, start));
            }
            matches = matches + same(start + size) - same(start);
        }
        // A block that holds exactly one window has been looked at as well.
        if best.is_none() {
            best = Some((matches, *from));
        }
    }
    best.map(|(_, start)| &bytes[start..start + size])
}

/// What an adaptive code of each column, as it is or as differences, saves over 8 bits a byte.
/// Adaptive, so that a length pays for what it learns and a long one does not win by having more
/// columns to learn.
fn saved_bits(bytes: &[u8], starts: &[usize], len: usize) -> f64 {
    let code = AdaptiveCode::up_to(starts.len());
    (0..len).map(|column| column_savings(bytes, starts, len, column, &code)).sum()
}

fn column_savings(
    bytes: &[u8],
    starts: &[usize],
    len: usize,
    column: usize,
    code: &AdaptiveCode,
) -> f64 {
    let (mut plain, mut steps) = ([0; 256], [0; 256]);
    for start in starts {
        plain[usize::from(bytes[start + column])] += 1;
    }
    for pair in starts.windows(2).filter(|pair| pair[0] + len == pair[1]) {
        let step = bytes[pair[1] + column].wrapping_sub(bytes[pair[0] + column]);
        steps[usize::from(step)] += 1;
    }
    let saved = |counts: &[usize; 256]| {
        let coded: usize = counts.iter().sum();
        8.0 * as_f64(coded) - code.bits(counts)
    };
    saved(&plain).max(saved(&steps)).max(0.0)
}

/// Code length of bytes whose distribution is learnt on the way: a byte seen c times among n costs
/// log2 of (n + 256 p) / (c + p). In the sum the order does not matter, only how often each came.
struct AdaptiveCode {
    /// Sums of log2(k + p) and of log2(k + 256 p) over k below the index.
    seen: Vec<f64>,
    all: Vec<f64>,
}

impl AdaptiveCode {
    const PRIOR: f64 = 1.0 / 16.0;

    fn up_to(count: usize) -> Self {
        let sums = |offset: f64| {
            let mut sum = 0.0;
            let added = (0..count).map(|k| {
                sum += (as_f64(k) + offset).log2();
                sum
            });
            std::iter::once(0.0).chain(added).collect()
        };
        Self { seen: sums(Self::PRIOR), all: sums(256.0 * Self::PRIOR) }
    }

    /// Bits of bytes of which each came so many times, `up_to` as many in all.
    fn bits(&self, counts: &[usize; 256]) -> f64 {
        let total: usize = counts.iter().sum();
        self.all[total] - counts.iter().map(|count| self.seen[*count]).sum::<f64>()
    }
}

#[expect(clippy::cast_precision_loss, reason = "counts of bytes, far below 2^52")]
pub(crate) fn as_f64(count: usize) -> f64 {
    count as f64
}

#[expect(clippy::cast_precision_loss, reason = "codes of at most 35 bits")]
pub(crate) fn as_float(code: u64) -> f64 {
    code as f64
}
