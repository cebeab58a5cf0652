//! FMI 2.0 calls, translated. The first argument is the C function's name, for log lines.
//!
//! # Safety
//! Of every function here: pointers must be what the standard asks for, and no other thread may be
//! inside a call with the same component.

#![expect(missing_docs, clippy::missing_safety_doc, reason = "see the module and the standard")]

use super::types::{
    fmi2Boolean, fmi2Byte, fmi2CallbackFunctions, fmi2CoSimulation, fmi2Component, fmi2FMUstate,
    fmi2Integer, fmi2LastSuccessfulTime, fmi2Real, fmi2Status, fmi2StatusKind, fmi2String,
    fmi2Terminated, fmi2Type, fmi2ValueReference,
};
use crate::access::{Float64, Int32, IntBoolean};
use crate::barrier::{enter, leave};
use crate::c_array::COutput;
use crate::calls::{self, Request};
use crate::instance::{Experiment, Instance};
use crate::log::LogCallback;
use crate::model::ModelType;
use crate::status::Reason;

/// What [`instantiate`] is told.
#[derive(Debug)]
pub struct Instantiate {
    pub models: &'static [ModelType],
    pub instance_name: fmi2String,
    pub fmu_type: fmi2Type,
    pub guid: fmi2String,
    pub functions: *const fmi2CallbackFunctions,
    pub logging_on: fmi2Boolean,
}

pub unsafe fn instantiate(function: &'static str, asked: &Instantiate) -> fmi2Component {
    let functions = asked.functions;
    // SAFETY: null or a callback structure, by the caller's promise.
    let functions = (!functions.is_null()).then(|| unsafe { functions.read_unaligned() });
    let (logger, environment) =
        functions.map_or((None, std::ptr::null_mut()), |f| (f.logger, f.componentEnvironment));
    let request = Request {
        function,
        instance_name: asked.instance_name,
        token: asked.guid,
        callback: LogCallback::Fmi2(logger, environment),
        logging_on: asked.logging_on != 0,
        unsupported: (asked.fmu_type != fmi2CoSimulation).then_some("model exchange"),
    };
    // SAFETY: promised by the caller.
    unsafe { calls::instantiate(asked.models, &request) }
}

pub unsafe fn free_instance(_function: &'static str, c: fmi2Component) {
    // SAFETY: promised by the caller.
    unsafe { leave(c) }
}

pub unsafe fn set_debug_logging(
    function: &'static str,
    c: fmi2Component,
    logging_on: fmi2Boolean,
    n_categories: usize,
    categories: *const fmi2String,
) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe { calls::set_debug_logging(function, c, logging_on != 0, (categories, n_categories)) }
}

#[expect(clippy::too_many_arguments, reason = "the signature of the standard")]
pub unsafe fn setup_experiment(
    function: &'static str,
    c: fmi2Component,
    _tolerance_defined: fmi2Boolean,
    _tolerance: fmi2Real,
    start_time: fmi2Real,
    stop_time_defined: fmi2Boolean,
    stop_time: fmi2Real,
) -> fmi2Status {
    let stop_s = (stop_time_defined != 0).then_some(stop_time);
    let call = |i: &mut Instance| i.set_up_experiment(Experiment::new(start_time, stop_s)?);
    // SAFETY: promised by the caller.
    unsafe { enter(c, function, call) }
}

pub unsafe fn enter_initialization_mode(function: &'static str, c: fmi2Component) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe { enter(c, function, Instance::enter_initialization_mode) }
}

pub unsafe fn exit_initialization_mode(function: &'static str, c: fmi2Component) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe { enter(c, function, Instance::exit_initialization_mode) }
}

pub unsafe fn terminate(function: &'static str, c: fmi2Component) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe { enter(c, function, Instance::terminate) }
}

pub unsafe fn reset(function: &'static str, c: fmi2Component) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe { enter(c, function, Instance::reset) }
}

#[inline]
pub unsafe fn get_real(
    function: &'static str,
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe { calls::get::<Float64>(function, c, (vr, nvr), (value, nvr)) }
}

pub unsafe fn get_integer(
    function: &'static str,
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Integer,
) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe { calls::get::<Int32>(function, c, (vr, nvr), (value, nvr)) }
}

pub unsafe fn get_boolean(
    function: &'static str,
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe { calls::get::<IntBoolean>(function, c, (vr, nvr), (value, nvr)) }
}

#[inline]
pub unsafe fn set_real(
    function: &'static str,
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Real,
) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe { calls::set::<Float64>(function, c, (vr, nvr), (value, nvr)) }
}

pub unsafe fn set_integer(
    function: &'static str,
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Integer,
) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe { calls::set::<Int32>(function, c, (vr, nvr), (value, nvr)) }
}

pub unsafe fn set_boolean(
    function: &'static str,
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Boolean,
) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe { calls::set::<IntBoolean>(function, c, (vr, nvr), (value, nvr)) }
}

pub unsafe fn get_fmu_state(
    function: &'static str,
    c: fmi2Component,
    state: *mut fmi2FMUstate,
) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe { calls::get_state(function, c, state) }
}

pub unsafe fn set_fmu_state(
    function: &'static str,
    c: fmi2Component,
    state: fmi2FMUstate,
) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe { calls::set_state(function, c, state) }
}

pub unsafe fn free_fmu_state(
    function: &'static str,
    c: fmi2Component,
    state: *mut fmi2FMUstate,
) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe { calls::free_state(function, c, state) }
}

pub unsafe fn serialized_fmu_state_size(
    function: &'static str,
    c: fmi2Component,
    state: fmi2FMUstate,
    size: *mut usize,
) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe { calls::serialized_state_size(function, c, state, size) }
}

pub unsafe fn serialize_fmu_state(
    function: &'static str,
    c: fmi2Component,
    state: fmi2FMUstate,
    bytes: *mut fmi2Byte,
    size: usize,
) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe { calls::serialize_state(function, c, state, (bytes.cast(), size)) }
}

pub unsafe fn deserialize_fmu_state(
    function: &'static str,
    c: fmi2Component,
    bytes: *const fmi2Byte,
    size: usize,
    state: *mut fmi2FMUstate,
) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe { calls::deserialize_state(function, c, (bytes.cast(), size), state) }
}

#[inline]
pub unsafe fn do_step(
    function: &'static str,
    c: fmi2Component,
    current_communication_point: fmi2Real,
    communication_step_size: fmi2Real,
    _no_set_fmu_state_prior_to_current_point: fmi2Boolean,
) -> fmi2Status {
    let call = |i: &mut Instance| i.do_step(current_communication_point, communication_step_size);
    // SAFETY: promised by the caller.
    unsafe { enter(c, function, call) }
}

/// Steps are never pending, so the time of the last step is all there is to tell.
pub unsafe fn get_real_status(
    function: &'static str,
    c: fmi2Component,
    kind: fmi2StatusKind,
    value: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe { answer(function, c, kind == fmi2LastSuccessfulTime, value, Instance::time_s) }
}

/// No model here ends a simulation by itself.
pub unsafe fn get_boolean_status(
    function: &'static str,
    c: fmi2Component,
    kind: fmi2StatusKind,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe { answer(function, c, kind == fmi2Terminated, value, |_| 0) }
}

unsafe fn answer<T: Copy>(
    function: &'static str,
    c: fmi2Component,
    known: bool,
    value: *mut T,
    get: impl FnOnce(&Instance) -> T,
) -> fmi2Status {
    // SAFETY: promised by the caller.
    unsafe {
        enter(c, function, |instance| {
            if !known {
                return Err(
                    Reason::Unsupported { reason: "this status kind has no such value" }.into()
                );
            }
            let mut target = COutput::new(value, 1, "the value pointer")?;
            target.fill(std::iter::once(get(instance)));
            Ok(())
        })
    }
}
