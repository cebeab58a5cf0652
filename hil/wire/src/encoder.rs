//! From raw field values to bytes.

use crate::field::When;
use crate::{FrameSpec, Kind, MAX_CONTENT_LEN, kind};

/// Why a frame was not encoded. Nothing was written and the counter did not move.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum EncodeError {
    /// Not one value for each field.
    #[error("{found} values for {expected} fields; give one value for each field, in file order")]
    FieldCount {
        /** Values given. */
        found: usize,
        /** Fields of the frame. */
        expected: usize,
    },
    /// A value that the field's bits cannot hold.
    #[error("raw value {raw} does not fit field `{field}`; it holds {min} to {max}")]
    RawOutOfRange {
        /** The field. */
        field: String,
        /** The value. */
        raw: i64,
        /** Least value that fits. */
        min: i64,
        /** Greatest value that fits. */
        max: i64,
    },
}

/// Writes frames of one layout, counting them.
///
/// The emulated gyro's last stage. After the output vector has grown to its working size, no
/// frame allocates.
#[derive(Debug, Clone)]
pub struct Encoder {
    spec: FrameSpec,
    next_index: u64,
}

impl Encoder {
    /// An encoder whose first frame has index zero.
    #[must_use]
    pub fn new(spec: &FrameSpec) -> Self {
        Self::starting_at(spec, 0)
    }

    /// An encoder whose first frame has index `first_index`: a gyro that has been running.
    #[must_use]
    pub fn starting_at(spec: &FrameSpec, first_index: u64) -> Self {
        Self { spec: spec.clone(), next_index: first_index }
    }

    /// Index of the next frame; the counter on the wire is this modulo the layout's modulus.
    #[must_use]
    pub const fn next_index(&self) -> u64 {
        self.next_index
    }

    /// Appends one frame to `out`. `raw` holds one raw value for each field, in file order; the
    /// value of a field that this frame does not carry is not looked at. Undeclared bits are sent
    /// as zero.
    ///
    /// # Errors
    /// [`EncodeError`] when `raw` does not fit the layout. Values are not saturated here:
    /// [`crate::FieldSpec::from_si`] and the gyro model do that, knowing why.
    pub fn encode(&mut self, raw: &[i64], out: &mut Vec<u8>) -> Result<(), EncodeError> {
        self.refuse_unfit(raw)?;
        let mut buffer = [0; MAX_CONTENT_LEN];
        let content = &mut buffer[..self.spec.len];
        if !is_text(&self.spec) {
            content[..self.spec.sync.len()].copy_from_slice(&self.spec.sync);
        }
        for (field, value) in self.spec.fields.iter().zip(raw) {
            if carried(field.when, raw) {
                field.write(*value, content);
            }
        }
        if let Some(sequence) = &self.spec.sequence {
            sequence.write(self.next_index, content);
        }
        if !is_text(&self.spec) {
            self.spec.check.write(content);
        }
        kind::emit(&self.spec, content, out);
        self.next_index = self.next_index.wrapping_add(1);
        Ok(())
    }

    fn refuse_unfit(&self, all: &[i64]) -> Result<(), EncodeError> {
        let fields = &self.spec.fields;
        if all.len() != fields.len() {
            return Err(EncodeError::FieldCount { found: all.len(), expected: fields.len() });
        }
        for (field, &raw) in fields.iter().zip(all) {
            let (min, max) = (field.raw_min(), field.raw_max());
            if carried(field.when, all) && !(min..=max).contains(&raw) {
                let field = field.name.clone();
                return Err(EncodeError::RawOutOfRange { field, raw, min, max });
            }
        }
        Ok(())
    }
}

/// Whether a frame with these raw values carries a field under this condition.
fn carried(when: Option<When>, raw: &[i64]) -> bool {
    when.is_none_or(|when| raw[when.field] == when.equals)
}

/// A line of text has its prefix and its check outside the record.
fn is_text(spec: &FrameSpec) -> bool {
    spec.kind() == Kind::Ascii
}
