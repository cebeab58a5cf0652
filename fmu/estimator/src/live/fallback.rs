//! The five-state filter that takes a swing for noise: its angle is a bound and no more.

use crate::augmented::{AugmentedConfig, AugmentedFilter, Densities, State};
use crate::config::{ConfigError, judge, not_negative, positive};
use crate::state_bytes::{Reader, RestoreError, Writer};
use crate::{Belief, EstimatorError, Innovation, RateEstimator};

/// One degree, rad.
const DEG: f64 = core::f64::consts::PI / 180.0;
/// Share of the largest coning rate ω·a²/2 that the bias is reckoned with.
const CONING: f64 = 0.6;
/// Time in which the coning rate forgets itself, s.
const CONING_TIME_S: f64 = 10.0;
/// Time in which the torque of the swing forgets itself, s.
const TORQUE_TIME_S: f64 = 3.0;
/// White angular acceleration that acts in any case, rad²/s³.
const ACCELERATION_FLOOR: f64 = 1e-6 * DEG * DEG;

/// What of a body decides how its swing acts on the twist.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SwingScale {
    /// Angular frequency of small swings, rad/s. Positive.
    pub swing_rad_s: f64,
    /// |A − B|/C: how unlike the two horizontal moments of inertia are. From 0 to 1, which no
    /// body exceeds.
    pub inertia_split: f64,
}

impl SwingScale {
    /// A bench body of which nothing is known: a swing of 1.6 Hz, and moments as unlike as can be.
    pub const UNKNOWN: Self = Self { swing_rad_s: 10.0, inertia_split: 1.0 };

    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        positive("swing_rad_s", self.swing_rad_s)?;
        not_negative("inertia_split", self.inertia_split)?;
        judge("inertia_split", self.inertia_split, self.inertia_split <= 1.0, "at most 1")
    }

    /// Standard deviation of the coning rate, which the gyro cannot tell from its bias, rad/s.
    fn coning_rad_s(&self, swing_rad: f64) -> f64 {
        CONING * 0.5 * self.swing_rad_s * swing_rad * swing_rad
    }

    /// Standard deviation of the angular acceleration by which the swing drives the twist, rad/s².
    fn torque_rad_s2(&self, swing_rad: f64) -> f64 {
        let rate_rad_s = swing_rad * self.swing_rad_s;
        0.25 * self.inertia_split * rate_rad_s * rate_rad_s
    }
}

/// [`AugmentedFilter`] with noise as large as the swing makes it.
///
/// A swing of amplitude a at frequency ω turns the body by ω·a²/2 at most that no string feels
/// (coning; here a bias that walks, σ = 0.6 of it, forgotten in 10 s) and drives the twist by
/// |A − B|/C·(a·ω)²/4 (here white acceleration of the power of such a torque forgotten in 3 s).
/// What leaks into the axis is counted as measurement noise. Narrower settings were tried: they
/// claim less and err more.
#[derive(Debug, Clone)]
pub struct SwingFallback {
    filter: AugmentedFilter,
    scale: SwingScale,
    quiet: Quiet,
    swing_rad: f64,
    rate_variance_rad2_s2: f64,
}

/// Noise without any swing.
#[derive(Debug, Clone, Copy)]
struct Quiet {
    r_rad2_s2: f64,
    acceleration_rad2_s3: f64,
    bias_walk_rad2_s3: f64,
}

impl SwingFallback {
    /// A filter for a body that does not swing yet: see [`set_swing`](Self::set_swing).
    ///
    /// # Errors
    /// [`ConfigError`] names the value out of its bound.
    pub fn new(config: &AugmentedConfig, scale: SwingScale) -> Result<Self, ConfigError> {
        scale.validate()?;
        config.validate()?;
        let config = config.without_quantiser();
        let quiet = Quiet {
            r_rad2_s2: config.measurement_variance_rad2_s2,
            acceleration_rad2_s3: config.process_noise_rad2_s3,
            bias_walk_rad2_s3: config.bias_walk_rad2_s3,
        };
        let filter = AugmentedFilter::new(&config)?;
        Ok(Self { filter, scale, quiet, swing_rad: 0.0, rate_variance_rad2_s2: 0.0 })
    }

    /// Sets what is reckoned with from now on: a swing of up to `swing_rad`, and a variance of the
    /// measured rate about its mean over 0.64 s.
    ///
    /// Coning is there at once when a swing is: the bias becomes less certain by what it may add.
    /// A call with anything but finite numbers that are not negative changes nothing.
    pub fn set_swing(&mut self, swing_rad: f64, rate_variance_rad2_s2: f64) {
        let sized = |value: f64| (0.0..f64::INFINITY).contains(&value);
        if !sized(swing_rad) || !sized(rate_variance_rad2_s2) {
            return;
        }
        let variance_of = |swing_rad| {
            let coning_rad_s = self.scale.coning_rad_s(swing_rad);
            coning_rad_s * coning_rad_s
        };
        let more = variance_of(swing_rad) - variance_of(self.swing_rad);
        if more > 0.0 && self.filter.widen(more, 0.0).is_err() {
            return;
        }
        self.size_noise(swing_rad, rate_variance_rad2_s2);
    }

    /// Noise for a swing, the belief left alone.
    fn size_noise(&mut self, swing_rad: f64, rate_variance_rad2_s2: f64) {
        (self.swing_rad, self.rate_variance_rad2_s2) = (swing_rad, rate_variance_rad2_s2);
        let (quiet, scale) = (&self.quiet, &self.scale);
        let (torque, coning) = (scale.torque_rad_s2(swing_rad), scale.coning_rad_s(swing_rad));
        let q = Densities {
            acceleration: quiet.acceleration_rad2_s3.max(ACCELERATION_FLOOR)
                + 2.0 * torque * torque * TORQUE_TIME_S,
            bias: quiet.bias_walk_rad2_s3 + 2.0 * coning * coning / CONING_TIME_S,
        };
        self.filter.set_noise(quiet.r_rad2_s2.max(rate_variance_rad2_s2), q);
    }

    /// Starts from the belief of a filter that knew of no swing, when one of `swing_rad` begins.
    ///
    /// Whatever made it swing may have turned it as well: the rate becomes as uncertain as the
    /// swing is fast, which a few samples cure.
    pub(super) fn begin(
        &mut self,
        from: State,
        swing_rad: f64,
        rate_variance_rad2_s2: f64,
    ) -> Result<(), EstimatorError> {
        self.filter.set_state(from)?;
        let rate_rad_s = swing_rad * self.scale.swing_rad_s;
        self.filter.widen(0.0, rate_rad_s * rate_rad_s)?;
        self.swing_rad = 0.0;
        self.set_swing(swing_rad, rate_variance_rad2_s2);
        Ok(())
    }

    pub(super) fn state(&self) -> State {
        self.filter.state()
    }
}

impl RateEstimator for SwingFallback {
    fn predict(&mut self, span_s: f64) -> Result<(), EstimatorError> {
        self.filter.predict(span_s)
    }

    fn update(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        self.filter.update(rate_rad_s)
    }

    fn update_over_range(&mut self, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        self.filter.update_over_range(rate_rad_s)
    }

    fn belief(&self) -> Belief {
        self.filter.belief()
    }

    fn saved_len(&self) -> usize {
        self.filter.saved_len() + 16
    }

    fn save(&self, out: &mut [u8]) {
        let mut out = Writer::new(out);
        out.f64(self.swing_rad);
        out.f64(self.rate_variance_rad2_s2);
        self.filter.state().write(&mut out);
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let mut bytes = Reader::new(bytes, self.saved_len())?;
        let swing_rad = bytes.finite("swing_rad")?;
        let variance = bytes.finite("rate variance")?;
        if swing_rad < 0.0 || variance < 0.0 {
            return Err(RestoreError::Impossible);
        }
        let state = State::read(&mut bytes)?;
        self.filter.set_state(state).map_err(|_| RestoreError::Impossible)?;
        self.size_noise(swing_rad, variance);
        Ok(())
    }
}
