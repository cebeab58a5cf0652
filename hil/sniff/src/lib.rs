//! Proposes the layout of an unknown gyro frame from its bytes alone.
//!
//! [`sniff`] takes a capture and returns a [`Report`]: layouts, the likeliest first, each as the
//! text of a frame file ([`Proposal::to_toml`]) with what speaks for every part of it and what the
//! bytes leave open, and a [`Verdict`]. Pure: no port, no file, no clock, no chance. Any bytes are
//! fit to be looked at.
//!
//! What cannot be in the bytes is not claimed: scale, sign, which constant byte is status and
//! which is sync, and what a number is that never moved. A proposal is
//! [confirmed](Verdict::Confirmed) only when it has read bytes it was not made from, most of them,
//! and the gyro was turned.
//!
//! **Architecture Invariant:** this crate knows bytes only. It does not name the decoder that will
//! read its proposals; the tests hold the two together.

mod align;
mod catalogue;
mod check;
mod counter;
mod discover;
mod field;
mod frames;
mod layout;
mod length;
mod motion;
mod propose;
mod rate;
mod report;
mod septet;
mod text;
mod toml;
mod word;

pub use catalogue::Crc;
pub use layout::{Check, CheckKind, Coding, Counter, Field, Kind, Layout, Role};
pub use length::length_score;
pub use propose::sniff;
pub use report::{Alternative, Described, Doubt, Evidence, Proposal, Report, Shape, Verdict};
pub use text::{Column, Lines};
pub use toml::Labels;
pub use word::ParityWord;
