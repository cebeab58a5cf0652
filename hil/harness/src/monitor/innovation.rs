//! The rate and its slope, followed by a filter; what surprises it.

use super::Declared;

/// The acceleration of the body is taken as a random walk that spreads to this share of the
/// declared maximum, one standard deviation, within a second.
const WALK_SHARE: f64 = 0.25;
/// Normalised squares count at most this much: one jolt is no scatter.
const SQUARE_MAX: f64 = 36.0;
/// What a sample may scatter above 1 before it counts.
const ALLOWANCE: f64 = 0.7;
/// Surprises in a row after which the filter believes them and starts anew.
const SURPRISES_MAX: u32 = 3;

/// Gains of the steady two-state filter (rate, slope), both per sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gains {
    rate: f64,
    slope: f64,
    /// Double pole, 0 to 1.
    pole: f64,
}

impl Gains {
    /// The filter that balances white noise of the declared deviation against the declared motion:
    /// its bandwidth is ω = (q/(σ²·T))^¼ with q = (a_max/4)² per second, and both its poles lie at
    /// r = exp(−ω·T), so that α = 1 − r² and β = (1 − r)².
    pub(super) fn of(declared: &Declared) -> Self {
        let walk = (WALK_SHARE * declared.acceleration_max_rad_s2).powi(2);
        let period_s = declared.period_s();
        let density = declared.total_sigma_rad_s().powi(2) * period_s;
        let bandwidth_rad_s = (walk / density).powf(0.25);
        let pole = (-bandwidth_rad_s * period_s).exp();
        Self { rate: 1.0 - pole * pole, slope: (1.0 - pole).powi(2), pole }
    }

    /// Samples after which the filter has forgotten, to e⁻²⁰.
    pub(super) fn memory(&self) -> usize {
        let samples = (20.0 / -self.pole.max(f64::MIN_POSITIVE).ln()).ceil();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped to a small positive number"
        )]
        let samples = samples.clamp(1.0, 131_072.0) as usize;
        samples
    }

    /// Surprise, in units of a_max·T, `k` samples after the acceleration has jumped by a_max:
    /// (k + 1)·rᵏ.
    pub(super) fn jolt(&self, k: usize) -> f64 {
        (k as f64 + 1.0) * self.pole.powf(k as f64)
    }

    /// The largest of them.
    pub(super) fn jolt_peak(&self) -> f64 {
        (0..self.memory()).map(|k| self.jolt(k)).fold(0.0, f64::max)
    }

    /// By how much the variance sum grows in such a jolt of `height` deviations.
    pub(super) fn jolt_sum(&self, height: f64) -> f64 {
        let square = |k| (height * self.jolt(k)).powi(2).min(SQUARE_MAX);
        (0..self.memory()).map(square).sum()
    }
}

/// The filter's belief.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Follower {
    rate_rad_s: f64,
    /// Change of the rate in one sample, rad/s.
    slope_rad_s: f64,
    started: bool,
    surprises: u32,
}

impl Follower {
    /// Carries the belief over `steps` samples of which only the last has come. Over more than
    /// `most` the slope says nothing: the follower starts anew.
    pub(super) fn carry(&mut self, steps: u64, most: u64) {
        self.started &= steps <= most;
        self.rate_rad_s += steps.saturating_sub(1) as f64 * self.slope_rad_s;
    }

    /// Takes the next sample; returns the surprise, none when it starts. A surprise beyond `gate`
    /// is not believed until it has come some times.
    pub(super) fn follow(&mut self, z: f64, gains: &Gains, gate: f64) -> Option<f64> {
        if !self.started || self.surprises >= SURPRISES_MAX {
            *self = Self { rate_rad_s: z, slope_rad_s: 0.0, started: true, surprises: 0 };
            return None;
        }
        self.rate_rad_s += self.slope_rad_s;
        let innovation = z - self.rate_rad_s;
        if innovation.abs() > gate {
            self.surprises += 1;
        } else {
            self.surprises = 0;
            self.rate_rad_s += gains.rate * innovation;
            self.slope_rad_s += gains.slope * innovation;
        }
        Some(innovation)
    }

    /// The filter as a linear map from sample to surprise, for deviations.
    pub(super) fn linear(gains: Gains) -> impl FnMut(f64) -> f64 {
        let mut follower = Self { started: true, ..Self::default() };
        move |z| follower.follow(z, &gains, f64::INFINITY).unwrap_or(0.0)
    }
}

/// A sum that grows while surprises are larger than noise makes them.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct VarianceSum(f64);

impl VarianceSum {
    /// Takes a surprise in deviations; returns the sum. Held at one and a half times `limit`, so
    /// that it falls soon after the cause has ended.
    pub(super) fn add(&mut self, normalised: f64, limit: f64) -> f64 {
        let square = (normalised * normalised).min(SQUARE_MAX);
        self.0 = (self.0 + square - 1.0 - ALLOWANCE).clamp(0.0, 1.5 * limit);
        self.0
    }
}
