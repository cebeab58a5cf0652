//! FMI 3.0 through the `fmi` crate.

use crate::description::{FmiVersion, FmuDescription, Kind, ValueReference, Variable};
use crate::error::{ImportError, not_an_fmu};
use crate::{Importer, Instance, messages};
use fmi::fmi3::import::Fmi3Import;
use fmi::fmi3::instance::InstanceCS;
use fmi::fmi3::{CoSimulation, Common, Fmi3Error, Fmi3Model, Fmi3Res, GetSet};
use fmi::schema::fmi3::VariableType;
use fmi::traits::FmiImport;
use std::path::Path;

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

    /// Why the shared library cannot be used. Every function that an instance calls is looked up
    /// here, because the `fmi` crate panics when it calls one that is not there.
    fn check_library(&self) -> Result<(), String> {
        let co_simulation = self.import.model_description().co_simulation.as_ref();
        let name = co_simulation.map_or("", |interface| &interface.model_identifier);
        let library = self.import.binding(name).map_err(|error| error.to_string())?;
        let lacks = [
            library.fmi3InstantiateCoSimulation.as_ref().err(),
            library.fmi3EnterInitializationMode.as_ref().err(),
            library.fmi3ExitInitializationMode.as_ref().err(),
            library.fmi3SetFloat64.as_ref().err(),
            library.fmi3SetInt32.as_ref().err(),
            library.fmi3SetBoolean.as_ref().err(),
            library.fmi3GetFloat64.as_ref().err(),
            library.fmi3DoStep.as_ref().err(),
            library.fmi3Terminate.as_ref().err(),
            library.fmi3FreeInstance.as_ref().err(),
        ];
        lacks.into_iter().flatten().next().map_or(Ok(()), |error| Err(error.to_string()))
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
        self.check_library().map_err(|reason| ImportError::Load { model: model(), reason })?;
        match self.import.instantiate_cs(name, false, true, false, false, &[]) {
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
        f.debug_struct("Fmi3Slave").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Slave {
    #[inline]
    fn check(
        &self,
        call: &'static str,
        result: Result<Fmi3Res, Fmi3Error>,
    ) -> Result<(), ImportError> {
        match result {
            Ok(_) => Ok(()),
            Err(status) => Err(self.refusal(call, &status)),
        }
    }

    #[cold]
    fn refusal(&self, call: &'static str, status: &Fmi3Error) -> ImportError {
        let status = match status {
            Fmi3Error::Discard => "Discard",
            Fmi3Error::Error => "Error",
            Fmi3Error::Fatal => "Fatal",
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
        let result = self.instance.set_float64(ValueReference::as_raw(references), values);
        self.check("SetFloat64", result)
    }

    fn set_i32(&mut self, reference: ValueReference, value: i32) -> Result<(), ImportError> {
        let result = self.instance.set_int32(&[reference.0], &[value]);
        self.check("SetInt32", result)
    }

    fn set_bool(&mut self, reference: ValueReference, value: bool) -> Result<(), ImportError> {
        let result = self.instance.set_boolean(&[reference.0], &[value]);
        self.check("SetBoolean", result)
    }

    fn get_f64(
        &mut self,
        references: &[ValueReference],
        values: &mut [f64],
    ) -> Result<(), ImportError> {
        let result = self.instance.get_float64(ValueReference::as_raw(references), values);
        self.check("GetFloat64", result)
    }

    fn initialise(&mut self, start_s: f64) -> Result<(), ImportError> {
        let entered = Common::enter_initialization_mode(&mut self.instance, None, start_s, None);
        self.check("EnterInitializationMode", entered)?;
        let left = Common::exit_initialization_mode(&mut self.instance);
        self.check("ExitInitializationMode", left)
    }

    fn do_step(&mut self, time_s: f64, step_s: f64) -> Result<(), ImportError> {
        let (mut event, mut terminate, mut early, mut reached_s) = (false, false, false, 0.0);
        let result = self.instance.do_step(
            time_s,
            step_s,
            true,
            &mut event,
            &mut terminate,
            &mut early,
            &mut reached_s,
        );
        self.check("DoStep", result)?;
        if terminate || early {
            let instance = self.name.clone();
            return Err(ImportError::StoppedEarly { instance, time_s: reached_s });
        }
        Ok(())
    }

    fn terminate(&mut self) -> Result<(), ImportError> {
        let result = Common::terminate(&mut self.instance);
        self.check("Terminate", result)
    }
}
