//! What the estimators that learn have in common as FMUs: period, damping and bias with what is
//! known of them before, the noise, and the gyro's range and counts.

use crate::exported::{ROWS, Starts, first_rows, parameter};
use crate::filter::{MEASUREMENT_VARIANCE_RAD2_S2_START, bad_parameter};
use struna_estimator::{
    AugmentedConfig, ConfigError, GyroRange, InnovationTest, LearntParameters, Quantiser,
    StartPrior,
};
use struna_fmi_export::{Domain, ModelError, Role, Unit, ValueReference, Values, Variable};

const PERIOD_S: ValueReference = 12;
const PERIOD_SIGMA_S: ValueReference = 13;
const DAMPING_RATIO: ValueReference = 14;
const DAMPING_RATIO_SIGMA: ValueReference = 15;
const BIAS_RAD_S: ValueReference = 16;
const BIAS_SIGMA_RAD_S: ValueReference = 17;
const ANGLE_START_RAD: ValueReference = 18;
const ANGLE_SIGMA_START_RAD: ValueReference = 19;
const RATE_START_RAD_S: ValueReference = 20;
const RATE_SIGMA_START_RAD_S: ValueReference = 21;
const PERIOD_START_S: ValueReference = 22;
const PERIOD_SIGMA_START_S: ValueReference = 23;
const DAMPING_RATIO_START: ValueReference = 24;
const DAMPING_RATIO_SIGMA_START: ValueReference = 25;
const BIAS_START_RAD_S: ValueReference = 26;
const BIAS_SIGMA_START_RAD_S: ValueReference = 27;
const MEASUREMENT_VARIANCE_RAD2_S2: ValueReference = 28;
const PROCESS_NOISE_RAD2_S3: ValueReference = 29;
const BIAS_WALK_RAD2_S3: ValueReference = 30;
const SCALE_FACTOR_SIGMA: ValueReference = 31;
const GYRO_RANGE_RAD_S: ValueReference = 32;
const GYRO_RANGE_MARGIN_RAD_S: ValueReference = 33;
const GYRO_COUNT_RAD_S: ValueReference = 34;
const GYRO_RAW_SIGMA_RAD_S: ValueReference = 35;
const GYRO_SAMPLES: ValueReference = 36;
const ALARMS: ValueReference = 37;
const TEST_FALSE_ALARMS: ValueReference = 38;
const TEST_HORIZON_SAMPLES: ValueReference = 39;
const TEST_KICK_FLOOR_RAD_S: ValueReference = 40;

/// What the parameters start from: a release on the rig of 2008, in a quiet laboratory.
const DEFAULT: AugmentedConfig =
    AugmentedConfig::quiet(StartPrior::released(0.0, 480.0), MEASUREMENT_VARIANCE_RAD2_S2_START);

const STARTS: Starts = Starts {
    angle: &[ANGLE_START_RAD, PERIOD_START_S],
    rate: &[RATE_START_RAD_S],
    angle_sigma: ANGLE_CLAIM,
    rate_sigma: &[RATE_START_RAD_S, RATE_SIGMA_START_RAD_S, SCALE_FACTOR_SIGMA],
    status: ANGLE_CLAIM,
};
const ANGLE_CLAIM: &[ValueReference] = &[
    ANGLE_START_RAD,
    ANGLE_SIGMA_START_RAD,
    PERIOD_START_S,
    PERIOD_SIGMA_START_S,
    SCALE_FACTOR_SIGMA,
];

pub(crate) const fn float(unit: Unit, start: f64) -> Domain {
    Domain::float64(unit, start)
}

pub(crate) const fn at_least_0(unit: Unit, start: f64) -> Domain {
    Domain::not_negative(unit, start)
}

/// An output that is calculated when it is read.
pub(crate) const fn output(
    reference: ValueReference,
    name: &'static str,
    unit: Unit,
    meaning: &'static str,
) -> Variable {
    let domain = Domain::float64(unit, 0.0);
    Variable::new(reference, Role::Output, name, domain, meaning).on_demand()
}

/// What the filter has learnt.
const LEARNT: [Variable; 6] = {
    let (s, one, rad_s) = (Unit::S, Unit::ONE, Unit::RAD_S);
    [
        output(PERIOD_S, "period_s", s, "Believed period of undamped torsion.")
            .starting_from(&[PERIOD_START_S]),
        output(PERIOD_SIGMA_S, "period_sigma_s", s, "Standard deviation claimed of it.")
            .starting_from(&[PERIOD_START_S, PERIOD_SIGMA_START_S]),
        output(DAMPING_RATIO, "damping_ratio", one, "Believed damping ratio.")
            .starting_from(&[PERIOD_START_S, DAMPING_RATIO_START]),
        output(DAMPING_RATIO_SIGMA, "damping_ratio_sigma", one, "Standard deviation of it.")
            .starting_from(&[PERIOD_START_S, DAMPING_RATIO_SIGMA_START]),
        output(BIAS_RAD_S, "bias_rad_s", rad_s, "Believed bias of the gyro.")
            .starting_from(&[BIAS_START_RAD_S]),
        output(BIAS_SIGMA_RAD_S, "bias_sigma_rad_s", rad_s, "Standard deviation of it.")
            .starting_from(&[BIAS_SIGMA_START_RAD_S]),
    ]
};

/// What is believed at the start.
const PRIOR: [Variable; 10] = {
    use parameter as p;
    let StartPrior {
        angle_rad,
        angle_sigma_rad,
        rate_rad_s,
        rate_sigma_rad_s,
        period_s,
        period_sigma_s,
        damping_ratio,
        damping_ratio_sigma,
        bias_rad_s,
        bias_sigma_rad_s,
    } = DEFAULT.start;
    let (rad, rad_s, s, one) = (Unit::RAD, Unit::RAD_S, Unit::S, Unit::ONE);
    let angle = "Believed angle at the start.";
    let angle_sigma = "Its standard deviation.";
    let rate = "Believed rate at the start.";
    let rate_sigma = "Its standard deviation.";
    let period = "Period of undamped torsion as known before, from 1e-6 to 1e12 s.";
    let period_sigma = "Its standard deviation; 0: certain, and not learnt.";
    let damping = "Damping ratio as known before.";
    let damping_sigma = "Its standard deviation; 0: certain, and not learnt.";
    let bias = "Bias of the gyro as known before.";
    let bias_sigma = "Its standard deviation; 0: certain, and not learnt.";
    [
        p(ANGLE_START_RAD, "angle_start_rad", float(rad, angle_rad), angle),
        p(
            ANGLE_SIGMA_START_RAD,
            "angle_sigma_start_rad",
            at_least_0(rad, angle_sigma_rad),
            angle_sigma,
        ),
        p(RATE_START_RAD_S, "rate_start_rad_s", float(rad_s, rate_rad_s), rate),
        p(
            RATE_SIGMA_START_RAD_S,
            "rate_sigma_start_rad_s",
            at_least_0(rad_s, rate_sigma_rad_s),
            rate_sigma,
        ),
        p(PERIOD_START_S, "period_start_s", at_least_0(s, period_s), period),
        p(
            PERIOD_SIGMA_START_S,
            "period_sigma_start_s",
            at_least_0(s, period_sigma_s),
            period_sigma,
        ),
        p(DAMPING_RATIO_START, "damping_ratio_start", at_least_0(one, damping_ratio), damping),
        p(
            DAMPING_RATIO_SIGMA_START,
            "damping_ratio_sigma_start",
            at_least_0(one, damping_ratio_sigma),
            damping_sigma,
        ),
        p(BIAS_START_RAD_S, "bias_start_rad_s", float(rad_s, bias_rad_s), bias),
        p(
            BIAS_SIGMA_START_RAD_S,
            "bias_sigma_start_rad_s",
            at_least_0(rad_s, bias_sigma_rad_s),
            bias_sigma,
        ),
    ]
};

/// Noise and gyro.
const NOISE: [Variable; 9] = {
    use parameter as p;
    let (rad_s, one, density) = (Unit::RAD_S, Unit::ONE, Unit::RAD2_S3);
    let r = at_least_0(Unit::RAD2_S2, DEFAULT.measurement_variance_rad2_s2);
    let q = at_least_0(density, DEFAULT.process_noise_rad2_s3);
    let walk = at_least_0(density, DEFAULT.bias_walk_rad2_s3);
    let scale = at_least_0(one, DEFAULT.scale_factor_sigma);
    let r_is = "Variance of one measured rate, rounding included; greater than 0.";
    let q_is = "Density of white angular acceleration.";
    let scale_is =
        "Relative standard deviation of the gyro's scale factor; widens what is claimed.";
    let range_is = "Largest rate that the gyro can tell; 0 when it cannot clip.";
    let margin_is = "Width below that range in which rates are not used; less than the range.";
    let count_is = "One count of the gyro; 0 when it is not known or fine.";
    let raw_is = "Standard deviation of its raw samples, before they are counted and averaged.";
    let samples = Domain::int32(1, 1, i32::MAX);
    let samples_is = "Raw samples in one measured rate.";
    [
        p(MEASUREMENT_VARIANCE_RAD2_S2, "measurement_variance_rad2_s2", r, r_is),
        p(PROCESS_NOISE_RAD2_S3, "process_noise_rad2_s3", q, q_is),
        p(BIAS_WALK_RAD2_S3, "bias_walk_rad2_s3", walk, "Density of the bias's random walk."),
        p(SCALE_FACTOR_SIGMA, "scale_factor_sigma", scale, scale_is),
        p(GYRO_RANGE_RAD_S, "gyro_range_rad_s", at_least_0(rad_s, 0.0), range_is),
        p(GYRO_RANGE_MARGIN_RAD_S, "gyro_range_margin_rad_s", at_least_0(rad_s, 0.0), margin_is),
        p(GYRO_COUNT_RAD_S, "gyro_count_rad_s", at_least_0(rad_s, 0.0), count_is),
        p(GYRO_RAW_SIGMA_RAD_S, "gyro_raw_sigma_rad_s", at_least_0(rad_s, 0.0), raw_is),
        p(GYRO_SAMPLES, "gyro_samples", samples, samples_is),
    ]
};

/// The test of the innovations.
const TEST: [Variable; 4] = {
    use parameter as p;
    let (one, usual) = (Unit::ONE, InnovationTest::STANDARD);
    let false_alarms = at_least_0(one, usual.false_alarms);
    let horizon = Domain::int32(usual.horizon_samples.cast_signed(), 0, i32::MAX);
    let kick = at_least_0(Unit::RAD_S, usual.kick_floor_rad_s);
    let counted = Domain::int32(0, 0, i32::MAX);
    let false_alarms_is = "False alarms for each of 12 windows allowed in the horizon, above 0 and \
                           below 1.";
    let kick_is = "Kick that an alarm reckons with on top of the one seen.";
    [
        Variable::new(ALARMS, Role::Output, "alarms", counted, "Alarms of the test so far.")
            .on_demand(),
        p(TEST_FALSE_ALARMS, "test_false_alarms", false_alarms, false_alarms_is),
        p(TEST_HORIZON_SAMPLES, "test_horizon_samples", horizon, "At least 2048."),
        p(TEST_KICK_FLOOR_RAD_S, "test_kick_floor_rad_s", kick, kick_is),
    ]
};

/// The rows that every estimator that learns has.
pub(crate) const LEARNING_ROWS: usize = ROWS + LEARNT.len() + PRIOR.len() + NOISE.len();
/// The same and those of the test.
pub(crate) const TESTED_ROWS: usize = LEARNING_ROWS + TEST.len();

/// A variable table that begins with the rows of every estimator that learns and ends in `own`.
pub(crate) const fn learning_table<const ALL: usize>(own: &[Variable]) -> [Variable; ALL] {
    let mut rows = [Variable::TIME; ALL];
    let (first, rest) = rows.split_at_mut(ROWS);
    first.copy_from_slice(&first_rows(&STARTS));
    let (learnt, rest) = rest.split_at_mut(LEARNT.len());
    learnt.copy_from_slice(&LEARNT);
    let (prior, rest) = rest.split_at_mut(PRIOR.len());
    prior.copy_from_slice(&PRIOR);
    let (noise, rest) = rest.split_at_mut(NOISE.len());
    noise.copy_from_slice(&NOISE);
    rest.copy_from_slice(own);
    rows
}

/// The same with the rows of the test before `own`.
pub(crate) const fn tested_table<const ALL: usize>(own: &[Variable]) -> [Variable; ALL] {
    let mut rows = [Variable::TIME; ALL];
    let (learning, rest) = rows.split_at_mut(LEARNING_ROWS);
    learning.copy_from_slice(&learning_table::<LEARNING_ROWS>(&[]));
    let (test, rest) = rest.split_at_mut(TEST.len());
    test.copy_from_slice(&TEST);
    rest.copy_from_slice(own);
    rows
}

/// Writes what a filter has learnt.
pub(crate) fn write_learnt(values: &mut Values, learnt: &LearntParameters) {
    values.set_float64(PERIOD_S, learnt.period_s);
    values.set_float64(PERIOD_SIGMA_S, learnt.period_sigma_s);
    values.set_float64(DAMPING_RATIO, learnt.damping_ratio);
    values.set_float64(DAMPING_RATIO_SIGMA, learnt.damping_ratio_sigma);
    values.set_float64(BIAS_RAD_S, learnt.bias_rad_s);
    values.set_float64(BIAS_SIGMA_RAD_S, learnt.bias_sigma_rad_s);
}

/// Writes how often the test has raised an alarm.
pub(crate) fn write_alarms(values: &mut Values, alarms: u64) {
    values.set_int32(ALARMS, i32::try_from(alarms).unwrap_or(i32::MAX));
}

/// Prior, noise and gyro.
pub(crate) fn config(values: &Values) -> AugmentedConfig {
    let limit_rad_s = values.float64(GYRO_RANGE_RAD_S);
    let margin_rad_s = values.float64(GYRO_RANGE_MARGIN_RAD_S);
    let step_rad_s = values.float64(GYRO_COUNT_RAD_S);
    let raw_sigma_rad_s = values.float64(GYRO_RAW_SIGMA_RAD_S);
    // The variable's bounds leave no negative one; if any came, it would be refused as none.
    let samples = u32::try_from(values.int32(GYRO_SAMPLES)).unwrap_or(0);
    let quantiser = Quantiser { step_rad_s, raw_sigma_rad_s, samples };
    AugmentedConfig {
        start: StartPrior {
            angle_rad: values.float64(ANGLE_START_RAD),
            angle_sigma_rad: values.float64(ANGLE_SIGMA_START_RAD),
            rate_rad_s: values.float64(RATE_START_RAD_S),
            rate_sigma_rad_s: values.float64(RATE_SIGMA_START_RAD_S),
            period_s: values.float64(PERIOD_START_S),
            period_sigma_s: values.float64(PERIOD_SIGMA_START_S),
            damping_ratio: values.float64(DAMPING_RATIO_START),
            damping_ratio_sigma: values.float64(DAMPING_RATIO_SIGMA_START),
            bias_rad_s: values.float64(BIAS_START_RAD_S),
            bias_sigma_rad_s: values.float64(BIAS_SIGMA_START_RAD_S),
        },
        measurement_variance_rad2_s2: values.float64(MEASUREMENT_VARIANCE_RAD2_S2),
        process_noise_rad2_s3: values.float64(PROCESS_NOISE_RAD2_S3),
        bias_walk_rad2_s3: values.float64(BIAS_WALK_RAD2_S3),
        scale_factor_sigma: values.float64(SCALE_FACTOR_SIGMA),
        range: (limit_rad_s > 0.0).then_some(GyroRange { limit_rad_s, margin_rad_s }),
        quantiser: (step_rad_s > 0.0).then_some(quantiser),
    }
}

/// The test of the innovations.
pub(crate) fn test(values: &Values) -> InnovationTest {
    InnovationTest {
        false_alarms: values.float64(TEST_FALSE_ALARMS),
        // The variable's bounds leave no negative one; if any came, it would be refused as too few.
        horizon_samples: u32::try_from(values.int32(TEST_HORIZON_SAMPLES)).unwrap_or(0),
        kick_floor_rad_s: values.float64(TEST_KICK_FLOOR_RAD_S),
    }
}

/// The filter speaks of its prior; here that is what outputs start from.
pub(crate) fn bad(error: ConfigError) -> ModelError {
    let name = match error.name {
        "angle_rad" => "angle_start_rad",
        "angle_sigma_rad" => "angle_sigma_start_rad",
        "rate_rad_s" => "rate_start_rad_s",
        "rate_sigma_rad_s" => "rate_sigma_start_rad_s",
        "period_s" => "period_start_s",
        "period_sigma_s" => "period_sigma_start_s",
        "damping_ratio" => "damping_ratio_start",
        "damping_ratio_sigma" => "damping_ratio_sigma_start",
        "bias_rad_s" => "bias_start_rad_s",
        "bias_sigma_rad_s" => "bias_sigma_start_rad_s",
        "limit_rad_s" => "gyro_range_rad_s",
        "margin_rad_s" => "gyro_range_margin_rad_s",
        "step_rad_s" => "gyro_count_rad_s",
        "raw_sigma_rad_s" => "gyro_raw_sigma_rad_s",
        "samples" => "gyro_samples",
        "false_alarms" => "test_false_alarms",
        "horizon_samples" => "test_horizon_samples",
        "kick_floor_rad_s" => "test_kick_floor_rad_s",
        other => other,
    };
    bad_parameter(ConfigError { name, ..error })
}
