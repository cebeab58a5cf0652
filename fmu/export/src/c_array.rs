//! Arrays that C hands over as a pointer and a length.
//!
//! They are not made into slices: C may leave output arrays uninitialised or let arrays overlap,
//! and a Rust slice promises otherwise.

use crate::status::{Reason, Refusal};

/// An array to read from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CInput<T> {
    first: *const T,
    len: usize,
}

impl<T: Copy> CInput<T> {
    /// # Safety
    /// `first` must be null or point at `len` readable elements for as long as the value is used.
    #[inline]
    pub(crate) unsafe fn new(
        first: *const T,
        len: usize,
        argument: &'static str,
    ) -> Result<Self, Refusal> {
        if first.is_null() && len > 0 {
            return Err(Reason::NullPointer { argument }.into());
        }
        Ok(Self { first, len })
    }

    pub(crate) fn len(&self) -> usize {
        self.len
    }

    #[inline]
    pub(crate) fn iter(&self) -> impl Iterator<Item = T> + use<T> {
        let Self { first, len } = *self;
        // SAFETY: `new` was promised `len` readable elements; no alignment is asked of C.
        (0..len).map(move |i| unsafe { first.add(i).read_unaligned() })
    }
}

/// An array to write into.
#[derive(Debug)]
pub(crate) struct COutput<T> {
    first: *mut T,
    len: usize,
}

impl<T: Copy> COutput<T> {
    /// # Safety
    /// `first` must be null or point at `len` writable elements for as long as the value is used.
    #[inline]
    pub(crate) unsafe fn new(
        first: *mut T,
        len: usize,
        argument: &'static str,
    ) -> Result<Self, Refusal> {
        if first.is_null() && len > 0 {
            return Err(Reason::NullPointer { argument }.into());
        }
        Ok(Self { first, len })
    }

    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Writes the elements of `source` one after the other, no more than there is room for.
    #[inline]
    pub(crate) fn fill(&mut self, source: impl Iterator<Item = T>) {
        for (i, element) in (0..self.len).zip(source) {
            // SAFETY: `new` was promised `len` writable elements; no alignment is asked of C.
            unsafe { self.first.add(i).write_unaligned(element) };
        }
    }
}

/// Writes `value` to `target` unless that is null: an importer that does not want it may say so.
///
/// # Safety
/// `target` must be null or writable.
pub(crate) unsafe fn write_if_wanted<T>(target: *mut T, value: T) {
    if !target.is_null() {
        // SAFETY: not null, so writable by the caller's promise.
        unsafe { target.write_unaligned(value) };
    }
}
