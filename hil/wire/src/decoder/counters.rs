//! What became of every byte and every frame.

/// What became of every byte and every frame.
///
/// Always `bytes == frame_bytes + skipped_bytes + pending`, where pending is
/// [`crate::Decoder::pending_bytes`], zero after [`crate::Decoder::finish`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Bytes pushed.
    pub bytes: u64,
    /// Frames handed out.
    pub ok: u64,
    /// Bytes of good frames: those handed out, duplicates, and those that came late.
    pub frame_bytes: u64,
    /// Places that looked like the start of a frame but failed the check, or whose content has not
    /// the form of one. In noise many of these were never frames.
    pub bad_check: u64,
    /// Places that passed the check but held a counter not below the modulus; treated as failed.
    pub bad_sequence: u64,
    /// Places that passed the check but whose rate is not credible beside the last one; treated
    /// as failed.
    pub implausible: u64,
    /// Places that passed the check of a weak layout but were not followed by as many good frames
    /// as it takes to believe one; treated as failed.
    pub unconfirmed: u64,
    /// Bytes that belong to no frame.
    pub skipped_bytes: u64,
    /// Times a frame was found again after skipped bytes. Finding the first one does not count.
    pub resyncs: u64,
    /// Times the stream was found: at first, and after it had been lost for long.
    pub locks: u64,
    /// Times it was lost: five frames' length of bytes without a good frame.
    pub unlocks: u64,
    /// Steps of the frame counter by more than one.
    pub sequence_gaps: u64,
    /// Frames missing in those gaps.
    pub lost: u64,
    /// Good frames that repeated the previous counter; counted, not handed out.
    pub duplicates: u64,
    /// Good frames whose counter went a few steps back; counted, not handed out, for the samples
    /// behind them have been used already. They stay counted as lost.
    pub backward: u64,
}
