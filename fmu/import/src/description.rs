//! What an importer needs of a model description, the same for both FMI versions.

use crate::ImportError;
use std::collections::BTreeMap;

/// Which FMI an FMU speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FmiVersion {
    /// FMI 2.0.
    Fmi2,
    /// FMI 3.0.
    Fmi3,
}

/// Handle of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(transparent)]
pub struct ValueReference(pub u32);

impl ValueReference {
    /// The same handles as plain numbers, without a copy.
    #[inline]
    #[expect(unsafe_code, reason = "a copy in every set and get would cost more than the call")]
    pub(crate) fn as_raw(references: &[Self]) -> &[u32] {
        // SAFETY: `repr(transparent)` gives both types one layout, and length and lifetime carry
        // over.
        unsafe { std::slice::from_raw_parts(references.as_ptr().cast(), references.len()) }
    }
}

/// The kinds of variable that are set and read here; others are listed as [`Kind::Other`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Float64, or Real.
    Float64,
    /// Int32, or Integer.
    Int32,
    /// Boolean.
    Boolean,
    /// Anything else.
    Other,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Float64 => "Float64",
            Self::Int32 => "Int32",
            Self::Boolean => "Boolean",
            Self::Other => "other",
        }
    }
}

/// One variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Variable {
    /// Its handle.
    pub reference: ValueReference,
    /// Its kind.
    pub kind: Kind,
}

/// The part of a model description that an importer works with.
#[derive(Debug, Clone)]
pub struct FmuDescription {
    /// Model name.
    pub model_name: String,
    /// FMI version.
    pub version: FmiVersion,
    /// Instantiation token (FMI 2.0: GUID).
    pub token: String,
    /// Variables by name.
    pub variables: BTreeMap<String, Variable>,
}

impl FmuDescription {
    /// The handle of the variable called `name`, which must be of kind `kind`.
    ///
    /// # Errors
    /// [`ImportError::NoVariable`], with the nearest name of that kind.
    pub fn variable(&self, name: &str, kind: Kind) -> Result<ValueReference, ImportError> {
        match self.variables.get(name) {
            Some(variable) if variable.kind == kind => Ok(variable.reference),
            _ => Err(ImportError::NoVariable {
                model: self.model_name.clone(),
                kind: kind.name(),
                name: name.to_owned(),
                nearest: self.nearest(name, kind),
            }),
        }
    }

    /// The name that shares the longest start with `name`: enough to catch a wrong unit suffix.
    fn nearest(&self, name: &str, kind: Kind) -> Option<String> {
        let of_kind = self.variables.iter().filter(|(_, variable)| variable.kind == kind);
        of_kind
            .map(|(other, _)| (shared_start(name, other), other))
            .max()
            .filter(|(length, _)| *length >= 3)
            .map(|(_, other)| other.clone())
    }
}

fn shared_start(a: &str, b: &str) -> usize {
    a.bytes().zip(b.bytes()).take_while(|(x, y)| x == y).count()
}
