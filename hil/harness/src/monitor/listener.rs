//! A decoder and a monitor behind it.

use super::{AlarmChange, Declared, Monitor};
use struna_kernel::{ParameterError, SimTime};
use struna_wire::{Decoder, FieldSpec, Frame, FrameSpec};

/// Hears bytes with their arrival times and says what is wrong with them.
///
/// Bytes are decoded a frame's length at a time, so that what the counters say of a chunk holds
/// for the one or two frames that it completes.
#[derive(Debug, Clone)]
pub struct Listener {
    decoder: Decoder,
    monitor: Monitor,
    rate: usize,
    field: FieldSpec,
    frames: Vec<Frame>,
}

/// Why there is nothing to listen to.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ListenerError {
    /// No rate in the layout.
    #[error("frame layout '{frame}' has no field 'rate'; add one")]
    NoRate {
        /** Name of the layout. */
        frame: String,
    },
    /// Something declared that cannot be.
    #[error(transparent)]
    Declared(#[from] ParameterError),
}

impl Listener {
    /// A listener to frames of layout `frame`, judged by `declared`.
    ///
    /// # Errors
    /// [`ListenerError`] when there is no rate, or something declared cannot be.
    pub fn new(frame: FrameSpec, declared: &Declared) -> Result<Self, ListenerError> {
        let rate = frame.field_index("rate");
        let rate = rate.ok_or_else(|| ListenerError::NoRate { frame: frame.name().to_owned() })?;
        let (monitor, field) = (Monitor::new(declared)?, frame.fields()[rate].clone());
        let (decoder, frames) = (Decoder::new(frame), Vec::with_capacity(16));
        Ok(Self { decoder, monitor, rate, field, frames })
    }

    /// Takes bytes that came at `arrival`.
    pub fn push(&mut self, arrival: SimTime, bytes: &[u8], sink: &mut dyn FnMut(AlarmChange)) {
        let Self { decoder, monitor, rate, field, frames } = self;
        let len = decoder.spec().frame_len();
        for piece in bytes.chunks(len) {
            frames.clear();
            decoder.push(piece, &mut |frame| frames.push(*frame));
            monitor.line(arrival, &decoder.counters(), sink);
            // Frames of other channels keep the counters going and have no rate to judge.
            for frame in frames.iter().filter(|frame| frame.has(*rate)) {
                let raw = frame.raw()[*rate];
                monitor.frame(arrival, frame.index, raw, field.to_si(raw), sink);
            }
        }
    }

    /// The monitor, to declare rest or to let time pass.
    pub fn monitor(&mut self) -> &mut Monitor {
        &mut self.monitor
    }

    /// The decoder, for its counters.
    #[must_use]
    pub const fn decoder(&self) -> &Decoder {
        &self.decoder
    }
}
