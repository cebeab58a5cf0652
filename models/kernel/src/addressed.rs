//! Random numbers with addresses: the value at an index, whatever was drawn before it.

use crate::{Channel, Seed, random};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Values kept at once: a seek costs as much as a dozen values, so sequential readers seek once
/// for each of these blocks.
const BLOCK: usize = 64;
/// One value takes two of the generator's 32-bit words.
const WORDS_PER_VALUE: u128 = 2;

/// A reproducible sequence of random numbers that can be read at any index.
///
/// One 64-bit ChaCha8 word per index, keyed like [`crate::RandomStream`] by seed, channel and run,
/// so a value depends on its address alone: not on the order of reading, the thread, or the length
/// of the run. Noise on a fixed grid needs this, for then neither the integrator's step nor the
/// number of bodies changes the path of any of them. Rejection methods such as the ziggurat spend
/// a varying number of words on each number and have no addresses; hence the inverse of the normal
/// distribution here.
#[derive(Debug, Clone)]
pub struct AddressedRandom {
    generator: ChaCha8Rng,
    /// Number of the block held, none before the first reading.
    block: Option<u64>,
    words: [u64; BLOCK],
}

impl AddressedRandom {
    /// Opens the sequence of `channel` in run `run` of the campaign `seed`.
    #[must_use]
    pub fn new(seed: Seed, channel: Channel, run: u64) -> Self {
        Self { generator: random::generator(seed, channel, run), block: None, words: [0; BLOCK] }
    }

    /// 64 random bits.
    pub fn word(&mut self, index: u64) -> u64 {
        self.words_from(index)[0]
    }

    /// A number uniform in the open interval (0, 1): an odd multiple of 2⁻⁵³, so the distance to
    /// one is as exact as the number itself.
    pub fn uniform(&mut self, index: u64) -> f64 {
        uniform_of(self.word(index))
    }

    /// A standard normal number (mean 0, variance 1), at most 8.3 in size because
    /// [`uniform`](Self::uniform) stays 2⁻⁵³ away from its ends.
    pub fn standard_normal(&mut self, index: u64) -> f64 {
        normal_quantile(self.uniform(index))
    }

    /// The standard normal numbers from index `first` on: to the bit those of
    /// [`standard_normal`](Self::standard_normal), some at a time and so at a lower price.
    pub fn fill_standard_normal(&mut self, first: u64, mut numbers: &mut [f64]) {
        let mut index = first;
        while !numbers.is_empty() {
            let words = self.words_from(index);
            let (filled, left) = numbers.split_at_mut(words.len().min(numbers.len()));
            for (words, numbers) in words.chunks(LANES).zip(filled.chunks_mut(LANES)) {
                let mut probabilities = [0.5; LANES];
                for (probability, word) in probabilities.iter_mut().zip(words) {
                    *probability = uniform_of(*word);
                }
                let quantiles = normal_quantiles(&probabilities);
                numbers.copy_from_slice(&quantiles[..numbers.len()]);
            }
            index = index.wrapping_add(filled.len() as u64);
            numbers = left;
        }
    }

    /// The word at `index` and all after it in its block.
    #[inline]
    fn words_from(&mut self, index: u64) -> &[u64] {
        let block = index / BLOCK as u64;
        if self.block != Some(block) {
            self.read_block(block);
        }
        #[expect(clippy::cast_possible_truncation, reason = "the remainder is below BLOCK")]
        let place = (index % BLOCK as u64) as usize;
        &self.words[place..]
    }

    #[inline(never)]
    fn read_block(&mut self, block: u64) {
        let first = u128::from(block) * BLOCK as u128;
        self.generator.set_word_pos(first * WORDS_PER_VALUE);
        let mut bytes = [0; BLOCK * size_of::<u64>()];
        self.generator.fill_bytes(&mut bytes);
        for (word, bytes) in self.words.iter_mut().zip(bytes.as_chunks().0) {
            *word = u64::from_le_bytes(*bytes);
        }
        self.block = Some(block);
    }
}

/// (w + ½)·2⁻⁵² with w the upper 52 bits of `word`: see [`AddressedRandom::uniform`].
///
/// Written into the fraction of a number between one and two, w needs no conversion. That of
/// x86-64 waits for whatever was last in its register, and so one normal number for the other.
#[inline(always)]
fn uniform_of(word: u64) -> f64 {
    const ONE: u64 = 1.0_f64.to_bits();
    const HALF_SPACING: f64 = 1.0 / (1_u64 << 53) as f64;
    // Neither difference nor sum rounds: both are multiples of 2⁻⁵³ below one.
    f64::from_bits(ONE | (word >> 12)) - 1.0 + HALF_SPACING
}

/// Half width of the centre, in probability, where no logarithm is needed.
const CENTRE: f64 = 0.425;
/// √(−ln p) at which the two rational approximations of the tail meet.
const FAR_TAIL: f64 = 5.0;

/// Quantiles found at once: what fits in vector registers with both polynomials.
const LANES: usize = 8;

/// [`normal_quantile`] of each, the centres side by side.
fn normal_quantiles(probabilities: &[f64; LANES]) -> [f64; LANES] {
    let offsets = probabilities.map(|probability| probability - 0.5);
    let squares = offsets.map(|offset| CENTRE * CENTRE - offset * offset);
    let (over, under) = (polynomials(&CENTRE_OVER, &squares), polynomials(&CENTRE_UNDER, &squares));
    let mut quantiles = [0.0; LANES];
    for lane in 0..LANES {
        quantiles[lane] = offsets[lane] * over[lane] / under[lane];
    }
    for lane in 0..LANES {
        if offsets[lane].abs() > CENTRE {
            quantiles[lane] = tail_quantile(probabilities[lane]);
        }
    }
    quantiles
}

/// [`polynomial`] of each.
#[inline(always)]
fn polynomials(coefficients: &[f64; 8], x: &[f64; LANES]) -> [f64; LANES] {
    let mut sums = [coefficients[0]; LANES];
    for coefficient in &coefficients[1..] {
        for (sum, x) in sums.iter_mut().zip(x) {
            *sum = *sum * x + coefficient;
        }
    }
    sums
}

/// The inverse of the standard normal distribution function at a probability in (0, 1), to about
/// 1e-16 relative.
///
/// The logarithm of the tails is not the platform's, because its last bit differs between
/// platforms and the bits of records must not.
///
/// # Source
/// Wichura, *Algorithm AS 241: The Percentage Points of the Normal Distribution*, Applied
/// Statistics 37, 1988, routine `PPND16`.
#[inline(always)]
fn normal_quantile(probability: f64) -> f64 {
    let offset = probability - 0.5;
    if offset.abs() <= CENTRE {
        let r = CENTRE * CENTRE - offset * offset;
        return offset * polynomial(&CENTRE_OVER, r) / polynomial(&CENTRE_UNDER, r);
    }
    tail_quantile(probability)
}

/// [`normal_quantile`] beyond the centre.
fn tail_quantile(probability: f64) -> f64 {
    let offset = probability - 0.5;
    let tail = if offset < 0.0 { probability } else { 1.0 - probability };
    let depth = (-libm::log(tail)).sqrt();
    let size = if depth <= FAR_TAIL {
        let r = depth - 1.6;
        polynomial(&NEAR_OVER, r) / polynomial(&NEAR_UNDER, r)
    } else {
        let r = depth - FAR_TAIL;
        polynomial(&FAR_OVER, r) / polynomial(&FAR_UNDER, r)
    };
    size.copysign(offset)
}

/// Horner's scheme; the highest power comes first.
fn polynomial(coefficients: &[f64; 8], x: f64) -> f64 {
    coefficients.iter().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

// Published to 21 digits, each rounded once to the nearest `f64`; the highest power comes first.

const CENTRE_OVER: [f64; 8] = [
    2_509.080_928_730_122_7,
    33_430.575_583_588_13,
    67_265.770_927_008_7,
    45_921.953_931_549_87,
    13_731.693_765_509_46,
    1_971.590_950_306_551_3,
    133.141_667_891_784_38,
    3.387_132_872_796_366_5,
];
const CENTRE_UNDER: [f64; 8] = [
    5_226.495_278_852_854,
    28_729.085_735_721_943,
    39_307.895_800_092_71,
    21_213.794_301_586_597,
    5_394.196_021_424_751,
    687.187_007_492_057_9,
    42.313_330_701_600_91,
    1.0,
];
const NEAR_OVER: [f64; 8] = [
    0.000_774_545_014_278_341_4,
    0.022_723_844_989_269_184,
    0.241_780_725_177_450_6,
    1.270_458_252_452_368_4,
    3.647_848_324_763_204_5,
    5.769_497_221_460_691,
    4.630_337_846_156_546,
    1.423_437_110_749_683_5,
];
const NEAR_UNDER: [f64; 8] = [
    1.050_750_071_644_416_9e-9,
    0.000_547_593_808_499_534_5,
    0.015_198_666_563_616_457,
    0.148_103_976_427_480_08,
    0.689_767_334_985_1,
    1.676_384_830_183_803_8,
    2.053_191_626_637_759,
    1.0,
];
const FAR_OVER: [f64; 8] = [
    2.010_334_399_292_288_1e-7,
    2.711_555_568_743_487_6e-5,
    0.001_242_660_947_388_078_4,
    0.026_532_189_526_576_124,
    0.296_560_571_828_504_87,
    1.784_826_539_917_291_3,
    5.463_784_911_164_114,
    6.657_904_643_501_103,
];
const FAR_UNDER: [f64; 8] = [
    2.044_263_103_389_939_7e-15,
    1.421_511_758_316_446e-7,
    1.846_318_317_510_054_8e-5,
    0.000_786_869_131_145_613_3,
    0.014_875_361_290_850_615,
    0.136_929_880_922_735_8,
    0.599_832_206_555_888,
    1.0,
];

#[cfg(test)]
mod tests {
    use super::*;

    fn open(seed: u64, channel: Channel, run: u64) -> AddressedRandom {
        AddressedRandom::new(Seed(seed), channel, run)
    }

    fn first_words(mut sequence: AddressedRandom) -> Vec<u64> {
        (0..8).map(|index| sequence.word(index)).collect()
    }

    #[test]
    fn a_value_depends_on_its_address_and_not_on_the_order_of_reading() {
        let mut forwards = open(7, Channel::TorqueNoise, 3);
        let expected: Vec<u64> = (0..1000).map(|index| forwards.word(index)).collect();
        let mut backwards = open(7, Channel::TorqueNoise, 3);
        // 617 and 1000 have no common factor: every index once, and no two in one block in a row.
        for index in (0..1000).rev().map(|k| k * 617 % 1000) {
            let place = usize::try_from(index).unwrap();
            assert_eq!(backwards.word(index), expected[place], "index {index}");
        }
    }

    #[test]
    fn the_words_are_those_of_the_generator_in_its_own_order() {
        let mut plain = random::generator(Seed(7), Channel::TorqueNoise, 3);
        let mut sequence = open(7, Channel::TorqueNoise, 3);
        for index in 0..300 {
            assert_eq!(sequence.word(index), plain.next_u64(), "index {index}");
        }
    }

    #[test]
    fn addresses_reach_to_the_end_without_wrapping() {
        let mut sequence = open(7, Channel::TorqueNoise, 3);
        let far = [0, 1 << 32, 1 << 62, 1 << 63, u64::MAX].map(|index| sequence.word(index));
        for (k, word) in far.iter().enumerate() {
            assert!(!far[..k].contains(word), "{far:x?}");
        }
    }

    #[test]
    fn seed_channel_and_run_each_change_the_sequence() {
        let all = [
            first_words(open(7, Channel::TorqueNoise, 0)),
            first_words(open(8, Channel::TorqueNoise, 0)),
            first_words(open(7, Channel::ImpulseTime, 0)),
            first_words(open(7, Channel::ImpulseSize, 0)),
            first_words(open(7, Channel::StartError, 0)),
            first_words(open(7, Channel::TorqueNoise, 1)),
        ];
        for (k, words) in all.iter().enumerate() {
            assert!(!all[..k].contains(words), "sequence {k} repeats an earlier one");
        }
    }

    #[test]
    fn a_uniform_number_is_the_middle_of_its_cell() {
        for word in [0, 1 << 11, 1 << 12, 1 << 63, 0x0123_4567_89ab_cdef, u64::MAX - 4096, u64::MAX]
        {
            let cell = (word >> 12) as f64;
            let expected = (cell + 0.5) / (1_u64 << 52) as f64;
            assert_eq!(uniform_of(word).to_bits(), expected.to_bits(), "{word:x}");
        }
    }

    #[test]
    fn uniform_numbers_fill_the_open_interval_evenly() {
        let n = 200_000_u32;
        let mut sequence = open(1, Channel::ImpulseTime, 0);
        let draws: Vec<f64> = (0..u64::from(n)).map(|index| sequence.uniform(index)).collect();
        assert!(draws.iter().all(|u| 0.0 < *u && *u < 1.0));
        let n = f64::from(n);
        let moment = |power| draws.iter().map(|u| (u - 0.5).powi(power)).sum::<f64>() / n;
        // Four standard errors: √(1/12n) for the mean, √(1/180n) for the variance.
        assert!(moment(1).abs() < 4.0 / (12.0 * n).sqrt(), "{}", moment(1));
        assert!((moment(2) - 1.0 / 12.0).abs() < 4.0 / (180.0 * n).sqrt(), "{}", moment(2));
    }

    #[test]
    fn normal_numbers_have_the_first_four_moments_of_the_normal_distribution() {
        let n = 200_000_u32;
        let mut sequence = open(1, Channel::TorqueNoise, 0);
        let draws: Vec<f64> =
            (0..u64::from(n)).map(|index| sequence.standard_normal(index)).collect();
        let n = f64::from(n);
        let moment = |power| draws.iter().map(|x: &f64| x.powi(power)).sum::<f64>() / n;
        // Four standard errors of each: the mean of x^k has variance (E x^2k − (E x^k)²)/n.
        for (power, expected, variance) in
            [(1, 0.0, 1.0), (2, 1.0, 2.0), (3, 0.0, 15.0), (4, 3.0, 96.0_f64)]
        {
            let off = moment(power) - expected;
            assert!(off.abs() < 4.0 * (variance / n).sqrt(), "moment {power}: off by {off}");
        }
    }

    #[test]
    fn normal_numbers_filled_in_are_those_of_their_addresses_to_the_bit() {
        let (mut one_by_one, mut filled) =
            (open(5, Channel::TorqueNoise, 0), open(5, Channel::TorqueNoise, 0));
        // Whole lanes, parts of them, across blocks of words, and nothing at all; of some
        // thousand numbers a seventh lies in the tails.
        let mut in_tails = 0;
        for (first, length) in [(0, 1000), (3, 1), (61, 7), (1 << 40, 129), (9, 0), (u64::MAX, 1)] {
            let mut numbers = vec![f64::NAN; length];
            filled.fill_standard_normal(first, &mut numbers);
            for (index, number) in (first..=u64::MAX).zip(&numbers) {
                let expected = one_by_one.standard_normal(index);
                assert_eq!(number.to_bits(), expected.to_bits(), "index {index}");
                in_tails += i32::from(number.abs() > 1.5);
            }
        }
        assert!(in_tails > 100, "{in_tails}");
    }

    #[test]
    fn neighbours_are_uncorrelated() {
        let n = 100_000_u32;
        let mut sequence = open(2, Channel::TorqueNoise, 0);
        let mut product = |lag: u64| {
            let pair = |k| sequence.standard_normal(k) * sequence.standard_normal(k + lag);
            (0..u64::from(n)).map(pair).sum::<f64>() / f64::from(n)
        };
        for lag in [1, 2, 3, 64] {
            // Four standard errors, 1/√n each.
            let correlation = product(lag);
            assert!(correlation.abs() < 4.0 / f64::from(n).sqrt(), "lag {lag}: {correlation}");
        }
    }

    #[test]
    fn the_quantile_meets_published_check_values() {
        // The first three are Wichura's, the last is in every table.
        for (probability, expected) in [
            (0.25, -0.674_489_750_196_081_7),
            (0.001, -3.090_232_306_167_813),
            (1e-20, -9.262_340_089_798_408),
            (0.975, 1.959_963_984_540_054),
        ] {
            let quantile = normal_quantile(probability);
            // Published to 1 part in 1e16; eight terms over eight round to a few times that.
            let off = (quantile / expected - 1.0).abs();
            assert!(off < 4.0 * f64::EPSILON, "{probability}: off by {off:e}");
        }
    }

    #[test]
    fn the_quantile_is_odd_about_one_half_to_the_bit() {
        assert_eq!(normal_quantile(0.5).to_bits(), 0.0_f64.to_bits());
        for k in 1..2048_u32 {
            // Multiples of 1/4096: the complement is exact.
            let p = f64::from(k) / 4096.0;
            assert_eq!(normal_quantile(p).to_bits(), (-normal_quantile(1.0 - p)).to_bits(), "{p}");
        }
    }

    #[test]
    fn the_quantile_climbs_through_the_seams_of_its_three_pieces() {
        for seam in [0.5 - CENTRE, (-FAR_TAIL * FAR_TAIL).exp()] {
            let around =
                [-1e-9, -1e-12, 1e-12, 1e-9].map(|off| normal_quantile(seam * (1.0 + off)));
            assert!(around.is_sorted(), "{seam}: {around:?}");
            // The slope is 1/φ(x), at most 1/(p·|x|): 2e-9 of p moves x by less than 2e-9/1.4.
            assert!(around[3] - around[0] < 2e-9, "{seam}: {around:?}");
        }
    }
}
