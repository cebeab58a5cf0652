//! From raw field values to bytes.

use crate::field::When;
use crate::frame::write_content;
use crate::plan::AnySendPlan;
use crate::{FieldSpec, FrameSpec, MAX_CONTENT_LEN, kind};

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
    plan: Option<AnySendPlan>,
    /// Least and greatest raw value of each field.
    limits: Vec<(i64, i64)>,
    /// Where frames are put together. Longer than any, so that each number in a frame has a whole
    /// word to be written in.
    content: Box<[u8; ROOM]>,
    /// The counter of the next frame, and the index of the frame that has zero of the same turn.
    /// A division is slow beside the rest of a frame, and so is a second number to count.
    next_counter: u64,
    turn_start: u64,
    /// Frames in the turn: the modulus, unless the index wraps before.
    turn_len: u64,
    modulus: u64,
}

/// The longest content and a word behind it.
const ROOM: usize = MAX_CONTENT_LEN + 8;

impl Encoder {
    /// An encoder whose first frame has index zero.
    #[must_use]
    pub fn new(spec: &FrameSpec) -> Self {
        Self::starting_at(spec, 0)
    }

    /// An encoder whose first frame has index `first_index`: a gyro that has been running.
    #[must_use]
    pub fn starting_at(spec: &FrameSpec, first_index: u64) -> Self {
        let limits = spec.fields.iter().map(|field| (field.raw_min(), field.raw_max())).collect();
        let (spec, plan) = (spec.clone(), AnySendPlan::of(spec));
        let content = Box::new([0; ROOM]);
        // A counter that nobody sees need not come round.
        let modulus = spec.sequence.map_or(u64::MAX, |sequence| sequence.modulus);
        let next_counter = first_index % modulus;
        let turn_start = first_index - next_counter;
        let turn_len = turn_len(turn_start, modulus);
        Self { spec, plan, limits, content, next_counter, turn_start, turn_len, modulus }
    }

    /// The same encoder, asking the layout about everything.
    #[cfg(test)]
    pub(crate) fn without_plan(self) -> Self {
        Self { plan: None, ..self }
    }

    /// Index of the next frame; the counter on the wire is this modulo the layout's modulus.
    #[must_use]
    pub const fn next_index(&self) -> u64 {
        self.turn_start + self.next_counter
    }

    /// Appends one frame to `out`. `raw` holds one raw value for each field, in file order; the
    /// value of a field that this frame does not carry is not looked at. Undeclared bits are sent
    /// as zero.
    ///
    /// # Errors
    /// [`EncodeError`] when `raw` does not fit the layout. Values are not saturated here:
    /// [`crate::FieldSpec::from_si`] and the gyro model do that, knowing why.
    #[inline(always)]
    pub fn encode(&mut self, raw: &[i64], out: &mut Vec<u8>) -> Result<(), EncodeError> {
        if let Some(AnySendPlan::Short(plan)) = &self.plan
            && plan.emit_single(raw, self.next_counter, out)
        {
            self.count();
            return Ok(());
        }
        self.encode_apart(raw, out)
    }

    /// The same for any frame, out of line: callers have room for the simplest ones only.
    #[inline(never)]
    fn encode_apart(&mut self, raw: &[i64], out: &mut Vec<u8>) -> Result<(), EncodeError> {
        let planned = match &self.plan {
            Some(AnySendPlan::Short(plan)) => plan.emit(raw, self.next_counter, out),
            Some(AnySendPlan::Long(plan)) => plan.emit(raw, self.next_counter, out),
            None => false,
        };
        if !planned {
            return self.encode_by_layout(raw, out);
        }
        self.count();
        Ok(())
    }

    #[inline(always)]
    fn count(&mut self) {
        self.next_counter += 1;
        if self.next_counter == self.turn_len {
            self.turn();
        }
    }

    #[inline(never)]
    fn turn(&mut self) {
        self.turn_start = self.turn_start.wrapping_add(self.turn_len);
        (self.next_counter, self.turn_len) = (0, turn_len(self.turn_start, self.modulus));
    }

    /// The same for any layout, and for values of any kind.
    #[inline(never)]
    fn encode_by_layout(&mut self, raw: &[i64], out: &mut Vec<u8>) -> Result<(), EncodeError> {
        self.refuse_unfit(raw)?;
        let Self { spec, content, next_counter, .. } = self;
        content[..spec.len].fill(0);
        let is_carried = |field: &FieldSpec| carried(field.when, raw);
        write_content(spec, raw, *next_counter, is_carried, &mut content[..]);
        kind::emit(spec, &content[..spec.len], out);
        self.count();
        Ok(())
    }

    fn refuse_unfit(&self, all: &[i64]) -> Result<(), EncodeError> {
        let fields = &self.spec.fields;
        if all.len() != fields.len() {
            return Err(EncodeError::FieldCount { found: all.len(), expected: fields.len() });
        }
        for ((field, &raw), &(min, max)) in fields.iter().zip(all).zip(&self.limits) {
            if carried(field.when, all) && !(min..=max).contains(&raw) {
                let field = field.name.clone();
                return Err(EncodeError::RawOutOfRange { field, raw, min, max });
            }
        }
        Ok(())
    }
}

/// Frames in a turn of the counter; with the last index there is it begins again.
fn turn_len(turn_start: u64, modulus: u64) -> u64 {
    let before_last = u64::MAX - turn_start;
    modulus.min(before_last.saturating_add(1))
}

/// Whether a frame with these raw values carries a field under this condition.
fn carried(when: Option<When>, raw: &[i64]) -> bool {
    when.is_none_or(|when| raw[when.field] == when.equals)
}
