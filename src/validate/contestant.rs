//! The estimators under one roof: what a campaign may ask of each.

use struna_estimator::{
    AugmentedConfig, AugmentedFilter, Belief, ConfigError, EstimatorError, Filter, FilterConfig,
    Innovation, InnovationTest, PlainIntegration, RateEstimator, Reading, Refinement, Status,
    TestedFilter,
};
use struna_kernel::RAD_PER_DEG;

/// One measured rate as an estimator gets it: nothing of the truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Measured {
    /// Time since the measurement before, s.
    pub(super) span_s: f64,
    /// The last part of it, over which the rate is a mean; 0 for a rate at an instant, s.
    pub(super) averaged_s: f64,
    /// The rate, rad/s.
    pub(super) rate_rad_s: f64,
    /// The gyro flags it as over range.
    pub(super) over_range: bool,
    /// Rates about the two axes across, rad/s, of a gyro of three axes.
    pub(super) across_rad_s: Option<[f64; 2]>,
}

impl Measured {
    /// The rate at an instant, about one axis, within range.
    pub(super) const fn new(span_s: f64, rate_rad_s: f64) -> Self {
        Self { span_s, averaged_s: 0.0, rate_rad_s, over_range: false, across_rad_s: None }
    }

    /// The mean over the last `averaged_s` of the span.
    pub(super) const fn mean(span_s: f64, averaged_s: f64, rate_rad_s: f64) -> Self {
        Self { averaged_s, ..Self::new(span_s, rate_rad_s) }
    }
}

/// True values that a whole error is taken against.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TrueState {
    /// Angle, rad.
    pub(super) angle_rad: f64,
    /// Rate, rad/s.
    pub(super) rate_rad_s: f64,
    /// Ω², 1/s².
    pub(super) s: f64,
    /// 2ζΩ, 1/s.
    pub(super) d: f64,
    /// Bias of the gyro, rad/s.
    pub(super) bias_rad_s: f64,
}

/// An estimator in a campaign.
pub(super) trait Contestant {
    /// Takes a measurement.
    ///
    /// # Errors
    /// What the estimator refuses: the run ends then.
    fn step(&mut self, measured: &Measured) -> Result<Innovation, EstimatorError>;

    /// What it believes now.
    fn belief(&self) -> Belief;

    /// What it says of itself.
    fn status(&self) -> Status;

    /// Alarms so far; none when it has no test.
    fn alarms(&self) -> Option<u64> {
        None
    }

    /// Twist over which the thread yields as far as it finds, rad; none when it looks for none.
    fn yield_rad(&self) -> Option<f64> {
        None
    }

    /// Normalised estimation error squared over all its states, and how many these are. None when
    /// its covariance is not positive definite.
    fn nees(&self, truth: &TrueState) -> Option<(f64, u32)> {
        let Belief { angle_rad, rate_rad_s, covariance } = self.belief();
        let error = [angle_rad - truth.angle_rad, rate_rad_s - truth.rate_rad_s];
        let p = covariance;
        let rows = [[p.angle_rad2, p.cross_rad2_s], [p.cross_rad2_s, p.rate_rad2_s2]];
        Some((error_squared(&rows, &error)?, 2))
    }
}

fn advance(
    estimator: &mut dyn RateEstimator,
    measured: &Measured,
) -> Result<Innovation, EstimatorError> {
    let Measured { span_s, averaged_s, rate_rad_s, over_range, .. } = *measured;
    if over_range {
        estimator.predict(span_s)?;
        return estimator.update_over_range(rate_rad_s);
    }
    if averaged_s == 0.0 {
        return estimator.step(span_s, rate_rad_s);
    }
    let gap_s = span_s - averaged_s;
    if gap_s > 0.0 {
        estimator.predict(gap_s)?;
    }
    estimator.step_mean(averaged_s, rate_rad_s)
}

/// An estimator that is judged by angle and rate alone.
pub(super) struct Single<E>(pub(super) E);

impl<E: RateEstimator> Contestant for Single<E> {
    fn step(&mut self, measured: &Measured) -> Result<Innovation, EstimatorError> {
        advance(&mut self.0, measured)
    }

    fn belief(&self) -> Belief {
        self.0.belief()
    }

    fn status(&self) -> Status {
        self.0.status()
    }
}

impl Contestant for AugmentedFilter {
    fn step(&mut self, measured: &Measured) -> Result<Innovation, EstimatorError> {
        advance(self, measured)
    }

    fn belief(&self) -> Belief {
        RateEstimator::belief(self)
    }

    fn status(&self) -> Status {
        RateEstimator::status(self)
    }

    fn nees(&self, truth: &TrueState) -> Option<(f64, u32)> {
        five_states(self, truth)
    }
}

impl Contestant for TestedFilter {
    fn step(&mut self, measured: &Measured) -> Result<Innovation, EstimatorError> {
        advance(self, measured)
    }

    fn belief(&self) -> Belief {
        RateEstimator::belief(self)
    }

    fn status(&self) -> Status {
        RateEstimator::status(self)
    }

    fn alarms(&self) -> Option<u64> {
        Some(TestedFilter::alarms(self))
    }

    fn nees(&self, truth: &TrueState) -> Option<(f64, u32)> {
        five_states(self.filter(), truth)
    }
}

fn five_states(filter: &AugmentedFilter, truth: &TrueState) -> Option<(f64, u32)> {
    let TrueState { angle_rad, rate_rad_s, s, d, bias_rad_s } = *truth;
    let state = [-s * angle_rad, rate_rad_s, s, d, bias_rad_s];
    let mean = filter.mean();
    let error: [f64; 5] = std::array::from_fn(|i| mean[i] - state[i]);
    Some((error_squared(&filter.covariance(), &error)?, 5))
}

/// eᵀ·P⁻¹·e by a Cholesky factor of the correlations: the units differ by ten orders of magnitude.
/// None when P is not positive definite.
pub(super) fn error_squared<const N: usize>(p: &[[f64; N]; N], error: &[f64; N]) -> Option<f64> {
    let sigma: [f64; N] = std::array::from_fn(|i| p[i][i].sqrt());
    let mut root = [[0.0; N]; N];
    let mut solved = [0.0; N];
    let mut sum = 0.0;
    for i in 0..N {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| root[i][k] * root[j][k]).sum();
            let left = p[i][j] / (sigma[i] * sigma[j]) - known;
            root[i][j] = if i == j { left.sqrt() } else { left / root[j][j] };
        }
        let known: f64 = (0..i).map(|k| root[i][k] * solved[k]).sum();
        solved[i] = (error[i] / sigma[i] - known) / root[i][i];
        sum += solved[i] * solved[i];
    }
    Some(sum).filter(|sum| sum.is_finite())
}

/// The estimators that need nothing but rates of one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    /// Plain integration.
    Integration,
    /// The 2008 filter of permanent rotation with refinement every so many samples.
    F1(u32),
    /// The 2008 filter of torsional oscillation with refinement every so many samples.
    F2(u32),
    /// Five states.
    Augmented,
    /// Five states behind the innovation test.
    Tested,
}

impl Kind {
    /// Name in tables.
    #[must_use]
    pub(super) fn name(self) -> String {
        match self {
            Self::Integration => "integration".to_owned(),
            Self::F1(n) => format!("F1 N={n}"),
            Self::F2(n) => format!("F2 N={n}"),
            Self::Augmented => "EKF5a".to_owned(),
            Self::Tested => "EKF5a+test".to_owned(),
        }
    }

    /// N of the refinement; none for estimators that have none.
    #[must_use]
    pub(super) const fn refinement_samples(self) -> Option<u32> {
        match self {
            Self::F1(n) | Self::F2(n) => Some(n),
            _ => None,
        }
    }

    /// The estimator, told `config` as far as it can use it: those of 2008 take the start angle,
    /// the period and R, and start with variances of 1 deg² and 1 (deg/s)².
    ///
    /// # Errors
    /// [`ConfigError`] names the value that the estimator cannot work with.
    pub(super) fn make(self, config: &AugmentedConfig) -> Result<Box<dyn Contestant>, ConfigError> {
        let paper = |samples| FilterConfig {
            angle_start_rad: config.start.angle_rad,
            rate_start_rad_s: config.start.rate_rad_s,
            angle_variance_start_rad2: RAD_PER_DEG * RAD_PER_DEG,
            rate_variance_start_rad2_s2: RAD_PER_DEG * RAD_PER_DEG,
            measurement_variance_rad2_s2: config.measurement_variance_rad2_s2,
            process_noise_rad2_s3: 0.0,
            refinement: Refinement { samples, reading: Reading::M6 },
        };
        Ok(match self {
            Self::Integration => Box::new(Single(PlainIntegration::new(paper(0))?)),
            Self::F1(n) => Box::new(Single(Filter::permanent_rotation(paper(n))?)),
            Self::F2(n) => {
                let filter = Filter::torsional_oscillation(paper(n), config.start.period_s)?;
                Box::new(Single(filter))
            }
            Self::Augmented => Box::new(AugmentedFilter::new(config)?),
            Self::Tested => Box::new(TestedFilter::new(config, &InnovationTest::STANDARD)?),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_squared_error_is_that_of_the_inverse() {
        // P⁻¹ = [[1, -1], [-1, 4]]/3 of [[4, 1], [1, 1]]: e = (2, 1) gives (4 - 4 + 4)/3.
        let squared = error_squared(&[[4.0, 1.0], [1.0, 1.0]], &[2.0, 1.0]).unwrap();
        assert!((squared - 4.0 / 3.0).abs() < 1e-14, "{squared}");
        assert_eq!(error_squared(&[[1.0, 2.0], [2.0, 1.0]], &[1.0, 0.0]), None);
        assert_eq!(error_squared(&[[0.0]], &[1.0]), None);
    }
}
