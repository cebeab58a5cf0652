//! FMI 2.0 through the `fmi` crate.

use crate::description::{FmiVersion, FmuDescription, Kind, ValueReference, Variable};
use crate::error::{ImportError, not_an_fmu};
use crate::{Importer, Instance, messages};
use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::InstanceCS;
use fmi::fmi2::instance::{CoSimulation, Common};
use fmi::fmi2::{Fmi2Error, Fmi2Res};
use fmi::schema::fmi2::ScalarVariableElement;
use fmi::traits::FmiImport;
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

    /// Why the shared library cannot be used. Every function that an instance calls is looked up
    /// here, because the `fmi` crate panics when it calls one that is not there.
    fn check_library(&self) -> Result<(), String> {
        let co_simulation = self.import.model_description().co_simulation.as_ref();
        let name = co_simulation.map_or("", |interface| &interface.model_identifier);
        let library = self.import.binding(name).map_err(|error| error.to_string())?;
        let lacks = [
            library.fmi2Instantiate.as_ref().err(),
            library.fmi2SetupExperiment.as_ref().err(),
            library.fmi2EnterInitializationMode.as_ref().err(),
            library.fmi2ExitInitializationMode.as_ref().err(),
            library.fmi2SetReal.as_ref().err(),
            library.fmi2SetInteger.as_ref().err(),
            library.fmi2SetBoolean.as_ref().err(),
            library.fmi2GetReal.as_ref().err(),
            library.fmi2DoStep.as_ref().err(),
            library.fmi2Terminate.as_ref().err(),
            library.fmi2FreeInstance.as_ref().err(),
        ];
        lacks.into_iter().flatten().next().map_or(Ok(()), |error| Err(error.to_string()))
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
        self.check_library().map_err(|reason| ImportError::Load { model: model(), reason })?;
        match InstanceCS::new(&self.import, name, false, true) {
            Ok(instance) => Ok(Box::new(Slave { instance, name: name.to_owned() })),
            Err(fmi::Error::Instantiation) => {
                Err(ImportError::Refused { model: model(), messages: messages::take() })
            }
            Err(e) => Err(ImportError::Load { model: model(), reason: e.to_string() }),
        }
    }
}

struct Slave {
    instance: InstanceCS,
    name: String,
}

impl std::fmt::Debug for Slave {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Fmi2Slave").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Slave {
    #[inline]
    fn check(
        &self,
        call: &'static str,
        result: Result<Fmi2Res, Fmi2Error>,
    ) -> Result<(), ImportError> {
        match result {
            Ok(_) => Ok(()),
            Err(status) => Err(self.refusal(call, &status)),
        }
    }

    #[cold]
    fn refusal(&self, call: &'static str, status: &Fmi2Error) -> ImportError {
        let status = match status {
            Fmi2Error::TypesPlatformMismatch(_) => "TypesPlatformMismatch",
            Fmi2Error::Discard => "Discard",
            Fmi2Error::Error => "Error",
            Fmi2Error::Fatal => "Fatal",
        };
        let messages = messages::take();
        ImportError::Call { instance: self.name.clone(), call, status, messages }
    }
}

impl Instance for Slave {
    fn set_f64(
        &mut self,
        references: &[ValueReference],
        values: &[f64],
    ) -> Result<(), ImportError> {
        let result = self.instance.set_real(ValueReference::as_raw(references), values);
        self.check("SetReal", result)
    }

    fn set_i32(&mut self, reference: ValueReference, value: i32) -> Result<(), ImportError> {
        let result = self.instance.set_integer(&[reference.0], &[value]);
        self.check("SetInteger", result)
    }

    fn set_bool(&mut self, reference: ValueReference, value: bool) -> Result<(), ImportError> {
        let result = self.instance.set_boolean(&[reference.0], &[i32::from(value)]);
        self.check("SetBoolean", result)
    }

    fn get_f64(
        &mut self,
        references: &[ValueReference],
        values: &mut [f64],
    ) -> Result<(), ImportError> {
        let result = self.instance.get_real(ValueReference::as_raw(references), values);
        self.check("GetReal", result)
    }

    fn initialise(&mut self, start_s: f64) -> Result<(), ImportError> {
        let set_up = self.instance.setup_experiment(None, start_s, None);
        self.check("SetupExperiment", set_up)?;
        let entered = Common::enter_initialization_mode(&mut self.instance);
        self.check("EnterInitializationMode", entered)?;
        let left = Common::exit_initialization_mode(&mut self.instance);
        self.check("ExitInitializationMode", left)
    }

    fn do_step(&mut self, time_s: f64, step_s: f64) -> Result<(), ImportError> {
        let result = self.instance.do_step(time_s, step_s, true);
        self.check("DoStep", result)
    }

    fn terminate(&mut self) -> Result<(), ImportError> {
        let result = Common::terminate(&mut self.instance);
        self.check("Terminate", result)
    }
}
