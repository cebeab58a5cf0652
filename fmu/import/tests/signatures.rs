//! The hand-written C signatures of `struna-fmi-export` against those that bindgen reads from the
//! standard's headers. Most of this test happens while it is compiled: assigning an exported
//! function to bindgen's field of the same name type-checks only if every argument agrees.

use fmi_sys::fmi2::{
    Fmi2Binding, fmi2Boolean, fmi2CallbackFunctions as TheirCallbacks, fmi2Component, fmi2String,
    fmi2Type,
};
use fmi_sys::fmi3::Fmi3Binding;
use struna_fmi_export::fmi2::types::fmi2CallbackFunctions as OurCallbacks;
use struna_fmi_export::{
    DefaultExperiment, Domain, Model, ModelDescription, ModelError, ModelType, Role, Unit, Values,
    Variable, export_fmi,
};

/// The least that is a model.
#[derive(Debug)]
pub struct Nothing;

static TABLE: [Variable; 2] = [
    Variable::TIME,
    Variable::new(1, Role::Input, "rate_rad_s", Domain::float64(Unit::RAD_S, 0.0), "A rate."),
];

impl Model for Nothing {
    const DESCRIPTION: ModelDescription = ModelDescription::new(
        "Nothing",
        "1",
        "",
        DefaultExperiment { stop_time_s: 1.0, step_size_s: 0.1 },
        &TABLE,
    );

    fn initialise(_: &Values, _: f64) -> Result<Self, ModelError> {
        Ok(Self)
    }

    fn step(&mut self, _: &Values, _: f64, _: f64) -> Result<(), ModelError> {
        Ok(())
    }

    fn write_outputs(&self, _: &mut Values) {}

    fn save(&self, _: &mut Vec<u8>) {}

    fn restore(_: &Values, _: &[u8]) -> Result<Self, ModelError> {
        Ok(Self)
    }
}

static MODELS: [ModelType; 1] = [ModelType::of::<Nothing>()];
export_fmi!(crate::MODELS);

/// Replaces each named field of a binding by the exported function.
macro_rules! assign {
    ($binding:ident, $version:ident, [$($name:ident),* $(,)?]) => {
        $($binding.$name = Ok($version::$name);)*
    };
}

fn assign_fmi2(binding: &mut Fmi2Binding) {
    assign!(
        binding,
        fmi2,
        [
            fmi2GetTypesPlatform,
            fmi2GetVersion,
            fmi2SetDebugLogging,
            fmi2FreeInstance,
            fmi2SetupExperiment,
            fmi2EnterInitializationMode,
            fmi2ExitInitializationMode,
            fmi2Terminate,
            fmi2Reset,
            fmi2GetReal,
            fmi2GetInteger,
            fmi2GetBoolean,
            fmi2GetString,
            fmi2SetReal,
            fmi2SetInteger,
            fmi2SetBoolean,
            fmi2SetString,
            fmi2GetFMUstate,
            fmi2SetFMUstate,
            fmi2FreeFMUstate,
            fmi2SerializedFMUstateSize,
            fmi2SerializeFMUstate,
            fmi2DeSerializeFMUstate,
            fmi2GetDirectionalDerivative,
            fmi2SetRealInputDerivatives,
            fmi2GetRealOutputDerivatives,
            fmi2DoStep,
            fmi2CancelStep,
            fmi2GetStatus,
            fmi2GetRealStatus,
            fmi2GetIntegerStatus,
            fmi2GetBooleanStatus,
            fmi2GetStringStatus,
        ]
    );
}

#[expect(clippy::too_many_lines, reason = "one line for each function of the standard")]
fn assign_fmi3(binding: &mut Fmi3Binding) {
    assign!(
        binding,
        fmi3,
        [
            fmi3GetVersion,
            fmi3SetDebugLogging,
            fmi3InstantiateModelExchange,
            fmi3InstantiateCoSimulation,
            fmi3InstantiateScheduledExecution,
            fmi3FreeInstance,
            fmi3EnterInitializationMode,
            fmi3ExitInitializationMode,
            fmi3EnterEventMode,
            fmi3Terminate,
            fmi3Reset,
            fmi3GetFloat32,
            fmi3GetFloat64,
            fmi3GetInt8,
            fmi3GetUInt8,
            fmi3GetInt16,
            fmi3GetUInt16,
            fmi3GetInt32,
            fmi3GetUInt32,
            fmi3GetInt64,
            fmi3GetUInt64,
            fmi3GetBoolean,
            fmi3GetString,
            fmi3GetBinary,
            fmi3GetClock,
            fmi3SetFloat32,
            fmi3SetFloat64,
            fmi3SetInt8,
            fmi3SetUInt8,
            fmi3SetInt16,
            fmi3SetUInt16,
            fmi3SetInt32,
            fmi3SetUInt32,
            fmi3SetInt64,
            fmi3SetUInt64,
            fmi3SetBoolean,
            fmi3SetString,
            fmi3SetBinary,
            fmi3SetClock,
            fmi3GetNumberOfVariableDependencies,
            fmi3GetVariableDependencies,
            fmi3GetFMUState,
            fmi3SetFMUState,
            fmi3FreeFMUState,
            fmi3SerializedFMUStateSize,
            fmi3SerializeFMUState,
            fmi3DeserializeFMUState,
            fmi3GetDirectionalDerivative,
            fmi3GetAdjointDerivative,
            fmi3EnterConfigurationMode,
            fmi3ExitConfigurationMode,
            fmi3GetIntervalDecimal,
            fmi3GetIntervalFraction,
            fmi3GetShiftDecimal,
            fmi3GetShiftFraction,
            fmi3SetIntervalDecimal,
            fmi3SetIntervalFraction,
            fmi3SetShiftDecimal,
            fmi3SetShiftFraction,
            fmi3EvaluateDiscreteStates,
            fmi3UpdateDiscreteStates,
            fmi3EnterContinuousTimeMode,
            fmi3CompletedIntegratorStep,
            fmi3SetTime,
            fmi3SetContinuousStates,
            fmi3GetContinuousStateDerivatives,
            fmi3GetEventIndicators,
            fmi3GetContinuousStates,
            fmi3GetNominalsOfContinuousStates,
            fmi3GetNumberOfEventIndicators,
            fmi3GetNumberOfContinuousStates,
            fmi3EnterStepMode,
            fmi3GetOutputDerivatives,
            fmi3DoStep,
            fmi3ActivateModelPartition,
        ]
    );
}

/// `fmi2Instantiate` takes a struct, which both sides define: its fields are compared one by one.
fn theirs_from_ours(ours: &OurCallbacks) -> TheirCallbacks {
    TheirCallbacks {
        logger: ours.logger,
        allocateMemory: ours.allocateMemory,
        freeMemory: ours.freeMemory,
        stepFinished: ours.stepFinished,
        componentEnvironment: ours.componentEnvironment,
    }
}

type Instantiate = unsafe extern "C" fn(
    fmi2String,
    fmi2Type,
    fmi2String,
    fmi2String,
    *const OurCallbacks,
    fmi2Boolean,
    fmi2Boolean,
) -> fmi2Component;

#[test]
fn every_exported_function_has_the_signature_of_the_headers() {
    let _: fn(&mut Fmi2Binding) = assign_fmi2;
    let _: fn(&mut Fmi3Binding) = assign_fmi3;
    let _: Instantiate = fmi2::fmi2Instantiate;
}

#[test]
fn the_callback_structs_agree_field_by_field() {
    let ours = OurCallbacks {
        logger: None,
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: std::ptr::without_provenance_mut(0x1234),
    };
    let theirs = theirs_from_ours(&ours);
    assert_eq!(theirs.componentEnvironment, ours.componentEnvironment);
    assert_eq!(size_of::<OurCallbacks>(), size_of::<TheirCallbacks>());
    assert_eq!(align_of::<OurCallbacks>(), align_of::<TheirCallbacks>());
    let (ours, theirs) = (
        std::mem::offset_of!(OurCallbacks, componentEnvironment),
        std::mem::offset_of!(TheirCallbacks, componentEnvironment),
    );
    assert_eq!(ours, theirs);
}
