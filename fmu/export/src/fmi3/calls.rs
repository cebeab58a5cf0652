//! FMI 3.0 calls, translated. The first argument is the C function's name, for log lines.
//!
//! # Safety
//! Of every function here: pointers must be what the standard asks for, and no other thread may be
//! inside a call with the same instance.

#![expect(missing_docs, clippy::missing_safety_doc, reason = "see the module and the standard")]

use super::types::{
    fmi3Boolean, fmi3Byte, fmi3FMUState, fmi3Float64, fmi3Instance, fmi3InstanceEnvironment,
    fmi3Int32, fmi3LogMessageCallback, fmi3Status, fmi3String, fmi3ValueReference,
};
use crate::access::{ByteBoolean, Float64, Int32};
use crate::barrier::{enter, leave};
use crate::c_array::write_if_wanted;
use crate::calls::{self, Request};
use crate::instance::{Experiment, Instance};
use crate::log::LogCallback;
use crate::model::ModelType;

/// What [`instantiate`] is told.
#[derive(Debug)]
pub struct Instantiate {
    pub models: &'static [ModelType],
    pub instance_name: fmi3String,
    pub instantiation_token: fmi3String,
    pub logging_on: fmi3Boolean,
    pub environment: fmi3InstanceEnvironment,
    pub log_message: fmi3LogMessageCallback,
    /// What the importer asks for that no model here supports.
    pub unsupported: Option<&'static str>,
}

pub unsafe fn instantiate(function: &'static str, asked: &Instantiate) -> fmi3Instance {
    let request = Request {
        function,
        instance_name: asked.instance_name,
        token: asked.instantiation_token,
        callback: LogCallback::Fmi3(asked.log_message, asked.environment),
        logging_on: asked.logging_on,
        unsupported: asked.unsupported,
    };
    // SAFETY: promised by the caller.
    unsafe { calls::instantiate(asked.models, &request) }
}

pub unsafe fn free_instance(_function: &'static str, instance: fmi3Instance) {
    // SAFETY: promised by the caller.
    unsafe { leave(instance) }
}

pub unsafe fn set_debug_logging(
    function: &'static str,
    instance: fmi3Instance,
    logging_on: fmi3Boolean,
    n_categories: usize,
    categories: *const fmi3String,
) -> fmi3Status {
    // SAFETY: promised by the caller.
    unsafe { calls::set_debug_logging(function, instance, logging_on, (categories, n_categories)) }
}

#[expect(clippy::too_many_arguments, reason = "the signature of the standard")]
pub unsafe fn enter_initialization_mode(
    function: &'static str,
    instance: fmi3Instance,
    _tolerance_defined: fmi3Boolean,
    _tolerance: fmi3Float64,
    start_time: fmi3Float64,
    stop_time_defined: fmi3Boolean,
    stop_time: fmi3Float64,
) -> fmi3Status {
    let call = |i: &mut Instance| {
        let stop_s = stop_time_defined.then_some(stop_time);
        i.set_up_experiment(Experiment::new(start_time, stop_s)?)?;
        i.enter_initialization_mode()
    };
    // SAFETY: promised by the caller.
    unsafe { enter(instance, function, call) }
}

pub unsafe fn exit_initialization_mode(
    function: &'static str,
    instance: fmi3Instance,
) -> fmi3Status {
    // SAFETY: promised by the caller.
    unsafe { enter(instance, function, Instance::exit_initialization_mode) }
}

pub unsafe fn terminate(function: &'static str, instance: fmi3Instance) -> fmi3Status {
    // SAFETY: promised by the caller.
    unsafe { enter(instance, function, Instance::terminate) }
}

pub unsafe fn reset(function: &'static str, instance: fmi3Instance) -> fmi3Status {
    // SAFETY: promised by the caller.
    unsafe { enter(instance, function, Instance::reset) }
}

#[inline]
pub unsafe fn get_float64(
    function: &'static str,
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    n_references: usize,
    values: *mut fmi3Float64,
    n_values: usize,
) -> fmi3Status {
    // SAFETY: promised by the caller.
    unsafe {
        calls::get::<Float64>(function, instance, (references, n_references), (values, n_values))
    }
}

pub unsafe fn get_int32(
    function: &'static str,
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    n_references: usize,
    values: *mut fmi3Int32,
    n_values: usize,
) -> fmi3Status {
    // SAFETY: promised by the caller.
    unsafe {
        calls::get::<Int32>(function, instance, (references, n_references), (values, n_values))
    }
}

pub unsafe fn get_boolean(
    function: &'static str,
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    n_references: usize,
    values: *mut fmi3Boolean,
    n_values: usize,
) -> fmi3Status {
    let (references, values) = ((references, n_references), (values.cast(), n_values));
    // SAFETY: promised by the caller.
    unsafe { calls::get::<ByteBoolean>(function, instance, references, values) }
}

#[inline]
pub unsafe fn set_float64(
    function: &'static str,
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    n_references: usize,
    values: *const fmi3Float64,
    n_values: usize,
) -> fmi3Status {
    // SAFETY: promised by the caller.
    unsafe {
        calls::set::<Float64>(function, instance, (references, n_references), (values, n_values))
    }
}

pub unsafe fn set_int32(
    function: &'static str,
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    n_references: usize,
    values: *const fmi3Int32,
    n_values: usize,
) -> fmi3Status {
    // SAFETY: promised by the caller.
    unsafe {
        calls::set::<Int32>(function, instance, (references, n_references), (values, n_values))
    }
}

pub unsafe fn set_boolean(
    function: &'static str,
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    n_references: usize,
    values: *const fmi3Boolean,
    n_values: usize,
) -> fmi3Status {
    let (references, values) = ((references, n_references), (values.cast(), n_values));
    // SAFETY: promised by the caller.
    unsafe { calls::set::<ByteBoolean>(function, instance, references, values) }
}

pub unsafe fn get_fmu_state(
    function: &'static str,
    instance: fmi3Instance,
    state: *mut fmi3FMUState,
) -> fmi3Status {
    // SAFETY: promised by the caller.
    unsafe { calls::get_state(function, instance, state) }
}

pub unsafe fn set_fmu_state(
    function: &'static str,
    instance: fmi3Instance,
    state: fmi3FMUState,
) -> fmi3Status {
    // SAFETY: promised by the caller.
    unsafe { calls::set_state(function, instance, state) }
}

pub unsafe fn free_fmu_state(
    function: &'static str,
    instance: fmi3Instance,
    state: *mut fmi3FMUState,
) -> fmi3Status {
    // SAFETY: promised by the caller.
    unsafe { calls::free_state(function, instance, state) }
}

pub unsafe fn serialized_fmu_state_size(
    function: &'static str,
    instance: fmi3Instance,
    state: fmi3FMUState,
    size: *mut usize,
) -> fmi3Status {
    // SAFETY: promised by the caller.
    unsafe { calls::serialized_state_size(function, instance, state, size) }
}

pub unsafe fn serialize_fmu_state(
    function: &'static str,
    instance: fmi3Instance,
    state: fmi3FMUState,
    bytes: *mut fmi3Byte,
    size: usize,
) -> fmi3Status {
    // SAFETY: promised by the caller.
    unsafe { calls::serialize_state(function, instance, state, (bytes, size)) }
}

pub unsafe fn deserialize_fmu_state(
    function: &'static str,
    instance: fmi3Instance,
    bytes: *const fmi3Byte,
    size: usize,
    state: *mut fmi3FMUState,
) -> fmi3Status {
    // SAFETY: promised by the caller.
    unsafe { calls::deserialize_state(function, instance, (bytes, size), state) }
}

#[expect(clippy::too_many_arguments, reason = "the signature of the standard")]
#[inline]
pub unsafe fn do_step(
    function: &'static str,
    instance: fmi3Instance,
    current_communication_point: fmi3Float64,
    communication_step_size: fmi3Float64,
    _no_set_fmu_state_prior_to_current_point: fmi3Boolean,
    event_handling_needed: *mut fmi3Boolean,
    terminate_simulation: *mut fmi3Boolean,
    early_return: *mut fmi3Boolean,
    last_successful_time: *mut fmi3Float64,
) -> fmi3Status {
    let call = |i: &mut Instance| {
        let done = i.do_step(current_communication_point, communication_step_size);
        // SAFETY: null or writable, by the caller's promise.
        unsafe {
            write_if_wanted(event_handling_needed, false);
            write_if_wanted(terminate_simulation, false);
            write_if_wanted(early_return, false);
            write_if_wanted(last_successful_time, i.time_s());
        }
        done
    };
    // SAFETY: promised by the caller.
    unsafe { enter(instance, function, call) }
}
