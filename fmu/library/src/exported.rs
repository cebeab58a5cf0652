//! What estimators with a status have in common as FMUs.
//!
//! The first rows are those of the filters of 2008, so that an importer treats all alike. One input
//! more tells that the gyro clipped, and one output more how far the angle may be trusted.

use crate::filter::{
    ANGLE_RAD, ANGLE_SIGMA_RAD, COMMON_VARIABLES, INNOVATION_RAD_S, MEASURED_RATE_RAD_S,
    MEASURED_RATE_VALID, NIS, RATE_RAD_S, RATE_SIGMA_RAD_S, bad_state,
};
use std::fmt::Debug;
use struna_estimator::{Belief, Covariance, EstimatorError, Innovation, RateEstimator};
use struna_fmi_export::{
    Domain, Model, ModelDescription, ModelError, Role, ValueReference, Values, Variable,
};

pub(crate) const MEASURED_RATE_OVER_RANGE: ValueReference = 9;
pub(crate) const STATUS: ValueReference = 10;
pub(crate) const MEASURED_RATE_IS_MEAN: ValueReference = 11;

/// The rows that every such estimator has.
pub(crate) const ROWS: usize = 12;

/// The outputs whose values at the start follow from an estimator's own parameters.
pub(crate) struct Starts {
    pub(crate) angle: &'static [ValueReference],
    pub(crate) rate: &'static [ValueReference],
    pub(crate) angle_sigma: &'static [ValueReference],
    pub(crate) rate_sigma: &'static [ValueReference],
    pub(crate) status: &'static [ValueReference],
}

pub(crate) const fn parameter(
    reference: ValueReference,
    name: &'static str,
    domain: Domain,
    meaning: &'static str,
) -> Variable {
    Variable::new(reference, Role::Parameter, name, domain, meaning)
}

/// The beginning of the variable table of an estimator whose outputs start from `starts`.
pub(crate) const fn first_rows(starts: &Starts) -> [Variable; ROWS] {
    let common = &COMMON_VARIABLES;
    let over_range = "The gyro itself marks the rate as clipped: it is then noted and not used.";
    let status = "How far the angle may be trusted. 0: nominal. 1: swinging, and followed. \
                  2: swinging, not yet fitted. 3: disturbed a while ago. 4: the body does not move \
                  as assumed. 5: the thread yields. 6: there is no angle.";
    let over_range = Variable::new(
        MEASURED_RATE_OVER_RANGE,
        Role::Input,
        "measured_rate_over_range",
        Domain::boolean(false),
        over_range,
    );
    let status = Variable::new(STATUS, Role::Output, "status", Domain::int32(0, 0, 6), status)
        .starting_from(starts.status)
        .on_demand();
    let mean =
        "True: the measured rate is the mean over the step. False: it is the rate at its end.";
    let domain = Domain::boolean(false);
    let mean = parameter(MEASURED_RATE_IS_MEAN, "measured_rate_is_mean", domain, mean);
    [
        common[0],
        common[MEASURED_RATE_RAD_S as usize],
        common[MEASURED_RATE_VALID as usize],
        common[ANGLE_RAD as usize].starting_from(starts.angle),
        common[RATE_RAD_S as usize].starting_from(starts.rate),
        common[ANGLE_SIGMA_RAD as usize].starting_from(starts.angle_sigma),
        common[RATE_SIGMA_RAD_S as usize].starting_from(starts.rate_sigma),
        common[INNOVATION_RAD_S as usize],
        common[NIS as usize],
        over_range,
        status,
        mean,
    ]
}

/// An estimator that is exported, configured by the values of its parameters.
pub(crate) trait ExportedEstimator: Debug + Send + Sized + 'static {
    /// Name and variable table; the table begins with [`first_rows`].
    const DESCRIPTION: ModelDescription;

    /// The estimator with the given parameters.
    fn from_values(values: &Values) -> Result<Self, ModelError>;

    /// What holds the belief.
    fn estimator(&self) -> &dyn RateEstimator;

    /// The same, to be changed.
    fn estimator_mut(&mut self) -> &mut dyn RateEstimator;

    /// Predicts and takes a measurement in: both, or neither.
    fn step(&mut self, span_s: f64, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        whole(self.estimator_mut(), span_s, rate_rad_s, |e| e.step(span_s, rate_rad_s))
    }

    /// The same with the mean over the span.
    fn step_mean(&mut self, span_s: f64, rate_rad_s: f64) -> Result<Innovation, EstimatorError> {
        whole(self.estimator_mut(), span_s, rate_rad_s, |e| e.step_mean(span_s, rate_rad_s))
    }

    /// Predicts and notes a measurement that the gyro flags as over range: both, or neither.
    fn step_over_range(
        &mut self,
        span_s: f64,
        rate_rad_s: f64,
    ) -> Result<Innovation, EstimatorError> {
        let note = |estimator: &mut dyn RateEstimator| {
            estimator.predict(span_s)?;
            estimator.update_over_range(rate_rad_s)
        };
        whole(self.estimator_mut(), span_s, rate_rad_s, note)
    }

    /// Writes the outputs beyond [`first_rows`], all of them on demand.
    fn write_more(&self, values: &mut Values);
}

/// Numbers up to this size can be squared, multiplied and added as estimators do without leaving
/// the range of floating point. No gyro and no body has larger ones.
const TAME: f64 = 1e30;

/// Makes a `step` of several calls, for estimators that cannot do all at once. If one is refused
/// those before it are taken back.
///
/// An update is refused when its numbers leave the range of floating point, and for nothing else:
/// the C layer lets finite inputs in alone. So the way back, a copy of all that the estimator
/// keeps, is laid when a number is wild, and costs nothing as long as none is.
fn whole(
    estimator: &mut dyn RateEstimator,
    span_s: f64,
    rate_rad_s: f64,
    step: impl FnOnce(&mut dyn RateEstimator) -> Result<Innovation, EstimatorError>,
) -> Result<Innovation, EstimatorError> {
    let Belief { angle_rad, rate_rad_s: believed_rad_s, covariance } = estimator.belief();
    let Covariance { angle_rad2, rate_rad2_s2, .. } = covariance;
    let numbers = [span_s, rate_rad_s, angle_rad, believed_rad_s, angle_rad2, rate_rad2_s2];
    let is_tame = numbers.iter().all(|number| number.abs() <= TAME);
    let way_back = (!is_tame).then(|| {
        let mut saved = vec![0; estimator.saved_len()];
        estimator.save(&mut saved);
        saved
    });
    let stepped = step(estimator);
    if let (Err(_), Some(saved)) = (&stepped, way_back) {
        estimator.restore(&saved).expect("an estimator takes its own bytes");
    }
    stepped
}

/// An estimator as an FMU.
#[derive(Debug)]
pub(crate) struct EstimatorModel<E> {
    exported: E,
    /// Of the last step; none if it had no measurement.
    innovation: Option<Innovation>,
}

impl<E: ExportedEstimator> Model for EstimatorModel<E> {
    const DESCRIPTION: ModelDescription = E::DESCRIPTION;

    fn initialise(values: &Values, _start_time_s: f64) -> Result<Self, ModelError> {
        Ok(Self { exported: E::from_values(values)?, innovation: None })
    }

    fn step(&mut self, values: &Values, _time_s: f64, step_s: f64) -> Result<(), ModelError> {
        let rate_rad_s = values.float64(MEASURED_RATE_RAD_S);
        let stepped = if !values.boolean(MEASURED_RATE_VALID) {
            self.exported.estimator_mut().predict(step_s).map(|()| None)
        } else if values.boolean(MEASURED_RATE_OVER_RANGE) {
            self.exported.step_over_range(step_s, rate_rad_s).map(Some)
        } else if values.boolean(MEASURED_RATE_IS_MEAN) {
            self.exported.step_mean(step_s, rate_rad_s).map(Some)
        } else {
            self.exported.step(step_s, rate_rad_s).map(Some)
        };
        self.innovation =
            stepped.map_err(|error| ModelError::Step { reason: error.to_string().into() })?;
        Ok(())
    }

    fn write_outputs(&self, values: &mut Values) {
        let belief = self.exported.estimator().belief();
        values.set_float64(ANGLE_RAD, belief.angle_rad);
        values.set_float64(RATE_RAD_S, belief.rate_rad_s);
        values.set_float64(INNOVATION_RAD_S, self.innovation.map_or(0.0, |i| i.residual_rad_s));
    }

    fn write_outputs_on_demand(&self, values: &mut Values) {
        let estimator = self.exported.estimator();
        let Covariance { angle_rad2, rate_rad2_s2, .. } = estimator.belief().covariance;
        values.set_float64(ANGLE_SIGMA_RAD, angle_rad2.sqrt());
        values.set_float64(RATE_SIGMA_RAD_S, rate_rad2_s2.sqrt());
        values.set_float64(NIS, self.innovation.map_or(0.0, |i| i.nis()));
        values.set_int32(STATUS, estimator.status().code());
        self.exported.write_more(values);
    }

    fn save(&self, saved: &mut Vec<u8>) {
        let (start, estimator) = (saved.len(), self.exported.estimator());
        saved.resize(start + estimator.saved_len(), 0);
        estimator.save(&mut saved[start..]);
    }

    /// The innovation is not brought back: it is an output of the last step, and outputs are among
    /// the values.
    fn restore(values: &Values, saved: &[u8]) -> Result<Self, ModelError> {
        let mut exported = E::from_values(values)?;
        exported.estimator_mut().restore(saved).map_err(bad_state)?;
        Ok(Self { exported, innovation: None })
    }
}
