//! Whether a guess is right, judged by reading new frames with it.

use struna_sniff::{Kind, Layout};

/// What was right.
#[expect(clippy::struct_excessive_bools, reason = "a row of a table of yes and no")]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Grade {
    pub(crate) len: bool,
    pub(crate) sync: bool,
    pub(crate) counter: bool,
    pub(crate) check: bool,
    pub(crate) rate: bool,
}

impl Grade {
    /// Everything that reading the gyro needs.
    pub(crate) fn is_functional(self) -> bool {
        self.len && self.counter && self.check && self.rate
    }
}

/// Reads `bytes`, whole frames of `truth` with these `rates`, as `guess` would, at whichever
/// column it takes for the first one: the sync word is graded by itself.
pub(crate) fn grade(guess: &Layout, truth: &Layout, bytes: &[u8], rates: &[i64]) -> Grade {
    if guess.len != truth.len || guess.kind != truth.kind {
        return Grade::default();
    }
    let phases = if guess.kind == Kind::Septet { 0..1 } else { 0..guess.len };
    let grades = phases.map(|phase| at_phase(guess, truth, &bytes[phase..], phase, rates));
    let worth = |grade: &Grade| {
        u32::from(grade.rate)
            + u32::from(grade.check)
            + u32::from(grade.counter)
            + u32::from(grade.sync)
    };
    let best = grades.max_by_key(worth).unwrap_or_default();
    Grade { len: true, ..best }
}

fn at_phase(guess: &Layout, truth: &Layout, bytes: &[u8], phase: usize, rates: &[i64]) -> Grade {
    let frames = || bytes.chunks_exact(guess.len);
    let check = match (&guess.check, &truth.check) {
        (None, None) => true,
        (Some(check), Some(_)) => frames().all(|frame| check.holds(frame)),
        _ => false,
    };
    let rate = guess.rate().is_some_and(|field| {
        let own = truth.rate().map_or(0, |rate| rate.at);
        // Read from the frame after when the guess begins a frame behind the true rate.
        let skip = usize::from(phase > own);
        let read = frames().map(|frame| field.raw(frame, guess.digit_bits()));
        read.zip(&rates[skip..]).all(|(read, sent)| read == *sent)
    });
    let counter = match (guess.counter, truth.counter) {
        (None, None) => true,
        (Some(guess), Some(truth)) => {
            guess.modulus == truth.modulus
                && guess.bytes == truth.bytes
                && (guess.at + phase) % bytes_of(rates, bytes, phase) == truth.at
                && (guess.bytes == 1 || guess.big_endian == truth.big_endian)
        }
        _ => false,
    };
    let sync = phase == 0 && guess.sync == truth.sync;
    Grade { len: true, sync, counter, check, rate }
}

/// Frame length, from the number of frames.
fn bytes_of(rates: &[i64], bytes: &[u8], phase: usize) -> usize {
    (bytes.len() + phase) / rates.len()
}
