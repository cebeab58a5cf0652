//! The exported C functions of FMI 2.0, with the signatures of `fmi2FunctionTypes.h`.

/// Defines every FMI 2.0 function that a co-simulation FMU needs.
#[doc(hidden)]
#[macro_export]
macro_rules! __export_fmi2 {
    ($models:path) => {
        use $crate::fmi2::{calls, types::*};

        $crate::__export_constant_texts! {
            fmi2GetTypesPlatform() -> fmi2String = c"default";
            fmi2GetVersion() -> fmi2String = c"2.0";
        }

        /// `fmi2Instantiate` of the FMI standard; the GUID picks the model.
        ///
        /// # Safety
        /// Every pointer must be what the standard asks for.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn fmi2Instantiate(
            instance_name: fmi2String,
            fmu_type: fmi2Type,
            guid: fmi2String,
            _resource_location: fmi2String,
            functions: *const fmi2CallbackFunctions,
            _visible: fmi2Boolean,
            logging_on: fmi2Boolean,
        ) -> fmi2Component {
            let models = &$models;
            let asked =
                calls::Instantiate { models, instance_name, fmu_type, guid, functions, logging_on };
            // SAFETY: the caller's promises are those asked for.
            unsafe { calls::instantiate("fmi2Instantiate", &asked) }
        }

        $crate::__export_functions! {
            fmi2FreeInstance(c: fmi2Component) = calls::free_instance;
            fmi2SetDebugLogging(
                c: fmi2Component, on: fmi2Boolean, n: usize, categories: *const fmi2String,
            ) -> fmi2Status = calls::set_debug_logging;
            fmi2SetupExperiment(
                c: fmi2Component, tolerance_defined: fmi2Boolean, tolerance: fmi2Real,
                start_time: fmi2Real, stop_time_defined: fmi2Boolean, stop_time: fmi2Real,
            ) -> fmi2Status = calls::setup_experiment;
            fmi2EnterInitializationMode(c: fmi2Component) -> fmi2Status =
                calls::enter_initialization_mode;
            fmi2ExitInitializationMode(c: fmi2Component) -> fmi2Status =
                calls::exit_initialization_mode;
            fmi2Terminate(c: fmi2Component) -> fmi2Status = calls::terminate;
            fmi2Reset(c: fmi2Component) -> fmi2Status = calls::reset;
            fmi2GetReal(
                c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *mut fmi2Real,
            ) -> fmi2Status = calls::get_real;
            fmi2GetInteger(
                c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *mut fmi2Integer,
            ) -> fmi2Status = calls::get_integer;
            fmi2GetBoolean(
                c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *mut fmi2Boolean,
            ) -> fmi2Status = calls::get_boolean;
            fmi2SetReal(
                c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *const fmi2Real,
            ) -> fmi2Status = calls::set_real;
            fmi2SetInteger(
                c: fmi2Component, vr: *const fmi2ValueReference, n: usize,
                value: *const fmi2Integer,
            ) -> fmi2Status = calls::set_integer;
            fmi2SetBoolean(
                c: fmi2Component, vr: *const fmi2ValueReference, n: usize,
                value: *const fmi2Boolean,
            ) -> fmi2Status = calls::set_boolean;
            fmi2GetFMUstate(c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status =
                calls::get_fmu_state;
            fmi2SetFMUstate(c: fmi2Component, state: fmi2FMUstate) -> fmi2Status =
                calls::set_fmu_state;
            fmi2FreeFMUstate(c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status =
                calls::free_fmu_state;
            fmi2SerializedFMUstateSize(
                c: fmi2Component, state: fmi2FMUstate, size: *mut usize,
            ) -> fmi2Status = calls::serialized_fmu_state_size;
            fmi2SerializeFMUstate(
                c: fmi2Component, state: fmi2FMUstate, bytes: *mut fmi2Byte, size: usize,
            ) -> fmi2Status = calls::serialize_fmu_state;
            fmi2DeSerializeFMUstate(
                c: fmi2Component, bytes: *const fmi2Byte, size: usize, state: *mut fmi2FMUstate,
            ) -> fmi2Status = calls::deserialize_fmu_state;
            fmi2DoStep(
                c: fmi2Component, point: fmi2Real, step_size: fmi2Real, no_set_prior: fmi2Boolean,
            ) -> fmi2Status = calls::do_step;
            fmi2GetRealStatus(
                c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2Real,
            ) -> fmi2Status = calls::get_real_status;
            fmi2GetBooleanStatus(
                c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2Boolean,
            ) -> fmi2Status = calls::get_boolean_status;
        }

        $crate::__export_refused_functions! {
            fmi2GetString(
                c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *mut fmi2String,
            ) -> fmi2Status = "there are no String variables";
            fmi2SetString(
                c: fmi2Component, vr: *const fmi2ValueReference, n: usize,
                value: *const fmi2String,
            ) -> fmi2Status = "there are no String variables";
            fmi2GetDirectionalDerivative(
                c: fmi2Component, unknowns: *const fmi2ValueReference, n_unknowns: usize,
                knowns: *const fmi2ValueReference, n_knowns: usize, seed: *const fmi2Real,
                sensitivity: *mut fmi2Real,
            ) -> fmi2Status = "providesDirectionalDerivative is false";
            fmi2SetRealInputDerivatives(
                c: fmi2Component, vr: *const fmi2ValueReference, n: usize,
                order: *const fmi2Integer, value: *const fmi2Real,
            ) -> fmi2Status = "canInterpolateInputs is false";
            fmi2GetRealOutputDerivatives(
                c: fmi2Component, vr: *const fmi2ValueReference, n: usize,
                order: *const fmi2Integer, value: *mut fmi2Real,
            ) -> fmi2Status = "maxOutputDerivativeOrder is 0";
            fmi2CancelStep(c: fmi2Component) -> fmi2Status = "canRunAsynchronuously is false";
            fmi2GetStatus(
                c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2Status,
            ) -> fmi2Status = "steps are never pending";
            fmi2GetIntegerStatus(
                c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2Integer,
            ) -> fmi2Status = "there is no status of type Integer";
            fmi2GetStringStatus(
                c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2String,
            ) -> fmi2Status = "steps are never pending";
        }
    };
}
