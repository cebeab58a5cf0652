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
        let once = |channel| RandomStream::new(seed, channel, run).standard_normal();
        let bias_spread = params.turn_on_bias_sigma_rad_s * once(Channel::GyroTurnOnBias);
        let scale_spread = params.scale.turn_on_sigma * once(Channel::GyroTurnOnScale);
        Ok(Self {
            responder: Responder::new(&params.response, params.sample_rate_hz, params.sampling),
            scale: 1.0 + params.scale.error + scale_spread,
            bend: Bend::new(params.linearity, params.rate_max_rad_s),
            bias_rad_s: params.bias_rad_s + bias_spread,
            drift: Drift::new(&params, seed, run),
            white_sigma_rad_s: params.noise_sigma_rad_s(),
            white: RandomStream::new(seed, Channel::GyroAngleRandomWalk, run),
            counts_at_range: params.counts_at_range(),
            held_rad_s: None,
            remainder: 0.0,
            last: (Counts::default(), false),
            params,
            seed,
            run,
        })
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
    pub fn sample(&mut self, input: impl Into<GyroInput>) -> GyroReading {
        self.sample_upset(input, &Upset::default())
    }

    /// The next sample, with a fault acting on it.
    pub fn sample_upset(&mut self, input: impl Into<GyroInput>, upset: &Upset) -> GyroReading {
        let input = input.into();
        let finite = input.is_finite();
        let white = self.white_sigma_rad_s * self.white.standard_normal() * upset.noise_factor;
        let drift_rad_s = self.drift.step();
        // A noise that overflows must not stay in the filter.
        let filtered = self.params.response.noise_before_filter && white.abs() < RATE_RAD_S_MAX;
        let (before, behind) = if filtered { (white, 0.0) } else { (0.0, white) };
        let passed_rad_s = self.respond(&input, before);
        let scaled_rad_s = passed_rad_s * self.scale_at(passed_rad_s, &input);
        let rate_rad_s = self.bend.apply(scaled_rad_s * upset.scale_factor)
            + self.bias_rad_s
            + self.params.bias_effects.of(&input, self.params.reference_temperature_deg_c)
            + drift_rad_s
            + upset.bias_rad_s
            + behind;
        let usable = (finite && rate_rad_s.is_finite()).then_some(rate_rad_s);
        self.reading(usable, &input, upset)
    }

    /// What passes delay and band limit.
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
    fn scale_at(&self, rate_rad_s: f64, input: &GyroInput) -> f64 {
        let scale = &self.params.scale;
        let warmer_deg_c = input.temperature_deg_c - self.params.reference_temperature_deg_c;
        self.scale
            + scale.per_deg_c * warmer_deg_c
            + 0.5 * scale.asymmetry.copysign(scale.asymmetry * rate_rad_s)
    }

    /// The rate in counts with its flags; none is an invalid reading.
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
    fn counts_of(&mut self, rate_rad_s: f64) -> Counts {
        let limit = f64::from(self.counts_at_range);
        let exact = rate_rad_s / self.params.lsb_rad_s + self.remainder;
        let clipped = exact.clamp(-limit, limit);
        let counts = rounded(clipped, self.params.rounding);
        if self.params.rounding == Rounding::Angle {
            // What saturation cuts off is lost.
            let is_clipped = exact.abs() > limit + 0.5;
            self.remainder = if is_clipped { 0.0 } else { exact - f64::from(counts) };
        }
        Counts(counts)
    }
}

/// The nearest whole number. Ties go away from zero, but of angles to even: a remainder of one half
/// would otherwise go back and forth for ever. Integer conversions, because `round` is a call into
/// the C library on plain x86-64 and costs as much as two normal numbers.
fn rounded(exact: f64, rounding: Rounding) -> i32 {
    #[expect(clippy::cast_possible_truncation, reason = "towards zero; within ±i32 by the caller")]
    let whole = exact as i32;
    let rest = exact - f64::from(whole);
    let is_odd = whole & 1 != 0;
    let up_at_half = rounding == Rounding::Rate || is_odd;
    let beyond = rest.abs() > 0.5 || (up_at_half && rest.abs() >= 0.5);
    let away = if exact < 0.0 { -1 } else { 1 };
    if beyond { whole + away } else { whole }
}

/// The rate to go on with, if the input holds one.
fn usable_rate(input: &GyroInput) -> Option<f64> {
    let rate_rad_s = input.rate_rad_s;
    rate_rad_s.is_finite().then(|| rate_rad_s.clamp(-RATE_RAD_S_MAX, RATE_RAD_S_MAX))
}

impl BiasEffects {
    /// What the surroundings of one sample add to the bias, rad/s.
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
            half in -4_000_000_i32..4_000_000,
            off in prop_oneof![Just(0.0), Just(f64::EPSILON), Just(-f64::EPSILON), -1.0..1.0],
        ) {
            let exact = 0.5 * f64::from(half) * (1.0 + off);
            let same = |counts: i32, library: f64| (f64::from(counts) - library).abs() < 0.5;
            prop_assert!(same(rounded(exact, Rounding::Rate), exact.round()), "{exact}");
            let to_even = exact.round_ties_even();
            prop_assert!(same(rounded(exact, Rounding::Angle), to_even), "{exact}");
        }
    }

    #[test]
    fn just_below_a_half_rounds_to_none() {
        for rounding in [Rounding::Rate, Rounding::Angle] {
            assert_eq!(rounded(0.5_f64.next_down(), rounding), 0);
            assert_eq!(rounded(-(0.5_f64.next_down()), rounding), 0);
        }
        assert_eq!(rounded(f64::from(i32::MAX), Rounding::Rate), i32::MAX);
        assert_eq!(rounded(-f64::from(i32::MAX), Rounding::Angle), -i32::MAX);
    }
}
