//! Finds the check: its algorithm, the bytes it covers, its place and byte order.
//!
//! Differences of frame pairs are looked at first. In them start value, final XOR and constant
//! bytes cancel, so that only the rule, the range and the order are left to try: some dozens of
//! rules, every range that ends at the check, both orders. Real frames then settle the rest.

use crate::catalogue::{CATALOGUE, Crc, KERNELS, Kernel};
use crate::layout::{CheckKind, read};
use crate::length::Framing;

/// Pairs in the first sieve, and in the count that compares ranges.
const SIEVE_PAIRS: usize = 32;
const COUNT_PAIRS: usize = 256;
/// Real frames that settle the start value.
const FRAMES: usize = 64;
/// Share of pairs, or frames, that must agree. Chance gives 1/256; at 1 % corrupted bytes a pair
/// of long frames is whole in six cases of ten.
const AGREE: f64 = 0.4;
/// Ranges this close to the best share are as good as it.
const EQUAL_SHARE: f64 = 0.006;
/// Different values an 8-bit check must take: fewer could be a sign byte.
const VALUES_MIN: usize = 4;

/// A check in the columns of a [`Framing`], whose phase is unknown: the range starts at column
/// `start`, covers `count` bytes around the circle and ends at the check.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    pub(crate) kind: CheckKind,
    pub(crate) start: usize,
    pub(crate) count: usize,
    pub(crate) big_endian: bool,
    /// Share of real frames that agree.
    pub(crate) share: f64,
}

impl Place {
    pub(crate) fn at(&self, len: usize) -> usize {
        (self.start + self.count) % len
    }
}

/// What is tried on differences.
#[derive(Clone, Copy)]
enum Rule {
    Sum,
    NegSum,
    Xor,
    Crc(&'static Kernel),
}

impl Rule {
    fn bytes(self) -> usize {
        match self {
            Self::Crc(kernel) => kernel.width as usize / 8,
            _ => 1,
        }
    }

    fn is_sum(self) -> bool {
        matches!(self, Self::Sum | Self::NegSum)
    }
}

/// Differences of frame pairs, two frames long, so that a range may cross the cut between frames.
struct Differences {
    xor: Vec<Vec<u8>>,
    sum: Vec<Vec<u8>>,
}

impl Differences {
    fn of(bytes: &[u8], doubles: &[usize], len: usize, count: usize) -> Self {
        let half = doubles.len() / 2;
        let (mut xor, mut sum) = (Vec::new(), Vec::new());
        for k in 0..count.min(half) {
            let first = k * half / count.min(half);
            // Not one distance for all: it could be a whole number of turns of the counter.
            let (a, b) = (doubles[first], doubles[first + half - k % half.min(37)]);
            let pair = || bytes[a..a + 2 * len].iter().zip(&bytes[b..b + 2 * len]);
            xor.push(pair().map(|(a, b)| a ^ b).collect());
            sum.push(pair().map(|(a, b)| a.wrapping_sub(*b)).collect());
        }
        Self { xor, sum }
    }

    fn of_rule(&self, rule: Rule) -> &[Vec<u8>] {
        if rule.is_sum() { &self.sum } else { &self.xor }
    }

    /// Columns that differ in some pair.
    fn active(&self, len: usize) -> Vec<bool> {
        (0..len).map(|c| self.xor.iter().any(|d| d[c] != 0 || d[c + len] != 0)).collect()
    }
}

/// Every check that the frames bear out, the likeliest first: those that follow the bytes equally
/// stand side by side.
pub(crate) fn search(
    bytes: &[u8],
    framing: &Framing,
    constant: &[bool],
    seven_bits: bool,
) -> Vec<Place> {
    let len = framing.len;
    let doubles = intact(bytes, doubles_of(framing), constant);
    if doubles.len() < 16 {
        return Vec::new();
    }
    let few = Differences::of(bytes, &doubles, len, SIEVE_PAIRS);
    let many = Differences::of(bytes, &doubles, len, COUNT_PAIRS);
    let active = many.active(len);
    for rules in rules_by_width(seven_bits) {
        let mut found: Vec<(f64, Vec<Place>)> = Vec::new();
        for rule in rules.into_iter().filter(|rule| rule.bytes() + 2 <= len) {
            for ((at, big_endian), starts) in sieve(rule, &few, &many, &active, seven_bits) {
                if rule.bytes() == 1 && counts_on(bytes, &doubles, len, at) {
                    continue;
                }
                let runs = run_after(constant, at + rule.bytes());
                let places =
                    settle(rule, bytes, &doubles, (len, at, big_endian, seven_bits), &starts);
                if !places.is_empty() {
                    found.push((runs, places));
                }
            }
        }
        // An XOR over everything makes every byte the check of the others; the true one ends the
        // frame, so the sync word follows it.
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        if let Some((_, places)) = found.into_iter().next() {
            return in_order_of_likelihood(places, constant, len);
        }
    }
    Vec::new()
}

/// Frames with a neighbour behind them: two frames' worth of clean bytes each.
pub(crate) fn doubles_of(framing: &Framing) -> Vec<usize> {
    let next = |pair: &[usize]| (pair[0] + framing.len == pair[1]).then_some(pair[0]);
    framing.starts.windows(2).filter_map(next).collect()
}

/// Those whose constant columns are undamaged. A flipped sync bit spoils the true range, which
/// covers it, and not a shorter one: the shorter would seem the better.
fn intact(bytes: &[u8], mut doubles: Vec<usize>, constant: &[bool]) -> Vec<usize> {
    let len = constant.len();
    for column in (0..2 * len).filter(|column| constant[column % len]) {
        let mut values: Vec<u8> = doubles.iter().map(|start| bytes[start + column]).collect();
        let middle = values.len() / 2;
        if values.is_empty() {
            break;
        }
        // The commonest value of a column that hardly ever changes is its median.
        let (_, median, _) = values.select_nth_unstable(middle);
        let median = *median;
        doubles.retain(|start| bytes[start + column] == median);
    }
    doubles
}

fn rules_by_width(seven_bits: bool) -> Vec<Vec<Rule>> {
    let sums = vec![Rule::Sum, Rule::NegSum, Rule::Xor];
    if seven_bits {
        return vec![sums];
    }
    let crcs = |width| KERNELS.iter().filter(move |kernel| kernel.width == width).map(Rule::Crc);
    vec![crcs(32).collect(), crcs(16).collect(), sums.into_iter().chain(crcs(8)).collect()]
}

/// A constant column that follows weighs as sync; 00 and FF are told apart later.
fn run_after(constant: &[bool], column: usize) -> f64 {
    let len = constant.len();
    let run = (0..len).take_while(|k| constant[(column + k) % len]).count();
    crate::length::as_f64(run)
}

type Slot = (usize, bool);

/// Places of the check where differences agree with `rule`, each with the starts of its range
/// that agree best.
fn sieve(
    rule: Rule,
    few: &Differences,
    many: &Differences,
    active: &[bool],
    seven_bits: bool,
) -> Vec<(Slot, Vec<usize>)> {
    let len = active.len();
    let passed = agreeing(rule, few.of_rule(rule), len, seven_bits, (0..len).collect());
    let mut slots: Vec<Slot> = passed.iter().map(|range| range.slot(len)).collect();
    slots.sort_unstable();
    slots.dedup();
    let mut kept = Vec::new();
    for slot in slots {
        let is_active = |range: &&Range| {
            let covered = range.start..range.start + range.count;
            covered.filter(|column| active[column % len]).count() >= 2
        };
        let of_slot = passed.iter().filter(|range| range.slot(len) == slot).filter(is_active);
        let starts: Vec<usize> = of_slot.map(|range| range.start).collect();
        if starts.is_empty() || !lively(many, slot.0, rule.bytes()) {
            continue;
        }
        let mut counted = agreeing(rule, many.of_rule(rule), len, seven_bits, starts);
        counted.retain(|range| range.slot(len) == slot);
        let best = counted.iter().map(|range| range.share).fold(0.0, f64::max);
        counted.retain(|range| range.share >= best - EQUAL_SHARE);
        kept.push((slot, counted.into_iter().map(|range| range.start).collect()));
    }
    kept
}

/// Whether a column steps evenly. In two frames taken for one, the second counter is the first
/// plus a constant, and that looks like a sum.
fn counts_on(bytes: &[u8], doubles: &[usize], len: usize, at: usize) -> bool {
    let mut steps = [0usize; 256];
    for start in doubles {
        let step = bytes[start + at + len].wrapping_sub(bytes[start + at]);
        steps[usize::from(step)] += 1;
    }
    10 * steps.iter().max().copied().unwrap_or(0) > 9 * doubles.len()
}

/// Whether the check at `at` takes enough different values to be one.
fn lively(many: &Differences, at: usize, width: usize) -> bool {
    let mut values: Vec<u64> =
        many.xor.iter().map(|d| read(&d[at..(at + width).min(d.len())], true, 8)).collect();
    let moved = values.iter().filter(|value| **value != 0).count();
    values.sort_unstable();
    values.dedup();
    4 * moved >= many.xor.len() && values.len() > VALUES_MIN
}

/// How often ranges agree with the check behind them, by start and number of bytes.
struct Tally {
    len: usize,
    width: usize,
    mask: u32,
    /// Pairs that tell anything, and those that agree in either order of the check's bytes.
    told: Vec<u32>,
    big: Vec<u32>,
    little: Vec<u32>,
}

impl Tally {
    fn new(len: usize, width: usize, seven_bits: bool) -> Self {
        let zeros = || vec![0; len * len];
        let mask = if seven_bits { 0x7F } else { u32::MAX };
        Self { len, width, mask, told: zeros(), big: zeros(), little: zeros() }
    }

    fn count(&mut self, rule: Rule, difference: &[u8], starts: &[usize]) {
        match rule {
            Rule::Sum => self.run(difference, starts, |sum, byte| (sum + byte) & 0xFF, |sum| sum),
            Rule::NegSum => {
                self.run(difference, starts, |sum, byte| sum.wrapping_sub(byte) & 0xFF, |sum| sum);
            }
            Rule::Xor => self.run(difference, starts, |sum, byte| sum ^ byte, |sum| sum),
            Rule::Crc(kernel) if kernel.reflected => {
                self.run(difference, starts, |r, byte| kernel.feed_right(r, byte), |r| r);
            }
            Rule::Crc(kernel) => {
                let top = |r| kernel.value(r);
                self.run(difference, starts, |r, byte| kernel.feed_left(r, byte), top);
            }
        }
    }

    /// One register runs through each start's longest range and is compared behind every byte.
    fn run(
        &mut self,
        difference: &[u8],
        starts: &[usize],
        feed: impl Fn(u32, u32) -> u32,
        value: impl Fn(u32) -> u32,
    ) {
        let (len, width) = (self.len, self.width);
        let stored = |big_endian: bool| -> Vec<u32> {
            let number = |digits| u32::try_from(read(digits, big_endian, 8)).unwrap_or(0);
            difference.windows(width).map(|digits| number(digits) & self.mask).collect()
        };
        let (big, little) = (stored(true), stored(false));
        for &start in starts {
            let row = start * len + 1..(start + 1) * len;
            let told = &mut self.told[row.clone()];
            let tallies = told.iter_mut().zip(&mut self.big[row.clone()]);
            let tallies = tallies.zip(&mut self.little[row]);
            let stored = big[start + 1..].iter().zip(&little[start + 1..]);
            let covered = &difference[start..start + len - width];
            let mut state = 0;
            for ((byte, stored), tallies) in covered.iter().zip(stored).zip(tallies) {
                state = feed(state, u32::from(*byte));
                let value = value(state) & self.mask;
                // Two frames with equal checks tell nothing unless the range contradicts them.
                let tells = value | stored.0 != 0;
                *tallies.0.0 += u32::from(tells);
                *tallies.0.1 += u32::from(tells && value == *stored.0);
                *tallies.1 += u32::from(tells && value == *stored.1);
            }
        }
    }

    /// Whether a range from `start` may yet agree in [`AGREE`] of all pairs.
    fn promises(&self, start: usize) -> bool {
        let row = start * self.len..(start + 1) * self.len;
        let hits = self.big[row.clone()].iter().zip(&self.little[row.clone()]);
        self.told[row].iter().zip(hits).any(|(told, (big, little))| {
            let hits = *big.max(little);
            hits >= 2 || (hits == 1 && *told < 6)
        })
    }

    /// Ranges that agree in enough of the pairs.
    fn agreeing(&self, starts: &[usize], pairs: usize) -> Vec<Range> {
        let enough = u32::try_from(pairs / 5).unwrap_or(u32::MAX).max(4);
        let orders: &[bool] = if self.width == 1 { &[true] } else { &[true, false] };
        let mut found = Vec::new();
        for &start in starts {
            for count in 1..=self.len - self.width {
                let cell = start * self.len + count;
                let told = self.told[cell];
                for &big_endian in orders.iter().filter(|_| told >= enough) {
                    let hits = if big_endian { self.big[cell] } else { self.little[cell] };
                    let share = f64::from(hits) / f64::from(told);
                    if share >= AGREE {
                        found.push(Range { start, count, big_endian, share });
                    }
                }
            }
        }
        found
    }
}

/// A range that ends at a check, and the share of pairs in which the two agree.
struct Range {
    start: usize,
    count: usize,
    big_endian: bool,
    share: f64,
}

impl Range {
    fn slot(&self, len: usize) -> Slot {
        ((self.start + self.count) % len, self.big_endian)
    }
}

/// Ranges from `starts` that agree with `rule`. Most rules and starts are done with after a third
/// of the pairs, taken from all over the capture.
fn agreeing(
    rule: Rule,
    differences: &[Vec<u8>],
    len: usize,
    seven_bits: bool,
    mut starts: Vec<usize>,
) -> Vec<Range> {
    let mut tally = Tally::new(len, rule.bytes(), seven_bits);
    for difference in differences.iter().step_by(3) {
        tally.count(rule, difference, &starts);
    }
    starts.retain(|start| tally.promises(*start));
    for (k, difference) in differences.iter().enumerate() {
        if k % 3 != 0 {
            tally.count(rule, difference, &starts);
        }
    }
    tally.agreeing(&starts, differences.len())
}

/// Which algorithms, over which of `starts`, real frames confirm.
fn settle(
    rule: Rule,
    bytes: &[u8],
    doubles: &[usize],
    (len, at, big_endian, seven_bits): (usize, usize, bool, bool),
    starts: &[usize],
) -> Vec<Place> {
    let mut places = Vec::new();
    for &start in starts {
        let count = (at + len - start) % len;
        for kind in kinds_of(rule) {
            let share = share_of(kind, bytes, doubles, (start, count, big_endian, seven_bits));
            if share >= AGREE {
                places.push(Place { kind, start, count, big_endian, share });
            }
        }
    }
    if let (true, Rule::Crc(kernel), Some(&start)) = (places.is_empty(), rule, starts.first()) {
        // Not in the catalogue. For one length any start value will do with the right final XOR.
        let count = (at + len - start) % len;
        places.extend(generic(kernel, bytes, doubles, (start, count, big_endian)));
    }
    places
}

fn kinds_of(rule: Rule) -> Vec<CheckKind> {
    match rule {
        Rule::Sum => vec![CheckKind::Sum8],
        Rule::NegSum => vec![CheckKind::NegSum8],
        Rule::Xor => vec![CheckKind::Xor8],
        Rule::Crc(kernel) => {
            CATALOGUE.iter().filter(|crc| kernel.belongs(crc)).map(|c| CheckKind::Crc(*c)).collect()
        }
    }
}

fn frames_of(doubles: &[usize]) -> impl Iterator<Item = usize> {
    let count = FRAMES.min(doubles.len());
    (0..count).map(move |k| doubles[k * doubles.len() / count])
}

fn share_of(
    kind: CheckKind,
    bytes: &[u8],
    doubles: &[usize],
    (start, count, big_endian, seven_bits): (usize, usize, bool, bool),
) -> f64 {
    let mask = if seven_bits { 0x7F } else { u64::MAX };
    let (mut good, mut all) = (0, 0);
    for frame in frames_of(doubles) {
        let range = &bytes[frame + start..][..count];
        let stored = &bytes[frame + start + count..][..kind.bytes()];
        all += 1;
        good += u32::from(kind.of(range.iter().copied()) & mask == read(stored, big_endian, 8));
    }
    f64::from(good) / f64::from(all.max(1))
}

fn generic(
    kernel: &Kernel,
    bytes: &[u8],
    doubles: &[usize],
    (start, count, big_endian): (usize, usize, bool),
) -> Option<Place> {
    let (width, poly, reflected) = (kernel.width, kernel.poly, kernel.reflected);
    let plain = Crc { name: "generic", width, poly, init: 0, reflected, xorout: 0 };
    frames_of(doubles).take(8).find_map(|frame| {
        let range = bytes[frame + start..][..count].iter().copied();
        let stored = &bytes[frame + start + count..][..width as usize / 8];
        let stored = u32::try_from(read(stored, big_endian, 8)).ok()?;
        let xorout = kernel.crc(&plain, range) ^ stored;
        let kind = CheckKind::Crc(Crc { xorout, ..plain });
        let share = share_of(kind, bytes, doubles, (start, count, big_endian, false));
        (share >= AGREE).then_some(Place { kind, start, count, big_endian, share })
    })
}

/// Ranges usually start behind a sync word of two bytes, or one, or with it; see the order.
fn in_order_of_likelihood(mut places: Vec<Place>, constant: &[bool], len: usize) -> Vec<Place> {
    let rank = |place: &Place| {
        let end = place.at(len) + place.kind.bytes();
        let skipped = (0..len).position(|k| constant[(end + k) % len]).unwrap_or(0);
        let distance = (place.start + 2 * len - end - skipped) % len;
        [2, 1, 0, 4, 3].iter().position(|usual| *usual == distance).unwrap_or(5 + distance)
    };
    let best = places.iter().map(|place| place.share).fold(0.0, f64::max);
    // Chance may let a wrong start agree in a few frames; it never agrees in all.
    places.retain(|place| place.share >= best - 0.1);
    places.sort_by_key(rank);
    places
}
