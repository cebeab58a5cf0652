//! The estimator for a live rig, which switches between filters as the body demands, as the FMU
//! `LiveEstimator`.

use crate::exported::{ExportedEstimator, parameter};
use crate::filter::EXPERIMENT;
use crate::learning::{
    TESTED_ROWS, at_least_0, bad, config, float, output, test, tested_table, write_alarms,
    write_learnt,
};
use struna_estimator::{
    ConfigError, InputAxis, LiveConfig, LiveEstimator, RateEstimator, Status, SwingBody,
    SwingConfig,
};
use struna_fmi_export::{
    Domain, ModelDescription, ModelError, Unit, ValueReference, Values, Variable,
};

#[expect(clippy::cast_possible_truncation, reason = "a few dozen rows")]
const SWING_RAD: ValueReference = TESTED_ROWS as ValueReference;
const YIELD_ANGLE_RAD: ValueReference = SWING_RAD + 1;
const FIT_COLLECTED_S: ValueReference = SWING_RAD + 2;
const FIT_NEEDED_S: ValueReference = SWING_RAD + 3;
const SAMPLE_PERIOD_S: ValueReference = SWING_RAD + 4;
const SWING_MAX_RAD: ValueReference = SWING_RAD + 5;
const FIT_WORK_PER_SAMPLE: ValueReference = SWING_RAD + 6;
const BODY_MASS_KG: ValueReference = SWING_RAD + 7;
const BODY_COM_DEPTH_M: ValueReference = SWING_RAD + 8;
const BODY_INERTIA_X_KG_M2: ValueReference = SWING_RAD + 9;
const BODY_INERTIA_Y_KG_M2: ValueReference = SWING_RAD + 10;
const BODY_INERTIA_Z_KG_M2: ValueReference = SWING_RAD + 11;
const BODY_INERTIA_SIGMA: ValueReference = SWING_RAD + 12;
const BODY_SWING_DAMPING_1_S: ValueReference = SWING_RAD + 13;
const BODY_SWING_DAMPING_SIGMA: ValueReference = SWING_RAD + 14;
const GRAVITY_M_S2: ValueReference = SWING_RAD + 15;
const INPUT_AXIS_X_RAD: ValueReference = SWING_RAD + 16;
const INPUT_AXIS_Y_RAD: ValueReference = SWING_RAD + 17;
const INPUT_AXIS_SIGMA_RAD: ValueReference = SWING_RAD + 18;

/// What it shows besides angle, rate and what it has learnt.
const SHOWN: [Variable; 4] = {
    let swing = "Swing of the body in the last window of 2.56 s; 0 where it cannot be measured.";
    let yields = "Angle at which the thread yields while the status says so, else 0.";
    let collected = "Time of the swing collected for a fit while the status says so, else 0.";
    let needed = "Time of the swing that this fit needs, else 0.";
    [
        output(SWING_RAD, "swing_rad", Unit::RAD, swing),
        output(YIELD_ANGLE_RAD, "yield_angle_rad", Unit::RAD, yields),
        output(FIT_COLLECTED_S, "fit_collected_s", Unit::S, collected),
        output(FIT_NEEDED_S, "fit_needed_s", Unit::S, needed),
    ]
};

/// Pace and limits.
const BENCH: [Variable; 3] = {
    use parameter as p;
    let period = at_least_0(Unit::S, 0.01);
    let period_is = "Time from one measurement to the next when none is lost.";
    let swing = Domain::Float64 { unit: Unit::RAD, start: SWING_MAX_START_RAD, min: 0.0, max: 1.5 };
    let swing_is = "Largest swing that may happen; stands for the swing where none is measured.";
    let work = Domain::int32(50, 1, i32::MAX);
    let work_is =
        "Steps of work that a fit may do in each measurement, some ten microseconds each.";
    [
        p(SAMPLE_PERIOD_S, "sample_period_s", period, period_is),
        p(SWING_MAX_RAD, "swing_max_rad", swing, swing_is),
        p(FIT_WORK_PER_SAMPLE, "fit_work_per_sample", work, work_is),
    ]
};
/// Five degrees.
const SWING_MAX_START_RAD: f64 = std::f64::consts::PI / 36.0;

/// The body, declared or not, and the gyro on it.
const BODY: [Variable; 12] = {
    use parameter as p;
    let inertia = at_least_0(Unit::KG_M2, 0.0);
    let mass_is = "Mass; 0 declares no body: a swing then leaves no angle.";
    let depth_is = "Depth of the centre of mass below the point that the string holds.";
    let x_is = "Central principal moment of inertia about x.";
    let y_is = "Central principal moment of inertia about y.";
    let z_is = "Central principal moment of inertia about z, the axis of the twist.";
    let share_is = "Relative standard deviation of the moments about x and y.";
    let decay_is = "Decay of the swing: its amplitude falls as exp(-t times this).";
    let decay_share_is = "Relative standard deviation of that decay.";
    let axis = float(Unit::RAD, 0.0);
    let axis_x_is = "Component of the gyro's input axis along body x.";
    let axis_y_is = "Component of the gyro's input axis along body y.";
    let axis_sigma_is = "Standard deviation of both, from calibration.";
    [
        p(BODY_MASS_KG, "body_mass_kg", at_least_0(Unit::KG, 0.0), mass_is),
        p(BODY_COM_DEPTH_M, "body_com_depth_m", at_least_0(Unit::M, 0.0), depth_is),
        p(BODY_INERTIA_X_KG_M2, "body_inertia_x_kg_m2", inertia, x_is),
        p(BODY_INERTIA_Y_KG_M2, "body_inertia_y_kg_m2", inertia, y_is),
        p(BODY_INERTIA_Z_KG_M2, "body_inertia_z_kg_m2", inertia, z_is),
        p(BODY_INERTIA_SIGMA, "body_inertia_sigma", at_least_0(Unit::ONE, 0.02), share_is),
        p(BODY_SWING_DAMPING_1_S, "body_swing_damping_1_s", at_least_0(Unit::PER_S, 0.0), decay_is),
        p(
            BODY_SWING_DAMPING_SIGMA,
            "body_swing_damping_sigma",
            at_least_0(Unit::ONE, 0.5),
            decay_share_is,
        ),
        p(GRAVITY_M_S2, "gravity_m_s2", at_least_0(Unit::M_S2, 9.81), "Acceleration of gravity."),
        p(INPUT_AXIS_X_RAD, "input_axis_x_rad", axis, axis_x_is),
        p(INPUT_AXIS_Y_RAD, "input_axis_y_rad", axis, axis_y_is),
        p(INPUT_AXIS_SIGMA_RAD, "input_axis_sigma_rad", at_least_0(Unit::RAD, 0.0), axis_sigma_is),
    ]
};

const OWN_ROWS: usize = SHOWN.len() + BENCH.len() + BODY.len();

static VARIABLES: [Variable; TESTED_ROWS + OWN_ROWS] = {
    let mut own = [Variable::TIME; OWN_ROWS];
    let (shown, rest) = own.split_at_mut(SHOWN.len());
    shown.copy_from_slice(&SHOWN);
    let (bench, body) = rest.split_at_mut(BENCH.len());
    bench.copy_from_slice(&BENCH);
    body.copy_from_slice(&BODY);
    tested_table(&own)
};

/// The estimator.
#[derive(Debug)]
pub(crate) struct Live(LiveEstimator);

impl ExportedEstimator for Live {
    const DESCRIPTION: ModelDescription = ModelDescription::new(
        "LiveEstimator",
        env!("CARGO_PKG_VERSION"),
        "Estimator of angle and rate from one gyro for a live rig: a tested filter of torsion, and \
         in its place whatever a swinging body or a yielding thread demands, with a status that \
         says so.",
        EXPERIMENT,
        &VARIABLES,
    );

    fn from_values(values: &Values) -> Result<Self, ModelError> {
        LiveEstimator::new(&live_config(values)).map(Self).map_err(bad_of_body)
    }

    fn estimator(&self) -> &dyn RateEstimator {
        &self.0
    }

    fn estimator_mut(&mut self) -> &mut dyn RateEstimator {
        &mut self.0
    }

    fn write_more(&self, values: &mut Values) {
        let torsion = self.0.torsion();
        write_learnt(values, &torsion.filter().learnt());
        write_alarms(values, torsion.alarms());
        let status = self.0.status();
        let yield_angle_rad = match status {
            Status::ThreadYields { yield_angle_rad } => yield_angle_rad,
            _ => 0.0,
        };
        let (collected_s, needed_s) = match status {
            Status::Fitting { collected_s, needed_s } => (collected_s, needed_s),
            _ => (0.0, 0.0),
        };
        values.set_float64(SWING_RAD, self.0.swing_rad().unwrap_or(0.0));
        values.set_float64(YIELD_ANGLE_RAD, yield_angle_rad);
        values.set_float64(FIT_COLLECTED_S, collected_s);
        values.set_float64(FIT_NEEDED_S, needed_s);
    }
}

fn live_config(values: &Values) -> LiveConfig {
    LiveConfig {
        test: test(values),
        swing: (values.float64(BODY_MASS_KG) > 0.0).then(|| swing(values)),
        swing_max_rad: values.float64(SWING_MAX_RAD),
        // The variable's bounds leave no negative one; if any came, it would be refused as none.
        work_per_sample: u32::try_from(values.int32(FIT_WORK_PER_SAMPLE)).unwrap_or(0),
        ..LiveConfig::new(config(values), values.float64(SAMPLE_PERIOD_S))
    }
}

fn swing(values: &Values) -> SwingConfig {
    let body = SwingBody {
        mass_kg: values.float64(BODY_MASS_KG),
        com_depth_m: values.float64(BODY_COM_DEPTH_M),
        inertia_kg_m2: [BODY_INERTIA_X_KG_M2, BODY_INERTIA_Y_KG_M2, BODY_INERTIA_Z_KG_M2]
            .map(|moment| values.float64(moment)),
        gravity_m_s2: values.float64(GRAVITY_M_S2),
        swing_damping_1_s: values.float64(BODY_SWING_DAMPING_1_S),
    };
    let axis = InputAxis {
        tilt_b_rad: [INPUT_AXIS_X_RAD, INPUT_AXIS_Y_RAD].map(|part| values.float64(part)),
        tilt_sigma_rad: values.float64(INPUT_AXIS_SIGMA_RAD),
    };
    let torsion = config(values);
    let r_rad2_s2 = torsion.measurement_variance_rad2_s2;
    SwingConfig {
        inertia_sigma: values.float64(BODY_INERTIA_SIGMA),
        swing_damping_sigma: values.float64(BODY_SWING_DAMPING_SIGMA),
        ..SwingConfig::quiet(body, axis, torsion.start, r_rad2_s2)
    }
}

/// The estimator speaks of a body; here a name says whose values they are.
fn bad_of_body(error: ConfigError) -> ModelError {
    let name = match error.name {
        "mass_kg" => "body_mass_kg",
        "com_depth_m" => "body_com_depth_m",
        "inertia_a_kg_m2" => "body_inertia_x_kg_m2",
        "inertia_b_kg_m2" => "body_inertia_y_kg_m2",
        "inertia_c_kg_m2" => "body_inertia_z_kg_m2",
        "swing_damping_1_s" => "body_swing_damping_1_s",
        "inertia_sigma" => "body_inertia_sigma",
        "swing_damping_sigma" => "body_swing_damping_sigma",
        "tilt_b_rad[0]" => "input_axis_x_rad",
        "tilt_b_rad[1]" => "input_axis_y_rad",
        "tilt_sigma_rad" => "input_axis_sigma_rad",
        other => other,
    };
    bad(ConfigError { name, ..error })
}
