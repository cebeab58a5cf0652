//! How frames are told apart on the wire, as declared.

use crate::{CheckSpec, Coding, FieldSpec, SequenceSpec};

/// How a frame is told from what surrounds it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kind {
    /// Sync word and fixed length.
    Fixed,
    /// One marker byte with bit 7 set; bit 7 of all others is clear.
    Septet,
    /// COBS-coded, ended by a zero byte.
    Cobs,
    /// A line of text.
    Ascii,
}

impl Kind {
    /// Its name in frame files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Septet => "septet",
            Self::Cobs => "cobs",
            Self::Ascii => "ascii",
        }
    }
}

/// What each kind needs to know beyond the common layout.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Framing {
    Fixed { mask: Vec<u8> },
    Septet,
    Cobs,
    Ascii(Text),
}

/// Layout of a line of text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Text {
    /// Between columns. A blank stands for any run of blanks.
    pub(crate) separator: u8,
    /// Coding of each column; `None` for one that is not looked at.
    pub(crate) columns: Vec<Option<Coding>>,
    /// The line ends in `*hh`.
    pub(crate) starred: bool,
    /// Longest line that is a frame, bytes, line end included.
    pub(crate) longest: usize,
    /// Blanks in it that the encoder does not send.
    pub(crate) padding: usize,
}

/// Longest text of a column that is not looked at.
const UNREAD_COLUMN_LEN: usize = 16;
/// Blanks more than one between columns that a line may have in all.
const PADDING: usize = 16;

impl Text {
    pub(crate) fn new(
        sync: &[u8],
        separator: u8,
        columns: usize,
        check: &CheckSpec,
        numbers: (&[FieldSpec], Option<&SequenceSpec>),
    ) -> Self {
        let (fields, sequence) = numbers;
        let mut codings = vec![None; columns];
        for field in fields {
            codings[field.at() / 8] = Some(field.coding);
        }
        if let Some(sequence) = sequence {
            let digits = decimal_digits(sequence.modulus() - 1);
            codings[sequence.at() / 8] = Some(Coding::Decimal { digits, decimals: 0 });
        }
        let starred = check.bits() > 0;
        let widths: usize = codings.iter().map(|coding| longest_text(*coding)).sum();
        let sent = sync.len() + widths + columns - 1 + if starred { 5 } else { 2 };
        let padding = if separator == b' ' { PADDING } else { 0 };
        Self { separator, columns: codings, starred, longest: sent + padding, padding }
    }
}

fn decimal_digits(number: u64) -> u32 {
    number.checked_ilog10().unwrap_or(0) + 1
}

fn longest_text(coding: Option<Coding>) -> usize {
    match coding {
        Some(Coding::Decimal { digits, decimals }) => {
            1 + digits as usize + decimals as usize + usize::from(decimals > 0)
        }
        Some(Coding::Hex { digits }) => digits as usize,
        _ => UNREAD_COLUMN_LEN,
    }
}
