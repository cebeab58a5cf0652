//! FMI 3.0: description and binding by the `fmi` crate, calls straight to the FMU.
//!
//! The crate's own instance is not used: it goes through two more functions in each call, and ends
//! the process when an FMU answers or logs with a status that the standard does not know.

#![expect(unsafe_code, reason = "calls into the FMU; every block states why it is sound")]

use crate::description::{FmiVersion, FmuDescription, Kind, ValueReference, Variable};
use crate::error::{ImportError, not_an_fmu};
use crate::status::{Status, check};
use crate::{Importer, Instance, messages};
use fmi::fmi3::binding::{Fmi3Binding, fmi3Instance, fmi3ValueReference};
use fmi::fmi3::import::Fmi3Import;
use fmi::schema::fmi3::VariableType;
use fmi::traits::FmiImport;
use std::ffi::{CString, NulError};
use std::path::Path;
use std::ptr::{null, null_mut};

pub(crate) struct Fmi3 {
    import: Fmi3Import,
    description: FmuDescription,
}

impl Fmi3 {
    pub(crate) fn open(path: &Path) -> Result<Self, ImportError> {
        let import: Fmi3Import = fmi::import::from_path(path).map_err(|e| not_an_fmu(path, &e))?;
        let raw = import.model_description();
        if raw.co_simulation.is_none() {
            return Err(ImportError::NotCoSimulation { path: path.to_owned() });
        }
        let variables = raw.model_variables.iter_abstract().map(|variable| {
            let kind = match variable.data_type() {
                VariableType::FmiFloat64 => Kind::Float64,
                VariableType::FmiInt32 => Kind::Int32,
                VariableType::FmiBoolean => Kind::Boolean,
                _ => Kind::Other,
            };
            let reference = ValueReference(variable.value_reference());
            (variable.name().to_owned(), Variable { reference, kind })
        });
        let description = FmuDescription {
            model_name: raw.model_name.clone(),
            version: FmiVersion::Fmi3,
            token: raw.instantiation_token.clone(),
            variables: variables.collect(),
        };
        Ok(Self { import, description })
    }

    /// Loads the shared library. Every function that an instance calls is looked up here, because
    /// the binding panics when it calls one that is not there.
    fn bind(&self) -> Result<(Fmi3Binding, StepFunctions), String> {
        let co_simulation = self.import.model_description().co_simulation.as_ref();
        let name = co_simulation.map_or("", |interface| &interface.model_identifier);
        let binding = self.import.binding(name).map_err(|error| error.to_string())?;
        let lacks = [
            binding.fmi3InstantiateCoSimulation.as_ref().err(),
            binding.fmi3EnterInitializationMode.as_ref().err(),
            binding.fmi3ExitInitializationMode.as_ref().err(),
            binding.fmi3SetInt32.as_ref().err(),
            binding.fmi3GetInt32.as_ref().err(),
            binding.fmi3SetBoolean.as_ref().err(),
            binding.fmi3Terminate.as_ref().err(),
            binding.fmi3FreeInstance.as_ref().err(),
        ];
        if let Some(error) = lacks.into_iter().flatten().next() {
            return Err(error.to_string());
        }
        let step = StepFunctions {
            set_float64: *binding.fmi3SetFloat64.as_ref().map_err(ToString::to_string)?,
            get_float64: *binding.fmi3GetFloat64.as_ref().map_err(ToString::to_string)?,
            do_step: *binding.fmi3DoStep.as_ref().map_err(ToString::to_string)?,
        };
        Ok((binding, step))
    }

    /// A new instance in the FMU; null if it refuses.
    fn handle(&self, binding: &Fmi3Binding, name: &str) -> Result<fmi3Instance, NulError> {
        let token = CString::new(self.description.token.as_str())?;
        let resources = CString::new(self.import.canonical_resource_path_string())?;
        let name = CString::new(name)?;
        // SAFETY: the texts are terminated and outlive the call, no intermediate variables are
        // promised, the log callback asks nothing of its environment, and the function was found.
        Ok(unsafe {
            binding.fmi3InstantiateCoSimulation(
                name.as_ptr(),
                token.as_ptr(),
                resources.as_ptr(),
                false,
                true,
                false,
                false,
                null(),
                0,
                null_mut(),
                Some(messages::fmi3_log_message),
                None,
            )
        })
    }
}

impl std::fmt::Debug for Fmi3 {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Fmi3").field("description", &self.description).finish_non_exhaustive()
    }
}

impl Importer for Fmi3 {
    fn description(&self) -> &FmuDescription {
        &self.description
    }

    fn instantiate(&self, name: &str) -> Result<Box<dyn Instance>, ImportError> {
        messages::take();
        let model = || self.description.model_name.clone();
        let load = |reason| ImportError::Load { model: model(), reason };
        let (binding, step) = self.bind().map_err(load)?;
        let handle = self.handle(&binding, name).map_err(|error| load(error.to_string()))?;
        if handle.is_null() {
            return Err(ImportError::Refused { model: model(), messages: messages::take() });
        }
        Ok(Box::new(Slave { binding, handle, step, name: name.to_owned() }))
    }
}

/// What every step calls, looked up once: the binding asks in each call whether it is there.
#[derive(Clone, Copy)]
struct StepFunctions {
    set_float64: SetFloat64,
    get_float64: GetFloat64,
    do_step: DoStep,
}

type SetFloat64 = unsafe extern "C" fn(
    fmi3Instance,
    *const fmi3ValueReference,
    usize,
    *const f64,
    usize,
) -> Status;
type GetFloat64 =
    unsafe extern "C" fn(fmi3Instance, *const fmi3ValueReference, usize, *mut f64, usize) -> Status;
type DoStep = unsafe extern "C" fn(
    fmi3Instance,
    f64,
    f64,
    bool,
    *mut bool,
    *mut bool,
    *mut bool,
    *mut f64,
) -> Status;

/// One instance.
///
/// That the calls below are sound rests on this: `handle` came from `binding`, which stays loaded
/// and in which every function was found; being no `Send`, the instance stays on its thread; and
/// it is freed when dropped, after which no call can follow.
struct Slave {
    binding: Fmi3Binding,
    handle: fmi3Instance,
    step: StepFunctions,
    name: String,
}

impl Drop for Slave {
    fn drop(&mut self) {
        // SAFETY: see the type.
        unsafe { self.binding.fmi3FreeInstance(self.handle) }
    }
}

impl std::fmt::Debug for Slave {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Fmi3Slave").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Instance for Slave {
    fn set_f64(
        &mut self,
        references: &[ValueReference],
        values: &[f64],
    ) -> Result<(), ImportError> {
        let (n, vr) = (references.len(), ValueReference::as_raw(references).as_ptr());
        // SAFETY: see the type; both arrays go with their lengths.
        let status =
            unsafe { (self.step.set_float64)(self.handle, vr, n, values.as_ptr(), values.len()) };
        check(&self.name, "SetFloat64", status)
    }

    fn set_i32(&mut self, reference: ValueReference, value: i32) -> Result<(), ImportError> {
        // SAFETY: see the type; one reference, one value.
        let status = unsafe { self.binding.fmi3SetInt32(self.handle, &reference.0, 1, &value, 1) };
        check(&self.name, "SetInt32", status)
    }

    fn set_bool(&mut self, reference: ValueReference, value: bool) -> Result<(), ImportError> {
        // SAFETY: see the type; one reference, one value.
        let status =
            unsafe { self.binding.fmi3SetBoolean(self.handle, &reference.0, 1, &value, 1) };
        check(&self.name, "SetBoolean", status)
    }

    fn get_f64(
        &mut self,
        references: &[ValueReference],
        values: &mut [f64],
    ) -> Result<(), ImportError> {
        let (n, vr) = (references.len(), ValueReference::as_raw(references).as_ptr());
        // SAFETY: see the type; both arrays go with their lengths.
        let status = unsafe {
            (self.step.get_float64)(self.handle, vr, n, values.as_mut_ptr(), values.len())
        };
        check(&self.name, "GetFloat64", status)
    }

    fn get_i32(&mut self, reference: ValueReference) -> Result<i32, ImportError> {
        let mut value = 0;
        // SAFETY: see the type; one reference, one value.
        let status =
            unsafe { self.binding.fmi3GetInt32(self.handle, &reference.0, 1, &mut value, 1) };
        check(&self.name, "GetInt32", status)?;
        Ok(value)
    }

    fn initialise(&mut self, start_s: f64) -> Result<(), ImportError> {
        // SAFETY: see the type.
        let entered = unsafe {
            self.binding.fmi3EnterInitializationMode(self.handle, false, 0.0, start_s, false, 0.0)
        };
        check(&self.name, "EnterInitializationMode", entered)?;
        // SAFETY: see the type.
        let left = unsafe { self.binding.fmi3ExitInitializationMode(self.handle) };
        check(&self.name, "ExitInitializationMode", left)
    }

    fn do_step(&mut self, time_s: f64, step_s: f64) -> Result<(), ImportError> {
        let (mut event, mut terminate, mut early, mut reached_s) = (0_u8, 0_u8, 0_u8, 0.0);
        // SAFETY: see the type; the results are this function's own. The Booleans are read as
        // bytes, for an FMU may write what is no `bool`.
        let status = unsafe {
            (self.step.do_step)(
                self.handle,
                time_s,
                step_s,
                true,
                (&raw mut event).cast(),
                (&raw mut terminate).cast(),
                (&raw mut early).cast(),
                &raw mut reached_s,
            )
        };
        check(&self.name, "DoStep", status)?;
        if terminate | early != 0 {
            return Err(self.stopped_early(reached_s));
        }
        Ok(())
    }

    fn terminate(&mut self) -> Result<(), ImportError> {
        // SAFETY: see the type.
        let status = unsafe { self.binding.fmi3Terminate(self.handle) };
        check(&self.name, "Terminate", status)
    }
}

impl Slave {
    #[cold]
    fn stopped_early(&self, time_s: f64) -> ImportError {
        ImportError::StoppedEarly { instance: self.name.clone(), time_s }
    }
}
