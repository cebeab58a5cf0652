//! One instance of a model, and the order in which its functions may be called.

use crate::log::{Log, LogCategory};
use crate::model::{ModelType, Running};
use crate::slots::Handle;
use crate::state::{Snapshots, State, deserialize, serialize, serialized_len};
use crate::status::{Reason, Refusal};
use crate::values::Values;
use crate::variable::{ValueReference, Variable};

/// Value reference of time, in every table.
const TIME: ValueReference = Variable::TIME.value_reference;

/// Where an instance is in its life; later phases compare greater.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub(crate) enum Phase {
    /// Parameters and inputs may be set.
    Instantiated,
    /// As before, and outputs may be read on trial.
    Initialization,
    /// Steps may be done.
    Step,
    /// Values may be read.
    Terminated,
    /// A panic went through the model: nothing but freeing is left.
    Fatal,
}

impl std::fmt::Display for Phase {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Instantiated => "before initialization mode",
            Self::Initialization => "in initialization mode",
            Self::Step => "in step mode",
            Self::Terminated => "after termination",
            Self::Fatal => "after a panic",
        })
    }
}

/// The span of time to be simulated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Experiment {
    pub(crate) start_s: f64,
    /// Infinite when the importer names no end.
    pub(crate) stop_s: f64,
}

impl Experiment {
    pub(crate) fn new(start_s: f64, stop_s: Option<f64>) -> Result<Self, Refusal> {
        let bad = |quantity, value, bound| Err(Reason::BadNumber { quantity, value, bound }.into());
        if !start_s.is_finite() {
            return bad("start time", start_s, "finite");
        }
        match stop_s {
            None => Ok(Self { start_s, stop_s: f64::INFINITY }),
            Some(stop_s) if stop_s.is_finite() && stop_s >= start_s => Ok(Self { start_s, stop_s }),
            Some(stop_s) => bad("stop time", stop_s, "finite and not before the start time"),
        }
    }
}

/// One instance. Reached from C through [`crate::barrier::enter`] only.
#[derive(Debug)]
pub(crate) struct Instance {
    model_type: &'static ModelType,
    state: State,
    snapshots: Snapshots,
    log: Log,
}

impl Instance {
    pub(crate) fn new(model_type: &'static ModelType, log: Log) -> Self {
        let state = State::fresh(model_type);
        Self { model_type, state, snapshots: Snapshots::default(), log }
    }

    pub(crate) fn model_type(&self) -> &'static ModelType {
        self.model_type
    }

    #[inline]
    pub(crate) fn phase(&self) -> Phase {
        self.state.phase
    }

    pub(crate) fn log(&self) -> &Log {
        &self.log
    }

    pub(crate) fn values(&self) -> &Values {
        &self.state.values
    }

    pub(crate) fn values_mut(&mut self) -> &mut Values {
        &mut self.state.values
    }

    /// The current communication point, s.
    pub(crate) fn time_s(&self) -> f64 {
        self.state.values.float64(TIME)
    }

    /// Gives the instance up after a panic.
    pub(crate) fn poison(&mut self) {
        self.state.phase = Phase::Fatal;
    }

    /// Switches log categories; no names mean all of them, and off means all off.
    pub(crate) fn set_debug_logging(&mut self, on: bool, names: &[String]) -> Result<(), Refusal> {
        let named = |name: &String| {
            let found =
                LogCategory::ALL.into_iter().find(|c| c.name().to_bytes() == name.as_bytes());
            found.ok_or_else(|| Reason::UnknownLogCategory { name: name.clone() })
        };
        let categories = names.iter().map(named).collect::<Result<Vec<_>, _>>()?;
        self.log.want_only(match (on, categories.as_slice()) {
            (false, _) => &[],
            (true, []) => &LogCategory::ALL,
            (true, some) => some,
        });
        Ok(())
    }

    /// Refuses the call outside `phase`.
    pub(crate) fn require(&self, phase: Phase, rule: &'static str) -> Result<(), Refusal> {
        if self.state.phase == phase {
            return Ok(());
        }
        Err(Reason::WrongPhase { phase: self.state.phase, rule }.into())
    }

    pub(crate) fn set_up_experiment(&mut self, experiment: Experiment) -> Result<(), Refusal> {
        self.require(Phase::Instantiated, "the experiment is set up before initialization mode")?;
        self.state.experiment = Some(experiment);
        self.state.values.set_float64(TIME, experiment.start_s);
        Ok(())
    }

    pub(crate) fn enter_initialization_mode(&mut self) -> Result<(), Refusal> {
        self.require(Phase::Instantiated, "initialization follows instantiation or a reset")?;
        if self.state.experiment.is_none() {
            let rule = "the experiment must be set up first, or no start time is known";
            return Err(Reason::WrongPhase { phase: self.state.phase, rule }.into());
        }
        self.state.phase = Phase::Initialization;
        Ok(())
    }

    pub(crate) fn exit_initialization_mode(&mut self) -> Result<(), Refusal> {
        self.require(Phase::Initialization, "initialization mode has not been entered")?;
        let running = self.initialise()?;
        running.write_outputs(&mut self.state.values);
        self.state.running = Some(running);
        self.state.phase = Phase::Step;
        Ok(())
    }

    /// The outputs on demand are those of an earlier step.
    #[inline]
    pub(crate) fn owes_outputs(&self) -> bool {
        self.state.owed
    }

    /// Brings the outputs on demand up to the last step.
    pub(crate) fn settle_outputs(&mut self) {
        self.state.settle();
    }

    /// Outputs as they would be if initialisation ended now.
    #[cold]
    pub(crate) fn write_trial_outputs(&mut self) -> Result<(), Refusal> {
        self.require(Phase::Initialization, "outputs are first calculated in initialization mode")?;
        self.initialise()?.write_outputs(&mut self.state.values);
        Ok(())
    }

    /// Starts a model with the present parameters and inputs, if they are all within bounds.
    fn initialise(&self) -> Result<Box<dyn Running>, Refusal> {
        let values = &self.state.values;
        for variable in self.model_type.description.variables.iter().filter(|v| v.has_start()) {
            variable.check_bounds(values.bits(variable.value_reference))?;
        }
        Ok((self.model_type.initialise)(values, self.time_s())?)
    }

    /// Advances from the communication point `time_s` by `step_s`.
    #[inline]
    pub(crate) fn do_step(&mut self, time_s: f64, step_s: f64) -> Result<(), Refusal> {
        let State { phase: Phase::Step, running: Some(running), values, experiment, owed } =
            &mut self.state
        else {
            return self.require(Phase::Step, "steps follow initialization and end at termination");
        };
        let stop_s = experiment.map_or(f64::INFINITY, |e| e.stop_s);
        let end_s = check_step(values.float64(TIME), stop_s, time_s, step_s)?;
        running.step(values, time_s, step_s)?;
        values.set_float64(TIME, end_s);
        *owed = true;
        Ok(())
    }

    pub(crate) fn terminate(&mut self) -> Result<(), Refusal> {
        self.require(Phase::Step, "only a running model can be terminated")?;
        self.state.phase = Phase::Terminated;
        Ok(())
    }

    /// Back to the state after instantiation. Saved FMU states and logging stay.
    pub(crate) fn reset(&mut self) -> Result<(), Refusal> {
        self.state = State::fresh(self.model_type);
        Ok(())
    }

    /// Saves the present state over the one at `at`, or as a new one when `at` is null.
    pub(crate) fn save_state(&mut self, at: Handle) -> Result<Handle, Refusal> {
        self.state.settle();
        self.snapshots.keep(at, self.state.to_body())
    }

    pub(crate) fn restore_state(&mut self, at: Handle) -> Result<(), Refusal> {
        self.state = State::from_body(self.model_type, self.snapshots.body(at)?)?;
        Ok(())
    }

    pub(crate) fn free_state(&mut self, at: Handle) -> Result<(), Refusal> {
        self.snapshots.free(at)
    }

    /// The length of [`serialize_state`](Self::serialize_state)'s result.
    pub(crate) fn serialized_state_len(&self, at: Handle) -> Result<usize, Refusal> {
        Ok(serialized_len(self.snapshots.body(at)?.len()))
    }

    pub(crate) fn serialize_state(&self, at: Handle) -> Result<Vec<u8>, Refusal> {
        Ok(serialize(self.model_type, self.snapshots.body(at)?))
    }

    /// Takes a serialized state in, over the one at `at` or as a new one when `at` is null.
    pub(crate) fn deserialize_state(
        &mut self,
        bytes: &[u8],
        at: Handle,
    ) -> Result<Handle, Refusal> {
        let body = deserialize(self.model_type, bytes)?;
        // Judged now, by restoring it on trial, rather than when it is first needed.
        State::from_body(self.model_type, body)?;
        self.snapshots.keep(at, body.to_vec())
    }
}

/// How far a communication point may lie from the end of the last step, s: 2 ns, because an
/// importer that counts time in whole nanoseconds rounds both ends of a step, and a few units in
/// the last place, because t + h is rounded too. A step lost or done twice is far beyond.
fn communication_point_tolerance_s(time_s: f64) -> f64 {
    2e-9 + 4.0 * f64::EPSILON * time_s.abs()
}

/// Judges a step and gives its end, s.
#[inline]
fn check_step(expected: f64, stop: f64, given: f64, step_s: f64) -> Result<f64, Refusal> {
    if !(step_s > 0.0 && step_s <= f64::MAX) {
        let (quantity, bound) = ("communication step size", "positive and finite");
        return Err(Reason::BadNumber { quantity, value: step_s, bound }.into());
    }
    let tolerance_s = communication_point_tolerance_s(expected);
    let near = (given - expected).abs() <= tolerance_s; // false for NaN
    if !near {
        return Err(Reason::WrongCommunicationPoint { given, expected }.into());
    }
    let end_s = given + step_s;
    if end_s > stop + tolerance_s || end_s == f64::INFINITY {
        return Err(Reason::PastStopTime { from: given, to: end_s, stop }.into());
    }
    Ok(end_s)
}
