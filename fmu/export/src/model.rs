//! The trait that a model implements to become an FMU.

use crate::description::ModelDescription;
use crate::status::Refusal;
use crate::values::Values;
use crate::{FmiVersion, fmi2, fmi3};
use std::borrow::Cow;
use std::fmt::Debug;

/// A co-simulation model. A value exists from the end of initialisation on, so none is half-made.
///
/// The C layer keeps the variables' [`Values`]; a model keeps only what evolves. It never meets a
/// pointer, a wrong call order or a value that is not finite.
pub trait Model: Debug + Send + Sized + 'static {
    /// Name, version and variable table.
    const DESCRIPTION: ModelDescription;

    /// Starts the model at `start_time_s` with the given parameters and inputs. May be called
    /// several times on trial before initialisation ends.
    ///
    /// # Errors
    /// [`ModelError::BadValue`] names the parameter that it cannot work with.
    fn initialise(values: &Values, start_time_s: f64) -> Result<Self, ModelError>;

    /// Advances from `time_s` by `step_s` (positive and finite) under the given inputs.
    ///
    /// # Errors
    /// [`ModelError::Step`]; the model must then be as it was before the call.
    fn step(&mut self, values: &Values, time_s: f64, step_s: f64) -> Result<(), ModelError>;

    /// Writes the outputs that follow from the present state. Called after initialisation and
    /// after each completed step, never after a refused one.
    fn write_outputs(&self, values: &mut Values);

    /// Writes the outputs whose rows are [on demand](crate::Variable::on_demand): those too dear
    /// for every step and seldom read. Called, once per step at most, before one of them is read
    /// or the state is saved. They must follow from the model alone: inputs may have been set since
    /// the step.
    fn write_outputs_on_demand(&self, _values: &mut Values) {}

    /// Appends everything that evolves, parameters excluded.
    fn save(&self, saved: &mut Vec<u8>);

    /// A model that continues, bit for bit, as the one saved would have.
    ///
    /// # Errors
    /// [`ModelError::BadState`] when the bytes cannot come from [`save`](Self::save).
    fn restore(values: &Values, saved: &[u8]) -> Result<Self, ModelError>;
}

/// Why a model refuses a call.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A parameter or input that it cannot work with.
    #[error("{variable} = {value} is refused: {reason}")]
    BadValue {
        /** The variable's name. */
        variable: &'static str,
        /** Its value. */
        value: f64,
        /** What is wrong with it. */
        reason: Cow<'static, str>,
    },
    /// The step cannot be done.
    #[error("the step is refused: {reason}")]
    Step {
        /** What is in the way. */
        reason: Cow<'static, str>,
    },
    /// Saved bytes that are no state of this model.
    #[error("the saved state is refused: {reason}")]
    BadState {
        /** What is wrong with them. */
        reason: Cow<'static, str>,
    },
}

/// A model past initialisation, its type forgotten.
pub(crate) trait Running: Debug + Send {
    /// Steps, and writes the outputs if the step was not refused, save those on demand. Refuses in
    /// the C layer's terms, which fit a register.
    fn step(&mut self, values: &mut Values, time_s: f64, step_s: f64) -> Result<(), Refusal>;
    /// All outputs, those on demand included.
    fn write_outputs(&self, values: &mut Values);
    fn write_outputs_on_demand(&self, values: &mut Values);
    fn save(&self, saved: &mut Vec<u8>);
}

impl<M: Model> Running for M {
    fn step(&mut self, values: &mut Values, time_s: f64, step_s: f64) -> Result<(), Refusal> {
        Model::step(self, values, time_s, step_s)?;
        Model::write_outputs(self, values);
        Ok(())
    }

    fn write_outputs(&self, values: &mut Values) {
        Model::write_outputs(self, values);
        Model::write_outputs_on_demand(self, values);
    }

    fn write_outputs_on_demand(&self, values: &mut Values) {
        Model::write_outputs_on_demand(self, values);
    }

    fn save(&self, saved: &mut Vec<u8>) {
        Model::save(self, saved);
    }
}

type Initialise = fn(&Values, f64) -> Result<Box<dyn Running>, ModelError>;
type Restore = fn(&Values, &[u8]) -> Result<Box<dyn Running>, ModelError>;

/// One model of a library: what the C layer needs to describe, start and restore it.
///
/// A library lists its models as a static slice of these; the instantiation token picks one.
#[derive(Debug)]
pub struct ModelType {
    pub(crate) description: ModelDescription,
    pub(crate) token: [u8; 64],
    pub(crate) initialise: Initialise,
    pub(crate) restore: Restore,
}

impl ModelType {
    /// The type of `M`, evaluated while compiling: the token stands in the library as plain bytes.
    #[must_use]
    pub const fn of<M: Model>() -> Self {
        Self {
            description: M::DESCRIPTION,
            token: M::DESCRIPTION.token(),
            initialise: |values, start_time_s| {
                M::initialise(values, start_time_s).map(|m| Box::new(m) as Box<dyn Running>)
            },
            restore: |values, saved| {
                M::restore(values, saved).map(|m| Box::new(m) as Box<dyn Running>)
            },
        }
    }

    /// Name, version and variable table.
    #[must_use]
    pub const fn description(&self) -> &ModelDescription {
        &self.description
    }

    /// The instantiation token (FMI 2.0: GUID): 64 hexadecimal digits that change with the name,
    /// the version and anything in the variable table.
    #[must_use]
    pub fn instantiation_token(&self) -> &str {
        // Hexadecimal digits are ASCII, so there is no default to fall back on.
        std::str::from_utf8(&self.token).unwrap_or_default()
    }

    /// The text of `modelDescription.xml`. The same model gives the same bytes.
    #[must_use]
    pub fn model_description_xml(&self, version: FmiVersion) -> String {
        match version {
            FmiVersion::Fmi2 => fmi2::description::xml(self),
            FmiVersion::Fmi3 => fmi3::description::xml(self),
        }
    }
}
