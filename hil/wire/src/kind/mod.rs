//! Cutting candidates out of a byte stream and putting frames onto one: one module for each kind
//! of frame, behind one seam.
//!
//! A kind knows delimiters, never what a frame means; the decoder knows meaning, never delimiters.
//! It is generic over [`Cutter`], so the choice of kind is made once for a stretch of bytes and
//! not once for a byte.

mod cobs;
mod fixed;
mod septet;
mod text;

use crate::framing::Framing;
use crate::{FrameSpec, MAX_CONTENT_LEN};
pub(crate) use cobs::Cobs;
pub(crate) use fixed::Fixed;
pub(crate) use septet::Septet;
pub(crate) use text::Line;

/// Where content is put that is not on the wire as it stands.
pub(crate) type Scratch = [u8; MAX_CONTENT_LEN];

/// What stands at the front of some bytes.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Cut<'a> {
    /// No frame; or none that is complete, and more bytes may tell.
    Short,
    /// No frame, whatever comes.
    Broken {
        /// Bytes up to the delimiter; 1 where frames have none behind them.
        wire_len: usize,
    },
    /// Something that has the form of a frame.
    Whole {
        /// The frame as the layout counts its bytes.
        content: &'a [u8],
        /// Bytes it takes on the wire.
        wire_len: usize,
    },
}

/// Bytes in which no frame can begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Seek {
    /// How many there are at the front.
    pub(crate) skip: usize,
    /// Whether a delimiter ends them.
    pub(crate) aligned: bool,
}

/// One kind of framing. What it says depends on the bytes alone, and more bytes never take back
/// anything but [`Cut::Short`].
pub(crate) trait Cutter {
    /// Whether frames end in a delimiter, so that one that is not believed is given up as a whole.
    /// Otherwise its bytes may hold the true start.
    const DELIMITED: bool;

    /// Looks for a frame at the very front. `aligned` says that a delimiter stands before it.
    fn cut<'a>(&self, bytes: &'a [u8], aligned: bool, scratch: &'a mut Scratch) -> Cut<'a>;

    /// Bytes at the front in which no frame begins. Asked when there is no frame at the front.
    fn seek(&self, bytes: &[u8], aligned: bool) -> Seek;
}

/// The cutter of a layout.
#[derive(Debug, Clone)]
pub(crate) enum AnyCutter {
    Fixed(Fixed),
    Septet(Septet),
    Cobs(Cobs),
    Line(Line),
}

impl AnyCutter {
    pub(crate) fn of(spec: &FrameSpec) -> Self {
        match &spec.framing {
            Framing::Fixed { mask } => Self::Fixed(Fixed::new(&spec.sync, mask, spec.len)),
            Framing::Septet => Self::Septet(Septet::new(spec.sync[0], spec.len)),
            Framing::Cobs => Self::Cobs(Cobs::new(spec.len)),
            Framing::Ascii(text) => Self::Line(Line::new(&spec.sync, text, &spec.check)),
        }
    }
}

/// Appends a frame with this content to `out`, as it goes onto the wire.
pub(crate) fn emit(spec: &FrameSpec, content: &[u8], out: &mut Vec<u8>) {
    match &spec.framing {
        Framing::Fixed { .. } | Framing::Septet => out.extend_from_slice(content),
        Framing::Cobs => cobs::emit(content, out),
        Framing::Ascii(text) => text::emit(&spec.sync, text, &spec.check, content, out),
    }
}
