//! One gyro axis, sampled.

use crate::drift::Drift;
use crate::linearity::Bend;
use crate::response::Responder;
use crate::{BiasEffects, GyroInput, GyroParams, Rail, Rounding, SampleClock, Sampling, Upset};
use struna_kernel::{
    Channel, Counts, GyroReading, ParameterError, RandomStream, ReadingFlags, SampleGrid, Seed,
};

/// Faster than this nothing turns, rad/s; a larger input would be lost in the filter for minutes.
const RATE_RAD_S_MAX: f64 = 1e9;

/// One gyro axis in one run.
///
/// The rate about the input axis passes delay and band limit, the scale factor, its bend, the
/// biases and noises, and is clipped at full scale and rounded to counts, in this order. Every
/// random term has a stream of its own and draws for every sample, clipped or invalid ones
/// included, so that the numbers of sample *k* never depend on the rates before it.
#[derive(Debug, Clone)]
pub struct Gyro {
    params: GyroParams,
    seed: Seed,
    run: u64,
    responder: Responder,
    /// Scale factor of this run at the reference temperature.
    scale: f64,
    bend: Bend,
    bias_rad_s: f64,
    drift: Drift,
    white_sigma_rad_s: f64,
    white: RandomStream,
    counts_at_range: i32,
    /// Counts per rate: what divides here divides once.
    counts_per_rad_s: f64,
    /// Last usable rate, none before the first.
    held_rad_s: Option<f64>,
    /// What rounding left of the angle so far, in counts.
    remainder: f64,
    last: (Counts, bool),
}

impl Gyro {
    /// A gyro in run `run` of the campaign `seed`, with the bias and scale factor that this run
    /// draws.
    ///
    /// # Errors
    /// [`ParameterError`] for the first parameter that no gyro can have.
    pub fn new(params: GyroParams, seed: Seed, run: u64) -> Result<Self, ParameterError> {
        params.validate()?;
        Ok(Self::drawn(params, seed, run))
    }

    /// The gyro about another axis of the same case: the same parameters in the same run, and
    /// every random number from a stream of its own. Axis 0 is this one.
    ///
    /// Streams are told apart by the two highest bits of the run, which no campaign counts up to.
    #[must_use]
    pub fn about_axis(&self, axis: u8) -> Self {
        Self::drawn(self.params, self.seed, self.run ^ (u64::from(axis & 3) << 62))
    }

    /// A gyro whose parameters are known to be possible.
    fn drawn(params: GyroParams, seed: Seed, run: u64) -> Self {
        let once = |channel| RandomStream::new(seed, channel, run).standard_normal();
        let bias_spread = params.turn_on_bias_sigma_rad_s * once(Channel::GyroTurnOnBias);
        let scale_spread = params.scale.turn_on_sigma * once(Channel::GyroTurnOnScale);
        Self {
            responder: Responder::new(&params.response, params.sample_rate_hz, params.sampling),
            scale: 1.0 + params.scale.error + scale_spread,
            bend: Bend::new(params.linearity, params.rate_max_rad_s),
            bias_rad_s: params.bias_rad_s + bias_spread,
            drift: Drift::new(&params, seed, run),
            white_sigma_rad_s: params.noise_sigma_rad_s(),
            white: RandomStream::new(seed, Channel::GyroAngleRandomWalk, run),
            counts_at_range: params.counts_at_range(),
            // Finite of the smallest numbers as well, so that no rate stays no counts.
            counts_per_rad_s: params.lsb_rad_s.recip().min(f64::MAX),
            held_rad_s: None,
            remainder: 0.0,
            last: (Counts::default(), false),
            params,
            seed,
            run,
        }
    }

    /// The parameters as given.
    #[must_use]
    pub fn params(&self) -> &GyroParams {
        &self.params
    }

    /// The bias of this run at the start, constant plus turn-on and without warm-up, rad/s: truth
    /// that only a score may look at.
    #[must_use]
    pub fn bias_rad_s(&self) -> f64 {
        self.bias_rad_s
    }

    /// Whether inputs are to be mean rates over the sample interval. A gyro with a band limit
    /// takes means even when it samples instantaneously: its filter sees the whole interval.
    #[must_use]
    pub fn takes_means(&self) -> bool {
        self.params.sampling == Sampling::Mean || self.params.response.natural_frequency_hz > 0.0
    }

    /// The clock of this run, which means to sample on `grid`.
    #[must_use]
    pub fn clock(&self, grid: SampleGrid) -> SampleClock {
        SampleClock::new(grid, &self.params.clock, self.seed, self.run)
    }

    /// The next sample: of a [`GyroInput`], or of a rate alone.
    ///
    /// An input that is not finite yields a reading marked invalid with zero counts, and leaves
    /// the gyro as if the rate before had lasted.
    #[inline]
    pub fn sample(&mut self, input: impl Into<GyroInput>) -> GyroReading {
        self.sample_upset(input, &Upset::default())
    }

    /// The next sample, with a fault acting on it.
    #[inline]
    pub fn sample_upset(&mut self, input: impl Into<GyroInput>, upset: &Upset) -> GyroReading {
        self.advance(&input.into(), upset)
    }

    /// One sample on. Not generic, so that it is compiled once, here, with all that it calls; the
    /// input by reference, because a copy made just before is slow to read.
    fn advance(&mut self, input: &GyroInput, upset: &Upset) -> GyroReading {
        let white = self.white_sigma_rad_s * self.white.standard_normal() * upset.noise_factor;
        let drift_rad_s = self.drift.step();
        // A noise that overflows must not stay in the filter.
        let filtered = self.params.response.noise_before_filter && white.abs() < RATE_RAD_S_MAX;
        let (before, behind) = if filtered { (white, 0.0) } else { (0.0, white) };
        let passed_rad_s = self.respond(input, before);
        let scaled_rad_s = passed_rad_s * self.scale_at(passed_rad_s, input);
        let rate_rad_s = self.bend.apply(scaled_rad_s * upset.scale_factor)
            + self.bias_rad_s
            + self.params.bias_effects.of(input, self.params.reference_temperature_deg_c)
            + drift_rad_s
            + upset.bias_rad_s
            + behind;
        // The rate's own finiteness is asked for because the last one stands in for it. Each other
        // number is a term of the sum, times zero at least, and spoils it unless it is finite.
        let usable = input.rate_rad_s.is_finite() && rate_rad_s.is_finite();
        self.reading(usable.then_some(rate_rad_s), input, upset)
    }

    /// What passes delay and band limit.
    #[inline]
    fn respond(&mut self, input: &GyroInput, noise_rad_s: f64) -> f64 {
        let held_rad_s = match self.held_rad_s {
            Some(held_rad_s) => held_rad_s,
            None => {
                let start_rad_s = usable_rate(input).unwrap_or_default();
                self.responder.settle(start_rad_s);
                start_rad_s
            }
        };
        let rate_rad_s = usable_rate(input).unwrap_or(held_rad_s);
        self.held_rad_s = Some(rate_rad_s);
        self.responder.step(rate_rad_s, noise_rad_s)
    }

    /// Counts per rate over their nominal value, at the sign of the rate.
    #[inline]
    fn scale_at(&self, rate_rad_s: f64, input: &GyroInput) -> f64 {
        let scale = &self.params.scale;
        let warmer_deg_c = input.temperature_deg_c - self.params.reference_temperature_deg_c;
        self.scale
            + scale.per_deg_c * warmer_deg_c
            + 0.5 * scale.asymmetry.copysign(scale.asymmetry * rate_rad_s)
    }

    /// The rate in counts with its flags; none is an invalid reading.
    #[inline]
    fn reading(
        &mut self,
        rate_rad_s: Option<f64>,
        input: &GyroInput,
        upset: &Upset,
    ) -> GyroReading {
        let measured = rate_rad_s.map_or_else(Default::default, |rate_rad_s| {
            let over_range = rate_rad_s.abs() > self.params.rate_max_rad_s;
            (self.counts_of(rate_rad_s), over_range)
        });
        let mut valid = rate_rad_s.is_some();
        let (counts, over_range) = match upset.railed {
            _ if upset.stuck => self.last,
            Some(Rail::Positive) => (Counts(self.counts_at_range), true),
            Some(Rail::Negative) => (Counts(-self.counts_at_range), true),
            None => measured,
        };
        valid |= upset.stuck || upset.railed.is_some();
        self.last = (counts, over_range);
        let flags = ReadingFlags {
            valid,
            over_range,
            warm_up: self.drift.is_warming_up(),
            temperature_valid: input.temperature_deg_c.is_finite(),
        };
        GyroReading { counts, temperature_deg_c: input.temperature_deg_c, flags }
    }

    /// Clips at full scale and rounds to the nearest count.
    #[inline]
    fn counts_of(&mut self, rate_rad_s: f64) -> Counts {
        let limit = f64::from(self.counts_at_range);
        let exact = rate_rad_s * self.counts_per_rad_s + self.remainder;
        let whole = rounded(exact.clamp(-limit, limit));
        if self.params.rounding == Rounding::Angle {
            // What saturation cuts off is lost.
            let is_clipped = exact.abs() > limit + 0.5;
            self.remainder = if is_clipped { 0.0 } else { exact - whole };
        }
        #[expect(clippy::cast_possible_truncation, reason = "a whole number within ±i32 by clamp")]
        let counts = whole as i32;
        Counts(counts)
    }
}

/// The nearest whole number, ties to even, of a number within ±2⁵¹.
///
/// By the spacing of `f64` beyond 2⁵², which is one: the standard library's rounding is a call into
/// the C library on plain x86-64, and a branch on the remainder is missed every other time.
#[inline]
fn rounded(exact: f64) -> f64 {
    const SPACING_ONE: f64 = 1.5 * (1_u64 << 52) as f64;
    (exact + SPACING_ONE) - SPACING_ONE
}

/// The rate to go on with, if the input holds one.
#[inline]
fn usable_rate(input: &GyroInput) -> Option<f64> {
    let rate_rad_s = input.rate_rad_s;
    rate_rad_s.is_finite().then(|| rate_rad_s.clamp(-RATE_RAD_S_MAX, RATE_RAD_S_MAX))
}

impl BiasEffects {
    /// What the surroundings of one sample add to the bias, rad/s.
    #[inline]
    fn of(&self, input: &GyroInput, reference_temperature_deg_c: f64) -> f64 {
        let [x, y, z] = self.per_specific_force_s_m;
        let [along_x, along_y, along_z] = input.specific_force_s_m_s2;
        self.per_deg_c_rad_s * (input.temperature_deg_c - reference_temperature_deg_c)
            + self.per_temperature_rate_rad_deg_c * input.temperature_rate_deg_c_s
            + (x * along_x + y * along_y + z * along_z)
            + self.per_magnetic_field_rad_s_t * input.magnetic_field_t
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn rounding_is_that_of_the_standard_library(
            half in -4_294_967_296_i64..4_294_967_296,
            off in prop_oneof![Just(0.0), Just(f64::EPSILON), Just(-f64::EPSILON), -1.0..1.0],
        ) {
            let exact = 0.5 * half as f64 * (1.0 + off);
            // Zeros of both signs are one.
            prop_assert!((rounded(exact) - exact.round_ties_even()).abs() == 0.0, "{exact}");
        }
    }

    #[test]
    fn gyros_about_other_axes_draw_everything_anew_and_the_first_as_ever() {
        let mut main = Gyro::new(crate::preset::vg910d(), Seed(3), 5).unwrap();
        let mut axes = [0, 1, 2].map(|axis| main.about_axis(axis));
        let biases = axes.each_ref().map(|gyro| gyro.bias_rad_s().to_bits());
        assert_eq!(biases[0], main.bias_rad_s().to_bits());
        assert!(biases[1] != biases[0] && biases[2] != biases[0] && biases[1] != biases[2]);
        let mut same = [[0; 3]; 3];
        for _ in 0..1000 {
            let of_main = main.sample(0.1);
            let of_axes = axes.each_mut().map(|gyro| gyro.sample(0.1));
            assert_eq!(of_axes[0], of_main);
            for (a, row) in same.iter_mut().enumerate() {
                for (b, count) in row.iter_mut().enumerate() {
                    *count += u32::from(of_axes[a].counts == of_axes[b].counts);
                }
            }
        }
        // Noise of 665 counts: one sample in 2400 agrees by chance.
        for (a, row) in same.iter().enumerate() {
            for (b, count) in row.iter().enumerate() {
                assert!(if a == b { *count == 1000 } else { *count < 10 }, "{a} {b}: {count}");
            }
        }
    }

    #[test]
    fn one_number_that_is_none_spoils_a_reading_of_a_gyro_that_feels_nothing_of_it() {
        let mut gyro = Gyro::new(GyroParams::exact(100.0, 1.0, 1e-3, 2000), Seed(1), 0).unwrap();
        let sound = GyroInput::from(0.1);
        assert!(gyro.sample(sound).flags.valid);
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut spoilt = [sound; 7];
            spoilt[0].rate_rad_s = bad;
            for axis in 0..3 {
                spoilt[1 + axis].specific_force_s_m_s2[axis] = bad;
            }
            spoilt[4].temperature_deg_c = bad;
            spoilt[5].temperature_rate_deg_c_s = bad;
            spoilt[6].magnetic_field_t = bad;
            for input in spoilt {
                let reading = gyro.sample(input);
                assert!(!reading.flags.valid && reading.counts == Counts(0), "{input:?}");
            }
        }
        assert_eq!(gyro.sample(sound).counts, Counts(100));
    }

    #[test]
    fn the_smallest_numbers_are_counted_and_keep_nothing_that_is_none() {
        let lsb_rad_s = f64::MIN_POSITIVE / 4.0;
        let exact = GyroParams::exact(100.0, 64.0 * lsb_rad_s, lsb_rad_s, 64);
        let linearity = crate::Linearity { nonlinearity: 0.1, ..exact.linearity };
        let params = GyroParams { rounding: Rounding::Angle, linearity, ..exact };
        let mut gyro = Gyro::new(params, Seed(1), 0).unwrap();
        let read = [0.0, 1.0, 0.0, f64::MAX, 0.0].map(|rate| gyro.sample(rate));
        assert!(read.iter().all(|reading| reading.flags.valid), "{read:?}");
        assert_eq!(read.map(|reading| reading.counts.0), [0, 64, 0, 64, 0]);
    }

    #[test]
    fn just_below_a_half_rounds_to_none() {
        assert!(rounded(0.5_f64.next_down()) == 0.0 && rounded(0.5) == 0.0);
        let up = [0.5_f64.next_up(), 1.5].map(|half| rounded(half).to_bits());
        assert_eq!(up, [1.0_f64, 2.0].map(f64::to_bits));
    }
}
