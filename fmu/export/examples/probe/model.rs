//! A model with variables of every type and role that panics, or refuses a step, when told to.

use struna_fmi_export::{
    DefaultExperiment, Domain, Model, ModelDescription, ModelError, Role, Unit, ValueReference,
    Values, Variable,
};

const RATE_RAD_S: ValueReference = 1;
const INCREMENT: ValueReference = 2;
const PANIC_NOW: ValueReference = 3;
const REFUSE_NOW: ValueReference = 4;
const ANGLE_START_RAD: ValueReference = 5;
const COUNT_START: ValueReference = 6;
const REVERSED: ValueReference = 7;
const GAIN: ValueReference = 8;
const ANGLE_RAD: ValueReference = 9;
const COUNT: ValueReference = 10;
const ODD: ValueReference = 11;

static VARIABLES: [Variable; 12] = {
    use Role::{Input, Output, Parameter, TunableParameter};
    let gain = Domain::Float64 { unit: Unit::ONE, start: 1.0, min: 0.0, max: 2.0 };
    [
        Variable::TIME,
        Variable::new(
            RATE_RAD_S,
            Input,
            "rate_rad_s",
            Domain::float64(Unit::RAD_S, 0.0),
            "Rate & sign; is \"integrated\" <exactly>.",
        ),
        Variable::new(INCREMENT, Input, "increment", Domain::int32(1, -9, 9), "Added each step."),
        Variable::new(PANIC_NOW, Input, "panic_now", Domain::boolean(false), "Panic in a step."),
        Variable::new(REFUSE_NOW, Input, "refuse_now", Domain::boolean(false), "Refuse a step."),
        Variable::new(
            ANGLE_START_RAD,
            Parameter,
            "angle_start_rad",
            Domain::not_negative(Unit::RAD, 0.25),
            "Angle at the start.",
        ),
        Variable::new(
            COUNT_START,
            Parameter,
            "count_start",
            Domain::int32(-7, i32::MIN, i32::MAX),
            "Count at the start; 13 is refused.",
        ),
        Variable::new(REVERSED, Parameter, "reversed", Domain::boolean(false), "Count down."),
        Variable::new(GAIN, TunableParameter, "gain", gain, "Factor on the rate."),
        Variable::new(
            ANGLE_RAD,
            Output,
            "angle_rad",
            Domain::float64(Unit::RAD, 0.0),
            "Integral of the rate.",
        )
        .starting_from(&[ANGLE_START_RAD]),
        Variable::new(COUNT, Output, "count", Domain::int32(0, i32::MIN, i32::MAX), "Sum.")
            .starting_from(&[COUNT_START]),
        Variable::new(ODD, Output, "odd", Domain::boolean(false), "The count is odd.")
            .starting_from(&[COUNT_START])
            .on_demand(),
    ]
};

/// Integrates a rate and counts.
#[derive(Debug)]
pub(crate) struct Probe {
    angle_rad: f64,
    count: i32,
}

impl Model for Probe {
    const DESCRIPTION: ModelDescription = ModelDescription::new(
        "Probe",
        "1.0",
        "A model that misbehaves on demand.",
        DefaultExperiment { stop_time_s: 1.0, step_size_s: 0.125 },
        &VARIABLES,
    );

    fn initialise(values: &Values, _start_time_s: f64) -> Result<Self, ModelError> {
        let (angle_rad, count) = (values.float64(ANGLE_START_RAD), values.int32(COUNT_START));
        if count == 13 {
            let (variable, reason) = ("count_start", "it is unlucky".into());
            return Err(ModelError::BadValue { variable, value: f64::from(count), reason });
        }
        Ok(Self { angle_rad, count })
    }

    #[expect(clippy::panic, reason = "panicking is what this model is for")]
    fn step(&mut self, values: &Values, _time_s: f64, step_s: f64) -> Result<(), ModelError> {
        if values.boolean(REFUSE_NOW) {
            return Err(ModelError::Step { reason: "it was told to refuse".into() });
        }
        self.angle_rad += values.float64(GAIN) * values.float64(RATE_RAD_S) * step_s;
        let sign = if values.boolean(REVERSED) { -1 } else { 1 };
        self.count = self.count.wrapping_add(sign * values.int32(INCREMENT));
        if values.boolean(PANIC_NOW) {
            panic!("told to panic at count {}", self.count);
        }
        Ok(())
    }

    fn write_outputs(&self, values: &mut Values) {
        values.set_float64(ANGLE_RAD, self.angle_rad);
        values.set_int32(COUNT, self.count);
    }

    fn write_outputs_on_demand(&self, values: &mut Values) {
        values.set_boolean(ODD, self.count % 2 != 0);
    }

    fn save(&self, saved: &mut Vec<u8>) {
        saved.extend(self.angle_rad.to_le_bytes());
        saved.extend(self.count.to_le_bytes());
    }

    fn restore(_values: &Values, saved: &[u8]) -> Result<Self, ModelError> {
        let bad = || ModelError::BadState { reason: "a probe saves 12 bytes".into() };
        let (angle, count) = saved.split_first_chunk().ok_or_else(bad)?;
        let count = count.try_into().map_err(|_| bad())?;
        Ok(Self { angle_rad: f64::from_le_bytes(*angle), count: i32::from_le_bytes(count) })
    }
}
