//! Reading and writing variables from C.

use crate::c_array::{CInput, COutput};
use crate::instance::{Instance, Phase};
use crate::status::{Reason, Refusal};
use crate::variable::{Domain, Kind, Role, ValueReference, Variable};

/// A variable type as one of the two C interfaces spells it.
pub(crate) trait Element {
    /// The C type.
    type C: Copy;
    const KIND: Kind;
    fn from_bits(bits: u64) -> Self::C;
    fn to_bits(value: Self::C) -> u64;
}

/// FMI 2.0 `Real` and FMI 3.0 `Float64`.
pub(crate) struct Float64;

impl Element for Float64 {
    type C = f64;
    const KIND: Kind = Kind::Float64;
    fn from_bits(bits: u64) -> f64 {
        f64::from_bits(bits)
    }
    fn to_bits(value: f64) -> u64 {
        value.to_bits()
    }
}

/// FMI 2.0 `Integer` and FMI 3.0 `Int32`.
pub(crate) struct Int32;

impl Element for Int32 {
    type C = i32;
    const KIND: Kind = Kind::Int32;
    #[expect(clippy::cast_possible_truncation, reason = "an Int32 lives in the low 32 bits")]
    fn from_bits(bits: u64) -> i32 {
        (bits as u32).cast_signed()
    }
    fn to_bits(value: i32) -> u64 {
        u64::from(value.cast_unsigned())
    }
}

/// FMI 2.0 `Boolean`: a C `int`, true if not zero.
pub(crate) struct IntBoolean;

impl Element for IntBoolean {
    type C = i32;
    const KIND: Kind = Kind::Boolean;
    fn from_bits(bits: u64) -> i32 {
        i32::from(bits != 0)
    }
    fn to_bits(value: i32) -> u64 {
        u64::from(value != 0)
    }
}

/// FMI 3.0 `Boolean`: a C `bool`, taken as a byte because Rust must not see a `bool` that is
/// neither 0 nor 1.
pub(crate) struct ByteBoolean;

impl Element for ByteBoolean {
    type C = u8;
    const KIND: Kind = Kind::Boolean;
    fn from_bits(bits: u64) -> u8 {
        u8::from(bits != 0)
    }
    fn to_bits(value: u8) -> u64 {
        u64::from(value != 0)
    }
}

impl Instance {
    /// Writes the values of `references` to `values`: all of them, or none when one is refused.
    #[inline]
    pub(crate) fn get<E: Element>(
        &mut self,
        references: CInput<ValueReference>,
        mut values: COutput<E::C>,
    ) -> Result<(), Refusal> {
        check_counts(references.len(), values.len())?;
        let may_be_stale = self.phase() < Phase::Step;
        let table = self.model_type().description.variables;
        for reference in references.iter() {
            let variable = row::<E>(table, reference)?;
            if may_be_stale && variable.role == Role::Output {
                self.write_trial_outputs()?;
            }
            if variable.on_demand && self.owes_outputs() {
                self.settle_outputs();
            }
        }
        let current = self.values().all_bits();
        values.fill(references.iter().map(|vr| E::from_bits(current[vr as usize])));
        Ok(())
    }

    /// Takes over `values` for `references`: all of them, or none when one is refused.
    #[inline]
    pub(crate) fn set<E: Element>(
        &mut self,
        references: CInput<ValueReference>,
        values: CInput<E::C>,
    ) -> Result<(), Refusal> {
        check_counts(references.len(), values.len())?;
        let phase = self.phase();
        let table = self.model_type().description.variables;
        for (reference, value) in references.iter().zip(values.iter()) {
            row::<E>(table, reference)?.check_set(phase, E::to_bits(value))?;
        }
        let current = self.values_mut();
        for (reference, value) in references.iter().zip(values.iter()) {
            current.set_bits(reference, E::to_bits(value));
        }
        Ok(())
    }
}

/// The row of a variable of type `E`.
#[inline]
fn row<E: Element>(
    table: &'static [Variable],
    reference: ValueReference,
) -> Result<&'static Variable, Refusal> {
    let Some(variable) = table.get(reference as usize) else {
        return Err(Reason::UnknownVariable { reference }.into());
    };
    let is = variable.domain.kind();
    if is != E::KIND {
        return Err(Reason::WrongType { variable: variable.name, is, asked: E::KIND }.into());
    }
    Ok(variable)
}

#[inline]
fn check_counts(references: usize, values: usize) -> Result<(), Refusal> {
    if references == values {
        Ok(())
    } else {
        Err(Reason::CountMismatch { references, values }.into())
    }
}

impl Variable {
    /// May `bits` be set now? Bounds of parameters are judged when they take effect, at the end of
    /// initialisation; those of inputs and tunable parameters from then on at once.
    #[inline(always)]
    fn check_set(&self, phase: Phase, bits: u64) -> Result<(), Refusal> {
        match (self.role, phase) {
            (Role::Input | Role::TunableParameter, Phase::Step) => self.check_bounds(bits),
            (
                Role::Input | Role::Parameter | Role::TunableParameter,
                Phase::Instantiated | Phase::Initialization,
            ) => self.check_finite(bits),
            _ => Err(self.not_settable(phase, bits)),
        }
    }

    #[inline]
    fn check_finite(&self, bits: u64) -> Result<(), Refusal> {
        if self.domain.kind() == Kind::Float64 && !f64::from_bits(bits).is_finite() {
            let value = f64::from_bits(bits);
            return Err(Reason::NotFinite { variable: self.name, value }.into());
        }
        Ok(())
    }

    #[inline]
    pub(crate) fn check_bounds(&self, bits: u64) -> Result<(), Refusal> {
        self.check_finite(bits)?;
        let within = match self.domain {
            Domain::Float64 { min, max, .. } => (min..=max).contains(&f64::from_bits(bits)),
            Domain::Int32 { min, max, .. } => (min..=max).contains(&Int32::from_bits(bits)),
            Domain::Boolean { .. } => true,
        };
        if within { Ok(()) } else { Err(self.out_of_bounds(bits)) }
    }

    #[cold]
    fn out_of_bounds(&self, bits: u64) -> Refusal {
        let bounds = match self.domain {
            Domain::Float64 { min, max: f64::MAX, .. } => format!("at least {min:?}"),
            Domain::Float64 { min, max, .. } => format!("{min:?} to {max:?}"),
            Domain::Int32 { min, max: i32::MAX, .. } => format!("at least {min}"),
            Domain::Int32 { min, max, .. } => format!("{min} to {max}"),
            Domain::Boolean { .. } => "true or false".into(),
        };
        Reason::OutOfBounds { variable: self.name, value: self.show(bits), bounds }.into()
    }

    #[cold]
    fn not_settable(&self, phase: Phase, bits: u64) -> Refusal {
        let (variable, value) = (self.name, self.show(bits));
        match self.role {
            Role::Independent | Role::Output => {
                Reason::NotSettable { variable, value, causality: self.causality() }.into()
            }
            Role::Parameter | Role::TunableParameter | Role::Input => {
                let variability = self.variability();
                Reason::NoLongerSettable { variable, value, variability, phase }.into()
            }
        }
    }

    /// A value of this variable in words.
    fn show(&self, bits: u64) -> String {
        match self.domain.kind() {
            Kind::Float64 => format!("{:?}", f64::from_bits(bits)),
            Kind::Int32 => Int32::from_bits(bits).to_string(),
            Kind::Boolean => (bits != 0).to_string(),
        }
    }
}
