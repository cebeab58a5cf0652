//! Gyro frames: a layout declared in a file, an encoder, and a decoder for byte streams of any
//! quality.
//!
//! A frame file becomes a [`FrameSpec`]; the spec feeds an [`Encoder`] (the emulated gyro) and a
//! [`Decoder`] (the bench). Neither touches a port: bytes go in, frames come out.
//!
//! ```
//! use struna_wire::{Decoder, Encoder, FrameSpec};
//!
//! let spec = FrameSpec::from_toml(include_str!("../../../frames/vg910d.toml"))?;
//! let rate = spec.field_index("rate").expect("the default frame carries a rate");
//! let mut raw = vec![0; spec.fields().len()];
//! raw[rate] = spec.fields()[rate].from_si(0.5);
//!
//! let mut wire = Vec::new();
//! Encoder::new(&spec).encode(&raw, &mut wire)?;
//!
//! let mut decoder = Decoder::new(spec.clone());
//! let mut rates_rad_s = Vec::new();
//! decoder.push(&wire, &mut |frame| {
//!     rates_rad_s.push(spec.fields()[rate].to_si(frame.raw()[rate]));
//! });
//! assert!((rates_rad_s[0] - 0.5).abs() <= spec.fields()[rate].scale_si() / 2.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! **Architecture Invariant:** decoding never fails, it reports. Any bytes in any split give the
//! same frames and the same [`Counters`], and every byte is accounted for.
//!
//! **Architecture Invariant:** of Struna only the TOML reader `struna_settings` is reachable from
//! here: no port, no clock, and no frame file is embedded. Units change in [`FieldSpec`] and
//! nowhere else.

// Tests of its inner parts share the layouts of the tests outside, which name the crate.
#[cfg(test)]
extern crate self as struna_wire;

mod check;
mod crc;
mod decoder;
mod encoder;
mod evidence;
mod field;
mod frame;
mod framing;
mod kind;
mod lint;
mod loss;
mod parse;
mod place;
mod plan;
mod sequence;
mod spec;

pub use check::{CheckKind, CheckSpec};
pub use crc::{Crc, CrcParams};
pub use decoder::{Counters, Decoder};
pub use encoder::{EncodeError, Encoder};
pub use evidence::{BELIEF_BITS, Evidence};
pub use field::{Coding, Endian, FieldSpec, Unit};
pub use frame::Frame;
pub use framing::Kind;
pub use lint::{Lint, Load, Undetected};
pub use loss::LossResolver;
pub use spec::{
    FlagSpec, FrameSpec, LineSpec, Parity, PlausibleSpec, Provenance, SequenceSpec, TimeSource,
    TimingSpec,
};

/// Longest frame that a file may declare, bytes. Every gyro frame in use is far shorter.
pub const MAX_FRAME_LEN: usize = 64;
/// Longest sync word, bytes.
pub const MAX_SYNC_LEN: usize = 8;
/// Most fields in a frame. Fixed, so that a decoded [`Frame`] needs no heap.
pub const MAX_FIELDS: usize = 16;
/// Most named status bits in a frame.
pub const MAX_FLAGS: usize = 32;
/// Longest line of text that is a frame, bytes, its end included.
pub const MAX_LINE_LEN: usize = 128;
/// Most frames in a row that may be asked for before any is believed.
pub const MAX_CONFIRM: usize = 24;
/// Longest content: a line of text has eight bytes for each column.
const MAX_CONTENT_LEN: usize = 8 * MAX_FIELDS;
