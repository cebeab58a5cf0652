//! The exported C functions of FMI 3.0, with the signatures of `fmi3FunctionTypes.h`.

/// Defines every FMI 3.0 function. Those of other interface types and of variable types that no
/// model has exist too, because the standard asks for them, and refuse.
#[doc(hidden)]
#[macro_export]
macro_rules! __export_fmi3 {
    ($models:path) => {
        use $crate::fmi3::{calls, types::*};

        $crate::__export_constant_texts! {
            fmi3GetVersion() -> fmi3String = c"3.0";
        }

        /// `fmi3InstantiateCoSimulation` of the FMI standard; the token picks the model.
        ///
        /// # Safety
        /// Every pointer must be what the standard asks for.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
            instance_name: fmi3String,
            instantiation_token: fmi3String,
            _resource_path: fmi3String,
            _visible: fmi3Boolean,
            logging_on: fmi3Boolean,
            event_mode_used: fmi3Boolean,
            _early_return_allowed: fmi3Boolean,
            _required_intermediate_variables: *const fmi3ValueReference,
            n_required_intermediate_variables: usize,
            environment: fmi3InstanceEnvironment,
            log_message: fmi3LogMessageCallback,
            _intermediate_update: fmi3IntermediateUpdateCallback,
        ) -> fmi3Instance {
            let unsupported = match (event_mode_used, n_required_intermediate_variables) {
                (false, 0) => None,
                (true, _) => Some("event mode"),
                (false, _) => Some("intermediate update"),
            };
            let models = &$models;
            let asked = calls::Instantiate {
                models,
                instance_name,
                instantiation_token,
                logging_on,
                environment,
                log_message,
                unsupported,
            };
            // SAFETY: the caller's promises are those asked for.
            unsafe { calls::instantiate("fmi3InstantiateCoSimulation", &asked) }
        }

        /// `fmi3InstantiateModelExchange` of the FMI standard: null, with a log line.
        ///
        /// # Safety
        /// Every pointer must be what the standard asks for.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn fmi3InstantiateModelExchange(
            instance_name: fmi3String,
            instantiation_token: fmi3String,
            _resource_path: fmi3String,
            _visible: fmi3Boolean,
            logging_on: fmi3Boolean,
            environment: fmi3InstanceEnvironment,
            log_message: fmi3LogMessageCallback,
        ) -> fmi3Instance {
            let asked = calls::Instantiate {
                models: &$models,
                instance_name,
                instantiation_token,
                logging_on,
                environment,
                log_message,
                unsupported: Some("model exchange"),
            };
            // SAFETY: the caller's promises are those asked for.
            unsafe { calls::instantiate("fmi3InstantiateModelExchange", &asked) }
        }

        /// `fmi3InstantiateScheduledExecution` of the FMI standard: null, with a log line.
        ///
        /// # Safety
        /// Every pointer must be what the standard asks for.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
            instance_name: fmi3String,
            instantiation_token: fmi3String,
            _resource_path: fmi3String,
            _visible: fmi3Boolean,
            logging_on: fmi3Boolean,
            environment: fmi3InstanceEnvironment,
            log_message: fmi3LogMessageCallback,
            _clock_update: fmi3ClockUpdateCallback,
            _lock_preemption: fmi3LockPreemptionCallback,
            _unlock_preemption: fmi3UnlockPreemptionCallback,
        ) -> fmi3Instance {
            let asked = calls::Instantiate {
                models: &$models,
                instance_name,
                instantiation_token,
                logging_on,
                environment,
                log_message,
                unsupported: Some("scheduled execution"),
            };
            // SAFETY: the caller's promises are those asked for.
            unsafe { calls::instantiate("fmi3InstantiateScheduledExecution", &asked) }
        }

        $crate::__export_functions! {
            fmi3FreeInstance(i: fmi3Instance) = calls::free_instance;
            fmi3SetDebugLogging(
                i: fmi3Instance, on: fmi3Boolean, n: usize, categories: *const fmi3String,
            ) -> fmi3Status = calls::set_debug_logging;
            fmi3EnterInitializationMode(
                i: fmi3Instance, tolerance_defined: fmi3Boolean, tolerance: fmi3Float64,
                start_time: fmi3Float64, stop_time_defined: fmi3Boolean, stop_time: fmi3Float64,
            ) -> fmi3Status = calls::enter_initialization_mode;
            fmi3ExitInitializationMode(i: fmi3Instance) -> fmi3Status =
                calls::exit_initialization_mode;
            fmi3Terminate(i: fmi3Instance) -> fmi3Status = calls::terminate;
            fmi3Reset(i: fmi3Instance) -> fmi3Status = calls::reset;
            fmi3GetFloat64(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *mut fmi3Float64,
                n_values: usize,
            ) -> fmi3Status = calls::get_float64;
            fmi3SetFloat64(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize,
                values: *const fmi3Float64, n_values: usize,
            ) -> fmi3Status = calls::set_float64;
            fmi3GetInt32(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *mut fmi3Int32,
                n_values: usize,
            ) -> fmi3Status = calls::get_int32;
            fmi3SetInt32(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize,
                values: *const fmi3Int32, n_values: usize,
            ) -> fmi3Status = calls::set_int32;
            fmi3GetBoolean(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *mut fmi3Boolean,
                n_values: usize,
            ) -> fmi3Status = calls::get_boolean;
            fmi3SetBoolean(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize,
                values: *const fmi3Boolean, n_values: usize,
            ) -> fmi3Status = calls::set_boolean;
            fmi3GetFMUState(i: fmi3Instance, state: *mut fmi3FMUState) -> fmi3Status =
                calls::get_fmu_state;
            fmi3SetFMUState(i: fmi3Instance, state: fmi3FMUState) -> fmi3Status =
                calls::set_fmu_state;
            fmi3FreeFMUState(i: fmi3Instance, state: *mut fmi3FMUState) -> fmi3Status =
                calls::free_fmu_state;
            fmi3SerializedFMUStateSize(
                i: fmi3Instance, state: fmi3FMUState, size: *mut usize,
            ) -> fmi3Status = calls::serialized_fmu_state_size;
            fmi3SerializeFMUState(
                i: fmi3Instance, state: fmi3FMUState, bytes: *mut fmi3Byte, size: usize,
            ) -> fmi3Status = calls::serialize_fmu_state;
            fmi3DeserializeFMUState(
                i: fmi3Instance, bytes: *const fmi3Byte, size: usize, state: *mut fmi3FMUState,
            ) -> fmi3Status = calls::deserialize_fmu_state;
            fmi3DoStep(
                i: fmi3Instance, point: fmi3Float64, step_size: fmi3Float64,
                no_set_prior: fmi3Boolean, event_handling_needed: *mut fmi3Boolean,
                terminate_simulation: *mut fmi3Boolean, early_return: *mut fmi3Boolean,
                last_successful_time: *mut fmi3Float64,
            ) -> fmi3Status = calls::do_step;
        }

        $crate::__export_refused_accessors! {
            fmi3GetFloat32, fmi3SetFloat32: fmi3Float32 = "there are no Float32 variables";
            fmi3GetInt8, fmi3SetInt8: fmi3Int8 = "there are no Int8 variables";
            fmi3GetUInt8, fmi3SetUInt8: fmi3UInt8 = "there are no UInt8 variables";
            fmi3GetInt16, fmi3SetInt16: fmi3Int16 = "there are no Int16 variables";
            fmi3GetUInt16, fmi3SetUInt16: fmi3UInt16 = "there are no UInt16 variables";
            fmi3GetUInt32, fmi3SetUInt32: fmi3UInt32 = "there are no UInt32 variables";
            fmi3GetInt64, fmi3SetInt64: fmi3Int64 = "there are no Int64 variables";
            fmi3GetUInt64, fmi3SetUInt64: fmi3UInt64 = "there are no UInt64 variables";
            fmi3GetString, fmi3SetString: fmi3String = "there are no String variables";
        }
        $crate::__export_fmi3_refused!();
    };
}

/// Getter and setter of a type that no model has.
#[doc(hidden)]
#[macro_export]
macro_rules! __export_refused_accessors {
    ($($get:ident, $set:ident: $type:ty = $reason:expr;)*) => {
        $crate::__export_refused_functions! {$(
            $get(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *mut $type,
                n_values: usize,
            ) -> fmi3Status = $reason;
            $set(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *const $type,
                n_values: usize,
            ) -> fmi3Status = $reason;
        )*}
    };
}
