//! FMI 3.0 functions that no model here supports, with the signatures of `fmi3FunctionTypes.h`.

/// Defines them: all refuse, with a log line.
#[doc(hidden)]
#[macro_export]
macro_rules! __export_fmi3_refused {
    () => {
        $crate::__export_refused_functions! {
            fmi3GetBinary(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize, sizes: *mut usize,
                values: *mut fmi3Binary, n_values: usize,
            ) -> fmi3Status = "there are no Binary variables";
            fmi3SetBinary(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize, sizes: *const usize,
                values: *const fmi3Binary, n_values: usize,
            ) -> fmi3Status = "there are no Binary variables";
            fmi3GetClock(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *mut fmi3Clock,
            ) -> fmi3Status = "there are no clocks";
            fmi3SetClock(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize,
                values: *const fmi3Clock,
            ) -> fmi3Status = "there are no clocks";
            fmi3GetIntervalDecimal(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize,
                intervals: *mut fmi3Float64, qualifiers: *mut fmi3IntervalQualifier,
            ) -> fmi3Status = "there are no clocks";
            fmi3GetIntervalFraction(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize,
                counters: *mut fmi3UInt64, resolutions: *mut fmi3UInt64,
                qualifiers: *mut fmi3IntervalQualifier,
            ) -> fmi3Status = "there are no clocks";
            fmi3GetShiftDecimal(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize,
                shifts: *mut fmi3Float64,
            ) -> fmi3Status = "there are no clocks";
            fmi3GetShiftFraction(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize,
                counters: *mut fmi3UInt64, resolutions: *mut fmi3UInt64,
            ) -> fmi3Status = "there are no clocks";
            fmi3SetIntervalDecimal(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize,
                intervals: *const fmi3Float64,
            ) -> fmi3Status = "there are no clocks";
            fmi3SetIntervalFraction(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize,
                counters: *const fmi3UInt64, resolutions: *const fmi3UInt64,
            ) -> fmi3Status = "there are no clocks";
            fmi3SetShiftDecimal(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize,
                shifts: *const fmi3Float64,
            ) -> fmi3Status = "there are no clocks";
            fmi3SetShiftFraction(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize,
                counters: *const fmi3UInt64, resolutions: *const fmi3UInt64,
            ) -> fmi3Status = "there are no clocks";
            fmi3ActivateModelPartition(
                i: fmi3Instance, clock: fmi3ValueReference, time: fmi3Float64,
            ) -> fmi3Status = "this is not scheduled execution";
            fmi3GetNumberOfVariableDependencies(
                i: fmi3Instance, vr: fmi3ValueReference, n: *mut usize,
            ) -> fmi3Status = "providesPerElementDependencies is false";
            fmi3GetVariableDependencies(
                i: fmi3Instance, dependent: fmi3ValueReference, dependent_elements: *mut usize,
                independents: *mut fmi3ValueReference, independent_elements: *mut usize,
                kinds: *mut fmi3DependencyKind, n: usize,
            ) -> fmi3Status = "providesPerElementDependencies is false";
            fmi3GetDirectionalDerivative(
                i: fmi3Instance, unknowns: *const fmi3ValueReference, n_unknowns: usize,
                knowns: *const fmi3ValueReference, n_knowns: usize, seed: *const fmi3Float64,
                n_seed: usize, sensitivity: *mut fmi3Float64, n_sensitivity: usize,
            ) -> fmi3Status = "providesDirectionalDerivatives is false";
            fmi3GetAdjointDerivative(
                i: fmi3Instance, unknowns: *const fmi3ValueReference, n_unknowns: usize,
                knowns: *const fmi3ValueReference, n_knowns: usize, seed: *const fmi3Float64,
                n_seed: usize, sensitivity: *mut fmi3Float64, n_sensitivity: usize,
            ) -> fmi3Status = "providesAdjointDerivatives is false";
            fmi3GetOutputDerivatives(
                i: fmi3Instance, vr: *const fmi3ValueReference, n: usize,
                orders: *const fmi3Int32, values: *mut fmi3Float64, n_values: usize,
            ) -> fmi3Status = "maxOutputDerivativeOrder is 0";
            fmi3EnterConfigurationMode(
                i: fmi3Instance,
            ) -> fmi3Status = "there are no structural parameters";
            fmi3ExitConfigurationMode(
                i: fmi3Instance,
            ) -> fmi3Status = "there are no structural parameters";
            fmi3EnterEventMode(i: fmi3Instance) -> fmi3Status = "hasEventMode is false";
            fmi3EnterStepMode(i: fmi3Instance) -> fmi3Status = "hasEventMode is false";
            fmi3EvaluateDiscreteStates(i: fmi3Instance) -> fmi3Status = "hasEventMode is false";
            fmi3UpdateDiscreteStates(
                i: fmi3Instance, need_update: *mut fmi3Boolean, terminate: *mut fmi3Boolean,
                nominals_changed: *mut fmi3Boolean, values_changed: *mut fmi3Boolean,
                next_event_time_defined: *mut fmi3Boolean, next_event_time: *mut fmi3Float64,
            ) -> fmi3Status = "hasEventMode is false";
            fmi3EnterContinuousTimeMode(
                i: fmi3Instance,
            ) -> fmi3Status = "this is not model exchange";
            fmi3CompletedIntegratorStep(
                i: fmi3Instance, no_set_prior: fmi3Boolean, enter_event_mode: *mut fmi3Boolean,
                terminate: *mut fmi3Boolean,
            ) -> fmi3Status = "this is not model exchange";
            fmi3SetTime(
                i: fmi3Instance, time: fmi3Float64,
            ) -> fmi3Status = "this is not model exchange";
            fmi3SetContinuousStates(
                i: fmi3Instance, states: *const fmi3Float64, n: usize,
            ) -> fmi3Status = "this is not model exchange";
            fmi3GetContinuousStateDerivatives(
                i: fmi3Instance, values: *mut fmi3Float64, n: usize,
            ) -> fmi3Status = "this is not model exchange";
            fmi3GetEventIndicators(
                i: fmi3Instance, values: *mut fmi3Float64, n: usize,
            ) -> fmi3Status = "this is not model exchange";
            fmi3GetContinuousStates(
                i: fmi3Instance, values: *mut fmi3Float64, n: usize,
            ) -> fmi3Status = "this is not model exchange";
            fmi3GetNominalsOfContinuousStates(
                i: fmi3Instance, values: *mut fmi3Float64, n: usize,
            ) -> fmi3Status = "this is not model exchange";
            fmi3GetNumberOfEventIndicators(
                i: fmi3Instance, n: *mut usize,
            ) -> fmi3Status = "this is not model exchange";
            fmi3GetNumberOfContinuousStates(
                i: fmi3Instance, n: *mut usize,
            ) -> fmi3Status = "this is not model exchange";
        }
    };
}
