//! The variable table: the one description of a model's interface.
//!
//! Both model descriptions, the instantiation token and every check on a get or set come from it.
//! Roles are chosen so that no illegal combination of causality, variability and initial can be
//! written down.

use crate::Unit;

/// What names a variable in C calls: its row in the variable table.
pub type ValueReference = u32;

/// What a variable is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Time, the first row of every table.
    Independent,
    /// Chosen before the end of initialisation, then fixed.
    Parameter,
    /// May also be changed between steps.
    TunableParameter,
    /// Comes from other models.
    Input,
    /// Calculated by this model.
    Output,
}

/// The type of a variable, its start value and its bounds (both included).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Domain {
    /// IEEE double: FMI 2.0 `Real`, FMI 3.0 `Float64`. Infinities and NaN belong to no domain.
    Float64 {
        /** Unit. */
        unit: Unit,
        /** Value after instantiation. */
        start: f64,
        /** Least value. */
        min: f64,
        /** Greatest value. */
        max: f64,
    },
    /// FMI 2.0 `Integer`, FMI 3.0 `Int32`.
    Int32 {
        /** Value after instantiation. */
        start: i32,
        /** Least value. */
        min: i32,
        /** Greatest value. */
        max: i32,
    },
    /// Boolean.
    Boolean {
        /** Value after instantiation. */
        start: bool,
    },
}

impl Domain {
    /// Any finite number.
    #[must_use]
    pub const fn float64(unit: Unit, start: f64) -> Self {
        Self::Float64 { unit, start, min: f64::MIN, max: f64::MAX }
    }

    /// Zero or any finite number above it.
    #[must_use]
    pub const fn not_negative(unit: Unit, start: f64) -> Self {
        Self::Float64 { unit, start, min: 0.0, max: f64::MAX }
    }

    /// Whole numbers from `min` to `max`.
    #[must_use]
    pub const fn int32(start: i32, min: i32, max: i32) -> Self {
        Self::Int32 { start, min, max }
    }

    /// True or false.
    #[must_use]
    pub const fn boolean(start: bool) -> Self {
        Self::Boolean { start }
    }

    /// Its type.
    #[must_use]
    pub const fn kind(&self) -> Kind {
        match self {
            Self::Float64 { .. } => Kind::Float64,
            Self::Int32 { .. } => Kind::Int32,
            Self::Boolean { .. } => Kind::Boolean,
        }
    }

    /// The start value as the 64 bits in which values are kept.
    pub(crate) const fn start_bits(&self) -> u64 {
        match *self {
            Self::Float64 { start, .. } => start.to_bits(),
            Self::Int32 { start, .. } => start.cast_unsigned() as u64,
            Self::Boolean { start } => start as u64,
        }
    }
}

/// The type of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// IEEE double.
    Float64,
    /// 32-bit signed integer.
    Int32,
    /// Boolean.
    Boolean,
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Float64 => "Float64",
            Self::Int32 => "Int32",
            Self::Boolean => "Boolean",
        })
    }
}

/// One row of the variable table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variable {
    pub(crate) value_reference: ValueReference,
    pub(crate) name: &'static str,
    pub(crate) role: Role,
    pub(crate) domain: Domain,
    pub(crate) description: &'static str,
    pub(crate) start_depends_on: &'static [ValueReference],
    pub(crate) on_demand: bool,
}

impl Variable {
    /// Time, s: row 0 of every table.
    pub const TIME: Self = Self {
        value_reference: 0,
        name: "time",
        role: Role::Independent,
        domain: Domain::float64(Unit::S, 0.0),
        description: "Current communication point.",
        start_depends_on: &[],
        on_demand: false,
    };

    /// A variable with the given row number, name (ending in its unit) and meaning.
    #[must_use]
    pub const fn new(
        value_reference: ValueReference,
        role: Role,
        name: &'static str,
        domain: Domain,
        description: &'static str,
    ) -> Self {
        let (start_depends_on, on_demand): (&'static [ValueReference], _) = (&[], false);
        Self { value_reference, name, role, domain, description, start_depends_on, on_demand }
    }

    /// What it means, in a sentence.
    #[must_use]
    pub const fn description(&self) -> &'static str {
        self.description
    }

    /// Names the parameters and inputs that the value of an output after initialisation depends on.
    #[must_use]
    pub const fn starting_from(mut self, references: &'static [ValueReference]) -> Self {
        self.start_depends_on = references;
        self
    }

    /// Makes an output one that is calculated when it is read, not in every step: see
    /// [`Model::write_outputs_on_demand`](crate::Model::write_outputs_on_demand).
    #[must_use]
    pub const fn on_demand(mut self) -> Self {
        self.on_demand = true;
        self
    }

    /// The name, which ends in the unit.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// The number that names it in C calls.
    #[must_use]
    pub const fn value_reference(&self) -> ValueReference {
        self.value_reference
    }

    /// What it is for.
    #[must_use]
    pub const fn role(&self) -> Role {
        self.role
    }

    /// Its type, start and bounds.
    #[must_use]
    pub const fn domain(&self) -> Domain {
        self.domain
    }

    /// Its unit; [`Unit::ONE`] for integers and Booleans.
    #[must_use]
    pub const fn unit(&self) -> Unit {
        match self.domain {
            Domain::Float64 { unit, .. } => unit,
            Domain::Int32 { .. } | Domain::Boolean { .. } => Unit::ONE,
        }
    }

    /// FMI's word for its causality.
    #[must_use]
    pub const fn causality(&self) -> &'static str {
        match self.role {
            Role::Independent => "independent",
            Role::Parameter | Role::TunableParameter => "parameter",
            Role::Input => "input",
            Role::Output => "output",
        }
    }

    pub(crate) const fn variability(&self) -> &'static str {
        match (self.role, self.domain) {
            (Role::Parameter, _) => "fixed",
            (Role::TunableParameter, _) => "tunable",
            (_, Domain::Float64 { .. }) => "continuous",
            (_, Domain::Int32 { .. } | Domain::Boolean { .. }) => "discrete",
        }
    }

    /// The `initial` attribute where the standard asks for one: an input's is implied.
    pub(crate) const fn initial(&self) -> Option<&'static str> {
        match self.role {
            Role::Parameter | Role::TunableParameter => Some("exact"),
            Role::Output => Some("calculated"),
            Role::Independent | Role::Input => None,
        }
    }

    /// Does it start from its table row, unless the importer sets it? Time and outputs do not.
    #[must_use]
    pub const fn has_start(&self) -> bool {
        matches!(self.role, Role::Parameter | Role::TunableParameter | Role::Input)
    }
}
