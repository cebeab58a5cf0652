//! Every limit, from what is declared.

use super::Declared;
use super::innovation::{Follower, Gains};
use super::noise::NoiseShape;
use struna_kernel::{Channel, ParameterError, RandomStream, Seed};

/// Room above what sound data reach.
const ROOM: f64 = 1.2;
/// Deviations that noise stays within for thousands of hours.
const SIGMAS: f64 = 6.0;
/// Deviations to expect beside a jolt, which is rare itself.
const SIGMAS_BESIDE: f64 = 3.0;
/// The variance sum of sound white noise passes h with probability of about exp(−h/2.9): this is
/// once in 10⁻¹⁰.
const VARIANCE_TAIL: f64 = 66.0;
/// Samples of a thousand hours, per Hz.
const SECONDS_BETWEEN_STUCK: f64 = 3.6e6;
/// Even white noise repeats itself now and then.
const STUCK_SAMPLES_MIN: f64 = 5.0;
/// A run longer than this would be waited for in vain.
const STUCK_SAMPLES_MAX: f64 = 1e5;

/// Limits of all detectors, SI units.
///
/// | limit | formula |
/// |---|---|
/// | stuck | the run of equal counts that declared noise makes once in 1000 h, see below |
/// | saturation | 0.9995·range |
/// | step | 1.2·(a_max·T + 6·σ_Δ + Δ), σ_Δ of the difference of two samples |
/// | innovation | 1.2·max(6·σ_ν, jolt + 3·σ_ν), the jolt of an acceleration that jumps by a_max |
/// | variance | 1.5·(sum over that jolt) + 66·(samples that are alike) |
/// | clock | 6 ms, chosen |
/// | rate | 3 % of the frames in 1 s, or silence of 50 ms, chosen |
/// | rest | largest bias + 1.2·6·σ of the mean over 1 s |
///
/// The run of equal counts is 1 + ln(3.6e6·f)/−ln p for white noise, p = erf(Δ/(√8·σ)); for
/// coloured noise it comes from a seeded trial, its tail continued.
///
/// Δ is one count, T the sample period, σ_ν the deviation of the innovation under declared noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Equal counts in a row; none when the noise is so small that a sound gyro at rest repeats
    /// itself for ever.
    pub stuck_samples: Option<u32>,
    /// Magnitude of the rate, rad/s.
    pub saturation_rad_s: f64,
    /// Change of the rate in one sample, rad/s.
    pub step_rad_s: f64,
    /// Additional change per sample missing between two, rad/s.
    pub step_per_gap_rad_s: f64,
    /// Magnitude of the innovation, rad/s.
    pub innovation_rad_s: f64,
    /// Deviation of the innovation, rad/s.
    pub innovation_sigma_rad_s: f64,
    /// Of the variance sum.
    pub variance: f64,
    /// Of arrival against counter, s.
    pub clock_s: f64,
    /// Of the number of frames in one second, as a share.
    pub rate_share: f64,
    /// Time without a byte, s.
    pub silence_s: f64,
    /// Of the mean over 1 s at rest, rad/s.
    pub rest_rad_s: f64,
}

impl Limits {
    /// The limits that follow from `declared`.
    ///
    /// # Errors
    /// [`ParameterError`] for the first value refused.
    pub fn of(declared: &Declared) -> Result<Self, ParameterError> {
        declared.validate()?;
        let shape = NoiseShape::new(declared.sample_rate_hz, declared.noise_bandwidth_hz);
        let white = NoiseShape::new(declared.sample_rate_hz, None);
        let gains = Gains::of(declared);
        let (sigma, rounding) = (declared.noise_sigma_rad_s, declared.rounding_sigma_rad_s());
        let memory = gains.memory();
        let through = |shape: &NoiseShape| shape.sigma_through(memory, Follower::linear(gains));
        let innovation_sigma = (sigma * through(&shape)).hypot(rounding * through(&white));
        let gained_rad_s = declared.acceleration_max_rad_s2 * declared.period_s();
        let jolt_rad_s = gained_rad_s * gains.jolt_peak();
        let noise_rad_s = SIGMAS * innovation_sigma;
        let gate = noise_rad_s.max(jolt_rad_s + SIGMAS_BESIDE * innovation_sigma);
        let alike = shape.alike_samples(memory, Follower::linear(gains));
        let jolted = gains.jolt_sum(gained_rad_s / innovation_sigma);
        let mean = sigma * shape.sigma_of_mean(declared.sample_rate_hz);
        let step_sigma = sigma * shape.sigma_through(1, difference());
        Ok(Self {
            stuck_samples: stuck_samples(declared, &shape),
            saturation_rad_s: 0.9995 * declared.rate_max_rad_s,
            step_rad_s: ROOM * (gained_rad_s + SIGMAS * step_sigma + declared.lsb_rad_s),
            step_per_gap_rad_s: ROOM * gained_rad_s,
            innovation_rad_s: ROOM * gate,
            innovation_sigma_rad_s: innovation_sigma,
            variance: 1.5 * jolted + VARIANCE_TAIL * alike,
            clock_s: 6e-3,
            rate_share: 0.03,
            silence_s: 0.05,
            rest_rad_s: declared.bias_max_rad_s + ROOM * SIGMAS * mean,
        })
    }
}

fn difference() -> impl FnMut(f64) -> f64 {
    let mut last = 0.0;
    move |x| x - std::mem::replace(&mut last, x)
}

/// The shortest run of equal counts that is a fault.
fn stuck_samples(declared: &Declared, shape: &NoiseShape) -> Option<u32> {
    let runs = SECONDS_BETWEEN_STUCK * declared.sample_rate_hz;
    let samples = match declared.noise_bandwidth_hz {
        None => 1.0 + runs.ln() / equal_share(declared).ln().abs(),
        Some(_) => longest_run(declared, shape, runs)?,
    };
    // A share of 1 gives infinity: noise that never leaves its count.
    (samples <= STUCK_SAMPLES_MAX).then(|| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 5 and 1e5"
        )]
        let samples = samples.ceil().max(STUCK_SAMPLES_MIN) as u32;
        samples
    })
}

/// Probability that a sample of white noise lies in the count in whose middle its mean lies.
fn equal_share(declared: &Declared) -> f64 {
    let half = 0.5 * declared.lsb_rad_s / declared.noise_sigma_rad_s.max(f64::MIN_POSITIVE);
    // Simpson's rule over the half count; beyond nine deviations nothing is left.
    let (end, n) = (half.min(9.0), 64_u32);
    let density = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    let step = end / f64::from(n);
    let weight = |k: u32| match k {
        0 => 1.0,
        _ if k == n => 1.0,
        _ if k % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let sum: f64 = (0..=n).map(|k| weight(k) * density(f64::from(k) * step)).sum();
    (2.0 * sum * step / 3.0).min(1.0)
}

/// Samples in the trial.
const TRIAL: u32 = 300_000;
const RUNS_KEPT: usize = 4096;

/// The run that coloured noise about the middle of a count makes once in `samples`, from a trial
/// of it: the number of runs that are longer falls exponentially, and its fall is carried on.
fn longest_run(declared: &Declared, shape: &NoiseShape, samples: f64) -> Option<f64> {
    let counts_per_sigma = declared.noise_sigma_rad_s / declared.lsb_rad_s;
    let mut stream = RandomStream::new(Seed(0), Channel::NoiseTrial, 0);
    // How many samples end a run of at least so many.
    let mut reached = vec![0_u32; RUNS_KEPT];
    let (mut last, mut before, mut run) = ([0.0; 2], f64::NAN, 0);
    for _ in 0..TRIAL {
        let now = shape.next(stream.standard_normal(), last);
        last = [now, last[0]];
        let count = (now * counts_per_sigma).round();
        // Whole numbers: the bits are equal when the counts are, but for the sign of zero.
        run = if (count - before).abs() < 0.5 { (run + 1).min(RUNS_KEPT - 1) } else { 0 };
        before = count;
        reached[run] += 1;
    }
    let (many, few) = (find(&reached, 2000)?, find(&reached, 60)?);
    if few == many {
        return Some(STUCK_SAMPLES_MIN);
    }
    let fall = (f64::from(reached[many]) / f64::from(reached[few])).ln() / (few - many) as f64;
    let wanted = f64::from(reached[few]) * samples / f64::from(TRIAL);
    (fall > 0.0).then(|| 1.0 + few as f64 + wanted.ln() / fall)
}

/// The first length that was reached at most `times` times, but was reached.
fn find(reached: &[u32], times: u32) -> Option<usize> {
    reached.iter().position(|n| *n <= times).filter(|at| reached[*at] > 0)
}
