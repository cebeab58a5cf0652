//! The values of one instance's variables.

use crate::variable::{ValueReference, Variable};

/// The values of all variables, each in 64 bits, indexed by value reference.
///
/// Owned by the C layer and lent to the model, so that getting and setting need no code per model
/// and no lookup: a value reference is an index.
#[derive(Debug, Clone)]
pub struct Values(Box<[u64]>);

impl Values {
    /// The start values of a table.
    pub(crate) fn starting(variables: &[Variable]) -> Self {
        Self(variables.iter().map(|v| v.domain.start_bits()).collect())
    }

    /// The value of a Float64 variable, in the unit of its table row.
    ///
    /// # Panics
    /// When the table has no such row, as do all the methods below: a mistake in the model.
    #[inline]
    #[must_use]
    pub fn float64(&self, reference: ValueReference) -> f64 {
        f64::from_bits(self.bits(reference))
    }

    /// The value of an Int32 variable.
    ///
    /// # Panics
    /// When the table has no such row.
    #[inline]
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "an Int32 lives in the low 32 bits")]
    pub fn int32(&self, reference: ValueReference) -> i32 {
        (self.bits(reference) as u32).cast_signed()
    }

    /// The value of a Boolean variable.
    ///
    /// # Panics
    /// When the table has no such row.
    #[inline]
    #[must_use]
    pub fn boolean(&self, reference: ValueReference) -> bool {
        self.bits(reference) != 0
    }

    /// Gives a Float64 variable a value, in the unit of its table row.
    ///
    /// # Panics
    /// When the table has no such row.
    #[inline]
    pub fn set_float64(&mut self, reference: ValueReference, value: f64) {
        self.set_bits(reference, value.to_bits());
    }

    /// Gives an Int32 variable a value.
    ///
    /// # Panics
    /// When the table has no such row.
    #[inline]
    pub fn set_int32(&mut self, reference: ValueReference, value: i32) {
        self.set_bits(reference, u64::from(value.cast_unsigned()));
    }

    /// Gives a Boolean variable a value.
    ///
    /// # Panics
    /// When the table has no such row.
    #[inline]
    pub fn set_boolean(&mut self, reference: ValueReference, value: bool) {
        self.set_bits(reference, u64::from(value));
    }

    #[inline]
    pub(crate) fn bits(&self, reference: ValueReference) -> u64 {
        self.0[reference as usize]
    }

    #[inline]
    pub(crate) fn set_bits(&mut self, reference: ValueReference, bits: u64) {
        self.0[reference as usize] = bits;
    }

    pub(crate) fn all_bits(&self) -> &[u64] {
        &self.0
    }

    pub(crate) fn all_bits_mut(&mut self) -> &mut [u64] {
        &mut self.0
    }
}
