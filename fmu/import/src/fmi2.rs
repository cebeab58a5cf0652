//! FMI 2.0: description, binding and callbacks by the `fmi` crate, calls straight to the FMU, for
//! the reasons given in the module `fmi3`.

#![expect(unsafe_code, reason = "calls into the FMU; every block states why it is sound")]

use crate::description::{FmiVersion, FmuDescription, Kind, ValueReference, Variable};
use crate::error::{ImportError, not_an_fmu};
use crate::status::{Status, check};
use crate::{Importer, Instance, messages};
use fmi::fmi2::CallbackFunctions;
use fmi::fmi2::binding::{
    Fmi2Binding, fmi2Boolean, fmi2Component, fmi2Type_fmi2CoSimulation, fmi2ValueReference,
};
use fmi::fmi2::import::Fmi2Import;
use fmi::schema::fmi2::ScalarVariableElement;
use fmi::traits::FmiImport;
use std::ffi::{CString, NulError};
use std::path::Path;

pub(crate) struct Fmi2 {
    import: Fmi2Import,
    description: FmuDescription,
}

impl Fmi2 {
    pub(crate) fn open(path: &Path) -> Result<Self, ImportError> {
        let import: Fmi2Import = fmi::import::from_path(path).map_err(|e| not_an_fmu(path, &e))?;
        let raw = import.model_description();
        if raw.co_simulation.is_none() {
            return Err(ImportError::NotCoSimulation { path: path.to_owned() });
        }
        let variables = raw.model_variables.variables.iter().map(|variable| {
            let kind = match variable.elem {
                ScalarVariableElement::Real(_) => Kind::Float64,
                ScalarVariableElement::Integer(_) => Kind::Int32,
                ScalarVariableElement::Boolean(_) => Kind::Boolean,
                _ => Kind::Other,
            };
            let reference = ValueReference(variable.value_reference);
            (variable.name.clone(), Variable { reference, kind })
        });
        let description = FmuDescription {
            model_name: raw.model_name.clone(),
            version: FmiVersion::Fmi2,
            token: raw.guid.clone(),
            variables: variables.collect(),
        };
        Ok(Self { import, description })
    }

    /// Loads the shared library. Every function that an instance calls is looked up here, because
    /// the binding panics when it calls one that is not there.
    fn bind(&self) -> Result<(Fmi2Binding, StepFunctions), String> {
        let co_simulation = self.import.model_description().co_simulation.as_ref();
        let name = co_simulation.map_or("", |interface| &interface.model_identifier);
        let binding = self.import.binding(name).map_err(|error| error.to_string())?;
        let lacks = [
            binding.fmi2Instantiate.as_ref().err(),
            binding.fmi2SetupExperiment.as_ref().err(),
            binding.fmi2EnterInitializationMode.as_ref().err(),
            binding.fmi2ExitInitializationMode.as_ref().err(),
            binding.fmi2SetInteger.as_ref().err(),
            binding.fmi2GetInteger.as_ref().err(),
            binding.fmi2SetBoolean.as_ref().err(),
            binding.fmi2Terminate.as_ref().err(),
            binding.fmi2FreeInstance.as_ref().err(),
        ];
        if let Some(error) = lacks.into_iter().flatten().next() {
            return Err(error.to_string());
        }
        let step = StepFunctions {
            set_real: *binding.fmi2SetReal.as_ref().map_err(ToString::to_string)?,
            get_real: *binding.fmi2GetReal.as_ref().map_err(ToString::to_string)?,
            do_step: *binding.fmi2DoStep.as_ref().map_err(ToString::to_string)?,
        };
        Ok((binding, step))
    }

    /// A new instance in the FMU; null if it refuses. `callbacks` must outlive it.
    fn handle(
        &self,
        binding: &Fmi2Binding,
        name: &str,
        callbacks: &CallbackFunctions,
    ) -> Result<fmi2Component, NulError> {
        let token = CString::new(self.description.token.as_str())?;
        let resources = CString::new(self.import.canonical_resource_path_string())?;
        let name = CString::new(name)?;
        // SAFETY: the texts are terminated and outlive the call, the callbacks have the layout of
        // the C header and outlive the instance, and the function was found.
        Ok(unsafe {
            binding.fmi2Instantiate(
                name.as_ptr(),
                fmi2Type_fmi2CoSimulation,
                token.as_ptr(),
                resources.as_ptr(),
                (&raw const *callbacks).cast(),
                0,
                1,
            )
        })
    }
}

impl std::fmt::Debug for Fmi2 {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Fmi2").field("description", &self.description).finish_non_exhaustive()
    }
}

impl Importer for Fmi2 {
    fn description(&self) -> &FmuDescription {
        &self.description
    }

    fn instantiate(&self, name: &str) -> Result<Box<dyn Instance>, ImportError> {
        messages::take();
        let model = || self.description.model_name.clone();
        let load = |reason| ImportError::Load { model: model(), reason };
        let (binding, step) = self.bind().map_err(load)?;
        let callbacks = Box::<CallbackFunctions>::default();
        let handle = self.handle(&binding, name, &callbacks);
        let handle = handle.map_err(|error| load(error.to_string()))?;
        if handle.is_null() {
            return Err(ImportError::Refused { model: model(), messages: messages::take() });
        }
        Ok(Box::new(Slave { binding, handle, step, name: name.to_owned(), _callbacks: callbacks }))
    }
}

/// What every step calls, looked up once: the binding asks in each call whether it is there.
#[derive(Clone, Copy)]
struct StepFunctions {
    set_real: SetReal,
    get_real: GetReal,
    do_step: DoStep,
}

type SetReal =
    unsafe extern "C" fn(fmi2Component, *const fmi2ValueReference, usize, *const f64) -> Status;
type GetReal =
    unsafe extern "C" fn(fmi2Component, *const fmi2ValueReference, usize, *mut f64) -> Status;
type DoStep = unsafe extern "C" fn(fmi2Component, f64, f64, fmi2Boolean) -> Status;

/// One instance.
///
/// That the calls below are sound rests on this: `handle` came from `binding`, which stays loaded
/// and in which every function was found; being no `Send`, the instance stays on its thread; and
/// it is freed when dropped, after which no call can follow, and before its callbacks.
struct Slave {
    binding: Fmi2Binding,
    handle: fmi2Component,
    step: StepFunctions,
    name: String,
    /// The FMU keeps their address.
    _callbacks: Box<CallbackFunctions>,
}

impl Drop for Slave {
    fn drop(&mut self) {
        // SAFETY: see the type.
        unsafe { self.binding.fmi2FreeInstance(self.handle) }
    }
}

impl std::fmt::Debug for Slave {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Fmi2Slave").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Instance for Slave {
    fn set_f64(
        &mut self,
        references: &[ValueReference],
        values: &[f64],
    ) -> Result<(), ImportError> {
        assert_eq!(references.len(), values.len(), "FMI 2.0 passes one length for both");
        let (n, vr) = (references.len(), ValueReference::as_raw(references).as_ptr());
        // SAFETY: see the type; both arrays have `n` elements.
        let status = unsafe { (self.step.set_real)(self.handle, vr, n, values.as_ptr()) };
        check(&self.name, "SetReal", status)
    }

    fn set_i32(&mut self, reference: ValueReference, value: i32) -> Result<(), ImportError> {
        // SAFETY: see the type; one reference, one value.
        let status = unsafe { self.binding.fmi2SetInteger(self.handle, &reference.0, 1, &value) };
        check(&self.name, "SetInteger", status)
    }

    fn set_bool(&mut self, reference: ValueReference, value: bool) -> Result<(), ImportError> {
        let value = fmi2Boolean::from(value);
        // SAFETY: see the type; one reference, one value.
        let status = unsafe { self.binding.fmi2SetBoolean(self.handle, &reference.0, 1, &value) };
        check(&self.name, "SetBoolean", status)
    }

    fn get_f64(
        &mut self,
        references: &[ValueReference],
        values: &mut [f64],
    ) -> Result<(), ImportError> {
        assert_eq!(references.len(), values.len(), "FMI 2.0 passes one length for both");
        let (n, vr) = (references.len(), ValueReference::as_raw(references).as_ptr());
        // SAFETY: see the type; both arrays have `n` elements.
        let status = unsafe { (self.step.get_real)(self.handle, vr, n, values.as_mut_ptr()) };
        check(&self.name, "GetReal", status)
    }

    fn get_i32(&mut self, reference: ValueReference) -> Result<i32, ImportError> {
        let mut value = 0;
        // SAFETY: see the type; one reference, one value.
        let status =
            unsafe { self.binding.fmi2GetInteger(self.handle, &reference.0, 1, &mut value) };
        check(&self.name, "GetInteger", status)?;
        Ok(value)
    }

    fn initialise(&mut self, start_s: f64) -> Result<(), ImportError> {
        // SAFETY: see the type.
        let set_up =
            unsafe { self.binding.fmi2SetupExperiment(self.handle, 0, 0.0, start_s, 0, 0.0) };
        check(&self.name, "SetupExperiment", set_up)?;
        // SAFETY: see the type.
        let entered = unsafe { self.binding.fmi2EnterInitializationMode(self.handle) };
        check(&self.name, "EnterInitializationMode", entered)?;
        // SAFETY: see the type.
        let left = unsafe { self.binding.fmi2ExitInitializationMode(self.handle) };
        check(&self.name, "ExitInitializationMode", left)
    }

    fn do_step(&mut self, time_s: f64, step_s: f64) -> Result<(), ImportError> {
        // SAFETY: see the type.
        let status = unsafe { (self.step.do_step)(self.handle, time_s, step_s, 1) };
        check(&self.name, "DoStep", status)
    }

    fn terminate(&mut self) -> Result<(), ImportError> {
        // SAFETY: see the type.
        let status = unsafe { self.binding.fmi2Terminate(self.handle) };
        check(&self.name, "Terminate", status)
    }
}
