//! One good frame, as the decoder hands it out.

use crate::{FieldSpec, FrameSpec, Kind, MAX_FIELDS};

/// One good frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    /// Sample index: the frame counter unwrapped across its modulus. The first frame of a stream
    /// keeps its counter value; without a counter, frames are numbered from zero.
    pub index: u64,
    /// Frames missing between the previous frame and this one, as far as the counter can tell, or
    /// the clock of [`crate::Decoder::push_at`].
    pub lost_before: u64,
    /// Whether it took a clock to tell `lost_before`.
    pub inferred: bool,
    pub(crate) raw: [i64; MAX_FIELDS],
    field_count: usize,
    pub(crate) has: u64,
    pub(crate) flags: u64,
}

impl Frame {
    /// Raw field values, indexed as [`FrameSpec::fields`]; zero for a field that this frame does
    /// not carry.
    #[must_use]
    #[inline]
    pub fn raw(&self) -> &[i64] {
        &self.raw[..self.field_count]
    }

    /// Whether the frame holds a usable value of the field with this index in
    /// [`FrameSpec::fields`]: it carries the field, the flag that vouches for it is set, and a
    /// float is a number.
    #[must_use]
    #[inline]
    pub fn has(&self, field_index: usize) -> bool {
        bit(self.has, field_index)
    }

    /// Whether the status bit with this index in [`FrameSpec::flags`] is set; `false` for an
    /// index that the layout does not have.
    #[must_use]
    #[inline]
    pub fn flag(&self, index: usize) -> bool {
        bit(self.flags, index)
    }

    /// A frame of nothing, to be read into.
    #[inline]
    pub(crate) const fn blank(spec: &FrameSpec) -> Self {
        let (raw, field_count) = ([0; MAX_FIELDS], spec.fields.len());
        Self { index: 0, lost_before: 0, inferred: false, raw, field_count, has: 0, flags: 0 }
    }

    /// Reads the fields out of a frame's content.
    #[inline]
    pub(crate) fn read(spec: &FrameSpec, content: &[u8]) -> Self {
        let mut raw = [0; MAX_FIELDS];
        let mut has = 0;
        for (k, field) in spec.fields.iter().enumerate() {
            // The deciding field stands earlier in the file.
            if field.when.is_none_or(|when| raw[when.field] == when.equals) {
                raw[k] = field.read(content);
                has |= u64::from(field.is_number(raw[k])) << k;
            }
        }
        let mut flags = 0;
        for (k, flag) in spec.flags.iter().enumerate() {
            flags |= (raw[flag.field].cast_unsigned() >> flag.bit & 1) << k;
        }
        for (k, field) in spec.fields.iter().enumerate() {
            if let Some(flag) = field.valid_if {
                has &= !(u64::from(!bit(flags, flag)) << k);
            }
        }
        Self { raw, has, flags, ..Self::blank(spec) }
    }
}

/// Writes the fields that are carried, and all else, into content that is zero. What a line of
/// text has outside its record, [`crate::kind`] adds.
pub(crate) fn write_content(
    spec: &FrameSpec,
    raw: &[i64],
    counter: u64,
    is_carried: impl Fn(&FieldSpec) -> bool,
    content: &mut [u8],
) {
    let is_text = spec.kind() == Kind::Ascii;
    if !is_text {
        content[..spec.sync.len()].copy_from_slice(&spec.sync);
    }
    for (field, value) in spec.fields.iter().zip(raw) {
        if is_carried(field) {
            field.write(*value, content);
        }
    }
    if let Some(sequence) = &spec.sequence {
        sequence.write(counter, content);
    }
    if !is_text {
        spec.check.write(content);
    }
}

#[inline]
fn bit(word: u64, index: usize) -> bool {
    u32::try_from(index).is_ok_and(|bit| word.checked_shr(bit).unwrap_or(0) & 1 == 1)
}
