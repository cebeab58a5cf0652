//! Estimator states as plain little-endian bytes.

/// Why bytes are not the state of this estimator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RestoreError {
    /// Too few or too many bytes.
    #[error("saved state has {got} bytes, this estimator's has {need}")]
    Length {
        /** Bytes that a state has. */
        need: usize,
        /** Bytes given. */
        got: usize,
    },
    /// A number that no running estimator can hold.
    #[error("saved state holds a value of {name} that is not finite")]
    NotFinite {
        /** Which number. */
        name: &'static str,
    },
    /// Counters that no running estimator can hold.
    #[error("saved state holds counters that contradict each other")]
    Impossible,
}

/// Writes numbers one after another.
pub(crate) struct Writer<'a> {
    rest: &'a mut [u8],
}

impl<'a> Writer<'a> {
    pub(crate) fn new(out: &'a mut [u8]) -> Self {
        Self { rest: out }
    }

    pub(crate) fn f64(&mut self, value: f64) {
        self.put(value.to_le_bytes());
    }

    pub(crate) fn u32(&mut self, value: u32) {
        self.put(value.to_le_bytes());
    }

    pub(crate) fn u64(&mut self, value: u64) {
        self.put(value.to_le_bytes());
    }

    fn put<const N: usize>(&mut self, bytes: [u8; N]) {
        let (head, tail) = core::mem::take(&mut self.rest).split_at_mut(N);
        head.copy_from_slice(&bytes);
        self.rest = tail;
    }
}

/// Reads back what [`Writer`] wrote. The length is judged once, at the start.
pub(crate) struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    pub(crate) fn new(bytes: &'a [u8], need: usize) -> Result<Self, RestoreError> {
        if bytes.len() == need {
            Ok(Self { rest: bytes })
        } else {
            Err(RestoreError::Length { need, got: bytes.len() })
        }
    }

    pub(crate) fn finite(&mut self, name: &'static str) -> Result<f64, RestoreError> {
        let value = f64::from_le_bytes(self.take());
        if value.is_finite() { Ok(value) } else { Err(RestoreError::NotFinite { name }) }
    }

    pub(crate) fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    pub(crate) fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.take())
    }

    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (head, tail) = self.rest.split_at(N);
        self.rest = tail;
        head.try_into().expect("split_at gave N bytes")
    }
}
