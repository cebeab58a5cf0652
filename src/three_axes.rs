//! The filter of three rates as a device under test.

use crate::scenario::ThreeAxisPlan;
use struna_estimator::{
    ConfigError, EstimatorError, Innovation, InputAxis, StartPrior, SwingConfig, ThreeAxisFilter,
};
use struna_harness::{DeviceError, DeviceFault, DeviceUnderTest};
use struna_kernel::{AngleEstimate, EstimateStatus, RAD_PER_DEG, RateOf, RateSample, SimTime};

/// What is known of the angle of a body that was lost: nothing within half a turn, rad.
const LOST_ANGLE_SIGMA_RAD: f64 = core::f64::consts::PI;
/// And of its rate, rad/s.
const LOST_RATE_SIGMA_RAD_S: f64 = 30.0 * RAD_PER_DEG;

/// [`ThreeAxisFilter`] in process, given the three rates of each sample.
///
/// A mean rate is the rate at the middle of its span, and there the filter takes it in; the
/// estimate is then carried to the span's end. At the end the rate of a body that swings is
/// another one, and 5 ms of delay in a twist at 20 °/s are 0.1° of angle.
///
/// Samples over range are clipped in one axis at least and are passed over, as gaps are. A motion
/// that the filter refuses ends nothing: it begins again from the angle that it had, claims no
/// angle until it has found one, and says so.
pub struct ThreeAxisDevice {
    name: String,
    plan: ThreeAxisPlan,
    axes: CaseAxes,
    filter: ThreeAxisFilter,
    /// Time of the filter's belief.
    time: SimTime,
}

impl ThreeAxisDevice {
    /// Starts the filter at time zero.
    ///
    /// # Errors
    /// [`ConfigError`] names the value out of its bound.
    pub fn new(name: &str, plan: ThreeAxisPlan) -> Result<Self, ConfigError> {
        let filter = ThreeAxisFilter::new(&plan.config, plan.swing_sigma_rad)?;
        let axes = CaseAxes::of(&plan.config.axis);
        Ok(Self { name: name.to_owned(), plan, axes, filter, time: SimTime::ZERO })
    }

    /// Carries the filter to the middle of the sample and takes its rates in; returns the mean of
    /// the three normalised innovations squared, NaN when there was nothing to take in.
    fn take(&mut self, sample: &RateSample, middle: SimTime) -> Result<f64, EstimatorError> {
        self.filter.predict(middle.seconds_since(self.time))?;
        self.time = middle;
        let (Some([x, y]), false) = (sample.cross_rates_rad_s, sample.over_range) else {
            return Ok(f64::NAN);
        };
        match self.filter.update(self.axes.to_body([x, y, sample.rate_rad_s])) {
            Ok(innovations) => Ok(innovations.iter().map(Innovation::nis).sum::<f64>() / 3.0),
            // A number that is none tells nothing, of body or filter.
            Err(EstimatorError::BadMeasurement { .. }) => Ok(f64::NAN),
            Err(refusal) => Err(refusal),
        }
    }

    /// Begins again at `time`, at rest at the angle last believed and sure of nothing.
    fn begin_again(&mut self, time: SimTime) -> Result<(), ConfigError> {
        let of = &self.plan.config;
        let start = StartPrior {
            angle_rad: self.filter.belief().angle_rad,
            angle_sigma_rad: LOST_ANGLE_SIGMA_RAD,
            rate_rad_s: 0.0,
            rate_sigma_rad_s: LOST_RATE_SIGMA_RAD_S,
            ..of.start
        };
        let config = SwingConfig { start, ..*of };
        self.filter = ThreeAxisFilter::new(&config, self.plan.swing_sigma_rad)?;
        self.time = time;
        Ok(())
    }

    fn failure(&self, sample: &RateSample, fault: ConfigError) -> DeviceError {
        let (device, time_s) = (self.name.clone(), sample.time.as_s());
        DeviceError { device, time_s, cause: Box::new(DeviceFault::InProcess(Box::new(fault))) }
    }
}

impl std::fmt::Debug for ThreeAxisDevice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ThreeAxisDevice").field("name", &self.name).finish_non_exhaustive()
    }
}

impl DeviceUnderTest for ThreeAxisDevice {
    fn name(&self) -> &str {
        &self.name
    }

    fn step(&mut self, sample: &RateSample) -> Result<AngleEstimate, DeviceError> {
        let (from_ns, to_ns) = (sample.from.as_ns(), sample.time.as_ns());
        let middle = SimTime::from_ns(from_ns + (to_ns - from_ns) / 2);
        let nis = match self.take(sample, middle) {
            Ok(nis) => nis,
            Err(_) => {
                self.begin_again(middle).map_err(|fault| self.failure(sample, fault))?;
                f64::NAN
            }
        };
        let mut ahead = self.filter;
        // What cannot be carried half a span on is begun again with the next sample.
        let _ = ahead.predict(sample.time.seconds_since(middle));
        let belief = ahead.belief();
        Ok(AngleEstimate {
            time: sample.time,
            angle_rad: belief.angle_rad,
            rate_rad_s: belief.rate_rad_s,
            angle_sigma_rad: belief.covariance.angle_rad2.sqrt(),
            rate_sigma_rad_s: belief.covariance.rate_rad2_s2.sqrt(),
            nis,
            status: EstimateStatus::from_code(ahead.status().code()),
            rate_of: RateOf::Twist,
        })
    }
}

/// Axes of the gyros' case in body components: x, y and the input axis z.
#[derive(Debug, Clone, Copy, PartialEq)]
struct CaseAxes([[f64; 3]; 3]);

impl CaseAxes {
    /// The case whose input axis leans by `axis`, and whose x axis has stayed in the plane of the
    /// body's x and z.
    fn of(axis: &InputAxis) -> Self {
        let [z_x, z_y] = axis.tilt_b_rad;
        let z_z = (1.0 - z_x * z_x - z_y * z_y).sqrt();
        let across = z_z.hypot(z_x);
        let (cos, sin) = (z_z / across, z_x / across);
        let x_b = [cos, 0.0, -sin];
        let y_b = [-z_y * sin, across, -z_y * cos];
        Self([x_b, y_b, [z_x, z_y, z_z]])
    }

    /// Rates about the axes of the case as rates about those of the body.
    fn to_body(self, case_rad_s: [f64; 3]) -> [f64; 3] {
        let Self(axes_b) = self;
        std::array::from_fn(|k| (0..3).map(|axis| case_rad_s[axis] * axes_b[axis][k]).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;
    use struna_body::Mounting;
    use struna_estimator::SwingBody;

    fn plan() -> ThreeAxisPlan {
        let body = SwingBody {
            mass_kg: 1.0,
            com_depth_m: 0.1,
            inertia_kg_m2: [0.0100, 0.0105, 0.0100],
            gravity_m_s2: 9.81,
            swing_damping_1_s: 1e-3,
        };
        let start = StartPrior { angle_sigma_rad: 0.1, ..StartPrior::released(TAU, 120.0) };
        let axis = InputAxis { tilt_b_rad: [0.0; 2], tilt_sigma_rad: 0.0 };
        let sigma_rad_s = 0.01 * RAD_PER_DEG;
        let config = SwingConfig::quiet(body, axis, start, sigma_rad_s * sigma_rad_s);
        ThreeAxisPlan { config, swing_sigma_rad: 0.1 }
    }

    fn sample(k: i64, rates_rad_s: Option<[f64; 3]>, over_range: bool) -> RateSample {
        let [x, y, z] = rates_rad_s.unwrap_or_default();
        RateSample {
            from: SimTime::from_ns(k * 10_000_000),
            time: SimTime::from_ns((k + 1) * 10_000_000),
            rate_rad_s: z,
            cross_rates_rad_s: rates_rad_s.map(|_| [x, y]),
            over_range,
            lost_before: 0,
        }
    }

    #[test]
    fn the_case_sits_as_a_mounting_puts_it() {
        for [a, b] in [[0.0, 0.0], [0.02, 0.0], [0.0, -0.03], [0.4, 0.6], [-0.7, 0.3]] {
            let mounting = Mounting::new([a, b], [0.0; 3]).unwrap();
            let input = mounting.input_axis_b();
            let axis = InputAxis { tilt_b_rad: [input.x, input.y], tilt_sigma_rad: 0.0 };
            let CaseAxes(axes_b) = CaseAxes::of(&axis);
            for (of, expected) in axes_b.iter().zip(mounting.case_axes_b()) {
                for (k, part) in of.iter().enumerate() {
                    // Roots of differences of numbers below one.
                    assert!((part - expected[k]).abs() < 1e-15, "{a} {b}: {of:?} {expected:?}");
                }
            }
            let body_rad_s = [0.3, -0.5, 0.9];
            let along = |axis_b: [f64; 3]| (0..3).map(|k| axis_b[k] * body_rad_s[k]).sum();
            let back = CaseAxes(axes_b).to_body(axes_b.map(along));
            for (rate, expected) in back.into_iter().zip(body_rad_s) {
                assert!((rate - expected).abs() < 1e-15, "{back:?}");
            }
        }
    }

    #[test]
    fn clipped_and_absent_rates_are_gaps() {
        let [mut clipped, mut absent] = [0; 2].map(|_| ThreeAxisDevice::new("x", plan()).unwrap());
        for k in 0..100 {
            let wrong = sample(k, Some([3.0, 3.0, 3.0]), true);
            let a = clipped.step(&wrong).unwrap();
            let b = absent.step(&sample(k, None, false)).unwrap();
            assert!(a.nis.is_nan() && b.nis.is_nan());
            assert_eq!((a.angle_rad, a.angle_sigma_rad), (b.angle_rad, b.angle_sigma_rad));
        }
        let heard = clipped.step(&sample(100, Some([0.0; 3]), false)).unwrap();
        assert!(heard.nis.is_finite(), "{heard:?}");
    }

    #[test]
    fn rates_that_are_no_numbers_are_gaps() {
        let [mut spoilt, mut absent] = [0; 2].map(|_| ThreeAxisDevice::new("x", plan()).unwrap());
        for axis in 0..3 {
            let mut rates_rad_s = [0.0; 3];
            rates_rad_s[axis] = f64::NAN;
            let k = i64::try_from(axis).unwrap();
            let a = spoilt.step(&sample(k, Some(rates_rad_s), false)).unwrap();
            let b = absent.step(&sample(k, None, false)).unwrap();
            assert!(a.nis.is_nan());
            assert_eq!((a.angle_rad, a.rate_rad_s), (b.angle_rad, b.rate_rad_s));
        }
    }

    #[test]
    fn a_motion_beyond_the_model_is_begun_again_and_claims_no_angle() {
        let mut device = ThreeAxisDevice::new("x", plan()).unwrap();
        for k in 0..100 {
            let quiet = device.step(&sample(k, Some([0.0; 3]), false)).unwrap();
            assert_ne!(quiet.status, EstimateStatus::NotObservable, "{quiet:?}");
        }
        // Turned over by hand, then still again.
        let thrown = (100..200).map(|k| sample(k, Some([60.0, -60.0, 5.0]), false));
        let worst = thrown.map(|sample| device.step(&sample).unwrap()).last().unwrap();
        assert!(worst.angle_rad.is_finite() && worst.angle_sigma_rad.is_finite());
        let after = device.step(&sample(200, Some([0.0; 3]), false)).unwrap();
        assert_eq!(after.status, EstimateStatus::NotObservable, "{after:?}");
        // An hour without a sample is more than the motion can be carried over.
        let late = device.step(&sample(360_000, Some([0.0; 3]), false)).unwrap();
        assert!(late.nis.is_nan());
        assert_eq!(late.status, EstimateStatus::NotObservable, "{late:?}");
    }
}
