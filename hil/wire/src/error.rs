//! Why a frame file was refused.

/// Why a frame file was refused: where, which key, what it held, and what to do about it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("line {line}, column {column}: `{key}` = {value}: {fault}")]
pub struct FrameSpecError {
    /// Line of the value, from 1.
    pub line: usize,
    /// Column of the value, in characters from 1.
    pub column: usize,
    /// Path of the key, such as `frame.field[1].bits`.
    pub key: String,
    /// The text at fault, cut short when it is long.
    pub value: String,
    /// What is wrong and the remedy.
    pub fault: FrameSpecFault,
}

/// What is wrong with one key of a frame file. Each message ends in the remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FrameSpecFault {
    /// The file is too long to be a frame description.
    #[error("the file has {found} bytes; a frame file has at most {limit}")]
    TooLong {
        /** Bytes in the file. */
        found: usize,
        /** Bytes allowed. */
        limit: usize,
    },
    /// Not TOML at all.
    #[error("not TOML ({message}); correct the syntax here")]
    Syntax {
        /** What the TOML parser said. */
        message: String,
    },
    /// A key that means nothing here: a typing error would otherwise pass in silence.
    #[error("no such key; remove it or use one of: {known}")]
    UnknownKey {
        /** Keys that are understood here. */
        known: String,
    },
    /// A key that has no default is absent.
    #[error("this key is missing; add it")]
    Missing,
    /// The value is of another type.
    #[error("found {found}; write {expected}")]
    WrongType {
        /** Type in the file. */
        found: &'static str,
        /** Type wanted. */
        expected: &'static str,
    },
    /// The value is of the right type but cannot be used.
    #[error("not usable; write {expected}")]
    OutOfRange {
        /** What would be accepted. */
        expected: String,
    },
    /// A word that is not supported.
    #[error("not supported; write one of: {supported}")]
    UnknownWord {
        /** Words that are. */
        supported: String,
    },
    /// The same name or the same status bit twice.
    #[error("already taken by {by}; choose another")]
    Taken {
        /** Who has it. */
        by: String,
    },
    /// Bytes past the end of the frame.
    #[error("reaches byte {last}, but the frame ends at byte {end}; move it or raise `frame.len`")]
    BeyondFrame {
        /** Last byte it would occupy. */
        last: usize,
        /** Last byte of the frame. */
        end: usize,
    },
    /// Two things in one byte.
    #[error("byte {byte} already belongs to {owner}; move one of them")]
    Overlap {
        /** The disputed byte. */
        byte: usize,
        /** Who has it. */
        owner: String,
    },
    /// A check over its own bytes could never be met by construction.
    #[error("covers the check's own byte {byte}; end the range before it")]
    CheckCoversItself {
        /** First byte of the check inside the range. */
        byte: usize,
    },
    /// A flag names a field that does not exist or cannot hold flags.
    #[error("no such unsigned field; write one of: {known}")]
    NotAFlagField {
        /** Fields that can hold flags. */
        known: String,
    },
    /// The declared line cannot carry the declared rate.
    #[error(
        "frames at this rate need {needed_baud:.0} baud; raise `line.baud` or lower \
         `timing.rate_hz`"
    )]
    LineTooSlow {
        /** Bits per second on the line, framing bits included. */
        needed_baud: f64,
    },
}
